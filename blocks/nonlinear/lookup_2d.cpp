// A table over two signals.

#include <fmt/format.h>

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Lookup2d final : Block {
  static constexpr auto summary = "Look a value up in a table of two inputs, with bilinear interpolation.";
  static constexpr auto details =
      "In the cell x[i] <= u < x[i+1], y[j] <= v < y[j+1], with f and g the shares of the way from its lower ends: "
      "value = (1-f)(1-g) z[i,j] + f (1-g) z[i+1,j] + (1-f) g z[i,j+1] + f g z[i+1,j+1]. outside: clip holds the "
      "values at the border, linear goes on with the outermost cells, error ends the run. The borders of cells are "
      "events, so no accuracy is lost at them.";
  static constexpr auto example = R"(
blocks:
  eta:
    type: lookup_2d
    in: {u: 1500 + 500*time, v: 25}
    x: [1000, 2000, 3000]
    y: [0, 50]
    z: [[0.2, 0.3], [0.3, 0.5], [0.3, 0.4]]
simulation: {stop: 3}
expect:
  - {signal: eta, at: 0, value: 0.325, abs: 1e-12}
  - {signal: eta, at: 1, value: 0.4, abs: 1e-12}
)";

  Input u{this, "u", {.doc = "where to look along x"}};
  Input v{this, "v", {.doc = "where to look along y"}};
  Table xs{this, "x", {.doc = "points of u, ascending", .ascending = true}};
  Table ys{this, "y", {.doc = "points of v, ascending", .ascending = true}};
  Table zs{this, "z", {.doc = "values: one row for each x, one column for each y"}};
  Choice outside{this, "outside", {.of = {"clip", "linear", "error"}, .doc = "what holds outside the points"}};
  Output value{this, "value", {.doc = "the value"}};

  void sizes(Sizing& sizing) const override {
    const Shape x = sizing.of(xs), y = sizing.of(ys), z = sizing.of(zs);
    if (!x.is_known() || !y.is_known() || !z.is_known()) return;
    if (x.size() < 2) return sizing.problem(xs, "a table needs at least two points");
    if (y.size() < 2) return sizing.problem(ys, "a table needs at least two points");
    if (z.rank == 2 && z.rows == x.size() && z.columns == y.size()) return;
    sizing.problem(zs, fmt::format("{} points x and {} points y need a {} by {} matrix z, but it is {}", x.size(),
                                   y.size(), x.size(), y.size(), to_string(z)));
  }

  void outputs(Now now, Out out) const override {
    const Array x = now[xs], y = now[ys], z = now[zs], first = now[u], second = now[v];
    Array result((first + second).shape());
    for (int e = 0; e < result.size(); ++e) {
      const Place f = place(now, u, first.at(e), x), g = place(now, v, second.at(e), y);
      const Value columns = static_cast<double>(y.size());
      const auto at = [&](double down, double right) {
        return pick(z.spread(Shape::vector(z.size())), (f.index + down) * columns + (g.index + right));
      };
      const Value near = at(0, 0), below = at(1, 0), beside = at(0, 1), across = at(1, 1);
      result[e] = near + f.share * (below - near) + g.share * (beside - near) +
                  f.share * g.share * (near - below - beside + across);
    }
    out[value] = result;
  }

 private:
  struct Place {
    Value index;  // of the interval, from 0
    Value share;  // of the way through it
  };
  Place place(Now now, const Input& port, Value at, const Array& points) const {
    const int n = points.size();
    Value index = 0;
    for (int i = 1; i + 1 < n; ++i) index = index + where(at >= points[i], 1.0, 0.0);
    if (outside.is("error"))
      stay_inside_table(now, fmt::format("the input '{}'", port.name), at, points[0], points[n - 1]);
    const Value inside = outside.is("linear") ? at : min(max(at, points[0]), points[n - 1]);
    const Value from = pick(points, index), to = pick(points, index + 1.0);
    return {index, (inside - from) / (to - from)};
  }
};

}  // namespace

PLANTLOOP_BLOCK(lookup_2d, Lookup2d)

}  // namespace plantloop
