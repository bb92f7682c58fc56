// A delay by a number of samples.

#include <cstddef>
#include <memory>

#include "engine/block.h"
#include "engine/program/kernel.h"

namespace plantloop {
namespace {

// The last samples in a ring: the state is where the oldest one stands, then the samples.
class Ring final : public Kernel {
 public:
  explicit Ring(int samples) : samples_(samples) {}
  std::string name() const override { return "sample delay"; }
  int outputs() const override { return 1; }
  int state_size() const override { return samples_ + 1; }
  bool starts_with_inputs() const override { return false; }
  void initialise(const KernelCall& call) const override {
    call.state[0] = 0;
    for (int i = 1; i <= samples_; ++i) call.state[i] = call.in[0];
  }
  void evaluate(const KernelCall& call) const override { call.out[0] = call.state[1 + oldest(call)]; }
  void advance(const KernelCall& call) const override {
    const std::size_t at = oldest(call);
    call.state[1 + at] = call.in[0];
    call.state[0] = static_cast<double>((at + 1) % static_cast<std::size_t>(samples_));
  }

 private:
  static std::size_t oldest(const KernelCall& call) { return static_cast<std::size_t>(call.state[0]); }
  int samples_;
};

struct SampleDelay final : Block {
  static constexpr auto summary = "Delay the input by a number of samples.";
  static constexpr auto details =
      "y[k] = u[k-samples]; samples before the start are `initial`. The time that it takes does not grow with their "
      "number. unit_delay is the delay by one sample, whose state can be reset; tapped_delay shows all of the last "
      "samples.";
  static constexpr auto example = R"(
blocks: {y: {type: sample_delay, in: time, samples: 3, initial: -1, rate: 1}}
simulation: {stop: 6}
expect:
  - {signal: y, at: 2, value: -1}
  - {signal: y, at: 5, value: 2}
)";

  Input u{this, "u", {.doc = "signal to delay"}};
  Count samples{this, "samples", {.init = 1, .doc = "how many samples", .min = 1}};
  Number initial_value{
      this, "initial", {.init = 0, .doc = "samples before the start; may read signals", .initial = true}};
  Output y{this, "y", {.doc = "the delayed signal"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void outputs(Now now, Out out) const override {
    const Array in = now[u], before = now[initial_value];
    Array delayed((in + before).shape());
    for (int i = 0; i < delayed.size(); ++i) {
      delayed[i] = now.kernel(std::make_shared<Ring>(samples.value()), {before.at(i)}, {in.at(i)})[0];
    }
    out[y] = delayed;
  }
};

}  // namespace

PLANTLOOP_BLOCK(sample_delay, SampleDelay)

}  // namespace plantloop
