// Least squares by a rank-revealing QR decomposition.

#include "identify/linear/least_squares.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Lengths of the columns without overflow; 1 for a column of zeros.
VectorXd lengths(const MatrixXd& X) {
  VectorXd scale(X.cols());
  for (Index i = 0; i < X.cols(); ++i) {
    scale[i] = X.col(i).stableNorm();
    if (!(scale[i] > 0)) scale[i] = 1;
  }
  return scale;
}

void add_warnings(LeastSquares& fit, Index columns) {
  if (fit.rank < columns) {
    fit.warnings.push_back(fmt::format(
        "the data determine only {} of {} parameters: {} set to 0. The input does not excite the process enough, or a "
        "regressor is a combination of others",
        fit.rank, columns, columns - fit.rank == 1 ? "one is" : fmt::format("{} are", columns - fit.rank)));
  } else if (fit.condition > 1e7) {
    fit.warnings.push_back(
        fmt::format("the regressors are nearly dependent: their condition number is {:.2g}", fit.condition));
  }
}

}  // namespace

LeastSquares least_squares(const MatrixXd& X, const VectorXd& y, const LeastSquaresOptions& options) {
  if (X.rows() != y.size()) fail("there are {} rows of regressors and {} targets", X.rows(), y.size());
  if (X.cols() == 0) fail("there are no regressors");
  if (X.rows() == 0) fail("there are no rows to fit");
  constexpr Index most = 5000;
  if (X.cols() > most) fail("least squares takes at most {} parameters at once, here are {}", most, X.cols());
  if (!(options.ridge >= 0)) fail("the ridge must be 0 or more, it is {}", options.ridge);
  if (!X.allFinite() || !y.allFinite()) fail("least squares needs finite numbers; some are missing or infinite");

  const Index p = X.cols();
  const VectorXd scale = lengths(X);
  const Index extra = options.ridge > 0 ? p : 0;
  MatrixXd A(X.rows() + extra, p);
  A.topRows(X.rows()) = X * scale.cwiseInverse().asDiagonal();
  VectorXd b = VectorXd::Zero(A.rows());
  b.head(y.size()) = y;
  if (extra > 0) {
    VectorXd weights = std::sqrt(options.ridge) * scale.cwiseInverse();
    weights.tail(options.free_columns).setZero();
    A.bottomRows(p) = MatrixXd(weights.asDiagonal());
  }

  Eigen::ColPivHouseholderQR<MatrixXd> qr(A.rows(), p);
  qr.setThreshold(options.rank_tolerance);
  qr.compute(A);
  LeastSquares fit;
  fit.rank = qr.rank();
  const Index rank = fit.rank;
  const MatrixXd R = qr.matrixQR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>();
  // A basic solution: qr.solve() would divide by the pivots beyond the rank, which are rounding.
  b.applyOnTheLeft(qr.householderQ().adjoint());
  VectorXd basic = VectorXd::Zero(p);
  basic.head(rank) = R.triangularView<Eigen::Upper>().solve(b.head(rank));
  fit.theta = scale.cwiseInverse().asDiagonal() * (qr.colsPermutation() * basic);
  fit.residuals = y - X * fit.theta;
  fit.sse = fit.residuals.squaredNorm();
  const Index freedom = X.rows() - rank;
  fit.s2 = freedom > 0 ? fit.sse / static_cast<double>(freedom) : std::numeric_limits<double>::quiet_NaN();
  if (rank > 0) {
    const VectorXd singular = Eigen::BDCSVD<MatrixXd>(R).singularValues();
    fit.condition = singular[0] / singular[rank - 1];
  }

  fit.covariance = MatrixXd::Zero(p, p);
  const MatrixXd R_inverse = R.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(rank, rank));
  const MatrixXd core = R_inverse * R_inverse.transpose();
  const auto& order = qr.colsPermutation().indices();
  for (Index i = 0; i < p; ++i) {
    for (Index j = 0; j < p; ++j) {
      const Index at_i = order[i];
      const Index at_j = order[j];
      if (i < rank && j < rank) {
        fit.covariance(at_i, at_j) = fit.s2 * core(i, j) / (scale[at_i] * scale[at_j]);
      } else if (i == j) {
        fit.covariance(at_i, at_i) = std::numeric_limits<double>::infinity();
      }
    }
  }
  add_warnings(fit, p);
  return fit;
}

std::string LeastSquares::account() const {
  return fmt::format("QR with pivots: rank {} of {}, condition {:.3g}", rank, theta.size(), condition);
}

}  // namespace plantloop::identify
