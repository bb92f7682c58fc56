// Nonlinear least squares with Marquardt's damping.

#include "identify/linear/levenberg_marquardt.h"

#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The step of min |J h + e|^2 + damping |diag(scale) h|^2 from the triangle R and Q'e of J's decomposition; solved for
// diag(scale) h, so that it does not depend on the units of parameters.
VectorXd damped_step(const MatrixXd& R, const VectorXd& Qe, const VectorXd& scale, double damping) {
  const Index p = R.cols();
  MatrixXd A(2 * p, p);
  A.topRows(p) = R * scale.cwiseInverse().asDiagonal();
  A.bottomRows(p) = MatrixXd::Identity(p, p) * std::sqrt(damping);
  VectorXd b = VectorXd::Zero(2 * p);
  b.head(p) = -Qe;
  return A.householderQr().solve(b).cwiseQuotient(scale);
}

}  // namespace

MarquardtResult minimise_squares(const Residuals& residuals, const VectorXd& start, const MarquardtOptions& options,
                                 const Allowed& allowed, const FitControl& control) {
  MarquardtResult best;
  best.theta = start;
  best.residuals = residuals(start, &best.jacobian);
  best.sse = best.residuals.squaredNorm();
  if (!std::isfinite(best.sse)) fail("the fit cannot begin: the prediction error at the start is not finite");
  const Index p = start.size();
  VectorXd scale = VectorXd::Zero(p);
  double damping = 1e-3;
  best.stopped = fmt::format("the limit of {} iterations", options.iterations);

  while (best.iterations < options.iterations && p > 0) {
    control.step(static_cast<double>(best.iterations) / options.iterations);
    const VectorXd lengths = best.jacobian.colwise().norm();
    const VectorXd gradient = best.jacobian.transpose() * best.residuals;
    scale = scale.cwiseMax(lengths);
    for (double& size : scale) size = size > 0 ? size : 1;
    if ((gradient.cwiseAbs() - options.gradient * std::sqrt(best.sse) * lengths).maxCoeff() <= 0) {
      best.stopped = "the gradient vanished";
      best.converged = true;
      break;
    }
    // Q'e and R, padded when there are fewer residuals than parameters.
    MatrixXd R = MatrixXd::Zero(p, p);
    VectorXd Qe = VectorXd::Zero(p);
    const Eigen::HouseholderQR<MatrixXd> qr(best.jacobian);
    const Index rank = std::min(p, best.jacobian.rows());
    R.topRows(rank) = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
    const VectorXd rotated = qr.householderQ().adjoint() * best.residuals;
    Qe.head(rank) = rotated.head(rank);

    bool moved = false;
    bool small = false;
    while (!moved && !small) {
      const VectorXd step = damped_step(R, Qe, scale, damping);
      VectorXd theta;
      double sse = std::numeric_limits<double>::infinity();
      small = damping > 1e20;
      const double size = options.step * std::max(scale.cwiseProduct(best.theta).norm(), std::sqrt(best.sse));
      for (VectorXd& end : allowed ? allowed(best.theta + step) : std::vector<VectorXd>{best.theta + step}) {
        theta = std::move(end);
        if (scale.cwiseProduct(theta - best.theta).cwiseAbs().maxCoeff() <= size) small = true;
        sse = residuals(theta, nullptr).squaredNorm();
        if (sse < best.sse) break;
      }
      if (sse < best.sse) {
        const double predicted = Qe.squaredNorm() - (Qe + R * step).squaredNorm();
        const double ratio = predicted > 0 ? (best.sse - sse) / predicted : 0;
        best.theta = theta;
        moved = true;
        if (ratio > 0.75) damping = std::max(damping * 0.1, 1e-15);
        if (ratio < 0.25) damping *= 4;
      } else {
        damping = std::max(damping, 1e-12) * 8;
      }
    }
    if (moved) {
      best.residuals = residuals(best.theta, &best.jacobian);
      best.sse = best.residuals.squaredNorm();
      ++best.iterations;
    }
    if (small) {
      best.stopped = "the steps vanished";
      best.converged = true;
      break;
    }
  }
  return best;
}

MatrixXd covariance_of(const MatrixXd& J, double s2) {
  const Index p = J.cols();
  VectorXd scale = J.colwise().norm();
  for (double& size : scale) size = size > 0 ? size : 1;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(J.rows(), p);
  qr.setThreshold(1e-12);
  qr.compute(J * scale.cwiseInverse().asDiagonal());
  if (qr.rank() < p) {
    return MatrixXd(VectorXd::Constant(p, std::numeric_limits<double>::infinity()).asDiagonal());
  }
  MatrixXd R_inverse = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>().solve(MatrixXd::Identity(p, p));
  R_inverse = scale.cwiseInverse().asDiagonal() * (qr.colsPermutation() * R_inverse);
  return s2 * R_inverse * R_inverse.transpose();
}

}  // namespace plantloop::identify
