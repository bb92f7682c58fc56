// The samples at which a signal differs from the one before.

#include "engine/block.h"

namespace plantloop {
namespace {

struct DetectChange final : Block {
  static constexpr auto summary = "Say at which samples a signal has changed.";
  static constexpr auto details =
      "y[k] = 1 where u[k] differs from u[k-1] (of: change), is greater (increase) or less (decrease), else 0. The "
      "sample before the first one is `initial`, by default the first one itself.";
  static constexpr auto example = R"(
blocks:
  u: {type: staircase, times: [0, 2, 4], values: [1, 3, 2]}
  more: {type: detect_change, in: u, of: increase, rate: 1}
simulation: {stop: 5}
expect:
  - {signal: more, at: 2, value: 1}
  - {signal: more, at: 3, value: 0}
  - {signal: more, at: 4, value: 0}
)";

  Input u{this, "u", {.doc = "the signal"}};
  Choice of{this, "of", {.of = {"change", "increase", "decrease"}, .doc = "which change counts"}};
  Number initial_value{this,
                       "initial",
                       {.doc = "sample before the first one; default: the first input; may read signals",
                        .optional = true,
                        .initial = true}};
  Discrete x{this, "x", {.doc = "the previous sample"}};
  Output y{this, "y", {.doc = "1 at a change, else 0"}};

  void initial(Now now, Init init) const override { init[x] = now.given(initial_value) ? now[initial_value] : now[u]; }
  void outputs(Now now, Out out) const override {
    if (of.is("increase")) {
      out[y] = (now[u] > now[x]).array;
    } else if (of.is("decrease")) {
      out[y] = (now[u] < now[x]).array;
    } else {
      out[y] = (!equal(now[u], now[x])).array;
    }
  }
  void update(Now now, Next next) const override { next[x] = now[u]; }
};

}  // namespace

PLANTLOOP_BLOCK(detect_change, DetectChange)

}  // namespace plantloop
