// A condition with memory.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Hysteresis final : Block {
  static constexpr auto summary = "Say whether a signal is high, with a band in which the answer stays as it is.";
  static constexpr auto details =
      "y becomes 1 when u reaches `upper` from below and 0 when u falls to `lower`; in between it stays. At the start "
      "it is 1 if u >= upper, unless `initial` says. relay is the same with values of its own for on and off.";
  static constexpr auto example = R"(
blocks:
  u: {type: sine}
  high: {type: hysteresis, in: u, lower: -0.5, upper: 0.5}
simulation: {stop: 2*pi}
expect:
  - {signal: high, at: 0.5, value: 0}
  - {signal: high, at: 3.5, value: 1}
  - {signal: high, at: 4, value: 0}
)";

  Input u{this, "u", {.doc = "the signal"}};
  Number lower{this, "lower", {.init = 0, .doc = "y becomes 0 here"}};
  Number upper{this, "upper", {.init = 1, .doc = "y becomes 1 here"}};
  Number initial_value{
      this,
      "initial",
      {.doc = "y is 1 at the start if this is greater than 0; may read signals", .optional = true, .initial = true}};
  Discrete state{this, "state", {.doc = "1 or 0"}};
  Output y{this, "y", {.doc = "1 or 0"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void check(Checking& checking) const override { check_order(checking, lower, upper, false); }

  void initial(Now now, Init init) const override {
    init[state] = now.given(initial_value) ? (now[initial_value] > 0.0).array : (now[u] >= now[upper]).array;
  }
  void outputs(Now now, Out out) const override { out[y] = value(now); }
  void update(Now now, Next next) const override { next[state] = value(now); }
  void jumps(Now now, Jumps jump) const override {
    if (is_sampled(now)) return;
    jump.when(crossing(now[u] - now[upper], Direction::rising)).set(state, Array(now[state].shape(), 1.0));
    jump.when(crossing(now[u] - now[lower], Direction::falling)).set(state, Array(now[state].shape(), 0.0));
  }

 private:
  Array value(Now now) const {
    if (!is_sampled(now)) return now[state];
    return where(now[u] >= now[upper], 1.0, where(now[u] <= now[lower], 0.0, now[state]));
  }
};

}  // namespace

PLANTLOOP_BLOCK(hysteresis, Hysteresis)

}  // namespace plantloop
