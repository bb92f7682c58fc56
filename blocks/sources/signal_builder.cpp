// A signal of straight lines between given points.

#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include "engine/block.h"

namespace plantloop {
namespace {

struct SignalBuilder final : Block {
  static constexpr auto summary = "Draw straight lines through points in time.";
  static constexpr auto details =
      "y = values[i] + (values[i+1] - values[i])/(times[i+1] - times[i]) (time - times[i]) between two points. Two "
      "points of equal time are a jump. Outside: hold gives the first and the last value, linear goes on with the "
      "outermost lines, zero gives 0. With a matrix of values, y is a vector with one line for each column. The points "
      "are stops of the solver.";
  static constexpr auto example = R"(
blocks: {u: {type: signal_builder, times: [0, 1, 1, 3], values: [0, 2, 5, 1]}}
simulation: {stop: 4}
expect:
  - {signal: u, at: 0.5, value: 1, abs: 1e-12}
  - {signal: u, at: 1, value: 5}
  - {signal: u, at: 2, value: 3, abs: 1e-12}
  - {signal: u, at: 3.5, value: 1}
)";

  Table times{this, "times", {.unit = "s", .doc = "time of each point, not descending"}};
  Table values{this, "values", {.doc = "one value for each time, or one row of a matrix"}};
  Choice outside{this,
                 "outside",
                 {.of = {"hold", "linear", "zero"}, .doc = "what holds before the first and after the last point"}};
  Output y{this, "y", {.doc = "the signal", .size = any_size}};

  void check(Checking& checking) const override {
    const auto t = checking.of(times);
    for (std::size_t i = 0; i + 1 < t.size(); ++i) {
      if (t[i + 1] < t[i])
        return checking.problem(
            times,
            fmt::format("the times of the points must not descend, but {:g} stands after {:g}; equal ones are a jump",
                        t[i + 1], t[i]));
    }
    if (outside.is("linear") && t.size() > 1 && (t[0] == t[1] || t[t.size() - 2] == t.back()))
      checking.problem(times, "outside: linear goes on with the outermost lines, so no jump may stand there");
  }

  void sizes(Sizing& sizing) const override {
    const Shape t = sizing.of(times), v = sizing.of(values);
    if (v.is_known()) sizing.set(y, v.rank == 2 && v.columns > 1 ? Shape::vector(v.columns) : Shape::scalar());
    if (!t.is_known() || !v.is_known()) return;
    if (t.size() < 2) return sizing.problem(times, "a line needs at least two points");
    if (t.size() == v.rows) return;
    sizing.problem(values,
                   std::to_string(t.size()) + " times need as many values, but there are " + std::to_string(v.rows));
  }

  void outputs(Now now, Out out) const override {
    const Array all = now[values], t = now[times];
    const Value passed = segment(t);
    std::vector<Value> row;
    for (int column = 0; column < all.columns(); ++column) row.push_back(line(all, column, t, passed, now.time()));
    out[y] = row.size() == 1 ? Array(row[0]) : Array::vector(std::move(row));
  }

 private:
  // Piece k holds while k points have passed: what is outside stands at both ends.
  Value line(const Array& all, int column, const Array& t, Value passed, Value time) const {
    const int n = t.size();
    std::vector<Value> from, value, slope;
    const auto piece = [&](Value at, Value v, Value s) { from.push_back(at), value.push_back(v), slope.push_back(s); };
    const auto slope_at = [&](int i) {
      const Value length = t[i + 1] - t[i];
      return where(length > 0.0, (all(i + 1, column) - all(i, column)) / length, Value(0));
    };
    const bool goes_on = outside.is("linear"), zero = outside.is("zero");
    piece(t[0], zero ? Value(0) : all(0, column), goes_on ? slope_at(0) : Value(0));
    for (int i = 0; i + 1 < n; ++i) piece(t[i], all(i, column), slope_at(i));
    piece(t[n - 1], zero ? Value(0) : all(n - 1, column), goes_on ? slope_at(n - 2) : Value(0));
    const auto chosen = [&](std::vector<Value>& of) { return pick(Array::vector(std::move(of)), passed); };
    return chosen(value) + chosen(slope) * (time - chosen(from));
  }
};

}  // namespace

PLANTLOOP_BLOCK(signal_builder, SignalBuilder)

}  // namespace plantloop
