// The mean of the last samples of a signal.

#include <vector>

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

  Input u{this, "u", {.doc = "signal to average"}};
  Count samples{this, "samples", {.init = 2, .doc = "how many samples", .min = 2}};
  Number initial_value{this,
                       "initial",
                       {.doc = "samples before the start; default: the first input; may read signals",
                        .optional = true,
                        .initial = true}};
  Discrete x{this, "x", {.doc = "the samples, newest first; of a vector one row for each", .size = any_size}};
  Output y{this, "y", {.doc = "the mean"}};

  void sizes(Sizing& sizing) const override {
    const Shape one = sizing.of(y);
    if (one.is_known())
      sizing.set(x, one.size() == 1 ? Shape::vector(samples.value()) : Shape::matrix(samples.value(), one.size()));
  }
  void initial(Now now, Init init) const override {
    const Array before = now.given(initial_value) ? now[initial_value] : now[u];
    Array start = now[x];
    for (int i = 0; i < start.size(); ++i) start[i] = before.at(i % width(start));
    init[x] = start;
  }
  void outputs(Now now, Out out) const override {
    const Array row = with_newest(now);
    const int n = width(row);
    Array mean(n == 1 ? Shape::scalar() : Shape::vector(n));
    for (int e = 0; e < n; ++e) {
      std::vector<Value> column;
      for (int i = e; i < row.size(); i += n) column.push_back(row[i]);
      mean[e] = sum(column) / static_cast<double>(samples.value());
    }
    out[y] = mean;
  }
  void update(Now now, Next next) const override { next[x] = with_newest(now); }

 private:
  static int width(const Array& rows) { return rows.shape().rank == 2 ? rows.columns() : 1; }
  // The present sample and those before it, without the oldest one.
  Array with_newest(Now now) const {
    Array shifted = now[x];
    const int n = width(shifted);
    for (int i = shifted.size() - 1; i >= n; --i) shifted[i] = shifted[i - n];
    for (int e = 0; e < n; ++e) shifted[e] = now[u].at(e);
    return shifted;
  }
};

}  // namespace

PLANTLOOP_BLOCK(moving_average, MovingAverage)

}  // namespace plantloop
