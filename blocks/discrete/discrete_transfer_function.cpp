// A transfer function in z.

#include "engine/block.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct DiscreteTransferFunction final : Block {
  static constexpr auto summary = "Filter the samples of the input by a transfer function in z.";
  static constexpr auto details =
      "y = num(z)/den(z) u with coefficients in descending powers of z: num: [1], den: [1, -0.5] is 1/(z - 0.5), that "
      "is y[k] = 0.5 y[k-1] + u[k-1]. The degree of num must not exceed that of den; where they are equal the input "
      "reaches the output at the same instant. The states are those of the observable canonical form. A vector is "
      "filtered element by element.";
  static constexpr auto icon = "num/den";
  static constexpr auto example = R"(
blocks: {y: {type: discrete_transfer_function, in: 1, num: [1], den: [1, -0.5], rate: 1}}
simulation: {stop: 4}
expect: [{signal: y, at: 3, value: 1.75}]
)";

  Table num{this, "num", {.init = "[1]", .doc = "numerator, descending powers of z", .zeros_matter = true}};
  Table den{this, "den", {.init = "[1, 0]", .doc = "denominator, descending powers of z", .zeros_matter = true}};
  Filter<Discrete> filter{this};

  void check(Checking& checking) const override { TransferFunction::check(checking, num, den); }
  void sizes(Sizing& sizing) const override { filter.sizes(sizing, sizing.of(den)); }
  void initial(Now now, Init init) const override { filter.initial(now, init, system(now)); }
  void outputs(Now now, Out out) const override { filter.outputs(now, out, system(now)); }
  void update(Now now, Next next) const override { next[filter.x] = filter.change(now, system(now)); }

 private:
  TransferFunction system(Now now) const { return {now[num], now[den]}; }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_transfer_function, DiscreteTransferFunction)

}  // namespace plantloop
