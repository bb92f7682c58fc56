// What plot types share that show the complex plane: axes, and lines of equal damping and frequency.

#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "render/numbers/statistics.h"
#include "render/plots/system.h"

namespace plantloop {

// Limits about the points, with the origin; equal units.
inline void set_plane(Canvas& canvas, const std::vector<Complex>& points, bool sampled) {
  canvas.name(canvas.own_x(), sampled ? "Re z" : "Re s [s^{-1}]");
  canvas.name(canvas.panel().y, sampled ? "Im z" : "Im s [s^{-1}]");
  Panel& panel = canvas.panel();
  panel.equal = true;
  double left = sampled ? -1.15 : 0, right = sampled ? 1.15 : 0, high = sampled ? 1.15 : 0;
  for (const Complex p : points) {
    if (!std::isfinite(p.real()) || !std::isfinite(p.imag())) continue;
    left = std::min(left, p.real());
    right = std::max(right, p.real());
    high = std::max(high, std::abs(p.imag()));
  }
  const double size = std::max({right - left, 2 * high, 1e-290});
  const double pad = sampled ? 0 : 0.12 * size;
  high = std::max(high, 0.25 * size);
  const auto widen = [](std::optional<double>& end, double to, bool upwards) {
    if (!end || (upwards ? to > *end : to < *end)) end = to;
  };
  widen(panel.x->limits.lower, left - pad, false);
  widen(panel.x->limits.upper, right + pad, true);
  widen(panel.y.limits.lower, -high - pad, false);
  widen(panel.y.limits.upper, high + pad, true);
}

// The border of stability, and in the left half plane rays of equal damping and circles of equal frequency.
inline void draw_plane(Panel& panel, const std::vector<Complex>& points, bool sampled) {
  constexpr double pi = 3.14159265358979323846;
  const auto arc = [&](double radius, double from, double to, const SeriesLook& look) {
    std::vector<double> x, y;
    for (const double angle : evenly(from, to, 121)) {
      x.push_back(radius * std::cos(angle));
      y.push_back(radius * std::sin(angle));
    }
    panel.line(x, y, look);
  };
  panel.lines.push_back({.axis = ReferenceLine::x, .at = 0, .style = LineStyle::solid});
  panel.lines.push_back({.at = 0, .style = LineStyle::solid});
  if (sampled) {
    arc(1, 0, 2 * pi, {.width = 0.7, .ink = Ink::reference});
    return;
  }
  double reach = 0;
  for (const Complex p : points)
    if (std::isfinite(std::abs(p))) reach = std::max(reach, std::abs(p));
  if (!(reach > 0)) return;
  const double decade = std::pow(10, std::floor(std::log10(reach))), part = reach / decade;
  const double step = decade * (part < 2 ? 0.5 : part < 5 ? 1 : 2);
  if (!std::isfinite(step)) return;
  for (double radius = step; radius < 1.4 * reach; radius += step)
    arc(radius, pi / 2, 3 * pi / 2, {.style = LineStyle::dotted, .width = 0.6, .ink = Ink::reference, .opacity = 0.75});
  for (const double damping : {0.2, 0.4, 0.6, 0.8}) {
    const double x = -damping, y = std::sqrt(1 - damping * damping), far = 3 * reach;
    panel.line({far * x, 0, far * x}, {far * y, 0, -far * y},
               {.style = LineStyle::dotted, .width = 0.6, .ink = Ink::reference, .opacity = 0.75});
    panel.callouts.push_back(
        {.x = 1.07 * reach * x, .y = 1.07 * reach * y, .label = "ζ " + short_number(damping), .quiet = true});
  }
}

}  // namespace plantloop
