// A signal sampled at hits and held in between.

#include "engine/block.h"

namespace plantloop {
namespace {

struct ZeroOrderHold final : Block {
  static constexpr auto summary = "Sample the input and hold it until the next sample.";
  static constexpr auto details = "y(t) = u(t_k) for t_k <= t < t_{k+1}, t_k the hits of the block's rate";
  static constexpr auto example = R"(
blocks: {y: {type: zero_order_hold, in: time, rate: 0.5}}
simulation: {stop: 2}
expect: [{signal: y, at: 0.9, value: 0.5}]
)";

  Input u{this, "u", {.doc = "signal to sample"}};
  Output y{this, "y", {.doc = "the held samples"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void outputs(Now now, Out out) const override { out[y] = now[u]; }
};

}  // namespace

PLANTLOOP_BLOCK(zero_order_hold, ZeroOrderHold)

}  // namespace plantloop
