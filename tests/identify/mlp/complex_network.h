// A network written anew on complex numbers, and derivatives by complex steps.

#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <string>

#include "identify/fit/training.h"
#include "identify/mlp/network.h"

namespace plantloop::identify {

using Complex = std::complex<double>;

inline Complex activated(Activation activation, Complex s) {
  if (activation == Activation::sigmoid) return 1.0 / (1.0 + std::exp(-s));
  if (activation == Activation::tanh) return std::tanh(s);
  if (activation == Activation::gaussian) return std::exp(-s * s);
  return s;
}

// The network written anew on complex numbers, for the complex step (J. Lyness, C. Moler 1967).
inline Eigen::VectorXcd complex_output(const Network& shape, const Eigen::VectorXcd& theta, const Eigen::VectorXcd& x) {
  Eigen::VectorXcd h = x;
  Eigen::Index end = theta.size() - shape.direct.size();
  for (const Layer& layer : shape.layers) {
    end -= layer.w.size();
    Eigen::VectorXcd next(layer.neurons());
    for (Eigen::Index i = 0; i < layer.neurons(); ++i) {
      Complex s = theta[end + i * layer.w.cols() + layer.inputs()];
      for (Eigen::Index k = 0; k < layer.inputs(); ++k) s += theta[end + i * layer.w.cols() + k] * h[k];
      next[i] = activated(layer.activation, s);
    }
    h = next;
  }
  for (Eigen::Index o = 0; o < shape.direct.rows(); ++o) {
    const Eigen::Index row = theta.size() - shape.direct.size() + o * x.size();
    for (Eigen::Index k = 0; k < x.size(); ++k) h[o] += theta[row + k] * x[k];
  }
  return h;
}

// d output/d theta by complex steps, for outputs(theta) as a vector.
template <typename Outputs>
Eigen::MatrixXd complex_step(const Eigen::VectorXd& theta, Outputs outputs) {
  constexpr double h = 1e-40;
  Eigen::MatrixXd J;
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    Eigen::VectorXcd moved = theta.cast<Complex>();
    moved[j] += Complex(0, h);
    const Eigen::VectorXd column = Eigen::VectorXcd(outputs(moved)).imag() / h;
    if (j == 0) J.resize(column.size(), theta.size());
    J.col(j) = column;
  }
  return J;
}

// Elements of J'J and J'e are compared with the lengths of the columns they are made of.
inline void expect_normal(const Training& training, const Eigen::VectorXd& theta, const Eigen::MatrixXd& J,
                          const Eigen::VectorXd& e, const std::string& what) {
  Eigen::MatrixXd R;
  Eigen::VectorXd g;
  EXPECT_NEAR(training.normal(theta, R, g), e.squaredNorm(), 1e-12 * e.squaredNorm()) << what;
  const Eigen::VectorXd length = J.colwise().norm();
  const Eigen::VectorXd expected = J.transpose() * e;
  const Eigen::MatrixXd square = J.transpose() * J;
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    EXPECT_NEAR(g[i], expected[i], 1e-12 * length[i] * e.norm()) << what << " " << i;
    for (Eigen::Index j = 0; j < theta.size(); ++j)
      EXPECT_NEAR(R(i, j), square(i, j), 1e-12 * length[i] * length[j]) << what;
  }
}

}  // namespace plantloop::identify
