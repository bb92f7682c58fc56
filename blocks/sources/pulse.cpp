// Rectangular pulses.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Pulse final : Block {
  static constexpr auto summary = "Give a train of rectangular pulses.";
  static constexpr auto details =
      "y = bias + amplitude while delay + k period <= time < delay + k period + width, k = 0, 1, ..., else bias";
  static constexpr auto example = R"(
blocks: {u: {type: pulse, amplitude: 2, period: 1, width: 0.25}}
simulation: {stop: 3}
expect:
  - {signal: u, at: 1.1, value: 2}
  - {signal: u, at: 1.5, value: 0}
)";

  Number amplitude{this, "amplitude", {.init = 1, .doc = "height of the pulses"}};
  Number period{this,
                "period",
                {.init = 1, .unit = "s", .doc = "time from one rising edge to the next", .above = 0, .size = scalar}};
  Number width{this,
               "width",
               {.unit = "s",
                .doc = "time at the upper value, at most the period; default: half the period",
                .min = 0,
                .size = scalar,
                .optional = true}};
  Number delay{this, "delay", {.init = 0, .unit = "s", .doc = "time of the first rising edge", .size = scalar}};
  Number bias{this, "bias", {.init = 0, .doc = "value between the pulses"}};
  Output y{this, "y", {.doc = "the pulses"}};

  void check(Checking& checking) const override {
    const auto wide = checking.of(width), time = checking.of(period);
    if (!wide.empty() && !time.empty() && wide[0] > time[0])
      checking.problem(width, "the width is longer than the period");
  }

  void outputs(Now now, Out out) const override {
    // Rising edges lead falling ones by one while the upper value holds.
    const Value length = now[period][0], high = now.given(width) ? now[width][0] : 0.5 * length;
    const Value risen = beats(now[delay][0], length), fallen = beats(now[delay][0] + high, length);
    const Truth up = risen > fallen || (high >= length && risen > 0.0);
    out[y] = now[bias] + where(up, now[amplitude], Array(0.0));
  }
};

}  // namespace

PLANTLOOP_BLOCK(pulse, Pulse)

}  // namespace plantloop
