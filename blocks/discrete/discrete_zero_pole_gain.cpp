// A transfer function in z by its zeros, poles and gain.

#include "engine/block.h"
#include "engine/block_design.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct DiscreteZeroPoleGain final : Block {
  static constexpr auto summary = "Filter the samples of the input by zeros, poles and a gain in z.";
  static constexpr auto details =
      "y = k (z - zeros[1]) (z - zeros[2]) ... / ((z - poles[1]) (z - poles[2]) ...) u. Real ones are written as a "
      "vector, [0.5, 0.2]; with complex ones each is a row of real and imaginary part, and both of a pair are given: "
      "[[0.5, 0.2], [0.5, -0.2]]. There are at most as many zeros as poles. k is the factor in front, not the gain at "
      "rest. The states are those of discrete_transfer_function.";
  static constexpr auto example = R"(
blocks: {y: {type: discrete_zero_pole_gain, in: 1, zeros: 0, poles: [0.5, -0.5], rate: 1}}
simulation: {stop: 3}
expect: [{signal: y, at: 1, value: 1}, {signal: y, at: 3, value: 1.25}]
)";

  Table zeros{this, "zeros", {.doc = "zeros; default: none", .optional = true}};
  Table poles{this, "poles", {.doc = "poles"}};
  Number k{this, "k", {.init = 1, .doc = "factor in front", .size = scalar}};
  Filter<Discrete> filter{this};

  void check(Checking& checking) const override { Roots::check(checking, zeros, poles); }
  void sizes(Sizing& sizing) const override { filter.sizes(sizing, Roots::polynomial_shape(sizing.of(poles))); }
  void initial(Now now, Init init) const override { filter.initial(now, init, system(now)); }
  void outputs(Now now, Out out) const override { filter.outputs(now, out, system(now)); }
  void update(Now now, Next next) const override { next[filter.x] = filter.change(now, system(now)); }

 private:
  TransferFunction system(Now now) const {
    return {now[k] * Roots::numerator(now, zeros), Roots::polynomial(now[poles])};
  }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_zero_pole_gain, DiscreteZeroPoleGain)

}  // namespace plantloop
