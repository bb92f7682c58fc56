// The size of a vector.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Norm final : Block {
  static constexpr auto summary = "Give the norm of a vector.";
  static constexpr auto details =
      "norm euclidean: y = sqrt(u1^2 + u2^2 + ...), of a matrix over all elements (Frobenius);  sum: |u1| + |u2| + "
      "...;  max: the greatest |ui|";
  static constexpr auto example = R"(
blocks: {r: {type: norm, in: [3, 4*time]}}
simulation: {stop: 1}
expect: [{signal: r, at: 1, value: 5, abs: 1e-12}]
)";

  Input u{this, "u", {.doc = "the vector", .size = any_size}};
  Choice norm{this, "norm", {.of = {"euclidean", "sum", "max"}, .doc = "which norm"}};
  Output y{this, "y", {.doc = "its norm", .size = scalar}};

  void outputs(Now now, Out out) const override {
    const Array x = now[u];
    if (norm.is("euclidean")) {
      // By hypot, which neither overflows nor loses small elements.
      Value sum = x.size() > 1 ? hypot(x[0], x[1]) : abs(x[0]);
      for (int i = 2; i < x.size(); ++i) sum = hypot(sum, x[i]);
      out[y] = sum;
    } else if (norm.is("sum")) {
      out[y] = sum(abs(x));
    } else {
      out[y] = greatest(abs(x));
    }
  }
};

}  // namespace

PLANTLOOP_BLOCK(norm, Norm)

}  // namespace plantloop
