// A number.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Constant final : Block {
  static constexpr auto summary = "Give a number, vector or matrix.";
  static constexpr auto details = "y = value";

  Number value{this, "value", {.doc = "the number"}};
  Output y{this, "y", {.doc = "the number"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void outputs(Now now, Out out) const override { out[y] = now[value]; }
};

}  // namespace

PLANTLOOP_BLOCK(constant, Constant)

}  // namespace plantloop
