// Rectangular pulses.

#include "engine/block_parts.h"

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
  RectangularWave wave{this};
  Number bias{this, "bias", {.init = 0, .doc = "value between the pulses"}};
  Output y{this, "y", {.doc = "the pulses"}};

  void check(Checking& checking) const override { wave.check(checking); }
  void outputs(Now now, Out out) const override {
    out[y] = now[bias] + where(wave.is_up(now), now[amplitude], Array(0.0));
  }
};

}  // namespace

PLANTLOOP_BLOCK(pulse, Pulse)

}  // namespace plantloop
