// The motor-generator of the book's chapter 2 as a closed form: a static curve, a delay, a lag of second order.

#pragma once

#include <Eigen/Core>
#include <cmath>

#include "identify/data/data_set.h"
#include "identify/data/excitation.h"

namespace plantloop::identify::motor {

inline constexpr double Ts = 0.02, wn = 11.45555, damping = 0.62957, delay = 0.031, bias = 8.5;

inline double curve(double u) {
  const double L = std::max(u - 1, 0.0);
  return 0.885 * L + 0.9 * std::min(L / 2, 1.0) / (1 + std::exp((u - 5) / 0.15));
}

// wn^2/(s^2 + 2 z wn s + wn^2) to a unit step.
inline double step_response(double t) {
  if (t <= 0) return 0;
  const double wd = wn * std::sqrt(1 - damping * damping);
  const double s = damping * wn;
  return 1 - std::exp(-s * t) * (std::cos(wd * t) + s / wd * std::sin(wd * t));
}

// The output at the samples for deviations du from the bias, from rest at the bias. The sum of step responses is exact.
inline Eigen::VectorXd respond(const Eigen::VectorXd& du) {
  Eigen::VectorXd y = Eigen::VectorXd::Constant(du.size(), curve(bias));
  double before = curve(bias);
  for (Eigen::Index j = 0; j < du.size(); ++j) {
    const double now = curve(bias + du[j]);
    const double change = now - before;
    before = now;
    if (change == 0) continue;
    for (Eigen::Index k = j; k < du.size(); ++k) {
      y[k] += change * step_response(static_cast<double>(k - j) * Ts - delay);
    }
  }
  return y;
}

inline DataSet record(const Eigen::VectorXd& du, double sigma = 0, std::uint32_t seed = 7919) {
  Eigen::VectorXd y = respond(du);
  if (sigma > 0) y += portable_noise(du.size(), sigma, seed);
  return make_data_set(du, y, Ts, {{"u", "V"}}, {{"y", "V"}});
}

inline DataSet prbs_record(double sigma = 0, std::uint32_t seed = 7919) { return record(prbs(7, 5, 1), sigma, seed); }

}  // namespace plantloop::identify::motor
