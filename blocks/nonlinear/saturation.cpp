// Limits on a signal.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Saturation final : Block {
  static constexpr auto summary = "Keep the input between two limits.";
  static constexpr auto details = "y = min(max(u, lower), upper), element by element";
  static constexpr auto example = R"(
blocks:
  u: {type: sine, amplitude: 2}
  y: {type: saturation, in: u, lower: -1, upper: 1}
simulation: {stop: 2}
expect: [{signal: y, at: pi/2, value: 1}]
)";

  Input u{this, "u", {.doc = "signal to limit"}};
  Number lower{this, "lower", {.init = -unbounded, .doc = "least value of the output"}};
  Number upper{this, "upper", {.init = unbounded, .doc = "greatest value of the output"}};
  Output y{this, "y", {.doc = "the limited signal"}};

  void check(Checking& checking) const override { check_order(checking, lower, upper, false); }
  void outputs(Now now, Out out) const override { out[y] = min(max(now[u], now[lower]), now[upper]); }
};

}  // namespace

PLANTLOOP_BLOCK(saturation, Saturation)

}  // namespace plantloop
