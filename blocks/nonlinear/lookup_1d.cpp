// A table of values, with straight lines in between.

#include <fmt/format.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/block.h"
#include "engine/program/kernel.h"

namespace plantloop {
namespace {

// Ends the run when an accepted value lies outside the table; what a solver tries in between does not count.
class InsideTable final : public Kernel {
 public:
  explicit InsideTable(std::string path) : path_(std::move(path)) {}
  std::string name() const override { return "range of a table"; }
  int outputs() const override { return 0; }
  void evaluate(const KernelCall&) const override {}
  void initialise(const KernelCall& call) const override { advance(call); }
  void advance(const KernelCall& call) const override {
    const double u = call.in[0], least = call.in[1], greatest = call.in[2];
    if (u >= least && u <= greatest) return;
    throw RunError(fmt::format("at time {:g} s the input of block '{}' is {:g}, outside its table from {:g} to {:g}",
                               call.time, path_, u, least, greatest),
                   call.time, path_);
  }

 private:
  std::string path_;
};

struct Lookup1d final : Block {
  static constexpr auto summary = "Look a value up in a table, with straight lines between its points.";
  static constexpr auto details =
      "y = y[i] + (y[i+1] - y[i])/(x[i+1] - x[i]) (u - x[i]) for x[i] <= u < x[i+1]. outside: clip holds the end "
      "values, "
      "linear goes on with the outermost lines, error ends the run. The kinks are events, so no accuracy is lost at "
      "them.";
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
    Lines lines;
    const int n = x.size();
    if (!outside.is("linear")) lines.push_back({x[0], y[0], 0.0});
    for (int i = 0; i + 1 < n; ++i) lines.push_back({x[i], y[i], (y[i + 1] - y[i]) / (x[i + 1] - x[i])});
    if (!outside.is("linear")) lines.push_back({x[n - 1], y[n - 1], 0.0});
    Array result(at.shape());
    for (int e = 0; e < at.size(); ++e) {
      const Line line = choose(lines, 0, lines.size(), at[e], outside.is("linear") ? 0 : -1, x);
      result[e] = line.value + line.slope * (at[e] - line.from);
      if (outside.is("error")) now.kernel(std::make_shared<InsideTable>(now.path()), {}, {at[e], x[0], x[n - 1]});
    }
    out[value] = result;
  }

 private:
  struct Line {
    Value from, value, slope;
  };
  using Lines = std::vector<Line>;

  // Line i holds from x[i + shift] on; which one is a mode, so only the line itself is computed in every step.
  static Line choose(const Lines& lines, std::size_t first, std::size_t last, Value at, int shift, const Array& x) {
    if (last - first == 1) return lines[first];
    const std::size_t middle = (first + last) / 2;
    const Truth below = at < x[static_cast<int>(middle) + shift];
    const Line left = choose(lines, first, middle, at, shift, x), right = choose(lines, middle, last, at, shift, x);
    return {where(below, left.from, right.from), where(below, left.value, right.value),
            where(below, left.slope, right.slope)};
  }
};

}  // namespace

PLANTLOOP_BLOCK(lookup_1d, Lookup1d)

}  // namespace plantloop
