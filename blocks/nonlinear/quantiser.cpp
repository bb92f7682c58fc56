// A signal rounded to steps.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Quantiser final : Block {
  static constexpr auto summary = "Round the input to multiples of an interval.";
  static constexpr auto details = "y = interval round(u/interval), halves away from zero";
  static constexpr auto example = R"(
blocks: {y: {type: quantiser, in: time, interval: 0.5}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.8, value: 1}]
)";

  Input u{this, "u", {.doc = "signal to round"}};
  Number interval{this, "interval", {.init = 1, .doc = "distance of two values of the output", .above = 0}};
  Output y{this, "y", {.doc = "the rounded signal"}};

  void outputs(Now now, Out out) const override { out[y] = now[interval] * round(now[u] / now[interval]); }
};

}  // namespace

PLANTLOOP_BLOCK(quantiser, Quantiser)

}  // namespace plantloop
