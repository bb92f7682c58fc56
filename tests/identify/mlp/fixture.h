// The first-order system of the book, y(k) = y(k-1) - 0.5 tanh(y(k-1) + u(k-1)^3), and its printed network.

#pragma once

#include <Eigen/Core>
#include <cmath>

#include "identify/data/data_set.h"
#include "identify/mlp/network.h"
#include "identify/random.h"

namespace plantloop::identify {

// Levels uniform in (-range, range), each held for `hold` samples; `equation` is noise that is fed back, `measurement`
// noise is not.
inline DataSet first_order_data(int samples, int hold, std::uint64_t seed, double equation = 0, double measurement = 0,
                                double range = 1.2) {
  Random random(seed);
  Eigen::MatrixXd u(samples, 1), y(samples, 1);
  double state = 0, level = 0;
  for (Eigen::Index k = 0; k < samples; ++k) {
    if (k % hold == 0) level = random.uniform(-range, range);
    if (k > 0) state = state - 0.5 * std::tanh(state + std::pow(u(k - 1, 0), 3)) + equation * random.normal();
    u(k, 0) = level;
    y(k, 0) = state + measurement * random.normal();
  }
  return make_data_set(u, y, 0.5, {{"u", ""}}, {{"y", ""}});
}

inline Network printed_network() {
  Network network = make_network(2, {5}, 1, Activation::tanh);
  network.layers[0].w << -0.5588, -2.0621, -1.9530, 0.5155, 0.0499, -0.8670, -1.5149, 0.3190, 0.4768, 0.3366, -1.2029,
      1.8379, 0.8411, 1.3841, 1.7123;
  network.layers[1].w << 1.2054, 1.7784, 0.0810, 1.1704, 1.4048, -0.0580;
  return network;
}

inline double rms(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::Index from = 0) {
  return std::sqrt((a - b).bottomRows(a.rows() - from).array().square().mean());
}

}  // namespace plantloop::identify
