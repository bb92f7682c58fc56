// A PI controller.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Pi final : Block {
  static constexpr auto summary = "Control by a proportional and an integral part.";
  static constexpr auto details =
      "raw = kp e + I,  I' = ki e,  u = raw between lower and upper.  What a limit cuts off would wind up the "
      "integral; "
      "anti_windup tracking: I' = ki e + (u - raw)/t_track, with the port `track`, what the actuator really did, in "
      "the place of u, so that another limit or a switch to manual "
      "control is followed too;  clamp: the integral itself stays within the limits;  "
      "none: nothing is "
      "done.  The gains are ports with defaults, so they can be scheduled: in: {e: w - y, kp: gains.kp}.";
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
  Input track{this, "track", {.doc = "what the actuator did, for anti_windup tracking; default: u", .init = 0}};
  Limits limits{this, "least value of the output", "greatest value of the output"};
  Choice anti_windup{
      this, "anti_windup", {.of = {"tracking", "clamp", "none"}, .doc = "what happens to the integral at a limit"}};
  Number t_track{this,
                 "t_track",
                 {.init = 1, .unit = "s", .doc = "time constant with which the integral follows a limit", .above = 0}};
  Number initial_value{this, "initial", {.init = 0, .doc = "integral at the start; may read signals", .initial = true}};
  State I{this, "I", {.doc = "integral part"}};
  Output u{this, "u", {.doc = "the limited output"}};
  Output integral{this, "integral", {.doc = "its integral part"}};

  void check(Checking& checking) const override { limits.check(checking); }
  void initial(Now now, Init init) const override {
    init[I] = anti_windup.is("clamp") ? limits.clamp(now, now[initial_value]) : now[initial_value];
  }
  void outputs(Now now, Out out) const override {
    out[u] = limits.clamp(now, raw(now));
    out[integral] = now[I];
  }
  void derivatives(Now now, Rates rate) const override {
    Array change = now[ki] * now[e];
    if (anti_windup.is("clamp")) change = limits.stand_still(now, now[I], change);
    if (anti_windup.is("tracking")) change = change + excess(now) / now[t_track];
    rate[I] = change;
  }
  void jumps(Now now, Jumps jump) const override {
    if (anti_windup.is("clamp")) limits.stop_at_limits(now, jump, I);
  }

 private:
  // What was done beyond what was wanted: below 0 at an upper limit.
  Array excess(Now now) const {
    if (now.connected(track)) return now[track] - raw(now);
    return limits.given(now) ? limits.clamp(now, raw(now)) - raw(now) : Array(0.0);
  }
  Array raw(Now now) const { return now[kp] * now[e] + now[I]; }
};

}  // namespace

PLANTLOOP_BLOCK(pi, Pi)

}  // namespace plantloop
