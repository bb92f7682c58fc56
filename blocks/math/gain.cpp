// A constant factor.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Gain final : Block {
  static constexpr auto summary = "Multiply the input by a number.";
  static constexpr auto details = "y = k u, element by element";
  static constexpr auto icon = "k";
  static constexpr auto example = R"(
blocks: {y: {type: gain, in: time, k: 3}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.5, value: 1.5}]
)";

  Input u{this, "u", {.doc = "signal to multiply"}};
  Number k{this, "k", {.init = 1, .doc = "factor"}};
  Output y{this, "y", {.doc = "the product"}};

  void outputs(Now now, Out out) const override { out[y] = now[k] * now[u]; }
};

}  // namespace

PLANTLOOP_BLOCK(gain, Gain)

}  // namespace plantloop
