// The last samples of a signal.

#include "engine/block.h"

namespace plantloop {
namespace {

struct TappedDelay final : Block {
  static constexpr auto summary = "Give the last samples of the input.";
  static constexpr auto details =
      "y = [u[k-1], u[k-2], ..., u[k-taps]], newest first; samples before the start are `initial`";
  static constexpr auto example = R"(
blocks: {y: {type: tapped_delay, in: time, taps: 2, rate: 1}}
simulation: {stop: 6}
expect: [{signal: y.2, at: 5, value: 3}]
)";

  Input u{this, "u", {.doc = "signal to delay", .size = scalar}};
  Count taps{this, "taps", {.init = 2, .doc = "how many samples", .min = 1}};
  Number initial_value{
      this,
      "initial",
      {.init = 0, .doc = "samples before the start; may read signals", .size = scalar, .initial = true}};
  Discrete x{this, "x", {.doc = "the samples, newest first", .size = taps}};
  Output y{this, "y", {.doc = "the samples, newest first", .size = taps}};

  void initial(Now now, Init init) const override { init[x] = now[initial_value]; }
  void outputs(Now now, Out out) const override { out[y] = now[x]; }
  void update(Now now, Next next) const override {
    Array shifted = now[x];
    for (int i = shifted.size() - 1; i > 0; --i) shifted[i] = shifted[i - 1];
    shifted[0] = now[u][0];
    next[x] = shifted;
  }
};

}  // namespace

PLANTLOOP_BLOCK(tapped_delay, TappedDelay)

}  // namespace plantloop
