// A comparison of two signals.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Compare final : Block {
  static constexpr auto summary = "Compare two signals.";
  static constexpr auto details = "y = 1 where u and v compare so, else 0, element by element";
  static constexpr auto example = R"(
blocks: {y: {type: compare, in: {u: time, v: 0.5}, operator: greater}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.7, value: 1}]
)";

  Input u{this, "u", {.doc = "left side"}};
  Input v{this, "v", {.doc = "right side", .init = 0}};
  Choice op{this,
            "operator",
            {.of = {"greater", "greater_equal", "less", "less_equal", "equal", "not_equal"}, .doc = "what u is to v"}};
  Output y{this, "y", {.doc = "1 or 0"}};

  void outputs(Now now, Out out) const override { out[y] = compared(now[u], now[v]).array; }

 private:
  Truths compared(const Array& a, const Array& b) const {
    if (op.is("greater")) return a > b;
    if (op.is("greater_equal")) return a >= b;
    if (op.is("less")) return a < b;
    if (op.is("less_equal")) return a <= b;
    return op.is("equal") ? equal(a, b) : !equal(a, b);
  }
};

}  // namespace

PLANTLOOP_BLOCK(compare, Compare)

}  // namespace plantloop
