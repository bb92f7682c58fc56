// A PI controller.

#include "engine/block.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct Pi final : Block {
  static constexpr auto summary = "Control by a proportional and an integral part.";
  static constexpr auto details =
      "raw = kp e + I,  I' = ki e,  u = raw between lower and upper.  What a limit cuts off would wind up the "
      "integral; anti_windup tracking: I' = ki e + (u - raw)/t_track, with the port `track`, what the actuator really "
      "did, in the place of u, so that another limit or a switch to manual control is followed too;  clamp: the "
      "integral itself stays within the limits;  none: nothing is done.  The gains are ports with defaults, so they "
      "can be scheduled: in: {e: w - y, kp: gains.kp}.";
  static constexpr auto icon = "kp + ki/s";
  static constexpr auto example = R"(
blocks:
  c: {type: pi, in: 1 - plant, kp: 2, ki: 4, lower: 0, upper: 3}
  plant: {type: first_order, in: c, tau: 0.5}
simulation: {stop: 5}
expect: [{signal: plant, measure: final, value: 1, abs: 1e-3}]
)";

  Input e{this, "e", {.doc = "control error, set point minus measured value"}};
  Input kp{this, "kp", {.doc = "proportional gain", .init = 1}};
  Input ki{this, "ki", {.doc = "integral gain, per second", .init = 1}};
  AntiWindup anti_windup{this};
  State I{this, "I", {.doc = "integral part"}};
  Output u{this, "u", {.doc = "the limited output"}};
  Output integral{this, "integral", {.doc = "its integral part"}};

  void check(Checking& checking) const override { anti_windup.check(checking); }
  void initial(Now now, Init init) const override { init[I] = anti_windup.start(now); }
  void outputs(Now now, Out out) const override {
    out[u] = anti_windup.limits.clamp(now, raw(now));
    out[integral] = now[I];
  }
  void derivatives(Now now, Rates rate) const override {
    Array change = now[ki] * now[e];
    if (anti_windup.clamps()) change = anti_windup.limits.stand_still(now, now[I], change);
    rate[I] = change + anti_windup.correction(now, raw(now));
  }
  void jumps(Now now, Jumps jump) const override {
    if (anti_windup.clamps()) anti_windup.limits.stop_at_limits(now, jump, I);
  }

 private:
  Array raw(Now now) const { return now[kp] * now[e] + now[I]; }
};

}  // namespace

PLANTLOOP_BLOCK(pi, Pi)

}  // namespace plantloop
