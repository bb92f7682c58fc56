// Dry and viscous friction.
//
// While parts stick, friction equals the force that would move them; `direction` remembers which way they slip, or that
// they stick.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct CoulombFriction final : Block {
  static constexpr auto summary = "Give the force of dry and viscous friction, with sticking where the force is known.";
  static constexpr auto details =
      "While parts slip, y = coulomb sign(v) + viscous v, to be subtracted from the other forces. With the port "
      "`force`, the sum of those, parts stick when v reaches 0: y = force, so nothing accelerates, until |force| "
      "exceeds `static`, and then they slip in its direction: in: {v: v, force: F}, v' = (F - y)/m. Without it y is 0 "
      "at v = 0 and jumps there.";
  static constexpr auto example = R"(
title: A block slows down on a table and sticks
blocks:
  v: {type: integrator, in: force - friction, initial: 2}
  force: {type: ramp, start: 2}
  friction: {type: coulomb_friction, in: {v: v, force: force}, coulomb: 2, static: 3}
simulation: {stop: 6}
expect:
  - {signal: v, at: 0.5, value: 1, abs: 1e-9}
  - {signal: v, at: 4, value: 0, abs: 1e-9}
  - {signal: v, at: 6, value: 1.5, abs: 1e-6}
)";

  Input v{this, "v", {.doc = "relative speed of the parts"}};
  Input force{this, "force", {.doc = "sum of all other forces; not connected: parts do not stick", .init = 0}};
  Number coulomb{
      this, "coulomb", {.init = 1, .doc = "friction of slipping parts, without its viscous share", .min = 0}};
  Number viscous{this, "viscous", {.init = 0, .doc = "friction per speed", .min = 0}};
  Number static_friction{
      this, "static", {.doc = "greatest friction of parts that stick; default: coulomb", .min = 0, .optional = true}};
  Discrete direction{this, "direction", {.doc = "1 or -1 while slipping, 0 while sticking"}};
  Output y{this, "y", {.doc = "the friction force"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void check(Checking& checking) const override {
    if (checking.given(static_friction)) check_order(checking, coulomb, static_friction, false);
  }

  void initial(Now now, Init init) const override {
    if (!now.connected(force)) return;
    init[direction] = where(now[v] > 0.0, 1.0, where(now[v] < 0.0, -1.0, breakaway(now)));
  }
  void outputs(Now now, Out out) const override {
    if (!now.connected(force)) {
      out[y] = now[coulomb] * sign(now[v]) + now[viscous] * now[v];
      return;
    }
    const Array way = value(now);
    out[y] = where(equal(way, 0.0), now[force], way * now[coulomb] + now[viscous] * now[v]);
  }
  void update(Now now, Next next) const override {
    if (now.connected(force)) next[direction] = value(now);
  }
  void jumps(Now now, Jumps jump) const override {
    if (is_sampled(now) || !now.connected(force)) return;
    const Array way = now[direction];
    // While parts do not slip that way, the speed is taken to be on the side that it would come from: the next slip may
    // start with a rounding error of the wrong sign.
    jump.when(crossing(where(way > 0.5, now[v], -1.0), Direction::falling)).set(direction, breakaway(now));
    jump.when(crossing(where(way < -0.5, now[v], 1.0), Direction::rising)).set(direction, breakaway(now));
    const Array nearest = abs(now[force]) - greatest_static(now);
    jump.when(crossing(where(equal(way, 0.0), nearest, -1.0), Direction::rising)).set(direction, sign(now[force]));
  }

 private:
  Array greatest_static(Now now) const { return now.given(static_friction) ? now[static_friction] : now[coulomb]; }
  // The way in which resting parts go.
  Array breakaway(Now now) const {
    return where(now[force] > greatest_static(now), 1.0, where(now[force] < -greatest_static(now), -1.0, 0.0));
  }
  Array value(Now now) const {
    if (!is_sampled(now)) return now[direction];
    return where(now[direction] * now[v] <= 0.0, breakaway(now), now[direction]);
  }
};

}  // namespace

PLANTLOOP_BLOCK(coulomb_friction, CoulombFriction)

}  // namespace plantloop
