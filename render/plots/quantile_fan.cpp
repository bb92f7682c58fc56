// Where the bulk of many runs lies.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/error.h"
#include "render/numbers/statistics.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct QuantileFan : Plot {
  Column x{this, "x", "time, or what else the runs share"};
  Grid runs{this, "runs", "a row for each x, a column for each run"};
  Real outer{this, "outer", 0.05, "below the pale band lies this part of the runs, and as many above it"};
  Real inner{this, "inner", 0.25, "the same for the dark band"};

  QuantileFan() : Plot("the median of many runs, and bands with most of them") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const GridValues& all = given[runs];
    if (all.rows != given[x].size())
      throw RenderError(fmt::format("x has {} numbers and runs has {} rows", given[x].size(), all.rows));
    std::vector<double> middle, low[2], high[2];
    const double parts[] = {std::clamp(given[outer], 0.0, 0.5), std::clamp(given[inner], 0.0, 0.5)};
    for (std::size_t i = 0; i < all.rows; ++i) {
      const auto row = all.values.begin() + static_cast<std::ptrdiff_t>(i * all.columns);
      const std::vector<double> sorted = finite_sorted({row, row + static_cast<std::ptrdiff_t>(all.columns)});
      middle.push_back(quantile(sorted, 0.5));
      for (int k = 0; k < 2; ++k) {
        low[k].push_back(quantile(sorted, parts[k]));
        high[k].push_back(quantile(sorted, 1 - parts[k]));
      }
    }
    SeriesLook look = given.look;
    if (look.label.empty()) look.label = "median";
    canvas.add(line_series(given[x], middle, look), given);
    look.same_color = true;
    for (int k = 0; k < 2; ++k) {
      look.opacity = k == 0 ? 0.2 : 0.36;
      look.label = fmt::format("{:g} to {:g} %", 100 * parts[k], 100 * (1 - parts[k]));
      canvas.add(band_series(given[x], low[k], high[k], look), given);
    }
  }

  Figure example() const override {
    Figure figure{.title = "Step response, 200 runs with uncertain damping"};
    figure.x.label = "time t [s]";
    figure.add_panel({.y = {.label = "output y"}}).lines.push_back({.at = 1});
    const auto t = example::grid(0, 10, 301);
    GridValues made{t.size(), 200, std::vector<double>(t.size() * 200)};
    example::Noise noise{5};
    for (std::size_t k = 0; k < 200; ++k) {
      const double zeta = std::clamp(0.25 + 0.08 * noise(), 0.05, 0.9), wn = 2.4 * (1 + 0.06 * noise());
      for (std::size_t i = 0; i < t.size(); ++i) made.values[i * 200 + k] = example::step_response(t[i], wn, zeta);
    }
    use(figure, 0, {{"x", t}, {"runs", made}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(quantile_fan, QuantileFan)

}  // namespace plantloop
