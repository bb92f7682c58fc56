// A function of two variables in three dimensions.

#include <cmath>

#include "render/plots/colored.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct SurfacePlot : Plot {
  Grid z{this, "z", "heights, a row for each y, a column for each x"};
  Column x{this, "x", "the columns' places; else 1, 2, ...", Need::optional};
  Column y{this, "y", "the rows' places; else 1, 2, ...", Need::optional};
  Column points_x{this, "points_x", "data to show with it: their x", Need::optional};
  Column points_y{this, "points_y", "their y", Need::optional};
  Column points_z{this, "points_z", "their height", Need::optional};
  Flag wireframe{this, "wireframe", "lines without colour between them"};
  Real azimuth{this, "azimuth", -50, "degrees that the eye is turned about the upright axis"};
  Real elevation{this, "elevation", 28, "degrees of the eye above the ground"};
  Text z_label{this, "z_label", "what the height is"};
  Colored colored{this};

  SurfacePlot() : Plot("a surface or wireframe over two variables, with data points") {}

  void draw(Canvas& canvas, const Given& given) const override {
    const GridValues& values = given[z];
    Surface surface{middles(given[x], values.columns), middles(given[y], values.rows), values.values, !given[wireframe],
                    given.look.label};
    check_grid(values, surface.x, surface.y);
    check_lengths("points_x", given[points_x], "points_y", given[points_y]);
    check_lengths("points_x", given[points_x], "points_z", given[points_z]);
    Panel& panel = canvas.panel();
    if (!panel.space) panel.space = Space{};
    Space& space = *panel.space;
    space.azimuth = given[azimuth];
    space.elevation = given[elevation];
    space.x.label = panel.x ? panel.x->label : canvas.figure().x.label;
    space.y.label = panel.y.label;
    space.z.label = given[z_label];
    if (!given[wireframe] && !panel.colors) {
      panel.colors = colored.scale(given, values.values);
      panel.colors->bar = !given[colored.label].empty();
    }
    space.surfaces.push_back(std::move(surface));
    if (!given[points_x].empty())
      space.curves.push_back({given[points_x], given[points_y], given[points_z], {}, false});
  }

  Figure example() const override {
    Figure figure{.title = "Lyapunov candidate V(x_1, x_2)"};
    figure.add_panel({.x = Axis{.label = "x_1"}, .y = {.label = "x_2"}});
    const auto u = example::grid(-2, 2, 45);
    std::vector<double> px, py, pz;
    const auto height = [](double a, double b) {
      return 0.5 * a * a + 0.35 * a * b + 0.4 * b * b + 0.35 * std::cos(1.4 * a) * std::cos(b) + 0.3;
    };
    for (int i = 0; i < 26; ++i) {
      const double r = 1.9 * std::exp(-0.09 * i), angle = 0.42 * i;
      px.push_back(r * std::cos(angle));
      py.push_back(r * std::sin(angle));
      pz.push_back(height(px.back(), py.back()) + 0.02);
    }
    use(figure, 0,
        {{"z", example::field(u, u, height)},
         {"x", u},
         {"y", u},
         {"points_x", px},
         {"points_y", py},
         {"points_z", pz},
         {"scale", std::string("V")}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(surface, SurfacePlot)

}  // namespace plantloop
