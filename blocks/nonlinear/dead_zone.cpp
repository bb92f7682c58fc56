// A signal that is felt only outside a zone.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct DeadZone final : Block {
  static constexpr auto summary = "Give nothing inside a zone, and what exceeds it outside.";
  static constexpr auto details = "y = u - lower below lower, u - upper above upper, 0 in between, element by element";
  static constexpr auto example = R"(
blocks:
  u: {type: sine, amplitude: 2}
  y: {type: dead_zone, in: u, lower: -0.5, upper: 0.5}
simulation: {stop: 2}
expect: [{signal: y, at: pi/2, value: 1.5, abs: 1e-9}]
)";

  Input u{this, "u", {.doc = "input"}};
  Number lower{this, "lower", {.init = -0.5, .doc = "lower end of the zone"}};
  Number upper{this, "upper", {.init = 0.5, .doc = "upper end of the zone"}};
  Output y{this, "y", {.doc = "what exceeds the zone"}};

  void check(Checking& checking) const override { check_order(checking, lower, upper, false); }
  void outputs(Now now, Out out) const override {
    const Array x = now[u];
    out[y] = where(x < now[lower], x - now[lower], where(x > now[upper], x - now[upper], 0.0));
  }
};

}  // namespace

PLANTLOOP_BLOCK(dead_zone, DeadZone)

}  // namespace plantloop
