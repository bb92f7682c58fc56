// The frequency response in the complex plane.

#include <algorithm>
#include <cmath>

#include "render/numbers/statistics.h"
#include "render/plots/system.h"

namespace plantloop {
namespace {

constexpr double pi = 3.14159265358979323846;

struct Nyquist : Plot {
  FrequencyData data{this};
  Flag mirror{this, "mirror", "also for negative frequencies, dashed", true};
  Flag sensitivity{this, "sensitivity", "the circle about -1 that touches the curve, with the greatest sensitivity",
                   true};

  Nyquist() : Plot("the frequency response in the complex plane, with the critical point") {}

  void draw(Canvas& canvas, const Given& given) const override {
    Response r = data.response(given);
    // Down to where a system without integrators is at rest.
    if (!given.has(data.w) && given[data.from] == 0 && !r.w.empty())
      r = respond(data.system(given), r.w.front() / 100, given[data.to] > 0 ? given[data.to] : r.w.back());
    std::vector<double> x, y, below;
    double least = 1e300;
    Complex nearest = 0;
    for (const Complex v : r.value) {
      x.push_back(v.real());
      y.push_back(v.imag());
      below.push_back(-v.imag());
      if (std::abs(v + 1.0) < least) least = std::abs(v + 1.0), nearest = v;
    }
    canvas.name(canvas.own_x(), "Re L(jω)");
    canvas.name(canvas.panel().y, "Im L(jω)");
    Panel& panel = canvas.panel();
    panel.equal = true;
    const bool first = panel.callouts.empty();
    if (first) {
      circle(panel, {0, 0}, 1, Ink::grid);
      panel.lines.push_back({.axis = ReferenceLine::x, .at = 0, .style = LineStyle::solid});
      panel.lines.push_back({.at = 0, .style = LineStyle::solid});
    }
    const std::size_t series = canvas.add(line_series(x, y, given.look), given);
    if (given[mirror]) {
      SeriesLook look = given.look;
      look.label.clear();
      look.same_color = true;
      look.style = LineStyle::dashed;
      canvas.add(line_series(x, below, look), given);
    }
    if (first) panel.callouts.push_back({.x = -1, .y = 0, .label = "−1", .marker = Marker::cross});
    if (given[sensitivity] && least > 0.02 && least < 1) {
      circle(panel, {-1, 0}, least, Ink::reference);
      panel.callouts.push_back(
          {.x = nearest.real(), .y = nearest.imag(), .label = "M_s = " + short_number(1 / least), .color_of = series});
    }
    limit(panel, r);
  }

  Figure example() const override {
    Figure figure{.title = "Nyquist diagram, L(s) = 1.4 / (s (s+1)^2) and 3 / (s+1)^3"};
    use(figure, 0,
        {{"num", std::vector<double>{1.4}}, {"den", std::vector<double>{1, 2, 1, 0}}, {"sensitivity", false}},
        {.label = "with integrator"});
    use(figure, 0, {{"num", std::vector<double>{3}}, {"den", std::vector<double>{1, 3, 3, 1}}},
        {.label = "three lags"});
    return figure;
  }

 private:
  static void circle(Panel& panel, Complex middle, double radius, Ink ink) {
    std::vector<double> x, y;
    for (const double angle : evenly(0, 2 * pi, 181)) {
      x.push_back(middle.real() + radius * std::cos(angle));
      y.push_back(middle.imag() + radius * std::sin(angle));
    }
    panel.line(x, y, {.style = ink == Ink::grid ? LineStyle::solid : LineStyle::dashed, .width = 0.6, .ink = ink});
  }

  // What grows without bound, as at integrators, is not followed beyond the neighbourhood of the critical point.
  static void limit(Panel& panel, const Response& r) {
    constexpr double reach = 3.2;
    double left = -1.3, right = 0.4, high = 0.5;
    for (const Complex v : r.value) {
      if (std::abs(v) > reach) continue;
      left = std::min(left, v.real());
      right = std::max(right, v.real());
      high = std::max(high, std::abs(v.imag()));
    }
    const auto widen = [](std::optional<double>& end, double to, bool upwards) {
      if (!end || (upwards ? to > *end : to < *end)) end = to;
    };
    widen(panel.x->limits.lower, left - 0.2, false);
    widen(panel.x->limits.upper, right + 0.2, true);
    widen(panel.y.limits.lower, -high - 0.1, false);
    widen(panel.y.limits.upper, high + 0.1, true);
  }
};

}  // namespace

PLANTLOOP_PLOT(nyquist, Nyquist)

}  // namespace plantloop
