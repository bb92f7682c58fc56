// Limits on the speed of a signal.
//
// y = min(max(u, y0 + lower (t - t0)), y0 + upper (t - t0)), where y0 and t0 belong to any earlier instant since which
// u has not become faster than a limit. So they are taken at the ends of steps, and the instants at which u becomes too
// fast are ends of steps.

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/program/kernel.h"

namespace plantloop {
namespace {

// Output and time at the last accepted instant or sample; advanced by u, lower and upper.
class LimitedSpeed final : public Kernel {
 public:
  explicit LimitedSpeed(bool starts_with_input) : starts_with_input_(starts_with_input) {}
  std::string name() const override { return "rate limiter"; }
  int outputs() const override { return 2; }
  int state_size() const override { return 2; }
  bool starts_with_inputs() const override { return starts_with_input_; }
  void initialise(const KernelCall& call) const override {
    call.state[0] = call.in[0];  // the input, or what the output starts at
    call.state[1] = call.time;
  }
  void evaluate(const KernelCall& call) const override {
    call.out[0] = call.state[0];
    call.out[1] = call.state[1];
  }
  void advance(const KernelCall& call) const override {
    const double elapsed = call.time - call.state[1];
    call.state[0] =
        std::min(std::max(call.in[0], call.state[0] + call.in[1] * elapsed), call.state[0] + call.in[2] * elapsed);
    call.state[1] = call.time;
  }

 private:
  bool starts_with_input_;
};

struct RateLimiter final : Block {
  static constexpr auto summary = "Follow the input no faster than its limits allow.";
  static constexpr auto details =
      "y' stays between lower and upper (per second): y = u while u is slow enough, else y runs after it at the limit "
      "until it meets u. Sampled with the period T, a step lies between T lower and T upper. y starts at u, or at "
      "`initial`. The instants at which y falls behind and meets u are located.";
  static constexpr auto example = R"(
blocks:
  u: {type: step, time: 1, after: 3}
  y: {type: rate_limiter, in: u, lower: -1, upper: 2}
simulation: {stop: 4}
expect:
  - {signal: y, at: 2, value: 2, abs: 1e-9}
  - {signal: y, at: 2.5, value: 3, abs: 1e-9}
)";

  Input u{this, "u", {.doc = "signal to follow"}};
  Number lower{this, "lower", {.init = -1, .doc = "least speed of the output per second, as a rule below 0"}};
  Number upper{this, "upper", {.init = 1, .doc = "greatest speed of the output per second"}};
  Number initial_value{
      this,
      "initial",
      {.doc = "output at the start; default: the input there; may read signals", .optional = true, .initial = true}};
  Output y{this, "y", {.doc = "the limited signal"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void check(Checking& checking) const override { check_order(checking, lower, upper, true); }
  void outputs(Now now, Out out) const override {
    const Array in = now[u], slowest = now[lower], fastest = now[upper];
    const bool given = now.given(initial_value);
    Array limited((in + slowest + fastest).shape());
    for (int i = 0; i < limited.size(); ++i) {
      const std::vector<Value> start = given ? std::vector{now[initial_value].at(i)} : std::vector<Value>{};
      const auto last =
          now.kernel(std::make_shared<LimitedSpeed>(!given), start, {in.at(i), slowest.at(i), fastest.at(i)});
      const Value elapsed = now.time() - last[1];
      limited[i] = min(max(in.at(i), last[0] + slowest.at(i) * elapsed), last[0] + fastest.at(i) * elapsed);
    }
    out[y] = limited;
  }
  void jumps(Now now, Jumps jump) const override {
    if (is_sampled(now)) return;
    jump.when(turning(now[u] - now[upper] * now.time(), Direction::rising));
    jump.when(turning(now[u] - now[lower] * now.time(), Direction::falling));
  }
};

}  // namespace

PLANTLOOP_BLOCK(rate_limiter, RateLimiter)

}  // namespace plantloop
