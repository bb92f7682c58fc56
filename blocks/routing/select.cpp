// Some elements of a vector.

#include <fmt/format.h>
#include <cmath>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Select final : Block {
  static constexpr auto summary = "Take elements out of a vector.";
  static constexpr auto details =
      "y = [u.i1, u.i2, ...] for the numbers in `elements`, which count from 1 and may repeat; a single number gives a "
      "scalar";
  static constexpr auto example = R"(
blocks: {y: {type: select, in: [time, 20, 30], elements: [3, 1]}}
simulation: {stop: 1}
expect:
  - {signal: y.1, at: 0.5, value: 30}
  - {signal: y.2, at: 0.5, value: 0.5}
)";

  Input u{this, "u", {.doc = "vector to take from", .size = any_size}};
  Table elements{this, "elements", {.doc = "which elements, from 1", .structural = true, .min = 1}};
  Output y{this, "y", {.doc = "the elements", .size = any_size}};

  void check(Checking& checking) const override {
    for (const double number : checking.of(elements)) {
      if (number != std::floor(number))
        return checking.problem(elements, "elements are counted with whole numbers from 1");
    }
  }

  void sizes(Sizing& sizing) const override {
    const Shape which = sizing.of(elements);
    if (which.is_known()) sizing.set(y, which.is_scalar() ? which : Shape::vector(which.size()));
    if (!sizing.of(u).is_known()) return;
    const int size = sizing.of(u).size();
    for (const double number : sizing.numbers(elements)) {
      if (number <= size) continue;
      return sizing.problem(elements,
                            fmt::format("there is no element {:g}: the input is {}", number, to_string(sizing.of(u))));
    }
  }

  void outputs(Now now, Out out) const override {
    const Array from = now[u], which = now[elements];
    Array taken(which.is_scalar() ? Shape::scalar() : Shape::vector(which.size()));
    for (int i = 0; i < taken.size(); ++i) taken[i] = from[static_cast<int>(which[i].number()) - 1];
    out[y] = taken;
  }
};

}  // namespace

PLANTLOOP_BLOCK(select, Select)

}  // namespace plantloop
