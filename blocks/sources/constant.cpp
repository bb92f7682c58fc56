// A number.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Constant final : Block {
  static constexpr auto summary = "Give a number, vector or matrix.";
  static constexpr auto details = "y = value";
  static constexpr auto example = R"(
blocks: {c: {type: constant, value: [2.5, 4]}}
simulation: {stop: 1}
expect: [{signal: c.1, at: 0.5, value: 2.5}]
)";

  Number value{this, "value", {.doc = "the number"}};
  Output y{this, "y", {.doc = "the number"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void outputs(Now now, Out out) const override { out[y] = now[value]; }
};

}  // namespace

PLANTLOOP_BLOCK(constant, Constant)

}  // namespace plantloop
