// The same elements in another shape.

#include <fmt/format.h>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Reshape final : Block {
  static constexpr auto summary = "Arrange the elements of a signal in another shape.";
  static constexpr auto details =
      "The elements are taken row by row. rows and columns: a matrix of that size; one of them alone: the other "
      "follows from the number of elements; neither: a vector. by: columns takes and puts the elements column by "
      "column.";
  static constexpr auto example = R"(
blocks: {M: {type: reshape, in: [1, 2, 3, 4, 5, 6*time], rows: 2}}
simulation: {stop: 1}
expect: [{signal: M.2.1, at: 1, value: 4}, {signal: M.2.3, at: 1, value: 6}]
)";

  Input u{this, "u", {.doc = "signal to arrange", .size = any_size}};
  Count rows{this, "rows", {.init = 0, .doc = "rows of the matrix; 0: as many as are needed"}};
  Count columns{this, "columns", {.init = 0, .doc = "columns of the matrix; 0: as many as are needed"}};
  Choice by{this, "by", {.of = {"rows", "columns"}, .doc = "the order in which elements are counted"}};
  Output y{this, "y", {.doc = "the same elements", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    const Shape from = sizing.of(u);
    if (!from.is_known()) return;
    const Shape to = target(from.size());
    if (to.size() != from.size()) {
      const bool both = rows.value() > 0 && columns.value() > 0;
      return sizing.problem(
          rows.value() > 0 ? rows : columns,
          both ? fmt::format("{} by {} elements are {}, but the input has {}", to.rows, to.columns, to.size(),
                             from.size())
               : fmt::format("{} elements do not fill {} {}", from.size(),
                             rows.value() > 0 ? rows.value() : columns.value(), rows.value() > 0 ? "rows" : "columns"));
    }
    sizing.set(y, to);
  }

  void outputs(Now now, Out out) const override {
    const Array from = now[u];
    Array to(target(from.size()));
    for (int k = 0; k < to.size(); ++k) to[place(k, to)] = from[place(k, from)];
    out[y] = to;
  }

 private:
  Shape target(int size) const {
    const int r = rows.value(), c = columns.value();
    if (r == 0 && c == 0) return Shape::vector(size);
    return Shape::matrix(r == 0 ? size / c : r, c == 0 ? size / r : c);
  }
  // Where element k in the order of counting stands.
  int place(int k, const Array& array) const {
    return by.is("rows") ? k : k % array.rows() * array.columns() + k / array.rows();
  }
};

}  // namespace

PLANTLOOP_BLOCK(reshape, Reshape)

}  // namespace plantloop
