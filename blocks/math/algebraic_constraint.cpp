// An equation in place of an expression: the output is what makes it hold.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct AlgebraicConstraint final : Block {
  static constexpr auto summary = "Find the value that makes an equation hold.";
  static constexpr auto details =
      "y such that residual = 0, where the residual's expression reads y, directly or through other blocks. Found by "
      "Newton's method whenever it is read, from the last value on, or from initial_guess at the start; with both "
      "bounds also by bisection between them. A vector residual gives as many unknowns as it has elements. With "
      "`solver: ida` y is an algebraic variable of the solver.";
  static constexpr auto example = R"(
blocks:
  pressure: {type: sine, amplitude: 1, bias: 2}
  flow: {type: algebraic_constraint, residual: flow + 0.5*flow^2 - pressure, lower: 0, upper: 10, initial_guess: 1}
simulation: {stop: 2}
expect: [{signal: flow, at: 0, value: sqrt(5) - 1, abs: 1e-12}]
)";

  Input residual{this, "residual", {.doc = "what must be zero; reads the output", .init = 0}};
  Number lower{this, "lower", {.init = -unbounded, .doc = "the output is not less"}};
  Number upper{this, "upper", {.init = unbounded, .doc = "the output is not greater"}};
  Number initial_guess{this, "initial_guess", {.init = 0, .doc = "where the search begins at the start"}};
  Output y{this, "y", {.doc = "the value at which the residual is zero"}};

  void check(Checking& checking) const override { check_order(checking, lower, upper, true); }

  void outputs(Now now, Out out) const override {
    const Array equation = now[residual];
    const Implicit about{now[initial_guess], now[lower], now[upper]};
    out[y] = implicit(equation.shape(), about, [&](const Array&) { return Array(equation); });
  }
};

}  // namespace

PLANTLOOP_BLOCK(algebraic_constraint, AlgebraicConstraint)

}  // namespace plantloop
