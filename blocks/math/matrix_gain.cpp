// A constant matrix times a vector.

#include <fmt/format.h>

#include "engine/block.h"

namespace plantloop {
namespace {

struct MatrixGain final : Block {
  static constexpr auto summary = "Multiply a vector or matrix by a constant matrix.";
  static constexpr auto details =
      "y = K u, the matrix product; a vector u is a column. One row in K gives a scalar. Where an entry of K is 0, "
      "that element of u does not reach that element of y. gain multiplies element by element.";
  static constexpr auto icon = "K";
  static constexpr auto example = R"(
blocks: {y: {type: matrix_gain, in: [time, 1], K: [[2, 0], [1, 3]]}}
simulation: {stop: 1}
expect: [{signal: y.2, at: 0.5, value: 3.5, abs: 1e-12}]
)";

  Input u{this, "u", {.doc = "vector or matrix to multiply", .size = any_size}};
  Table K{this, "K", {.doc = "the matrix; a vector is one row", .zeros_matter = true}};
  Output y{this, "y", {.doc = "the product", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    const Shape k = as_matrix(sizing.of(K)), x = sizing.of(u);
    if (!k.is_known() || !x.is_known()) return;
    if (k.columns != x.rows) {
      return sizing.problem(K, fmt::format("K has {} columns, but the input is {}", k.columns, to_string(x)));
    }
    sizing.set(y, product_shape(k, x));
  }

  void outputs(Now now, Out out) const override {
    const Array k = now[K], x = now[u];
    const Shape shape = as_matrix(k.shape());
    const Array column = x.is_scalar() ? x.spread(Shape::vector(1)) : x;
    out[y] = mul(k.spread(shape), column).spread(product_shape(shape, x.shape()));
  }

 private:
  static Shape as_matrix(const Shape& k) { return !k.is_known() || k.rank == 2 ? k : Shape::matrix(1, k.size()); }
  static Shape product_shape(const Shape& k, const Shape& x) {
    if (x.rank == 2) return Shape::matrix(k.rows, x.columns);
    return k.rows == 1 ? Shape::scalar() : Shape::vector(k.rows);
  }
};

}  // namespace

PLANTLOOP_BLOCK(matrix_gain, MatrixGain)

}  // namespace plantloop
