// A transfer function in s.

#include "engine/block.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct TransferFunctionBlock final : Block {
  static constexpr auto summary = "Filter the input by a transfer function in s.";
  static constexpr auto details =
      "y = num(s)/den(s) u with coefficients in descending powers of s: num: [1], den: [1, 2, 1] is 1/(s^2 + 2 s + 1). "
      "The degree of num must not exceed that of den; where they are equal the input reaches the output at the same "
      "instant. The states are those of the observable canonical form, in the scale of the output. A vector is "
      "filtered element by element.";
  static constexpr auto icon = "num/den";
  static constexpr auto example = R"(
blocks: {y: {type: transfer_function, in: 1, num: [1], den: [1, 2, 1]}}
simulation: {stop: 2}
expect: [{signal: y, at: 2, value: 1 - 3*exp(-2), abs: 1e-6}]
)";

  Table num{this, "num", {.init = "[1]", .doc = "numerator, descending powers of s", .zeros_matter = true}};
  Table den{this, "den", {.init = "[1, 1]", .doc = "denominator, descending powers of s", .zeros_matter = true}};
  Filter<State> filter{this};

  void check(Checking& checking) const override { TransferFunction::check(checking, num, den); }
  void sizes(Sizing& sizing) const override { filter.sizes(sizing, sizing.of(den)); }
  void initial(Now now, Init init) const override { filter.initial(now, init, system(now)); }
  void outputs(Now now, Out out) const override { filter.outputs(now, out, system(now)); }
  void derivatives(Now now, Rates rate) const override { rate[filter.x] = filter.change(now, system(now)); }

 private:
  TransferFunction system(Now now) const { return {now[num], now[den]}; }
};

}  // namespace

PLANTLOOP_BLOCK(transfer_function, TransferFunctionBlock)

}  // namespace plantloop
