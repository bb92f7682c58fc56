// A first-order lag.

#include "engine/block.h"

namespace plantloop {
namespace {

struct FirstOrder final : Block {
  static constexpr auto summary = "Follow the input with a lag.";
  static constexpr auto details = "x' = (k u - x) / tau,  y = x";
  static constexpr auto icon = "k/(tau*s + 1)";
  static constexpr auto example = R"(
blocks: {x: {type: first_order, in: 1, k: 2, tau: 0.5}}
simulation: {stop: 2}
expect: [{signal: x, at: 0.5, value: 2*(1 - exp(-1)), abs: 1e-6}]
)";

  Input u{this, "u", {.doc = "signal to follow"}};
  Number k{this, "k", {.init = 1, .doc = "gain at rest"}};
  Number tau{this, "tau", {.init = 1, .unit = "s", .doc = "time constant", .min = 1e-9}};
  Number initial_value{this, "initial", {.init = 0, .doc = "value at the start; may read signals", .initial = true}};
  State x{this, "x", {.doc = "lagged value"}};
  Output y{this, "y", {.doc = "the lagged value"}};

  void initial(Now now, Init init) const override { init[x] = now[initial_value]; }
  void outputs(Now now, Out out) const override { out[y] = now[x]; }
  void derivatives(Now now, Rates rate) const override { rate[x] = (now[k] * now[u] - now[x]) / now[tau]; }
};

}  // namespace

PLANTLOOP_BLOCK(first_order, FirstOrder)

}  // namespace plantloop
