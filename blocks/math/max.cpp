// The greatest of any number of signals.

#include <cstddef>
#include <vector>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Maximum final : Block {
  static constexpr auto summary = "Give the greatest of some signals.";
  static constexpr auto details =
      "y = max(u1, u2, ...), element by element. A single input that is a vector gives its greatest element.";
  static constexpr auto example = R"(
blocks: {y: {type: max, in: [time, 0.5]}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.25, value: 0.5}]
)";

  Inputs terms{this, "terms", {.doc = "what to compare; in: [a, b, ...]"}};
  Output y{this, "y", {.doc = "the greatest one"}};

  void outputs(Now now, Out out) const override {
    const std::vector<Array> values = now[terms];
    Array found = values[0];
    for (std::size_t i = 1; i < values.size(); ++i) found = max(found, values[i]);
    out[y] = found;
  }
};

}  // namespace

PLANTLOOP_BLOCK(max, Maximum)

}  // namespace plantloop
