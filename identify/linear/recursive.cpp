// Recursive least squares.

#include "identify/linear/recursive.h"

#include <cmath>
#include <limits>

#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;

RecursiveLeastSquares::RecursiveLeastSquares(Index parameters, const RecursiveOptions& options)
    : options_(options),
      theta_(Eigen::VectorXd::Zero(parameters)),
      P_(options.initial_covariance * Eigen::MatrixXd::Identity(parameters, parameters)) {
  if (!(options.forgetting > 0 && options.forgetting <= 1)) {
    fail("the forgetting factor lies above 0 and at most at 1, it is {}", options.forgetting);
  }
  if (!(options.initial_covariance > 0))
    fail("the initial covariance must be greater than 0, it is {}", options.initial_covariance);
}

double RecursiveLeastSquares::update(const Eigen::VectorXd& psi, double y) {
  const double error = y - psi.dot(theta_);
  if (!std::isfinite(error)) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd P_psi = P_ * psi;
  const Eigen::VectorXd K = P_psi / (options_.forgetting + psi.dot(P_psi));
  theta_ += K * error;
  P_ = (P_ - K * P_psi.transpose()) / options_.forgetting;
  P_ = (0.5 * (P_ + P_.transpose())).eval();  // rounding must not make it unsymmetric
  return error;
}

RecursiveResult recursive_least_squares(const Eigen::MatrixXd& X, const Eigen::VectorXd& y,
                                        const RecursiveOptions& options) {
  if (X.rows() != y.size()) fail("there are {} rows of regressors and {} targets", X.rows(), y.size());
  RecursiveLeastSquares rls(X.cols(), options);
  RecursiveResult result{Eigen::MatrixXd(X.rows(), X.cols()), Eigen::VectorXd(X.rows()), {}};
  for (Index k = 0; k < X.rows(); ++k) {
    result.errors[k] = rls.update(X.row(k).transpose(), y[k]);
    result.theta.row(k) = rls.theta().transpose();
  }
  result.P = rls.P();
  return result;
}

}  // namespace plantloop::identify
