// The product of any number of signals.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Product final : Block {
  static constexpr auto summary = "Multiply signals, or divide by some of them.";
  static constexpr auto details =
      "y = u1 u2 ..., element by element. operations: \"*/\" divides by the second one. A single input that is a "
      "vector is multiplied over its elements.";
  static constexpr auto example = R"(
blocks: {y: {type: product, in: [time, 4, 2], operations: "**/"}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.5, value: 1}]
)";

  Inputs factors{this, "factors", {.doc = "what to multiply; in: [a, b, ...]"}};
  Text operations{this, "operations", {.doc = "one * or / for each factor, \"*/\"; none: all are multiplied"}};
  Output y{this, "y", {.doc = "the product"}};

  void sizes(Sizing& sizing) const override {
    const std::string text = operations.value();
    if (text.find_first_not_of("*/") != std::string::npos) {
      return sizing.problem(operations, "operations are written with * and / only, as in \"*/\"");
    }
    const auto shapes = sizing.of(factors);
    const std::size_t given = text.size(), expected = shapes.size();
    if (given == 0 || given == expected || (expected == 1 && !shapes.front().is_known())) return;
    if (expected == 1 && given == static_cast<std::size_t>(shapes.front().size())) return;
    sizing.problem(operations,
                   "there are " + std::to_string(given) + " operations for " + std::to_string(expected) + " factors");
  }

  void outputs(Now now, Out out) const override {
    const std::string text = operations.value();
    const std::vector<Array> values = now[factors];
    Array total = 1.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      total = !text.empty() && text[i] == '/' ? total / values[i] : total * values[i];
    }
    out[y] = total;
  }
};

}  // namespace

PLANTLOOP_BLOCK(product, Product)

}  // namespace plantloop
