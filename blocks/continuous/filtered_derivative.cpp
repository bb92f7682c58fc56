// The derivative of a signal, filtered so that it can be built.

#include "engine/block.h"

namespace plantloop {
namespace {

struct FilteredDerivative final : Block {
  static constexpr auto summary = "Give the filtered derivative of the input.";
  static constexpr auto details =
      "y = N (u - x),  x' = y: the transfer function N s/(s + N). x starts at u, so the output starts at 0; the error "
      "of the derivative is about u''/N.";
  static constexpr auto icon = "N*s/(s + N)";
  static constexpr auto example = R"(
blocks:
  u: {type: ramp, slope: 3}
  d: {type: filtered_derivative, in: u, N: 50}
simulation: {stop: 1}
expect: [{signal: d, measure: final, value: 3, abs: 1e-3}]
)";

  Input u{this, "u", {.doc = "signal to differentiate"}};
  Number N{this, "N", {.init = 100, .unit = "rad/s", .doc = "pole of the filter", .above = 0}};
  Number initial_value{this,
                       "initial",
                       {.doc = "filtered input at the start; default: the input there; may read signals",
                        .optional = true,
                        .initial = true}};
  State x{this, "x", {.doc = "the filtered input"}};
  Output y{this, "y", {.doc = "its derivative"}};
  Output filtered{this, "filtered", {.doc = "the filtered input, whose exact derivative y is"}};

  void initial(Now now, Init init) const override { init[x] = now.given(initial_value) ? now[initial_value] : now[u]; }
  void outputs(Now now, Out out) const override {
    out[y] = now[N] * (now[u] - now[x]);
    out[filtered] = now[x];
  }
  void derivatives(Now now, Rates rate) const override { rate[x] = now[N] * (now[u] - now[x]); }
};

}  // namespace

PLANTLOOP_BLOCK(filtered_derivative, FilteredDerivative)

}  // namespace plantloop
