// Directions in the plane of two states, and the ways through it.

#include <cmath>
#include <limits>

#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct PhasePortrait : Plot {
  Column x{this, "x", "first state, where directions are known"};
  Column y{this, "y", "second state there"};
  Column dx{this, "dx", "its rate of change, first state"};
  Column dy{this, "dy", "second state"};

  PhasePortrait() : Plot("arrows along the rates of change of two states; draw trajectories over them as lines") {}

  void draw(Canvas& canvas, const Given& given) const override {
    check_lengths("x", given[x], "y", given[y]);
    check_lengths("x", given[x], "dx", given[dx]);
    check_lengths("x", given[x], "dy", given[dy]);
    canvas.own_x();
    Series arrows{.kind = Series::Kind::arrows, .x = given[x], .y = given[y]};
    arrows.toward_x = given[dx];
    arrows.toward_y = given[dy];
    arrows.look = given.look;
    arrows.look.label.clear();
    if (arrows.look.width == 0) arrows.look.width = 0.55;
    if (!arrows.look.color && arrows.look.ink == Ink::palette) arrows.look.ink = Ink::reference;
    // Wide enough for every arrow: what has the ink of a reference does not widen the axes.
    const auto reach = [](Limits& limits, const std::vector<double>& at) {
      double least = std::numeric_limits<double>::infinity(), most = -least;
      for (const double v : at)
        if (std::isfinite(v)) least = std::min(least, v), most = std::max(most, v);
      if (!(least < most)) return;
      if (!limits.lower) limits.lower = least;
      if (!limits.upper) limits.upper = most;
    };
    reach(canvas.panel().x->limits, given[x]);
    reach(canvas.panel().y.limits, given[y]);
    canvas.add(std::move(arrows), given);
  }

  Figure example() const override {
    Figure figure{.title = "Phase portrait of the van der Pol oscillator, μ = 1"};
    Panel& panel = figure.add_panel({.x = Axis{.label = "x_1"}, .y = {.label = "x_2"}});
    std::vector<double> xs, ys, us, vs;
    for (const double b : example::grid(-4, 4, 19))
      for (const double a : example::grid(-4, 4, 25)) {
        xs.push_back(a);
        ys.push_back(b);
        us.push_back(b);
        vs.push_back((1 - a * a) * b - a);
      }
    use(figure, 0, {{"x", xs}, {"y", ys}, {"dx", us}, {"dy", vs}});
    for (const auto& [a0, b0] : {std::pair{0.1, 0.0}, {3.5, 3.0}, {-3.5, -2.5}}) {
      double a = a0, b = b0;
      std::vector<double> way_a, way_b;
      for (int i = 0; i < 16000; ++i) {
        way_a.push_back(a);
        way_b.push_back(b);
        b += 0.001 * ((1 - a * a) * b - a);
        a += 0.001 * b;
      }
      panel.line(way_a, way_b);
      panel.callouts.push_back({.x = a0, .y = b0, .label = "", .color_of = panel.series.size() - 1});
    }
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(phase_portrait, PhasePortrait)

}  // namespace plantloop
