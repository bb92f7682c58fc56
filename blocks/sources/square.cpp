// A square wave.

#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct Square final : Block {
  static constexpr auto summary = "Give a square wave.";
  static constexpr auto details =
      "y = bias + amplitude while delay + k period <= time < delay + k period + width, k = 0, 1, ..., else bias - "
      "amplitude";
  static constexpr auto example = R"(
blocks: {u: {type: square, amplitude: 3, period: 1}}
simulation: {stop: 2}
expect:
  - {signal: u, at: 0.25, value: 3}
  - {signal: u, at: 0.75, value: -3}
)";

  Number amplitude{this, "amplitude", {.init = 1, .doc = "distance of both values from the bias"}};
  RectangularWave wave{this};
  Number bias{this, "bias", {.init = 0, .doc = "mean of both values"}};
  Output y{this, "y", {.doc = "the wave"}};

  void check(Checking& checking) const override { wave.check(checking); }
  void outputs(Now now, Out out) const override {
    out[y] = now[bias] + where(wave.is_up(now), now[amplitude], -now[amplitude]);
  }
};

}  // namespace

PLANTLOOP_BLOCK(square, Square)

}  // namespace plantloop
