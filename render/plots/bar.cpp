// Bars over names or numbers.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/error.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Bar : Plot {
  Column y{this, "y", "heights"};
  Texts names{this, "names", "what stands below each bar; else its number"};
  Real base{this, "base", 0, "where the bars begin"};
  Real width{this, "width_of", 0.72, "of a bar or a group of bars, as a part of the distance between them"};
  Real nth{this, "nth", 1, "which of the bars that stand side by side these are, from 1"};
  Real of{this, "of", 1, "how many stand side by side"};

  Bar() : Plot("bars over names, several side by side") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const std::size_t n = given[y].size();
    if (!given[names].empty() && given[names].size() != n)
      throw RenderError(fmt::format("y has {} numbers and names has {}", n, given[names].size()));
    const double count = std::clamp(given[of], 1.0, 100.0), place = std::clamp(given[nth], 1.0, count);
    const double group = std::clamp(given[width], 0.05, 1.0), each = group / count;
    Series bars{.kind = Series::Kind::areas};
    bars.look = given.look;
    bars.crisp = true;
    for (std::size_t i = 0; i < n; ++i) {
      const double middle = static_cast<double>(i) + 1 - group / 2 + (place - 0.5) * each, half = 0.47 * each;
      const double a = middle - half, b = middle + half, top = given[y][i];
      if (std::isfinite(top)) bars.areas.push_back({{a, b, b, a}, {given[base], given[base], top, top}, {}});
    }
    Axis& axis = canvas.own_x();
    axis.limits = {0.4, static_cast<double>(std::max<std::size_t>(n, 1)) + 0.6};
    for (std::size_t i = axis.ticks.size(); i < n; ++i)
      axis.ticks.push_back(
          {static_cast<double>(i) + 1, given[names].empty() ? fmt::format("{}", i + 1) : given[names][i]});
    canvas.add(std::move(bars), given);
    if (!given.right) canvas.panel().lines.push_back({.at = given[base], .style = LineStyle::solid});
  }

  Figure example() const override {
    Figure figure{.title = "Steps of five solvers on two problems"};
    figure.add_panel({.y = {.label = "steps"}});
    const std::vector<std::string> solvers{"euler", "rk4", "dopri5", "cvode", "trapezoid"};
    use(figure, 0, {{"y", std::vector<double>{1000, 250, 96, 141, 320}}, {"names", solvers}, {"nth", 1.0}, {"of", 2.0}},
        {.label = "pendulum"});
    use(figure, 0,
        {{"y", std::vector<double>{1000, 1000, 642, 188, 400}}, {"names", solvers}, {"nth", 2.0}, {"of", 2.0}},
        {.label = "stiff tank"});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(bar, Bar)

}  // namespace plantloop
