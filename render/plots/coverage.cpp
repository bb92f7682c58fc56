// Which part of the space of regressors the training data cover.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "render/numbers/statistics.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Coverage : Plot {
  Column x{this, "x", "first regressor of the training data"};
  Column y{this, "y", "second regressor"};
  Column test_x{this, "test_x", "first regressor where the model is used", Need::optional};
  Column test_y{this, "test_y", "second regressor", Need::optional};
  Real cells{this, "cells", 24, "cells each way"};

  Coverage() : Plot("how often training data visit each cell of two regressors, and where a model is used outside") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "y", given[y]);
    check_lengths("test_x", given[test_x], "test_y", given[test_y]);
    const double n = std::isfinite(given[cells]) ? std::floor(std::clamp(given[cells], 1.0, 200.0)) : 24;
    std::vector<double> all_x = given[x], all_y = given[y];
    all_x.insert(all_x.end(), given[test_x].begin(), given[test_x].end());
    all_y.insert(all_y.end(), given[test_y].begin(), given[test_y].end());
    const std::vector<double> sorted_x = finite_sorted(all_x), sorted_y = finite_sorted(all_y);
    canvas.own_x();
    if (sorted_x.empty() || sorted_y.empty()) return;
    const Scale1 across(sorted_x, n), up(sorted_y, n);
    std::map<std::pair<int, int>, double> counts;
    for (std::size_t i = 0; i < given[x].size(); ++i)
      if (std::isfinite(given[x][i]) && std::isfinite(given[y][i]))
        ++counts[{across.cell(given[x][i]), up.cell(given[y][i])}];
    double most = 1;
    for (const auto& [cell, count] : counts) most = std::max(most, count);
    // A few visits must show: the colours follow the logarithm.
    Series visited{.kind = Series::Kind::areas};
    visited.crisp = true;
    for (const auto& [cell, count] : counts) {
      const double a = across.edge(cell.first), b = across.edge(cell.first + 1), c = up.edge(cell.second),
                   d = up.edge(cell.second + 1);
      visited.areas.push_back({{a, b, b, a}, {c, c, d, d}, std::log10(count)});
    }
    canvas.panel().colors =
        ColorScale{.lower = 0, .upper = std::max(std::log10(most), 0.3), .label = "log_{10} visits", .map = "tint"};
    canvas.add(std::move(visited), given);

    std::vector<double> in_x, in_y, out_x, out_y;
    for (std::size_t i = 0; i < given[test_x].size(); ++i) {
      const double u = given[test_x][i], v = given[test_y][i];
      if (!std::isfinite(u) || !std::isfinite(v)) continue;
      const bool inside = counts.contains({across.cell(u), up.cell(v)});
      (inside ? in_x : out_x).push_back(u);
      (inside ? in_y : out_y).push_back(v);
    }
    const double total = static_cast<double>(in_x.size() + out_x.size());
    if (total == 0) return;
    canvas.add(
        marker_series(in_x, in_y,
                      {.label = "used inside", .marker = Marker::dot, .ink = Ink::text, .opacity = 0.8, .size = 2.4}),
        given);
    canvas.add(
        marker_series(out_x, out_y,
                      {.label = fmt::format("used outside, {:.1f} %", 100 * static_cast<double>(out_x.size()) / total),
                       .marker = Marker::cross,
                       .color = given.look.color.value_or(rgb(0xD55E00)),
                       .width = 1.0,
                       .size = 4}),
        given);
  }

  Figure example() const override {
    Figure figure{.title = "Regressors of the training data, and of the closed loop"};
    figure.add_panel({.x = Axis{.label = "y(k−1)"}, .y = {.label = "u(k−1)"}});
    example::Noise noise{12};
    std::vector<double> xs, ys, test_xs, test_ys;
    double state = 0;
    for (int i = 0; i < 3000; ++i) {
      const double u = std::clamp(0.9 * noise(), -2.2, 2.2);
      xs.push_back(state);
      ys.push_back(u);
      state = 0.82 * state + 0.3 * u;
    }
    for (int i = 0; i < 180; ++i) {
      const double angle = 0.035 * i;
      test_xs.push_back(1.75 * std::cos(angle));
      test_ys.push_back(1.5 * std::sin(1.2 * angle + 0.5));
    }
    use(figure, 0, {{"x", xs}, {"y", ys}, {"test_x", test_xs}, {"test_y", test_ys}});
    return figure;
  }

 private:
  // Cells between the least and the greatest value.
  struct Scale1 {
    double lower, width, count;
    Scale1(const std::vector<double>& sorted, double n)
        : lower(sorted.front()), width((sorted.back() - sorted.front()) / n), count(n) {
      if (!(width > 0) || !std::isfinite(width)) width = std::max(std::abs(lower), 1.0) / n;
    }
    int cell(double v) const { return static_cast<int>(std::clamp(std::floor((v - lower) / width), 0.0, count - 1)); }
    double edge(int k) const { return lower + k * width; }
  };
};

}  // namespace

PLANTLOOP_PLOT(coverage, Coverage)

}  // namespace plantloop
