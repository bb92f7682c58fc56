// Straight rises and falls that repeat: a sawtooth, or a triangle.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Sawtooth final : Block {
  static constexpr auto summary = "Give a sawtooth or triangle wave.";
  static constexpr auto details =
      "From `delay` on y rises evenly from bias - amplitude to bias + amplitude during `width`, falls back evenly "
      "during the rest of the period, and so on; before, it is bias - amplitude. As wide as the period it is a "
      "sawtooth that drops at once, half as wide a triangle, with width 0 a falling sawtooth. The corners are stops of "
      "the solver.";
  static constexpr auto example = R"(
blocks:
  saw: {type: sawtooth, period: 2}
  triangle: {type: sawtooth, period: 2, width: 1}
simulation: {stop: 4}
expect:
  - {signal: saw, at: 1.5, value: 0.5, abs: 1e-12}
  - {signal: triangle, at: 1.5, value: 0, abs: 1e-12}
)";

  Number amplitude{this, "amplitude", {.init = 1, .doc = "greatest distance from the bias"}};
  Number period{
      this, "period", {.init = 1, .unit = "s", .doc = "time from one rise to the next", .above = 0, .size = scalar}};
  Number width{this,
               "width",
               {.unit = "s",
                .doc = "time that a rise takes, at most the period; default: the period",
                .min = 0,
                .size = scalar,
                .optional = true}};
  Number delay{this, "delay", {.init = 0, .unit = "s", .doc = "time of the first rise", .size = scalar}};
  Number bias{this, "bias", {.init = 0, .doc = "mean value"}};
  Output y{this, "y", {.doc = "the wave"}};

  void check(Checking& checking) const override {
    const auto wide = checking.of(width), time = checking.of(period);
    if (!wide.empty() && !time.empty() && wide[0] > time[0])
      checking.problem(width, "the width is longer than the period");
  }

  void outputs(Now now, Out out) const override {
    const Value length = now[period][0], rise = now.given(width) ? now[width][0] : length, start = now[delay][0];
    const Value risen = beats(start, length), turned = beats(start + rise, length);
    const Value age = now.time() - (start + (risen - 1.0) * length);
    // Rises lead turns by one while the wave rises. A rise as long as the period turns when the next one begins.
    const Truth rising = risen > turned || rise >= length;
    const Value rises = where(rise > 0.0, 2.0 * age / rise - 1.0, Value(1));
    const Value falls = where(rise < length, 1.0 - 2.0 * (age - rise) / (length - rise), Value(1));
    out[y] = now[bias] + now[amplitude] * where(risen > 0.0, where(rising, rises, falls), Value(-1));
  }
};

}  // namespace

PLANTLOOP_BLOCK(sawtooth, Sawtooth)

}  // namespace plantloop
