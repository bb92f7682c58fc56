// Uncertain inputs: naive, first order, moment matching.

#include "identify/gp/propagate.h"

#include <fmt/format.h>

#include "identify/dense/dense.h"
#include "identify/error.h"

namespace plantloop::identify {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Propagation find_propagation(const std::string& name) {
  if (name == "naive") return Propagation::naive;
  if (name == "first_order") return Propagation::first_order;
  if (name == "moment_matching") return Propagation::moment_matching;
  fail("there is no propagation '{}'; there are naive, first_order, moment_matching", name);
}

Propagator::Propagator(const GaussianProcess& model, Propagation method) : model_(model), method_(method) {
  if (method != Propagation::moment_matching) return;
  KernelMoments moments;
  const VectorXd mu = model.x().row(0).transpose();
  const MatrixXd none = MatrixXd::Zero(model.inputs(), model.inputs());
  if (!model.covariance().moments(model.hyperparameters().theta, model.x().topRows(1), mu, none, moments))
    throw IdentifyError(
        fmt::format("moment matching has a closed form for se_ard, linear and se_ard + linear only, not for '{}'; "
                    "first_order works with every covariance",
                    model.covariance().name()));
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
  const double m = beta.dot(moments.q);
  result.mean = m;
  result.slope = moments.g.transpose() * beta;
  result.variance = moments.k + (spread_.array() * moments.Q.array()).sum() - m * m;
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
