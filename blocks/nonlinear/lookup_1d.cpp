// A table of values, with straight lines in between.

#include <fmt/format.h>
#include <vector>

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Lookup1d final : Block {
  static constexpr auto summary = "Look a value up in a table.";
  static constexpr auto details =
      "interpolation linear: y = y[i] + (y[i+1] - y[i])/(x[i+1] - x[i]) (u - x[i]) for x[i] <= u < x[i+1];  hold: "
      "y[i];  nearest: the value of the nearest point. outside: clip holds the end values, linear goes on with the "
      "outermost lines, error ends the run. Kinks and jumps are events, so no accuracy is lost at them.";
  static constexpr auto example = R"(
blocks: {y: {type: lookup_1d, in: time, x: [0, 1, 3], y: [0, 2, 3]}}
simulation: {stop: 4}
expect:
  - {signal: y, at: 2, value: 2.5, abs: 1e-12}
  - {signal: y, at: 3.5, value: 3}
)";

  Input u{this, "u", {.doc = "where to look"}};
  Table xs{this, "x", {.doc = "points, ascending", .ascending = true}};
  Table ys{this, "y", {.doc = "value at each point"}};
  Choice interpolation{
      this, "interpolation", {.of = {"linear", "hold", "nearest"}, .doc = "what holds between the points"}};
  Choice outside{this, "outside", {.of = {"clip", "linear", "error"}, .doc = "what holds outside the points"}};
  Output value{this, "value", {.doc = "the value"}};

  void sizes(Sizing& sizing) const override {
    const Shape x = sizing.of(xs), y = sizing.of(ys);
    if (!x.is_known() || !y.is_known()) return;
    if (x.size() < 2) return sizing.problem(xs, "a table needs at least two points");
    if (x.size() == y.size()) return;
    sizing.problem(ys, fmt::format("{} points x need as many values y, but there are {}", x.size(), y.size()));
  }

  void outputs(Now now, Out out) const override {
    const Array at = now[u], x = now[xs], y = now[ys];
    const int n = x.size();
    const bool goes_on = interpolation.is("linear") && outside.is("linear");
    // Line k holds from begins[k] on, the first one from the beginning.
    Lines lines;
    std::vector<Value> begins;
    const auto add = [&](Value begin, const Line& line) { begins.push_back(begin), lines.push_back(line); };
    if (interpolation.is("linear")) {
      if (!goes_on) add(x[0], {x[0], y[0], 0.0});
      for (int i = 0; i + 1 < n; ++i) add(x[i], {x[i], y[i], (y[i + 1] - y[i]) / (x[i + 1] - x[i])});
      if (!goes_on) add(x[n - 1], {x[n - 1], y[n - 1], 0.0});
    } else {
      const bool held = interpolation.is("hold");
      for (int i = 0; i < n; ++i) add(held || i == 0 ? x[i] : 0.5 * (x[i - 1] + x[i]), {x[i], y[i], 0.0});
    }
    Array result(at.shape());
    for (int e = 0; e < at.size(); ++e) {
      const Line line = choose(lines, begins, 0, lines.size(), at[e]);
      result[e] = line.value + line.slope * (at[e] - line.from);
      if (outside.is("error")) stay_inside_table(now, "the input", at[e], x[0], x[n - 1]);
    }
    out[value] = result;
  }

 private:
  struct Line {
    Value from, value, slope;
  };
  using Lines = std::vector<Line>;

  // Which line holds is a mode, so only the line itself is computed in every step.
  static Line choose(const Lines& lines, const std::vector<Value>& begins, std::size_t first, std::size_t last,
                     Value at) {
    if (last - first == 1) return lines[first];
    const std::size_t middle = (first + last) / 2;
    const Truth below = at < begins[middle];
    const Line left = choose(lines, begins, first, middle, at), right = choose(lines, begins, middle, last, at);
    return {where(below, left.from, right.from), where(below, left.value, right.value),
            where(below, left.slope, right.slope)};
  }
};

}  // namespace

PLANTLOOP_BLOCK(lookup_1d, Lookup1d)

}  // namespace plantloop
