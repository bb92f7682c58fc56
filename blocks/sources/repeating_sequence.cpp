// Straight lines between points, again and again.

#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include "engine/block.h"

namespace plantloop {
namespace {

struct RepeatingSequence final : Block {
  static constexpr auto summary = "Repeat straight lines through points in time.";
  static constexpr auto details =
      "The points (times[i], values[i]) are joined by straight lines; the last time is the period, after which it "
      "begins again. times[0] is 0. Before time 0 the first value holds. The points are stops of the solver.";
  static constexpr auto example = R"(
blocks: {u: {type: repeating_sequence, times: [0, 1, 3], values: [0, 2, 0]}}
simulation: {stop: 9}
expect:
  - {signal: u, at: 0.5, value: 1, abs: 1e-12}
  - {signal: u, at: 7, value: 2, abs: 1e-12}
  - {signal: u, at: 8, value: 1, abs: 1e-12}
)";

  Table times{this,
              "times",
              {.unit = "s",
               .doc = "time of each point, from 0, ascending; the last one is the period",
               .ascending = true,
               .min = 0}};
  Table values{this, "values", {.doc = "value at each time"}};
  Output y{this, "y", {.doc = "the sequence", .size = scalar}};

  void check(Checking& checking) const override {
    const auto t = checking.of(times);
    if (t.empty() || t[0] == 0) return;
    checking.problem(times, fmt::format("the first time of a sequence that repeats is 0, but it is {:g}", t[0]));
  }

  void sizes(Sizing& sizing) const override {
    const Shape t = sizing.of(times), v = sizing.of(values);
    if (!t.is_known() || !v.is_known()) return;
    if (t.size() < 2) return sizing.problem(times, "a line needs at least two points");
    if (t.size() == v.size()) return;
    sizing.problem(values,
                   std::to_string(t.size()) + " times need as many values, but there are " + std::to_string(v.size()));
  }

  void outputs(Now now, Out out) const override {
    const Array t = now[times], v = now[values];
    const int n = t.size();
    const Value period = t[n - 1];
    // Each point has beats of its own; the pieces that have begun since the period did say which one holds.
    const Value begun = beats(Value(0), period);
    Value piece = 0;
    for (int i = 1; i + 1 < n; ++i) piece = piece + (beats(t[i], period) - (begun - 1.0));
    std::vector<Value> from, value, slope;
    for (int i = 0; i + 1 < n; ++i) {
      from.push_back(t[i]), value.push_back(v[i]);
      slope.push_back((v[i + 1] - v[i]) / (t[i + 1] - t[i]));
    }
    const auto chosen = [&](std::vector<Value>& of) { return pick(Array::vector(std::move(of)), piece); };
    const Value age = now.time() - (begun - 1.0) * period;
    out[y] = where(begun > 0.0, chosen(value) + chosen(slope) * (age - chosen(from)), v[0]);
  }
};

}  // namespace

PLANTLOOP_BLOCK(repeating_sequence, RepeatingSequence)

}  // namespace plantloop
