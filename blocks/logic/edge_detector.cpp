// The samples at which a condition changes.

#include "engine/block.h"

namespace plantloop {
namespace {

struct EdgeDetector final : Block {
  static constexpr auto summary = "Say at which samples a condition begins or ends to hold.";
  static constexpr auto details =
      "y[k] = 1 where u[k] > 0 and u[k-1] <= 0 (edge rising), the other way round (falling), or either, else 0. At the "
      "first sample it is 0. An edge between samples lasts no time: for events of continuous signals there are counter "
      "and hit_crossing.";
  static constexpr auto example = R"(
blocks:
  button: {type: pulse, period: 5, width: 2, delay: 1}
  pressed: {type: edge_detector, in: button, rate: 0.5}
simulation: {stop: 5}
expect:
  - {signal: pressed, at: 1, value: 1}
  - {signal: pressed, at: 1.5, value: 0}
)";

  Input u{this, "u", {.doc = "the condition: holds while greater than 0"}};
  Choice edge{this, "edge", {.of = {"rising", "falling", "either"}, .doc = "which changes count"}};
  Discrete was{this, "was", {.init = -1, .doc = "1 if u held at the last sample, 0 if not, -1 before the first"}};
  Output y{this, "y", {.doc = "1 at an edge, else 0"}};

  void outputs(Now now, Out out) const override {
    const Truths holds = now[u] > 0.0, rising = holds && equal(now[was], 0.0), falling = !holds && equal(now[was], 1.0);
    out[y] = edge.is("rising") ? rising.array : edge.is("falling") ? falling.array : (rising || falling).array;
  }
  void update(Now now, Next next) const override { next[was] = (now[u] > 0.0).array; }
};

}  // namespace

PLANTLOOP_BLOCK(edge_detector, EdgeDetector)

}  // namespace plantloop
