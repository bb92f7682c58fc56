// Data for the examples of plot types: closed forms, and noise that is the same everywhere.

#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "render/plots/plot.h"

namespace plantloop::example {

inline std::vector<double> grid(double from, double to, int count) {
  std::vector<double> result;
  for (int i = 0; i < count; ++i) result.push_back(from + (to - from) * i / (count - 1));
  return result;
}

inline std::vector<double> map(const std::vector<double>& x, const std::function<double(double)>& f) {
  std::vector<double> result;
  for (const double v : x) result.push_back(f(v));
  return result;
}

inline GridValues field(const std::vector<double>& x, const std::vector<double>& y,
                        const std::function<double(double, double)>& f) {
  GridValues z{y.size(), x.size(), {}};
  for (const double v : y)
    for (const double u : x) z.values.push_back(f(u, v));
  return z;
}

// Nearly normal: the sum of twelve numbers of a linear congruence.
struct Noise {
  std::uint32_t state = 1;
  double uniform() {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / 16777216.0;
  }
  double operator()() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
};

// The step response of a second-order lag at time t, damping below one.
inline double step_response(double t, double wn, double zeta) {
  if (t < 0) return 0;
  const double wd = wn * std::sqrt(1 - zeta * zeta);
  return 1 - std::exp(-zeta * wn * t) * (std::cos(wd * t) + zeta * wn / wd * std::sin(wd * t));
}

}  // namespace plantloop::example
