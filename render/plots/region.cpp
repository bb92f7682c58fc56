// Filled polygons.

#include <cmath>

#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Region : Plot {
  Column x{this, "x", "corners; a not-a-number begins the next polygon"};
  Column y{this, "y", "corners"};

  Region() : Plot("filled polygons with their borders") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "y", given[y]);
    Series filled{.kind = Series::Kind::areas};
    filled.look = given.look;
    if (filled.look.opacity == 1) filled.look.opacity = 0.22;
    std::vector<double> border_x, border_y;
    Area area;
    const auto close = [&] {
      if (area.x.size() >= 3) {
        border_x.insert(border_x.end(), area.x.begin(), area.x.end());
        border_y.insert(border_y.end(), area.y.begin(), area.y.end());
        border_x.insert(border_x.end(), {area.x.front(), std::nan("")});
        border_y.insert(border_y.end(), {area.y.front(), std::nan("")});
        filled.areas.push_back(area);
      }
      area = {};
    };
    for (std::size_t i = 0; i < given[x].size(); ++i) {
      if (std::isnan(given[x][i]) || std::isnan(given[y][i])) {
        close();
        continue;
      }
      area.x.push_back(given[x][i]);
      area.y.push_back(given[y][i]);
    }
    close();
    canvas.own_x();
    canvas.add(std::move(filled), given);
    SeriesLook border = given.look;
    border.label.clear();
    border.same_color = true;
    if (border.width == 0) border.width = 0.7;
    canvas.add(line_series(border_x, border_y, border), given);
  }

  Figure example() const override {
    Figure figure{.title = "Gains for which the loop is stable, and which keep the margins"};
    figure.add_panel({.x = Axis{.label = "K_i [1/s]"}, .y = {.label = "K_p"}});
    const auto shape = [](double size) {
      std::pair<std::vector<double>, std::vector<double>> ring;
      for (const double a : example::grid(0, 6.283185307, 121)) {
        ring.first.push_back(4 + size * 3 * std::cos(a) + 0.4 * size * std::cos(3 * a));
        ring.second.push_back(3 + size * 2 * std::sin(a) * (1 + 0.3 * std::cos(a)));
      }
      return ring;
    };
    for (const auto& [size, label] : {std::pair{1.0, "stable"}, {0.55, "with margins"}}) {
      const auto [xs, ys] = shape(size);
      use(figure, 0, {{"x", xs}, {"y", ys}}, {.label = label});
    }
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(region, Region)

}  // namespace plantloop
