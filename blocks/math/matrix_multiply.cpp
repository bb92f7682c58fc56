// The matrix product of two signals.

#include <fmt/format.h>

#include "engine/block.h"

namespace plantloop {
namespace {

struct MatrixMultiply final : Block {
  static constexpr auto summary = "Multiply two signals as matrices.";
  static constexpr auto details =
      "y = u v, the matrix product; a vector v is a column, a vector u before a matrix is a row, and of two vectors "
      "the product is their scalar product. A scalar multiplies every element. product multiplies element by element.";
  static constexpr auto example = R"(
blocks:
  A: {type: constant, value: [[1, 2], [3, 4]]}
  y: {type: matrix_multiply, in: {u: A, v: [time, 1]}}
simulation: {stop: 1}
expect: [{signal: y.2, at: 0.5, value: 5.5, abs: 1e-12}]
)";

  Input u{this, "u", {.doc = "left factor", .size = any_size}};
  Input v{this, "v", {.doc = "right factor", .size = any_size}};
  Output y{this, "y", {.doc = "the product", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    const Shape a = sizing.of(u), b = sizing.of(v);
    if (!a.is_known() || !b.is_known()) return;
    if (!a.is_scalar() && !b.is_scalar() && inner_left(a) != b.rows) {
      return sizing.problem(v, fmt::format("the left factor is {}, the right one {}: {} columns meet {} rows",
                                           to_string(a), to_string(b), inner_left(a), b.rows));
    }
    sizing.set(y, product_shape(a, b));
  }

  void outputs(Now now, Out out) const override {
    const Array a = now[u], b = now[v];
    if (a.is_scalar() || b.is_scalar()) {
      out[y] = a * b;
    } else if (a.shape().rank == 1 && b.shape().rank == 1) {
      out[y] = dot(a, b);
    } else {
      out[y] = mul(a, b).spread(product_shape(a.shape(), b.shape()));
    }
  }

 private:
  static int inner_left(const Shape& a) { return a.rank == 1 ? a.rows : a.columns; }
  static Shape product_shape(const Shape& a, const Shape& b) {
    if (a.is_scalar()) return b;
    if (b.is_scalar()) return a;
    if (a.rank == 1) return b.rank == 1 ? Shape::scalar() : Shape::vector(b.columns);
    return b.rank == 1 ? Shape::vector(a.rows) : Shape::matrix(a.rows, b.columns);
  }
};

}  // namespace

PLANTLOOP_BLOCK(matrix_multiply, MatrixMultiply)

}  // namespace plantloop
