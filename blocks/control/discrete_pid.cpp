// A sampled PID controller.

#include "engine/block.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct DiscretePid final : Block {
  static constexpr auto summary = "Control samples by a proportional, an integral and a derivative part.";
  static constexpr auto details =
      "With the period T: raw = kp e + I + kd d,  u = raw between lower and upper.  method, of the integral: forward I "
      "= x, backward I = x + T ki e, trapezoidal I = x + T ki e/2; each time x+ = x + T ki e.  filter_method, of the "
      "derivative d = N (e - s), s the integral of d: forward needs N T < 2 to be stable, backward and trapezoidal are "
      "so always. s starts at e, so the derivative part starts at 0.  What a limit cuts off would wind up the "
      "integral; anti_windup tracking: x+ gets T (u - raw)/t_track more, with the port `track`, what the actuator "
      "really did, in the place of u;  clamp: the integral itself stays within the limits;  none: nothing is done.  "
      "The gains are ports with defaults, so they can be scheduled.";
  static constexpr auto example = R"(
blocks:
  c: {type: discrete_pid, in: 1 - plant, kp: 2, ki: 4, lower: 0, upper: 3, rate: 0.05}
  plant: {type: first_order, in: c, tau: 0.5}
simulation: {stop: 5}
expect: [{signal: plant, measure: final, value: 1, abs: 1e-3}]
)";

  Input e{this, "e", {.doc = "control error, set point minus measured value"}};
  Input kp{this, "kp", {.doc = "proportional gain", .init = 1}};
  Input ki{this, "ki", {.doc = "integral gain, per second", .init = 1}};
  Input kd{this, "kd", {.doc = "derivative gain, in seconds", .init = 0}};
  Number N{this, "N", {.init = 100, .unit = "rad/s", .doc = "pole of the derivative's filter", .above = 0}};
  Choice method{
      this, "method", {.of = {"forward", "backward", "trapezoidal"}, .doc = "how the integral counts a sample"}};
  Choice filter_method{
      this,
      "filter_method",
      {.of = {"backward", "forward", "trapezoidal"}, .doc = "how the derivative's filter counts a sample"}};
  AntiWindup anti_windup{this};
  Discrete x{this, "I", {.doc = "integral of the samples before"}};
  Discrete s{this, "x", {.doc = "filtered error"}};
  Output u{this, "u", {.doc = "the limited output"}};
  Output integral{this, "integral", {.doc = "its integral part"}};

  void check(Checking& checking) const override { anti_windup.check(checking); }
  void initial(Now now, Init init) const override {
    init[x] = anti_windup.start(now);
    init[s] = now[e];
  }
  void outputs(Now now, Out out) const override {
    out[u] = anti_windup.limits.clamp(now, raw(now));
    out[integral] = integral_now(now);
  }
  void update(Now now, Next next) const override {
    next[x] = anti_windup.within(now, now[x] + now.period() * now[ki] * now[e]) +
              now.period() * anti_windup.correction(now, raw(now));
    next[s] = now[s] + now.period() * derivative(now);
  }

 private:
  // The part of a period that a sample counts for at once; the rest counts from the next hit on.
  static double at_once(const Choice& how) { return how.is("forward") ? 0 : how.is("backward") ? 1 : 0.5; }
  Array integral_now(Now now) const {
    return anti_windup.within(now, now[x] + at_once(method) * now.period() * now[ki] * now[e]);
  }
  Array derivative(Now now) const {
    return now[N] * (now[e] - now[s]) / (1.0 + at_once(filter_method) * now.period() * now[N]);
  }
  Array raw(Now now) const { return now[kp] * now[e] + integral_now(now) + now[kd] * derivative(now); }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_pid, DiscretePid)

}  // namespace plantloop
