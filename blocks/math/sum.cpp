// The sum of any number of signals, each with a sign.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Sum final : Block {
  static constexpr auto summary = "Add signals, some with a minus sign.";
  static constexpr auto details =
      "y = + u1 - u2 ... with the signs in their order. A single input that is a vector is added up over its elements.";
  static constexpr auto example = R"(
blocks: {y: {type: sum, in: [time, 3], signs: "+-"}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.5, value: -2.5}]
)";

  Inputs terms{this, "terms", {.doc = "what to add; in: [a, b, ...]"}};
  Text signs{this, "signs", {.doc = "one + or - for each term, \"+-\"; none: all are added"}};
  Output y{this, "y", {.doc = "the sum"}};

  void sizes(Sizing& sizing) const override {
    const std::string text = signs.value();
    if (text.find_first_not_of("+-") != std::string::npos) {
      return sizing.problem(signs, "signs are written with + and - only, as in \"+-\"");
    }
    const auto shapes = sizing.of(terms);
    const std::size_t given = text.size(), expected = shapes.size();
    if (given == 0 || given == expected || (expected == 1 && !shapes.front().is_known())) return;
    if (expected == 1 && given == static_cast<std::size_t>(shapes.front().size())) return;
    sizing.problem(signs, "there are " + std::to_string(given) + " signs for " + std::to_string(expected) + " terms");
  }

  void outputs(Now now, Out out) const override {
    const std::string text = signs.value();
    std::vector<Array> values = now[terms];
    Array total = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      total = !text.empty() && text[i] == '-' ? total - values[i] : total + values[i];
    }
    out[y] = total;
  }
};

}  // namespace

PLANTLOOP_BLOCK(sum, Sum)

}  // namespace plantloop
