// A polynomial of a signal.

#include <fmt/format.h>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Polynomial final : Block {
  static constexpr auto summary = "Give the value of a polynomial.";
  static constexpr auto details =
      "y = coefficients[1] u^n + ... + coefficients[n] u + coefficients[n+1], descending powers, element by element; "
      "computed by Horner's rule";
  static constexpr auto example = R"(
blocks: {y: {type: polynomial, in: time, coefficients: [1, 0, -2]}}
simulation: {stop: 3}
expect: [{signal: y, at: 3, value: 7, abs: 1e-12}]
)";

  Input u{this, "u", {.doc = "argument"}};
  Table coefficients{this, "coefficients", {.doc = "of the powers of u, the highest one first"}};
  Output y{this, "y", {.doc = "value of the polynomial"}};

  void sizes(Sizing& sizing) const override {
    const Shape c = sizing.of(coefficients);
    if (c.is_known() && c.size() == 0) return sizing.problem(coefficients, "a polynomial needs a coefficient");
    if (c.is_known() && c.rank == 2)
      sizing.problem(coefficients,
                     fmt::format("coefficients are a vector, [1, 0, -2] for u^2 - 2, but they are {}", to_string(c)));
  }

  void outputs(Now now, Out out) const override {
    const Array c = now[coefficients], x = now[u];
    Array sum(x.shape(), c[0]);
    for (int i = 1; i < c.size(); ++i) sum = sum * x + c[i];
    out[y] = sum;
  }
};

}  // namespace

PLANTLOOP_BLOCK(polynomial, Polynomial)

}  // namespace plantloop
