// A PI controller in velocity form, whose gains may be scheduled.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct VelocityPi final : Block {
  static constexpr auto summary = "Control by a PI controller in velocity form, with gains that may vary.";
  static constexpr auto details =
      "z' = p (e - z),  u' = k0 p (e - z) + k1 z: the filter stands in front, so its input gives the derivative of the "
      "error (book figures 6.5 and 6.6). With constant gains this is (k0 + k1/s)/(s/p + 1). k0 belongs to the "
      "proportional part, k1 to the integral one; both are ports, so that they can follow an operating point without "
      "disturbing u.  With lower or upper u stands still at a limit while its rate points further out.";
  static constexpr auto icon = "(k0 + k1/s)/(s/p + 1)";
  static constexpr auto example = R"(
blocks:
  c: {type: velocity_pi, in: {e: 1 - plant, k0: 2, k1: 4}, p: 100}
  plant: {type: first_order, in: c, tau: 0.5}
simulation: {stop: 5}
expect: [{signal: plant, measure: final, value: 1, abs: 1e-3}]
)";

  Input e{this, "e", {.doc = "control error, set point minus measured value"}};
  Input k0{this, "k0", {.doc = "proportional gain", .init = 1}};
  Input k1{this, "k1", {.doc = "integral gain, per second", .init = 1}};
  Number p{this, "p", {.init = 100, .unit = "rad/s", .doc = "pole of the filter of the error", .above = 0}};
  Number initial_value{this, "initial", {.init = 0, .doc = "output at the start; may read signals", .initial = true}};
  Limits limits{this, "least value of the output", "greatest value of the output"};
  State z{this, "z", {.doc = "filtered error"}};
  State x{this, "u", {.doc = "output"}};
  Output u{this, "u", {.doc = "the control signal"}};
  Output filtered{this, "z", {.doc = "the filtered error"}};

  void check(Checking& checking) const override { limits.check(checking); }
  void initial(Now now, Init init) const override { init[x] = limits.clamp(now, now[initial_value]); }
  void outputs(Now now, Out out) const override {
    out[u] = now[x];
    out[filtered] = now[z];
  }
  void derivatives(Now now, Rates rate) const override {
    const Array zd = now[p] * (now[e] - now[z]);
    rate[z] = zd;
    rate[x] = limits.stand_still(now, now[x], now[k0] * zd + now[k1] * now[z]);
  }
  void jumps(Now now, Jumps jump) const override { limits.stop_at_limits(now, jump, x); }
};

}  // namespace

PLANTLOOP_BLOCK(velocity_pi, VelocityPi)

}  // namespace plantloop
