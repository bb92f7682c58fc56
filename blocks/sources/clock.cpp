// The simulated time.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Clock final : Block {
  static constexpr auto summary = "Give the simulated time.";
  static constexpr auto details = "y = time";

  Output y{this, "y", {.doc = "the time", .unit = "s", .size = scalar}};

  void outputs(Now now, Out out) const override { out[y] = now.time(); }
};

}  // namespace

PLANTLOOP_BLOCK(clock, Clock)

}  // namespace plantloop
