// A transfer function in s by its zeros, poles and gain.

#include "engine/block.h"
#include "engine/block_design.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct ZeroPoleGain final : Block {
  static constexpr auto summary = "Filter the input by zeros, poles and a gain in s.";
  static constexpr auto details =
      "y = k (s - zeros[1]) (s - zeros[2]) ... / ((s - poles[1]) (s - poles[2]) ...) u. Real ones are written as a "
      "vector, [-1, -2]; with complex ones each is a row of real and imaginary part, and both of a pair are given: "
      "[[-1, 2], [-1, -2]]. There are at most as many zeros as poles. k is the factor in front, not the gain at rest. "
      "The states are those of transfer_function.";
  static constexpr auto example = R"(
blocks: {y: {type: zero_pole_gain, in: 1, poles: [[-1, 2], [-1, -2]], k: 5}}
simulation: {stop: 10}
expect:
  - {signal: y, at: pi/2, value: 1 + exp(-pi/2), abs: 1e-5}
  - {signal: y, measure: final, value: 1, abs: 1e-3}
)";

  Table zeros{this, "zeros", {.unit = "rad/s", .doc = "zeros; default: none", .optional = true}};
  Table poles{this, "poles", {.unit = "rad/s", .doc = "poles"}};
  Number k{this, "k", {.init = 1, .doc = "factor in front", .size = scalar}};
  Filter<State> filter{this};

  void check(Checking& checking) const override { Roots::check(checking, zeros, poles); }
  void sizes(Sizing& sizing) const override { filter.sizes(sizing, Roots::polynomial_shape(sizing.of(poles))); }
  void initial(Now now, Init init) const override { filter.initial(now, init, system(now)); }
  void outputs(Now now, Out out) const override { filter.outputs(now, out, system(now)); }
  void derivatives(Now now, Rates rate) const override { rate[filter.x] = filter.change(now, system(now)); }

 private:
  TransferFunction system(Now now) const {
    return {now[k] * Roots::numerator(now, zeros), Roots::polynomial(now[poles])};
  }
};

}  // namespace

PLANTLOOP_BLOCK(zero_pole_gain, ZeroPoleGain)

}  // namespace plantloop
