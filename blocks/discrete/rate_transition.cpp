// A signal that goes from one rate to another, with a defined latency.

#include "engine/block.h"

namespace plantloop {
namespace {

struct RateTransition final : Block {
  static constexpr auto summary = "Carry a signal to another rate, with a latency that is defined.";
  static constexpr auto details =
      "`rate:` is that of what reads the block. From a faster rate, or a continuous signal, it samples: y[k] = u(t_k). "
      "From a slower one it is `protected`: y is the input of the slow hit before the latest, one slow period late and "
      "without a path at the same instant, and `initial` at first. Where neither period is a whole multiple of the "
      "other, y is the input at its last hit strictly before now. `mode: direct` takes the present input in all cases.";
  static constexpr auto example = R"(
blocks:
  slow: {type: zero_order_hold, in: time, rate: 0.3}
  y: {type: rate_transition, in: slow, initial: -1, rate: 0.1}
simulation: {stop: 1}
expect:
  - {signal: y, at: 0.2, value: -1}
  - {signal: y, at: 0.5, value: 0}
  - {signal: y, at: 0.7, value: 0.3}
)";

  Input u{this, "u", {.doc = "signal of another rate"}};
  Choice mode{
      this, "mode", {.of = {"protected", "direct"}, .doc = "from a slower rate: one slow period late, or at once"}};
  Number initial_value{
      this, "initial", {.init = 0, .doc = "output before there was an earlier hit; may read signals", .initial = true}};
  Output y{this, "y", {.doc = "the signal at the block's rate"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void outputs(Now now, Out out) const override {
    const Meeting meeting = now.meeting(u);
    if (mode.is("direct") || meeting == Meeting::never || meeting == Meeting::faster) {
      out[y] = now[u];
    } else {
      out[y] = now.earlier(u, now[initial_value], meeting == Meeting::slower);
    }
  }
};

}  // namespace

PLANTLOOP_BLOCK(rate_transition, RateTransition)

}  // namespace plantloop
