// Points with the interval in which the truth may lie.

#include <cmath>
#include <limits>

#include "render/error.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct ErrorBars : Plot {
  Column x{this, "x", "where"};
  Column y{this, "y", "measured values"};
  Column error{this, "error", "half the length of each bar", Need::optional, {"lower", "upper"}};
  Column lower{this, "lower", "its lower ends, instead of error", Need::optional};
  Column upper{this, "upper", "its upper ends, instead of error", Need::optional};

  ErrorBars() : Plot("points with bars from the lower to the upper end of what may be true") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "y", given[y]);
    std::vector<double> low = given[lower], high = given[upper];
    if (given.has(error)) {
      check_lengths("y", given[y], "error", given[error]);
      low.clear();
      high.clear();
      for (std::size_t i = 0; i < given[y].size(); ++i) {
        low.push_back(given[y][i] - std::abs(given[error][i]));
        high.push_back(given[y][i] + std::abs(given[error][i]));
      }
    }
    if (low.empty() && high.empty() && !given[y].empty())
      throw RenderError("error_bars needs 'error', or 'lower' and 'upper'");
    check_lengths("y", given[y], "lower", low);
    check_lengths("y", given[y], "upper", high);
    std::vector<double> bar_x, bar_y, ends_x, ends_y;
    for (std::size_t i = 0; i < low.size(); ++i) {
      bar_x.insert(bar_x.end(), 3, given[x][i]);
      bar_y.insert(bar_y.end(), {low[i], high[i], std::numeric_limits<double>::quiet_NaN()});
      ends_x.insert(ends_x.end(), 2, given[x][i]);
      ends_y.insert(ends_y.end(), {low[i], high[i]});
    }
    SeriesLook bars = given.look, points = given.look;
    bars.label.clear();
    bars.marker = Marker::none;
    bars.style = LineStyle::solid;
    if (bars.width == 0) bars.width = 0.8;
    canvas.add(line_series(bar_x, bar_y, bars), given);
    bars.same_color = points.same_color = true;
    bars.marker = Marker::dash;
    canvas.add(marker_series(ends_x, ends_y, bars), given);
    canvas.add(marker_series(given[x], given[y], points), given);
  }

  Figure example() const override {
    Figure figure{.title = "Static gain by five repeated measurements"};
    figure.x = {.label = "valve opening [%]", .limits = {0, 100}};
    figure.add_panel({.y = {.label = "flow [l/min]"}});
    const auto at = example::grid(10, 90, 9);
    example::Noise noise{11};
    const auto flow = [](double u) { return 60 * std::tanh(u / 55); };
    use(figure, 0,
        {{"x", at},
         {"y", example::map(at, [&](double u) { return flow(u) + 1.2 * noise(); })},
         {"error", example::map(at, [](double u) { return 1.5 + 0.03 * u; })}},
        {.label = "measured, ±2σ"});
    const auto u = example::grid(0, 100, 101);
    figure.panels[0].line(u, example::map(u, flow), {.label = "model"});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(error_bars, ErrorBars)

}  // namespace plantloop
