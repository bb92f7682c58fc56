// A PID controller.

#include "engine/block.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct Pid final : Block {
  static constexpr auto summary = "Control by a proportional, an integral and a derivative part.";
  static constexpr auto details =
      "raw = kp e + I + kd d,  I' = ki e,  d = N (e - x), x' = d,  u = raw between lower and upper: kp + ki/s + kd N "
      "s/(s + N). x starts at e, so the derivative part starts at 0.  What a limit cuts off would wind up the "
      "integral; anti_windup tracking: I' = ki e + (u - raw)/t_track, with the port `track`, what the actuator really "
      "did, in the place of u, so that another limit or a switch to manual control is followed too;  clamp: the "
      "integral itself stays within the limits;  none: nothing is done.  The gains are ports with defaults, so they "
      "can be scheduled: in: {e: w - y, kp: gains.kp}.";
  static constexpr auto icon = "kp + ki/s + kd*N*s/(s + N)";
  static constexpr auto example = R"(
blocks:
  c: {type: pid, in: 1 - plant, kp: 4, ki: 1, kd: 2}
  plant: {type: transfer_function, in: c, num: [1], den: [1, 1, 0]}
simulation: {stop: 20}
expect: [{signal: plant, measure: final, value: 1, abs: 0.02}]
)";

  Input e{this, "e", {.doc = "control error, set point minus measured value"}};
  Input kp{this, "kp", {.doc = "proportional gain", .init = 1}};
  Input ki{this, "ki", {.doc = "integral gain, per second", .init = 1}};
  Input kd{this, "kd", {.doc = "derivative gain, in seconds", .init = 0}};
  Number N{this, "N", {.init = 100, .unit = "rad/s", .doc = "pole of the derivative's filter", .above = 0}};
  AntiWindup anti_windup{this};
  State I{this, "I", {.doc = "integral part"}};
  State x{this, "x", {.doc = "filtered error"}};
  Output u{this, "u", {.doc = "the limited output"}};
  Output integral{this, "integral", {.doc = "its integral part"}};

  void check(Checking& checking) const override { anti_windup.check(checking); }
  void initial(Now now, Init init) const override {
    init[I] = anti_windup.start(now);
    init[x] = now[e];
  }
  void outputs(Now now, Out out) const override {
    out[u] = anti_windup.limits.clamp(now, raw(now));
    out[integral] = now[I];
  }
  void derivatives(Now now, Rates rate) const override {
    Array change = now[ki] * now[e];
    if (anti_windup.clamps()) change = anti_windup.limits.stand_still(now, now[I], change);
    rate[I] = change + anti_windup.correction(now, raw(now));
    rate[x] = derivative(now);
  }
  void jumps(Now now, Jumps jump) const override {
    if (anti_windup.clamps()) anti_windup.limits.stop_at_limits(now, jump, I);
  }

 private:
  Array derivative(Now now) const { return now[N] * (now[e] - now[x]); }
  Array raw(Now now) const { return now[kp] * now[e] + now[I] + now[kd] * derivative(now); }
};

}  // namespace

PLANTLOOP_BLOCK(pid, Pid)

}  // namespace plantloop
