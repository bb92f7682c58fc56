// Least squares by a rank-revealing QR decomposition, with the covariance of what was estimated.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plantloop::identify {

struct LeastSquaresOptions {
  double ridge = 0;               // adds ridge*|theta|^2 to the sum of squares; at least 0
  Eigen::Index free_columns = 0;  // the last ones, which the ridge leaves free, as a constant
  double rank_tolerance = 1e-12;  // of a diagonal entry of R against the largest, columns scaled to length 1
};

// theta = argmin |y - X theta|^2 + ridge |theta|^2.
struct LeastSquares {
  Eigen::VectorXd theta;
  Eigen::MatrixXd covariance;  // s2 (X'X + ridge I)^-1; columns without influence on the fit have infinite variance
  Eigen::VectorXd residuals;   // y - X theta
  double sse = 0;              // sum of squared residuals
  double s2 = 0;               // sse/(rows - rank): the noise's variance, (2.21) of the book; NaN when rows = rank
  Eigen::Index rank = 0;
  double condition = 1;  // in the 2-norm, of the columns that have parameters, scaled to length 1
  std::vector<std::string> warnings;

  // What was tried, for a report: "QR with pivots: rank 3 of 4, condition 120".
  std::string account() const;
  Eigen::VectorXd deviations() const { return covariance.diagonal().cwiseSqrt(); }  // standard deviations
};

// X: rows x parameters, y: rows. Fewer rows than parameters and dependent columns are no errors: parameters that the
// data do not determine are 0 (a basic solution: the other columns alone), and a warning counts them. Raises
// IdentifyError for sizes that differ and for numbers that are not finite.
LeastSquares least_squares(const Eigen::MatrixXd& X, const Eigen::VectorXd& y, const LeastSquaresOptions& options = {});

}  // namespace plantloop::identify
