// The previous sample of a signal.

#include "engine/block.h"

namespace plantloop {
namespace {

struct UnitDelay final : Block {
  static constexpr auto summary = "Delay the input by one sample.";
  static constexpr auto details = "y[k] = u[k-1],  y[0] = initial";
  static constexpr auto icon = "1/z";
  static constexpr auto example = R"(
blocks: {n: {type: unit_delay, in: n + 1, rate: 1}}
simulation: {stop: 6}
expect: [{signal: n, at: 5, value: 5}]
)";

  Input u{this, "u", {.doc = "signal to delay"}};
  Number initial_value{this, "initial", {.init = 0, .doc = "first output; may read signals", .initial = true}};
  Discrete x{this, "x", {.doc = "the previous sample"}};
  Output y{this, "y", {.doc = "the delayed signal"}};

  void initial(Now now, Init init) const override { init[x] = now[initial_value]; }
  void outputs(Now now, Out out) const override { out[y] = now[x]; }
  void update(Now now, Next next) const override { next[x] = now[u]; }
};

}  // namespace

PLANTLOOP_BLOCK(unit_delay, UnitDelay)

}  // namespace plantloop
