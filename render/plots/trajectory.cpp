// The way of three states.

#include <cmath>

#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Trajectory : Plot {
  Column x{this, "x", "first state"};
  Column y{this, "y", "second state"};
  Column z{this, "z", "third state"};
  Real azimuth{this, "azimuth", -50, "degrees that the eye is turned about the upright axis"};
  Real elevation{this, "elevation", 28, "degrees of the eye above the ground"};
  Text z_label{this, "z_label", "what the third state is"};

  Trajectory() : Plot("the way of three states through space") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "y", given[y]);
    check_lengths("x", given[x], "z", given[z]);
    Panel& panel = canvas.panel();
    if (!panel.space) panel.space = Space{};
    Space& space = *panel.space;
    space.azimuth = given[azimuth];
    space.elevation = given[elevation];
    space.x.label = panel.x ? panel.x->label : canvas.figure().x.label;
    space.y.label = panel.y.label;
    if (!given[z_label].empty()) space.z.label = given[z_label];
    space.curves.push_back({given[x], given[y], given[z], given.look.label, true});
  }

  Figure example() const override {
    Figure figure{.title = "Lorenz attractor"};
    figure.add_panel({.x = Axis{.label = "x"}, .y = {.label = "y"}});
    double a = 1, b = 1, c = 20;
    std::vector<double> xs, ys, zs;
    for (int i = 0; i < 24000; ++i) {
      constexpr double h = 0.0015;
      const double da = 10 * (b - a), db = a * (28 - c) - b, dc = a * b - 8.0 / 3 * c;
      a += h * da;
      b += h * db;
      c += h * dc;
      xs.push_back(a);
      ys.push_back(b);
      zs.push_back(c);
    }
    use(figure, 0, {{"x", xs}, {"y", ys}, {"z", zs}, {"z_label", std::string("z")}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(trajectory, Trajectory)

}  // namespace plantloop
