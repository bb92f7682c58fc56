// A Gaussian process with its data: a function known at N points through noise, and how certain it is elsewhere.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "identify/gp/covariance.h"

namespace plantloop::identify {

// What is assumed far from all data. Its coefficients are the maximum-likelihood ones for the hyperparameters (the
// generalised least-squares estimate) and are taken as known afterwards.
enum class MeanFunction { zero, constant, linear };
MeanFunction find_mean_function(const std::string& name);  // "zero", "constant", "linear"; throws IdentifyError
std::string name_of(MeanFunction mean);
// The regressors of the mean: N x 0, N x 1 or N x (1 + D).
Eigen::MatrixXd mean_basis(MeanFunction mean, const Eigen::MatrixXd& x);

struct Hyperparameters {
  Eigen::VectorXd theta;  // of the covariance, in the order of its names; all positive
  double v0 = 0;          // variance of the white noise of each target
};

// log p(y | X) = -1/2 r' K^-1 r - sum log L_ii - N/2 log 2 pi with r = y - mean, and its derivatives with respect to
// the logarithms of theta and, last, of v0. Not defined: value -infinity.
struct Likelihood {
  double value = 0;
  Eigen::VectorXd gradient;
};
Likelihood log_likelihood(const Covariance& covariance, MeanFunction mean, const Hyperparameters& at,
                          const Eigen::MatrixXd& x, const Eigen::VectorXd& y, bool with_gradient = true);

// Of each predicted point.
struct Prediction {
  Eigen::VectorXd mean;
  Eigen::VectorXd variance;  // of the function itself; that of a measurement adds the noise v0
};

// Targets predicted from all the others, with the hyperparameters kept: mean_i = y_i - alpha_i/[K^-1]_ii,
// variance_i = 1/[K^-1]_ii with the noise (C. Rasmussen, C. Williams 2006, (5.10) to (5.12)).
struct LeaveOneOut {
  Eigen::VectorXd mean;
  Eigen::VectorXd variance;
  double log_probability = 0;  // sum of log p(y_i | the others)
};

class GaussianProcess {
 public:
  // x: N x D, y: N. Where the matrix of covariances is singular to working precision, the smallest sufficient jitter
  // of 1e-12, 1e-11, ... 1e-4 times its mean diagonal is added; jitter() tells. Throws IdentifyError when data or
  // hyperparameters cannot be used.
  GaussianProcess(std::shared_ptr<const Covariance> covariance, MeanFunction mean, Hyperparameters hyperparameters,
                  Eigen::MatrixXd x, Eigen::VectorXd y);

  Prediction predict(const Eigen::MatrixXd& x) const;            // M x D
  Eigen::VectorXd predict_mean(const Eigen::MatrixXd& x) const;  // the means alone
  // The mean's slope at a point (D), and that of the variance.
  Eigen::VectorXd mean_gradient(const Eigen::VectorXd& x) const;
  Eigen::VectorXd variance_gradient(const Eigen::VectorXd& x) const;
  double log_likelihood() const;
  LeaveOneOut leave_one_out() const;
  // Takes in one more measurement: O(N^2); the hyperparameters and the mean's coefficients stay.
  void add(const Eigen::VectorXd& x, double y);

  const Covariance& covariance() const { return *covariance_; }
  std::shared_ptr<const Covariance> shared_covariance() const { return covariance_; }
  MeanFunction mean_function() const { return mean_; }
  const Eigen::VectorXd& mean_coefficients() const { return coefficients_; }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  const Eigen::MatrixXd& x() const { return x_; }
  const Eigen::VectorXd& y() const { return y_; }
  const Eigen::VectorXd& alpha() const { return alpha_; }    // K^-1 (y - mean)
  const Eigen::MatrixXd& factor() const { return factor_; }  // L in its lower triangle
  double jitter() const { return jitter_; }
  int inputs() const { return covariance_->inputs_of(x_.cols()); }
  int size() const { return static_cast<int>(x_.rows()); }

 private:
  void solve_alpha();

  std::shared_ptr<const Covariance> covariance_;
  MeanFunction mean_;
  Hyperparameters hyperparameters_;
  Eigen::MatrixXd x_;
  Eigen::VectorXd y_, coefficients_, alpha_;
  Eigen::MatrixXd factor_;
  double jitter_ = 0;
};

// Throws IdentifyError when a number is not finite, the sizes differ or there are no rows.
void check_data(const Eigen::MatrixXd& x, const Eigen::VectorXd& y);

}  // namespace plantloop::identify
