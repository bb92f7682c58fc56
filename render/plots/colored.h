// What plot types share that show a grid of values as colours.

#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/error.h"
#include "render/plots/plot.h"
#include "render/theme.h"

namespace plantloop {

// The inputs `map`, `lower`, `upper` and `scale`.
struct Colored {
  Plot::Choice map;
  Plot::Real lower, upper;
  Plot::Text label;

  explicit Colored(Plot* plot)
      : map(plot, "map", {"viridis", "diverging", "gray", "tint"}, "the colours"),
        lower(plot, "lower", std::nan(""), "the value of the first colour; else the least"),
        upper(plot, "upper", std::nan(""), "the value of the last colour; else the greatest"),
        label(plot, "scale", "what the colour bar says") {}

  ColorScale scale(const Given& given, const std::vector<double>& values) const {
    ColorScale scale{.lower = given[lower], .upper = given[upper], .label = given[label], .map = given[map]};
    double least = 1, most = -1;
    for (const double v : values) {
      if (!std::isfinite(v)) continue;
      if (least > most) least = most = v;
      least = std::min(least, v);
      most = std::max(most, v);
    }
    if (least > most) least = 0, most = 1;
    if (scale.map == "diverging") {
      most = std::max(std::abs(least), std::abs(most));
      least = -most;
    }
    if (!std::isfinite(scale.lower)) scale.lower = std::max(least, -1e300);
    if (!std::isfinite(scale.upper)) scale.upper = std::min(most, 1e300);
    if (!(scale.lower < scale.upper)) scale.upper = scale.lower + std::max(1.0, std::abs(scale.lower));
    return scale;
  }
};

// The given middles, or 1, 2, ...
inline std::vector<double> middles(const std::vector<double>& given, std::size_t count) {
  if (!given.empty()) return given;
  std::vector<double> result;
  for (std::size_t i = 1; i <= count; ++i) result.push_back(static_cast<double>(i));
  return result;
}

inline void check_grid(const GridValues& z, const std::vector<double>& x, const std::vector<double>& y) {
  if (z.columns != x.size())
    throw RenderError(fmt::format("x has {} numbers and z has {} columns", x.size(), z.columns));
  if (z.rows != y.size()) throw RenderError(fmt::format("y has {} numbers and z has {} rows", y.size(), z.rows));
}

// The panel ends where the field ends, unless the user says else.
inline void frame(Canvas& canvas, const std::vector<double>& x, const std::vector<double>& y) {
  const auto set = [](Limits& limits, const std::vector<double>& ends) {
    double least = 1, most = -1;
    for (const double v : ends) {
      if (!std::isfinite(v)) continue;
      if (least > most) least = most = v;
      least = std::min(least, v);
      most = std::max(most, v);
    }
    if (!(least < most)) return;
    if (!limits.lower) limits.lower = least;
    if (!limits.upper) limits.upper = most;
  };
  set(canvas.own_x().limits, x);
  set(canvas.panel().y.limits, y);
}

}  // namespace plantloop
