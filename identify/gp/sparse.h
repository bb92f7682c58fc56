// A Gaussian process for large sets of data, seen through a few inducing inputs.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "identify/gp/gaussian_process.h"

namespace plantloop::identify {

// Rows of x for a subset of data: `count` rows that lie as far from each other as can be, each one the farthest from
// those chosen before it, in units of the columns' standard deviations; the first one is drawn. Ascending.
std::vector<Eigen::Index> spread_subset(const Eigen::MatrixXd& x, int count, std::uint64_t seed = 1);

// The fully independent training conditional (E. Snelson, Z. Ghahramani 2006): with inducing inputs U,
//   Q = K_fu K_uu^-1 K_uf,  G = diag(K_ff - Q) + v0 I,
//   L L' = K_uu + jitter,  V = L^-1 K_uf,  B = I + V G^-1 V',  c = chol(B)^-1 V G^-1 y,  Z = chol(B)^-1 L^-1 K_u*,
//   mean = Z' c,  variance = k_** - |L^-1 K_u*|^2 + |Z|^2.
// Memory and time grow with N M and N M^2 for M inducing inputs. With U = all inputs it is the full process.
class SparseGaussianProcess {
 public:
  // x: N x D, y: N, inducing: M x D; the mean is zero. Throws IdentifyError.
  SparseGaussianProcess(std::shared_ptr<const Covariance> covariance, Hyperparameters hyperparameters,
                        const Eigen::MatrixXd& x, const Eigen::VectorXd& y, Eigen::MatrixXd inducing);

  Prediction predict(const Eigen::MatrixXd& x) const;
  // log N(y; 0, Q + G).
  double log_likelihood() const { return log_likelihood_; }
  const Eigen::MatrixXd& inducing() const { return inducing_; }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }

 private:
  std::shared_ptr<const Covariance> covariance_;
  Hyperparameters hyperparameters_;
  Eigen::MatrixXd inducing_, factor_, inner_;  // U, L, chol(B)
  Eigen::VectorXd weights_;                    // c
  double log_likelihood_ = 0;
};

}  // namespace plantloop::identify
