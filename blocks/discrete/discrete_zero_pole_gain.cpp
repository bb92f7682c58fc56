// A transfer function in z by its zeros, poles and gain.

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/block_design.h"

namespace plantloop {
namespace {

struct DiscreteZeroPoleGain final : Block {
  static constexpr auto summary = "Filter the samples of the input by zeros, poles and a gain in z.";
  static constexpr auto details =
      "y = k (z - zeros[1]) (z - zeros[2]) ... / ((z - poles[1]) (z - poles[2]) ...) u. Real ones are written as a "
      "vector, "
      "[0.5, 0.2]; with complex ones each is a row of real and imaginary part, and both of a pair are given: "
      "[[0.5, 0.2], [0.5, -0.2]]. There are at most as many zeros as poles. k is the factor in front, not the gain at "
      "rest. The "
      "states are those of discrete_transfer_function.";
  static constexpr auto example = R"(
blocks: {y: {type: discrete_zero_pole_gain, in: 1, zeros: 0, poles: [0.5, -0.5], rate: 1}}
simulation: {stop: 3}
expect: [{signal: y, at: 1, value: 1}, {signal: y, at: 3, value: 1.25}]
)";

  Input u{this, "u", {.doc = "signal to filter"}};
  Table zeros{this, "zeros", {.doc = "zeros; default: none", .optional = true}};
  Table poles{this, "poles", {.doc = "poles"}};
  Number k{this, "k", {.init = 1, .doc = "factor in front", .size = scalar}};
  Number initial_value{this,
                       "initial",
                       {.doc = "output before the start, where everything has come to rest; default: all states are 0",
                        .optional = true,
                        .initial = true}};
  Discrete x{this, "x", {.doc = "states of the observable canonical form", .size = any_size}};
  Output y{this, "y", {.doc = "the filtered signal"}};

  void check(Checking& checking) const override { Roots::check(checking, zeros, poles); }
  void sizes(Sizing& sizing) const override {
    const Shape shape = TransferFunction::state_shape(Roots::polynomial_shape(sizing.of(poles)), sizing.of(y));
    if (shape.is_known()) sizing.set(x, shape);
  }
  void initial(Now now, Init init) const override {
    if (now.given(initial_value)) init[x] = system(now).at_rest(now[initial_value], input(now), true);
  }
  void outputs(Now now, Out out) const override { out[y] = system(now).output(now[x], input(now)); }
  void update(Now now, Next next) const override { next[x] = system(now).change(now[x], input(now)); }

 private:
  TransferFunction system(Now now) const {
    const Array num = now.given(zeros) ? Roots::polynomial(now[zeros]) : Array(Shape::vector(1), 1.0);
    return {now[k] * num, Roots::polynomial(now[poles])};
  }
  Array input(Now now) const { return TransferFunction::as_wide_as(now[x], now[u]); }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_zero_pole_gain, DiscreteZeroPoleGain)

}  // namespace plantloop
