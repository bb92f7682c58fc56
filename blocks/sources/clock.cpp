// The simulated time.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Clock final : Block {
  static constexpr auto summary = "Give the simulated time.";
  static constexpr auto details = "y = time";
  static constexpr auto example = R"(
blocks: {t: {type: clock}}
simulation: {stop: 1}
expect: [{signal: t, at: 0.5, value: 0.5}]
)";

  Output y{this, "y", {.doc = "the time", .unit = "s", .size = scalar}};

  void outputs(Now now, Out out) const override { out[y] = now.time(); }
};

}  // namespace

PLANTLOOP_BLOCK(clock, Clock)

}  // namespace plantloop
