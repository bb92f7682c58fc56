// When something happened.

#include <fmt/format.h>

#include <cmath>

#include "render/error.h"
#include "render/plots/example.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Events : Plot {
  Column times{this, "times", "when"};
  Texts names{this, "names", "what, one for each or none"};

  Events() : Plot("upright lines where something happened, with names") {}

  void draw(Canvas& canvas, const Given& given) const override {
    if (!given[names].empty() && given[names].size() != given[times].size())
      throw RenderError(fmt::format("times has {} numbers and names has {}", given[times].size(), given[names].size()));
    const LineStyle style = given.look.style == LineStyle::solid ? LineStyle::dotted : given.look.style;
    for (std::size_t i = 0; i < given[times].size(); ++i)
      if (std::isfinite(given[times][i]))
        canvas.panel().lines.push_back({.axis = ReferenceLine::x,
                                        .at = given[times][i],
                                        .label = given[names].empty() ? "" : given[names][i],
                                        .style = style,
                                        .color = given.look.color});
  }

  Figure example() const override {
    Figure figure{.title = "A ball that bounces"};
    figure.x.label = "time [s]";
    Panel& panel = figure.add_panel({.y = {.label = "height [m]"}});
    std::vector<double> t, h, hits;
    const double g = 9.81;
    double speed = 4.2, begin = 0;
    for (int bounce = 0; bounce < 6; ++bounce) {
      const double length = 2 * speed / g;
      for (int i = 0; i <= 60; ++i) {
        const double s = length * i / 60;
        t.push_back(begin + s);
        h.push_back(speed * s - g * s * s / 2);
      }
      begin += length;
      hits.push_back(begin);
      speed *= 0.75;
    }
    panel.line(t, h, {.label = "h"});
    use(figure, 0, {{"times", hits}, {"names", std::vector<std::string>{"1st", "2nd", "3rd", "4th", "5th", "6th"}}});
    return figure;
  }
};

}  // namespace

PLANTLOOP_PLOT(events, Events)

}  // namespace plantloop
