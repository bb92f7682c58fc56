// Nonlinear least squares: Gauss-Newton steps with Marquardt's damping, by QR decompositions.

#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "identify/fit_report.h"

namespace plantloop::identify {

// Residuals at theta, and their derivative (residuals x parameters) when `jacobian` is given. A result that is not
// finite means that theta is not allowed; the step is then shortened.
using Residuals = std::function<Eigen::VectorXd(const Eigen::VectorXd& theta, Eigen::MatrixXd* jacobian)>;

struct MarquardtOptions {
  int iterations = 200;     // at most
  double gradient = 1e-12;  // stop when |J_i'e| <= gradient |J_i| |e| for all columns i
  // stop when no |J_i| |change of theta_i| is more than this part of the norm of all |J_i| theta_i (or of |e|)
  double step = 1e-13;
};

struct MarquardtResult {
  Eigen::VectorXd theta;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;  // at theta
  double sse = 0;
  int iterations = 0;  // accepted steps
  std::string stopped;
  bool converged = false;  // by gradient or step, not by the limit
};

// Where a step into a forbidden region may end instead: points of the allowed one, of which the first that is better is
// taken. Of an allowed theta itself.
using Allowed = std::function<std::vector<Eigen::VectorXd>(const Eigen::VectorXd& theta)>;

// Minimises the sum of squared residuals from `start`, at which they must be finite. `allowed` may be empty.
MarquardtResult minimise_squares(const Residuals& residuals, const Eigen::VectorXd& start,
                                 const MarquardtOptions& options = {}, const Allowed& allowed = {},
                                 const FitControl& control = {});

// The covariance of parameters whose residuals have the variance s2 and this Jacobian: s2 (J'J)^-1; all variances are
// infinite where J does not determine all of them (its rank by QR, columns scaled to length 1, is less at 1e-12).
Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& jacobian, double s2);

}  // namespace plantloop::identify
