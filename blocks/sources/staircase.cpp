// A signal that is constant between given times.

#include <string>
#include <utility>
#include <vector>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Staircase final : Block {
  static constexpr auto summary = "Hold a value from each given time on.";
  static constexpr auto details =
      "y = values[i] for times[i] <= time < times[i+1]; before the first time it is the first value. With a matrix of "
      "values, y is its i-th row.";
  static constexpr auto example = R"(
blocks: {u: {type: staircase, times: [0, 1, 2], values: [0, 5, 3]}}
simulation: {stop: 3}
expect: [{signal: u, at: 1.5, value: 5}]
)";

  Table times{this, "times", {.unit = "s", .doc = "when each value begins, ascending", .ascending = true}};
  Table values{this, "values", {.doc = "one value for each time, or one row of a matrix"}};
  Output y{this, "y", {.doc = "the value in force", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    const Shape t = sizing.of(times), v = sizing.of(values);
    if (v.is_known()) sizing.set(y, v.rank == 2 && v.columns > 1 ? Shape::vector(v.columns) : Shape::scalar());
    if (!t.is_known() || !v.is_known()) return;
    if (t.size() == 0) return sizing.problem(times, "times needs at least one entry");
    if (t.size() == v.rows) return;
    sizing.problem(values,
                   std::to_string(t.size()) + " times need as many values, but there are " + std::to_string(v.rows));
  }

  void outputs(Now now, Out out) const override {
    const Array all = now[values];
    const Value index = segment(now[times]) - 1.0;
    if (all.columns() == 1) {
      out[y] = pick(all, index);
      return;
    }
    std::vector<Value> row;
    for (int column = 0; column < all.columns(); ++column) {
      std::vector<Value> one;
      for (int i = 0; i < all.rows(); ++i) one.push_back(all(i, column));
      row.push_back(pick(Array::vector(std::move(one)), index));
    }
    out[y] = Array::vector(std::move(row));
  }
};

}  // namespace

PLANTLOOP_BLOCK(staircase, Staircase)

}  // namespace plantloop
