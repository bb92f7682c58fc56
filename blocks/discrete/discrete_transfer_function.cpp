// A transfer function in z.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct DiscreteTransferFunction final : Block {
  static constexpr auto summary = "Filter the samples of the input by a transfer function in z.";
  static constexpr auto details =
      "y = num(z)/den(z) u with coefficients in descending powers of z: num: [1], den: [1, -0.5] is 1/(z - 0.5), that "
      "is y[k] "
      "= 0.5 y[k-1] + u[k-1]. The degree of num must not exceed that of den; where they are equal the input reaches "
      "the output at "
      "the same instant. The states are those of the observable canonical form. A vector is filtered element by "
      "element.";
  static constexpr auto icon = "num/den";
  static constexpr auto example = R"(
blocks: {y: {type: discrete_transfer_function, in: 1, num: [1], den: [1, -0.5], rate: 1}}
simulation: {stop: 4}
expect: [{signal: y, at: 3, value: 1.75}]
)";

  Input u{this, "u", {.doc = "signal to filter"}};
  Table num{this, "num", {.init = "[1]", .doc = "numerator, descending powers of z", .zeros_matter = true}};
  Table den{this, "den", {.init = "[1, 0]", .doc = "denominator, descending powers of z", .zeros_matter = true}};
  Number initial_value{this,
                       "initial",
                       {.doc = "output before the start, where everything has come to rest; default: all states are 0",
                        .optional = true,
                        .initial = true}};
  Discrete x{this, "x", {.doc = "states of the observable canonical form", .size = any_size}};
  Output y{this, "y", {.doc = "the filtered signal"}};

  void check(Checking& checking) const override { TransferFunction::check(checking, num, den); }
  void sizes(Sizing& sizing) const override {
    const Shape shape = TransferFunction::state_shape(sizing.of(den), sizing.of(y));
    if (shape.is_known()) sizing.set(x, shape);
  }
  void initial(Now now, Init init) const override {
    if (now.given(initial_value))
      init[x] = TransferFunction(now[num], now[den]).at_rest(now[initial_value], input(now), true);
  }
  void outputs(Now now, Out out) const override {
    out[y] = TransferFunction(now[num], now[den]).output(now[x], input(now));
  }
  void update(Now now, Next next) const override {
    next[x] = TransferFunction(now[num], now[den]).change(now[x], input(now));
  }

 private:
  Array input(Now now) const { return TransferFunction::as_wide_as(now[x], now[u]); }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_transfer_function, DiscreteTransferFunction)

}  // namespace plantloop
