// Conditions put together.

#include <cstddef>
#include <vector>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Logic final : Block {
  static constexpr auto summary = "Combine conditions.";
  static constexpr auto details =
      "y is 1 where the combination holds, else 0; a signal counts as true where it is greater than 0. xor holds when "
      "an odd number of signals is true. A single input that is a vector is combined over its elements.";
  static constexpr auto example = R"(
blocks: {y: {type: logic, in: [time > 0.25, time < 0.75], operator: and}}
simulation: {stop: 1}
expect:
  - {signal: y, at: 0.5, value: 1}
  - {signal: y, at: 0.8, value: 0}
)";

  Inputs terms{this, "terms", {.doc = "the conditions; in: [a, b, ...]"}};
  Choice op{this, "operator", {.of = {"and", "or", "not", "xor", "nand", "nor"}, .doc = "how they are combined"}};
  Output y{this, "y", {.doc = "1 or 0"}};

  void sizes(Sizing& sizing) const override {
    const auto shapes = sizing.of(terms);
    if (!op.is("not") ||
        (shapes.size() == 1 && (!shapes[0].is_known() || shapes[0].size() == 1 || sizing.of(y).size() > 1)))
      return;
    sizing.problem(op, "not takes one condition; in: [flags] turns each element of a vector");
  }

  void outputs(Now now, Out out) const override {
    const std::vector<Array> values = now[terms];
    Truths total = values[0] > 0.0;
    for (std::size_t i = 1; i < values.size(); ++i) total = combined(total, values[i] > 0.0);
    const bool turned = op.is("not") || op.is("nand") || op.is("nor");
    out[y] = turned ? (!total).array : total.array;
  }

 private:
  Truths combined(const Truths& a, const Truths& b) const {
    if (op.is("or") || op.is("nor")) return a || b;
    if (op.is("xor")) return (a && !b) || (!a && b);
    return a && b;
  }
};

}  // namespace

PLANTLOOP_BLOCK(logic, Logic)

}  // namespace plantloop
