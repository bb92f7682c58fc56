// The integral of a signal, with optional limits.
//
// At a limit the state stands still while the input pushes further out, and leaves as soon as the input turns: whether
// it is held is a condition on the state and the input, so no time constant is added and nothing winds up.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Integrator final : Block {
  static constexpr auto summary = "Integrate the input over time.";
  static constexpr auto details =
      "x' = u,  y = x.  With lower or upper the state never leaves the limits: at a limit it stands still while the "
      "input pushes further out.";
  static constexpr auto icon = "1/s";
  static constexpr auto example = R"(
blocks: {x: {type: integrator, in: cos(time), upper: 0.5}}
simulation: {stop: 2}
expect:
  - {signal: x, at: 0.3, value: sin(0.3), abs: 1e-6}
  - {signal: x, at: 1.5, value: 0.5}
)";

  Input u{this, "u", {.doc = "signal to integrate"}};
  Number initial_value{this, "initial", {.init = 0, .doc = "value at the start; may read signals", .initial = true}};
  Limits limits{this, "least value of the integral", "greatest value of the integral"};
  State x{this, "x", {.doc = "integral"}};
  Output y{this, "y", {.doc = "the integral"}};

  void check(Checking& checking) const override { limits.check(checking); }
  void initial(Now now, Init init) const override { init[x] = limits.clamp(now, now[initial_value]); }
  void outputs(Now now, Out out) const override { out[y] = now[x]; }
  void derivatives(Now now, Rates rate) const override { rate[x] = limits.stand_still(now, now[x], now[u]); }
  void jumps(Now now, Jumps jump) const override { limits.stop_at_limits(now, jump, x); }
};

}  // namespace

PLANTLOOP_BLOCK(integrator, Integrator)

}  // namespace plantloop
