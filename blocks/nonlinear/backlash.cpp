// Play between two parts.
//
// y moves only when u pushes it: y = min(max(y0, u - width/2), u + width/2), where y0 is y at any earlier instant since
// which u has not turned. So y0 is taken at the ends of steps, and the instants at which u turns are ends of steps.

#include <algorithm>
#include <memory>

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/program/kernel.h"

namespace plantloop {
namespace {

// The position at the last accepted instant or sample; advanced by the least and the greatest position that u allows.
class PlayedPosition final : public Kernel {
 public:
  std::string name() const override { return "backlash"; }
  int outputs() const override { return 1; }
  int state_size() const override { return 1; }
  bool starts_with_inputs() const override { return false; }
  void initialise(const KernelCall& call) const override { call.state[0] = call.in[0]; }
  void evaluate(const KernelCall& call) const override { call.out[0] = call.state[0]; }
  void advance(const KernelCall& call) const override {
    call.state[0] = std::min(std::max(call.state[0], call.in[0]), call.in[1]);
  }
};

struct Backlash final : Block {
  static constexpr auto summary = "Follow the input with play.";
  static constexpr auto details =
      "y stands still while u moves inside the play, |u - y| < width/2, and is pushed along at its ends: y = u - "
      "width/2 while u rises, y = u + width/2 while it falls. y starts at `initial`, moved into the play around u. The "
      "instants at which y is pushed or left are located.";
  static constexpr auto example = R"(
blocks:
  u: {type: sine}
  y: {type: backlash, in: u, width: 1}
simulation: {stop: 2*pi}
expect:
  - {signal: y, at: pi/2, value: 0.5, abs: 1e-9}
  - {signal: y, at: pi, value: 0.5, abs: 1e-9}
  - {signal: y, at: 3*pi/2, value: -0.5, abs: 1e-9}
)";

  Input u{this, "u", {.doc = "position that pushes"}};
  Number width{this, "width", {.init = 1, .doc = "the whole play, from end to end", .min = 0}};
  Number initial_value{
      this, "initial", {.init = 0, .doc = "output before the start; may read signals", .initial = true}};
  Output y{this, "y", {.doc = "position that is pushed"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void outputs(Now now, Out out) const override {
    const Array least = now[u] - 0.5 * now[width], greatest = now[u] + 0.5 * now[width];
    Array position(least.shape());
    for (int i = 0; i < position.size(); ++i) {
      const Value before =
          now.kernel(std::make_shared<PlayedPosition>(), {now[initial_value].at(i)}, {least[i], greatest[i]})[0];
      position[i] = min(max(before, least[i]), greatest[i]);
    }
    out[y] = position;
  }
  void jumps(Now now, Jumps jump) const override {
    if (!is_sampled(now)) jump.when(turning(now[u]));
  }
};

}  // namespace

PLANTLOOP_BLOCK(backlash, Backlash)

}  // namespace plantloop
