// Covariances that are sums of Gaussians times affine factors: their moments over x ~ N(mu, S) in closed form.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "identify/gp/covariance.h"

namespace plantloop::identify {

// c exp(-1/2 sum_d w_d (x_d - z_d)^2) prod_f (b_f + sum_d a_fd x_d z_d). Products of such terms are such terms: weights
// add, factors stand beside each other.
struct GaussianTerm {
  struct Affine {
    Eigen::VectorXd a;
    double b = 0;
  };
  double c = 1;
  Eigen::VectorXd w;
  std::vector<Affine> factors;
};

// The moments of the sum of the terms, with the points z. A term has at most most_factors factors, else false. With
// y = x - mu, a Gaussian times N(0, S) is |I + S W|^-1/2 exp(...) times N(M h, M), M = (I + S W)^-1 S, so what is left
// is the mean of a product of affine functions of normal variables (L. Isserlis 1918). No inverse of S is needed.
inline constexpr std::size_t most_factors = 2;
bool moments_of(const std::vector<GaussianTerm>& terms, const Eigen::MatrixXd& z, const Eigen::VectorXd& mu,
                const Eigen::MatrixXd& s, KernelMoments& result);

}  // namespace plantloop::identify
