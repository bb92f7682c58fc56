// A network written anew on complex numbers, for derivatives by complex steps.

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <complex>

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

}  // namespace plantloop::identify
