// Uncertain inputs: naive, first order, moment matching.

#include "identify/gp/propagate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/dense/dense.h"
#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// C = G G' + rest by Cholesky's method with pivots, until the rest is rounding or G has `most` columns; C becomes the
// rest, or 0 where that is rounding, which K^-1 would make large.
MatrixXd take_apart(MatrixXd& C, Index most) {
  const Index n = C.rows();
  VectorXd left = C.diagonal();
  const double enough = 2e-15 * left.maxCoeff();
  MatrixXd G(n, most);
  Index columns = 0;
  for (Index pivot = 0; columns < most && left.maxCoeff(&pivot) > enough; ++columns) {
    G.col(columns) =
        (C.col(pivot) - G.leftCols(columns) * G.row(pivot).head(columns).transpose()) / std::sqrt(left[pivot]);
    left -= G.col(columns).cwiseAbs2();
    left[pivot] = 0;
  }
  G.conservativeResize(n, columns);
  if (columns < most || most == n) {
    C.setZero();
  } else {
    C.noalias() -= G * G.transpose();
  }
  return G;
}

}  // namespace

Propagation find_propagation(const std::string& name) {
  if (name == "naive") return Propagation::naive;
  if (name == "first_order") return Propagation::first_order;
  if (name == "moment_matching") return Propagation::moment_matching;
  fail("there is no propagation '{}'; there are naive, first_order, moment_matching", name);
}

Propagator::Propagator(const GaussianProcess& model, Propagation method) : model_(model), method_(method) {
  if (method != Propagation::moment_matching) return;
  if (model.x().cols() > model.inputs())
    fail("moment matching is for observed values, this model has observed slopes too; first_order works with both");
  KernelMoments moments;
  const VectorXd mu = model.x().row(0).head(model.inputs()).transpose();
  const MatrixXd none = MatrixXd::Zero(model.inputs(), model.inputs());
  if (!model.covariance().moments(model.hyperparameters().theta, model.x().topRows(1), mu, none, moments))
    throw IdentifyError(fmt::format(
        "moment matching has a closed form for sums and products of se_ard and linear, at most two linear in a "
        "product, not for '{}'; "
        "first_order works with every covariance",
        model.covariance().name()));
  whitened_ = model.factor().triangularView<Eigen::Lower>().transpose() * model.alpha();
  // Columns cost as much as the matrix itself where there are some hundred points: then a few must do.
  const double points = model.size();
  rank_ =
      std::min<Eigen::Index>(model.size(), std::max<Eigen::Index>(8, static_cast<Eigen::Index>(4e6 / points / points)));
  spread_ = model.factor();
  invert_factored(spread_);
  mirror_lower(spread_);
  spread_ = model.alpha() * model.alpha().transpose() - spread_;
}

UncertainPrediction Propagator::predict(const UncertainPoint& point) const {
  if (method_ == Propagation::moment_matching) return moment_matching(point);
  return first_order(point);
}

UncertainPrediction Propagator::first_order(const UncertainPoint& point) const {
  const Prediction at = model_.predict(point.mean.transpose());
  UncertainPrediction result{at.mean[0], at.variance[0], VectorXd::Zero(point.mean.size())};
  if (method_ == Propagation::naive) return result;
  result.slope = model_.mean_gradient(point.mean);
  result.variance += result.slope.dot(point.covariance * result.slope);
  return result;
}

UncertainPrediction Propagator::moment_matching(const UncertainPoint& point) const {
  KernelMoments moments;
  model_.covariance().moments(model_.hyperparameters().theta, model_.x(), point.mean, point.covariance, moments);
  const VectorXd& beta = model_.alpha();
  UncertainPrediction result;
  VectorXd q = moments.q;
  solve_lower(model_.factor(), q);
  result.mean = whitened_.dot(q);
  result.slope = moments.g.transpose() * beta;
  MatrixXd G = take_apart(moments.C, rank_);
  solve_lower(model_.factor(), G);
  result.variance = moments.k - q.squaredNorm() + (G.transpose() * whitened_).squaredNorm() - G.squaredNorm();
  result.variance += (spread_.array() * moments.C.array()).sum();
  // The mean function is affine in x and adds its own part, and its product with the rest.
  const VectorXd& b = model_.mean_coefficients();
  if (b.size() > 0) result.mean += b[0];
  if (b.size() > 1) {
    const VectorXd own = b.tail(b.size() - 1);
    result.mean += own.dot(point.mean);
    result.variance += own.dot(point.covariance * (own + 2 * result.slope));
    result.slope += own;
  }
  if (result.variance < 0) result.variance = 0;
  return result;
}

}  // namespace plantloop::identify
