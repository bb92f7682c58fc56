// A step at a given time.

#include "engine/block.h"

namespace plantloop {
namespace {

struct StepSource final : Block {
  static constexpr auto summary = "Change from one value to another at a given time.";
  static constexpr auto details =
      "y = before while time < time, then after; with time <= start it is after from the start";
  static constexpr auto example = R"(
blocks: {u: {type: step, time: 1, after: 5}}
simulation: {stop: 2}
expect:
  - {signal: u, at: 1, value: 5}
  - {signal: u, at: 1, side: left, value: 0}
)";

  Number at{this, "time", {.init = 0, .unit = "s", .doc = "when the step happens", .size = scalar}};
  Number before{this, "before", {.init = 0, .doc = "value before the step"}};
  Number after{this, "after", {.init = 1, .doc = "value from the step on"}};
  Output y{this, "y", {.doc = "the step"}};

  void outputs(Now now, Out out) const override { out[y] = where(segment(now[at]) > 0.0, now[after], now[before]); }
};

}  // namespace

PLANTLOOP_BLOCK(step, StepSource)

}  // namespace plantloop
