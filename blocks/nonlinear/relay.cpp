// A switch with hysteresis.
//
// Whether it is on is a discrete state: of a continuous input it changes at located crossings, of a sampled one at
// hits.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Relay final : Block {
  static constexpr auto summary = "Switch on and off at two different values.";
  static constexpr auto details =
      "The relay goes on when u reaches `on` from below and off when u falls to `off`; in between it stays as it is. "
      "y = on_value while it is on, else off_value. At the start it is on if u >= on, unless `initial` says.";
  static constexpr auto example = R"(
title: A thermostat
blocks:
  heater: {type: relay, in: 20 - T, on: 0.5, off: -0.5, on_value: 5}
  T: {type: first_order, in: 10 + 4*heater, tau: 10, initial: 15}
simulation: {stop: 60}
expect: [{signal: T, measure: max, value: 20.5, abs: 1e-6}, {signal: T, measure: min, from: 10, value: 19.5, abs: 1e-6}]
)";

  Input u{this, "u", {.doc = "what switches"}};
  Number on{this, "on", {.init = 1, .doc = "it goes on here"}};
  Number off{this, "off", {.init = 0, .doc = "it goes off here"}};
  Number on_value{this, "on_value", {.init = 1, .doc = "output while on"}};
  Number off_value{this, "off_value", {.init = 0, .doc = "output while off"}};
  Number initial_value{
      this,
      "initial",
      {.doc = "on at the start if greater than 0; may read signals", .optional = true, .initial = true}};
  Discrete state{this, "state", {.doc = "1 while on, else 0"}};
  Output y{this, "y", {.doc = "on_value or off_value"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void check(Checking& checking) const override { check_order(checking, off, on, false); }

  void initial(Now now, Init init) const override {
    init[state] = now.given(initial_value) ? (now[initial_value] > 0.0).array : (now[u] >= now[on]).array;
  }
  void outputs(Now now, Out out) const override { out[y] = where(is_on(now) > 0.5, now[on_value], now[off_value]); }
  void update(Now now, Next next) const override { next[state] = is_on(now); }

  void jumps(Now now, Jumps jump) const override {
    if (is_sampled(now)) return;
    jump.when(crossing(now[u] - now[on], Direction::rising)).set(state, Array(now[state].shape(), 1.0));
    jump.when(crossing(now[u] - now[off], Direction::falling)).set(state, Array(now[state].shape(), 0.0));
  }

 private:
  Array is_on(Now now) const {
    if (!is_sampled(now)) return now[state];
    return where(now[u] >= now[on], 1.0, where(now[u] <= now[off], 0.0, now[state]));
  }
};

}  // namespace

PLANTLOOP_BLOCK(relay, Relay)

}  // namespace plantloop
