// Where each local model counts.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/error.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Weighting : Plot {
  Column x{this, "x", "the variable that the models are blended by, ascending"};
  Grid weights{this, "weights", "a row for each x, a column for each model"};
  Texts names{this, "names", "the models' names"};

  Weighting() : Plot("weighting functions of local models, each with its area") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const GridValues& all = given[weights];
    if (all.rows != given[x].size())
      throw RenderError(fmt::format("x has {} numbers and weights has {} rows", given[x].size(), all.rows));
    if (!given[names].empty() && given[names].size() != all.columns)
      throw RenderError(fmt::format("weights has {} columns and names has {}", all.columns, given[names].size()));
    canvas.name(canvas.panel().y, "weight μ");
    const std::vector<double> zero(given[x].size(), 0.0);
    for (std::size_t k = 0; k < all.columns; ++k) {
      std::vector<double> mu;
      for (std::size_t i = 0; i < all.rows; ++i) mu.push_back(all.at(i, k));
      const std::string name = given[names].empty() ? fmt::format("μ_{{{}}}", k + 1) : given[names][k];
      // A few curves have their names at their tops, many have a key.
      const bool at_top = all.columns <= 8;
      const std::size_t series =
          canvas.add(line_series(given[x], mu, {.label = at_top ? "" : name, .width = given.look.width}), given);
      const auto top =
          std::max_element(mu.begin(), mu.end(), [](double a, double b) { return a < b || std::isnan(a); });
      if (at_top && top != mu.end())
        canvas.panel().callouts.push_back({.x = given[x][static_cast<std::size_t>(top - mu.begin())],
                                           .y = *top,
                                           .label = name,
                                           .marker = Marker::none,
                                           .color_of = series,
                                           .right = given.right});
      canvas.add(band_series(given[x], zero, mu, {.same_color = true, .opacity = 0.14}), given);
    }
  }

  Figure example() const override {
    Figure figure{.title = "Weights of four local models"};
    figure.x.label = "operating point q";
    figure.add_panel();
    const auto q = example::grid(0, 1, 201);
    GridValues mu{q.size(), 4, {}};
    for (const double at : q) {
      double value[4], sum = 0;
      for (int k = 0; k < 4; ++k) sum += value[k] = std::exp(-0.5 * std::pow((at - k / 3.0) / 0.13, 2));
      for (const double v : value) mu.values.push_back(v / sum);
    }
    use(figure, 0, {{"x", q}, {"weights", mu}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(weighting, Weighting)

}  // namespace plantloop
