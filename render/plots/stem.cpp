// Samples as stems.

#include <cmath>
#include <limits>

#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Stem : Plot {
  Column x{this, "x", "where the stems stand"};
  Column y{this, "y", "how far they reach"};
  Real base{this, "base", 0, "where they begin"};

  Stem() : Plot("samples as stems from a base line") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "y", given[y]);
    std::vector<double> xs, ys;
    for (std::size_t i = 0; i < given[x].size(); ++i) {
      const double at = given[x][i];
      xs.insert(xs.end(), {at, at, at});
      ys.insert(ys.end(), {given[base], given[y][i], std::numeric_limits<double>::quiet_NaN()});
    }
    SeriesLook stems = given.look, heads = given.look;
    stems.label.clear();
    stems.marker = Marker::none;
    if (stems.width == 0) stems.width = 0.8;
    heads.same_color = true;
    canvas.add(line_series(std::move(xs), std::move(ys), stems), given);
    canvas.add(marker_series(given[x], given[y], heads), given);
    if (!given.right) canvas.panel().lines.push_back({.at = given[base], .style = LineStyle::solid});
  }

  Figure example() const override {
    Figure figure{.title = "Impulse response of a sampled lag"};
    figure.x.label = "sample k";
    figure.add_panel({.y = {.label = "g(k)"}});
    const auto k = example::grid(0, 30, 31);
    use(figure, 0,
        {{"x", k}, {"y", example::map(k, [](double i) { return std::exp(-0.11 * i) * std::cos(0.55 * i); })}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(stem, Stem)

}  // namespace plantloop
