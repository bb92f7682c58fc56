// Recursive least squares with exponential forgetting.

#pragma once

#include <Eigen/Core>

namespace plantloop::identify {

struct RecursiveOptions {
  double forgetting = 1;            // lambda, in (0, 1]; 1 forgets nothing
  double initial_covariance = 1e4;  // P0 = this times the identity; theta0 = 0
};

// K = P psi/(lambda + psi'P psi), theta += K (y - psi'theta), P = (P - K psi'P)/lambda. With lambda = 1 the estimate is
// that of least squares with the ridge 1/initial_covariance.
class RecursiveLeastSquares {
 public:
  // Raises IdentifyError for options out of their ranges.
  RecursiveLeastSquares(Eigen::Index parameters, const RecursiveOptions& options = {});
  // Takes one row; returns the error of its prediction before. A row or target that is not a number changes nothing.
  double update(const Eigen::VectorXd& psi, double y);
  const Eigen::VectorXd& theta() const { return theta_; }
  const Eigen::MatrixXd& P() const { return P_; }

 private:
  RecursiveOptions options_;
  Eigen::VectorXd theta_;
  Eigen::MatrixXd P_;
};

struct RecursiveResult {
  Eigen::MatrixXd theta;   // rows x parameters: the estimate after each row
  Eigen::VectorXd errors;  // of the predictions before each row
  Eigen::MatrixXd P;       // after the last
};
RecursiveResult recursive_least_squares(const Eigen::MatrixXd& X, const Eigen::VectorXd& y,
                                        const RecursiveOptions& options = {});

}  // namespace plantloop::identify
