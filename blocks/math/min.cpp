// The least of any number of signals.

#include <cstddef>
#include <vector>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Minimum final : Block {
  static constexpr auto summary = "Give the least of some signals.";
  static constexpr auto details =
      "y = min(u1, u2, ...), element by element. A single input that is a vector gives its least element.";
  static constexpr auto example = R"(
blocks: {y: {type: min, in: [time, 0.5]}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.75, value: 0.5}]
)";

  Inputs terms{this, "terms", {.doc = "what to compare; in: [a, b, ...]"}};
  Output y{this, "y", {.doc = "the least one"}};

  void outputs(Now now, Out out) const override {
    const std::vector<Array> values = now[terms];
    Array found = values[0];
    for (std::size_t i = 1; i < values.size(); ++i) found = min(found, values[i]);
    out[y] = found;
  }
};

}  // namespace

PLANTLOOP_BLOCK(min, Minimum)

}  // namespace plantloop
