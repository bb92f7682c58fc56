// The loop of a user's program around DOPRI5.

#include "tests/accuracy/hand_written.h"

#include <algorithm>
#include <cmath>

namespace plantloop::accuracy {

// HNW, II.4 and II.5, and the step control of the author's program: beta = 0.04, factors from 0.2 to 10.
std::vector<double> by_dopri5(const Rates& f, std::vector<double> x, double stop, const Tolerances& tol) {
  static constexpr double c[] = {0, 0.2, 0.3, 0.8, 8.0 / 9, 1, 1};
  static constexpr double a[7][6] = {{},
                                     {0.2},
                                     {3.0 / 40, 9.0 / 40},
                                     {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                                     {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
  static constexpr double e[] = {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
  const std::size_t n = x.size();
  std::vector<std::vector<double>> k(7, std::vector<double>(n));
  std::vector<double> stage(n);
  const auto norm = [&](const std::vector<double>& v, const std::vector<double>& other) {
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double scaled = v[i] / (tol.atol + tol.rtol * std::max(std::abs(x[i]), std::abs(other[i])));
      sum += scaled * scaled;
    }
    return std::sqrt(sum / static_cast<double>(n));
  };
  f(0, x.data(), k[0].data());
  double t = 0, h = std::min(stop, 0.01 * norm(x, x) / std::max(norm(k[0], x), 1e-6)), last = 1e-4;
  if (!(h > 0)) h = 1e-6;
  for (bool rejected = false; t < stop;) {
    const bool ends = t + 1.01 * h >= stop;
    if (ends) h = stop - t;
    for (std::size_t s = 1; s < 7; ++s) {
      for (std::size_t i = 0; i < n; ++i) {
        stage[i] = x[i];
        for (std::size_t j = 0; j < s; ++j) stage[i] += h * a[s][j] * k[j][i];
      }
      f(t + c[s] * h, stage.data(), k[s].data());
    }
    std::vector<double> error(n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t s = 0; s < 7; ++s) error[i] += h * e[s] * k[s][i];
    }
    const double size = norm(error, stage);
    const double grow = std::pow(size, 0.2 - 0.04 * 0.75);
    if (size <= 1) {
      double factor = std::clamp(0.9 * std::pow(last, 0.04) / std::max(grow, 1e-10), 0.2, 10.0);
      if (rejected) factor = std::min(factor, 1.0);
      last = std::max(size, 1e-4);
      t = ends ? stop : t + h;
      x = stage;
      std::swap(k[0], k[6]);
      h *= factor;
      rejected = false;
    } else {
      h *= std::max(0.2, 0.9 / grow);
      rejected = true;
    }
  }
  return x;
}

}  // namespace plantloop::accuracy
