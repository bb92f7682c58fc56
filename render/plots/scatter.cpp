// Points.

#include <algorithm>
#include <cmath>

#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Scatter : Plot {
  Column x{this, "x", "first coordinates"};
  Column y{this, "y", "second coordinates"};

  Scatter() : Plot("points; many of them are translucent, so that density shows") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "y", given[y]);
    canvas.own_x();
    SeriesLook look = given.look;
    const std::size_t n = given[x].size();
    if (look.opacity == 1 && n > 150) look.opacity = n > 2000 ? 0.3 : 0.55;
    canvas.add(marker_series(given[x], given[y], look), given);
  }

  Figure example() const override {
    Figure figure{.title = "Closed-loop poles over 600 samples"};
    Panel& panel = figure.add_panel({.x = Axis{.label = "Re [s^{-1}]"}, .y = {.label = "Im [s^{-1}]"}});
    panel.lines.push_back({.axis = ReferenceLine::x, .at = 0, .style = LineStyle::solid});
    example::Noise noise{7};
    for (const double sign : {1.0, -1.0}) {
      std::vector<double> xs, ys;
      for (int i = 0; i < 300; ++i) {
        xs.push_back(-1.35 + 0.42 * noise());
        ys.push_back(sign * (1.6 + 0.3 * noise()));
      }
      use(figure, 0, {{"x", xs}, {"y", ys}}, {.label = sign > 0 ? "upper half plane" : "lower half plane"});
    }
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(scatter, Scatter)

}  // namespace plantloop
