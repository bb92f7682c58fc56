// A Gaussian process with its data: a function known at N points through noise, and how certain it is elsewhere.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "identify/gp/posterior.h"

namespace plantloop::identify {

// log p(y | X) = -1/2 r' K^-1 r - sum log L_ii - N/2 log 2 pi with r = y - mean, and its derivatives with respect to
// the logarithms of theta and, last, of v0. Not defined: value -infinity. `jitter` stands on the diagonal of K and does
// not vary.
Likelihood log_likelihood(const Covariance& covariance, MeanFunction mean, const Hyperparameters& at,
                          const Eigen::MatrixXd& x, const Eigen::VectorXd& y, bool with_gradient = true,
                          double jitter = 0);

class GaussianProcess final : public GpPosterior {
 public:
  // x: N x D, y: N. Where the matrix of covariances is singular to working precision, the smallest sufficient jitter
  // of 1e-12, 1e-11, ... 1e-4 times its mean diagonal is added; jitter() tells. Throws IdentifyError when data or
  // hyperparameters cannot be used.
  GaussianProcess(std::shared_ptr<const Covariance> covariance, MeanFunction mean, Hyperparameters hyperparameters,
                  Eigen::MatrixXd x, Eigen::VectorXd y);

  double log_likelihood() const override;
  Likelihood likelihood() const override;  // the jitter does not vary
  // mean_i = y_i - alpha_i/[K^-1]_ii, variance_i = 1/[K^-1]_ii (C. Rasmussen, C. Williams 2006, (5.10) to (5.12)).
  LeaveOneOut leave_one_out() const override;
  long long samples() const override { return size(); }
  void write(Item& item) const override;
  // Takes in one more measurement: O(N^2); the hyperparameters and the mean's coefficients stay.
  void add(const Eigen::VectorXd& x, double y);

  const Eigen::VectorXd& y() const { return y_; }
  int size() const { return static_cast<int>(x_.rows()); }

 private:
  void solve_alpha();

  Eigen::VectorXd y_;
};

}  // namespace plantloop::identify
