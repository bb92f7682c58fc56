// Data for the tests of Gaussian processes.

#pragma once

#include <Eigen/Core>

#include "identify/random.h"

namespace plantloop::identify {

inline Eigen::MatrixXd random_points(int n, int d, std::uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd x(n, d);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < d; ++j) x(i, j) = random.uniform(-1.5, 1.5);
  }
  return x;
}

// Positive numbers around 1.
inline Eigen::VectorXd random_positive(int n, std::uint64_t seed) {
  Random random(seed);
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = random.uniform(0.3, 2.0);
  return v;
}

// y(k) = y(k-1) - 0.5 tanh(y(k-1) + u(k-1)^3) as a static map of its two regressors, with noise.
inline Eigen::VectorXd first_order_targets(const Eigen::MatrixXd& x, double sigma, std::uint64_t seed) {
  Random random(seed + 700);
  Eigen::VectorXd y(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    y[i] = x(i, 0) - 0.5 * std::tanh(x(i, 0) + std::pow(x(i, 1), 3)) + sigma * random.normal();
  return y;
}

// The eight points of the static example f(x) = 4 x^2 + x - 6 sin x + 1, noise included.
inline Eigen::MatrixXd eight_x() {
  Eigen::MatrixXd x(8, 1);
  x << 0.03, 0.10, 0.38, 0.51, 0.56, 0.68, 0.74, 0.95;
  return x;
}
inline Eigen::VectorXd eight_y() {
  Eigen::VectorXd y(8);
  y << 0.914, 0.477, -0.157, -0.310, -0.429, -0.233, -0.162, 0.684;
  return y;
}
// Exponential form v1 exp(-w d^2/2) plus noise.
inline Eigen::VectorXd se(double w, double v1) {
  Eigen::VectorXd theta(2);
  theta << w, v1;
  return theta;
}

}  // namespace plantloop::identify
