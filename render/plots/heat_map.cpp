// A matrix as colours.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/error.h"
#include "render/plots/colored.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

constexpr std::size_t most = 600;  // cells each way: more than pixels are no use

struct HeatMap : Plot {
  Grid z{this, "z", "values, a row for each y, a column for each x"};
  Column x{this, "x", "the columns' middles; else 1, 2, ...", Need::optional};
  Column y{this, "y", "the rows' middles; else 1, 2, ...", Need::optional};
  Colored colored{this};

  HeatMap() : Plot("a matrix as colours") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const GridValues& values = given[z];
    const std::vector<double> xs = middles(given[x], values.columns), ys = middles(given[y], values.rows);
    check_grid(values, xs, ys);
    const ColorScale scale = colored.scale(given, values.values);
    const std::vector<double> left = edges(xs), low = edges(ys);
    // Cells of one colour that are neighbours in a row become one; equal colours are drawn together.
    std::vector<std::pair<int, Area>> cells;
    const std::size_t step_x = (values.columns + most - 1) / most, step_y = (values.rows + most - 1) / most;
    for (std::size_t row = 0; row < values.rows; row += step_y)
      for (std::size_t column = 0; column < values.columns;) {
        const int level = level_of(scale, values.at(row, column));
        std::size_t end = column + step_x;
        while (end < values.columns && level_of(scale, values.at(row, end)) == level) end += step_x;
        end = std::min(end, values.columns);
        const double a = left[column], b = left[end], c = low[row], d = low[std::min(row + step_y, values.rows)];
        if (level >= 0)
          cells.push_back(
              {level, {{a, b, b, a}, {c, c, d, d}, scale.lower + (level + 0.5) / 256 * (scale.upper - scale.lower)}});
        column = end;
      }
    std::stable_sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    Series series{.kind = Series::Kind::areas};
    series.crisp = true;
    for (auto& [level, area] : cells) series.areas.push_back(std::move(area));
    canvas.panel().colors = scale;
    frame(canvas, left, low);
    canvas.add(std::move(series), given);
  }

  Figure example() const override {
    Figure figure{.title = "Cost landscape of a PD controller"};
    figure.add_panel({.x = Axis{.label = "K_p"}, .y = {.label = "K_d"}});
    const auto u = example::grid(-3, 3, 121), v = example::grid(-3, 3, 121);
    use(figure, 0,
        {{"z", example::field(u, v,
                              [](double a, double b) {
                                return std::log10(0.05 + std::pow(1 - a, 2) + 1.5 * std::pow(b - 0.3 * a * a, 2));
                              })},
         {"x", u},
         {"y", v},
         {"scale", std::string("log_{10} J")}});
    return figure;
  }

 private:
  static int level_of(const ColorScale& scale, double value) {
    if (!std::isfinite(value)) return -1;
    const double part = (value - scale.lower) / (scale.upper - scale.lower);
    return part > 0 ? static_cast<int>(std::min(256 * part, 255.0)) : 0;
  }

  // Halfway between the middles.
  static std::vector<double> edges(const std::vector<double>& at) {
    std::vector<double> result;
    const std::size_t n = at.size();
    for (std::size_t i = 0; i <= n; ++i) {
      if (n == 0) break;
      if (n == 1)
        result.push_back(at[0] + (i == 0 ? -0.5 : 0.5));
      else if (i == 0)
        result.push_back(at[0] - (at[1] - at[0]) / 2);
      else if (i == n)
        result.push_back(at[n - 1] + (at[n - 1] - at[n - 2]) / 2);
      else
        result.push_back(at[i - 1] + (at[i] - at[i - 1]) / 2);
    }
    return result;
  }
};

}  // namespace

PLANTLOOP_PLOT(heat_map, HeatMap)

}  // namespace plantloop
