// Signals put together to one vector.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Concat final : Block {
  static constexpr auto summary = "Join signals to one vector.";
  static constexpr auto details =
      "y = [u1, u2, ...], in the order of the sequence; vectors are taken apart into their elements";
  static constexpr auto example = R"(
blocks: {y: {type: concat, in: [time, [1, 2]]}}
simulation: {stop: 1}
expect: [{signal: y.3, at: 0.5, value: 2}]
)";

  Input u{this, "u", {.doc = "what to join; in: [a, b, ...]", .size = any_size}};
  Output y{this, "y", {.doc = "the vector", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    if (sizing.of(u).is_known()) sizing.set(y, Shape::vector(sizing.of(u).size()));
  }
  void outputs(Now now, Out out) const override { out[y] = now[u].spread(Shape::vector(now[u].size())); }
};

}  // namespace

PLANTLOOP_BLOCK(concat, Concat)

}  // namespace plantloop
