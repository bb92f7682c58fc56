// The limits of controllers, and rectangular waves.

#include "engine/block_parts.h"

namespace plantloop {

AntiWindup::AntiWindup(Block* block)
    : track(block, "track", {.doc = "what the actuator did, for anti_windup tracking; default: u", .init = 0}),
      limits(block, "least value of the output", "greatest value of the output"),
      method(block, "anti_windup",
             {.of = {"tracking", "clamp", "none"}, .doc = "what happens to the integral at a limit"}),
      t_track(block, "t_track",
              {.init = 1, .unit = "s", .doc = "time constant with which the integral follows a limit", .above = 0}),
      initial_value(block, "initial", {.init = 0, .doc = "integral at the start; may read signals", .initial = true}) {}

Array AntiWindup::correction(Now now, const Array& raw) const {
  if (!method.is("tracking")) return Array(0.0);
  if (now.connected(track)) return (now[track] - raw) / now[t_track];
  return limits.given(now) ? (limits.clamp(now, raw) - raw) / now[t_track] : Array(0.0);
}

RectangularWave::RectangularWave(Block* block)
    : period(
          block, "period",
          {.init = 1, .unit = "s", .doc = "time from one rising edge to the next", .above = 0, .size = Block::scalar}),
      width(block, "width",
            {.unit = "s",
             .doc = "time at the upper value, at most the period; default: half the period",
             .min = 0,
             .size = Block::scalar,
             .optional = true}),
      delay(block, "delay", {.init = 0, .unit = "s", .doc = "time of the first rising edge", .size = Block::scalar}) {}

void RectangularWave::check(Checking& checking) const {
  const auto wide = checking.of(width), time = checking.of(period);
  if (!wide.empty() && !time.empty() && wide[0] > time[0])
    checking.problem(width, "the width is longer than the period");
}

Truth RectangularWave::is_up(Now now) const {
  // Rising edges lead falling ones by one while the upper value holds.
  const Value length = now[period][0], high = now.given(width) ? now[width][0] : 0.5 * length;
  const Value risen = beats(now[delay][0], length), fallen = beats(now[delay][0] + high, length);
  return risen > fallen || (high >= length && risen > 0.0);
}

}  // namespace plantloop
