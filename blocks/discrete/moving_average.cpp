// The mean of the last samples of a signal.

#include "engine/block.h"

namespace plantloop {
namespace {

struct MovingAverage final : Block {
  static constexpr auto summary = "Average the last samples of the input.";
  static constexpr auto details =
      "y[k] = (u[k] + u[k-1] + ... + u[k-samples+1])/samples; samples before the start are `initial`, else the first "
      "input";
  static constexpr auto example = R"(
blocks: {y: {type: moving_average, in: time, samples: 3, rate: 1}}
simulation: {stop: 6}
expect: [{signal: y, at: 5, value: 4}]
)";

  Input u{this, "u", {.doc = "signal to average", .size = scalar}};
  Count samples{this, "samples", {.init = 2, .doc = "how many samples", .min = 2}};
  Number initial_value{this,
                       "initial",
                       {.doc = "samples before the start; default: the first input; may read signals",
                        .size = scalar,
                        .optional = true,
                        .initial = true}};
  Discrete x{this, "x", {.doc = "the samples, newest first", .size = samples}};
  Output y{this, "y", {.doc = "the mean", .size = scalar}};

  void initial(Now now, Init init) const override { init[x] = now.given(initial_value) ? now[initial_value] : now[u]; }
  void outputs(Now now, Out out) const override {
    out[y] = sum(with_newest(now)) / static_cast<double>(samples.value());
  }
  void update(Now now, Next next) const override { next[x] = with_newest(now); }

 private:
  // The present sample and those before it, without the oldest one.
  Array with_newest(Now now) const {
    Array shifted = now[x];
    for (int i = shifted.size() - 1; i > 0; --i) shifted[i] = shifted[i - 1];
    shifted[0] = now[u][0];
    return shifted;
  }
};

}  // namespace

PLANTLOOP_BLOCK(moving_average, MovingAverage)

}  // namespace plantloop
