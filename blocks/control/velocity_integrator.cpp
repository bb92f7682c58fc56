// The integrator at the end of a controller in velocity form.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct VelocityIntegrator final : Block {
  static constexpr auto summary =
      "Integrate the speed of a control signal, with limits on the signal and on its speed.";
  static constexpr auto details =
      "u' = v between slowest and fastest.  With lower or upper u stands still at a limit while v points further out, "
      "so nothing winds up: the reason to compute the speed of a control signal instead of the signal (book section "
      "6.1, figure 6.5).";
  static constexpr auto icon = "1/s";
  static constexpr auto example = R"(
blocks: {u: {type: velocity_integrator, in: 10, fastest: 2, upper: 1}}
simulation: {stop: 1}
expect:
  - {signal: u, at: 0.25, value: 0.5, abs: 1e-9}
  - {signal: u, measure: final, value: 1}
)";

  Input v{this, "v", {.doc = "speed of the control signal"}};
  Number initial_value{
      this, "initial", {.init = 0, .doc = "control signal at the start; may read signals", .initial = true}};
  Limits limits{this, "least value of the control signal", "greatest value of the control signal"};
  Number slowest{this, "slowest", {.doc = "least speed, as a rule below 0", .max = 0, .optional = true}};
  Number fastest{this, "fastest", {.doc = "greatest speed", .min = 0, .optional = true}};
  State x{this, "u", {.doc = "control signal"}};
  Output u{this, "u", {.doc = "the control signal"}};

  void check(Checking& checking) const override { limits.check(checking); }
  void initial(Now now, Init init) const override { init[x] = limits.clamp(now, now[initial_value]); }
  void outputs(Now now, Out out) const override { out[u] = now[x]; }
  void derivatives(Now now, Rates rate) const override {
    Array speed = now[v];
    if (now.given(slowest)) speed = max(speed, now[slowest]);
    if (now.given(fastest)) speed = min(speed, now[fastest]);
    rate[x] = limits.stand_still(now, now[x], speed);
  }
  void jumps(Now now, Jumps jump) const override { limits.stop_at_limits(now, jump, x); }
};

}  // namespace

PLANTLOOP_BLOCK(velocity_integrator, VelocityIntegrator)

}  // namespace plantloop
