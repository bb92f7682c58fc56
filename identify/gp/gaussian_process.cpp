// The likelihood of an exact process, and what it tells of its own points.

#include "identify/gp/gaussian_process.h"

#include <fmt/format.h>

#include <cmath>

#include "identify/dense/dense.h"
#include "identify/error.h"
#include "identify/fit/parallel.h"
#include "identify/linear/least_squares.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double log_two_pi = 1.8378770664093453;

// The generalised least-squares coefficients of the mean: minimal |L^-1 (y - H b)|.
VectorXd fit_mean(MeanFunction mean, const MatrixXd& factor, const MatrixXd& x, const VectorXd& y) {
  MatrixXd h = mean_basis(mean, x);
  if (h.cols() == 0) return {};
  VectorXd target = y;
  solve_lower(factor, h);
  solve_lower(factor, target);
  if (!h.allFinite() || !target.allFinite()) return VectorXd::Zero(h.cols());
  return least_squares(h, target).theta;
}

VectorXd residual(MeanFunction mean, const VectorXd& coefficients, const MatrixXd& x, const VectorXd& y) {
  return coefficients.size() == 0 ? y : VectorXd(y - mean_basis(mean, x) * coefficients);
}

VectorXd solved(const MatrixXd& factor, VectorXd r) {
  solve_lower(factor, r);
  solve_lower_transposed(factor, r);
  return r;
}

double value_of(const MatrixXd& factor, const VectorXd& r, const VectorXd& alpha) {
  return -0.5 * r.dot(alpha) - factor.diagonal().array().log().sum() - 0.5 * static_cast<double>(r.size()) * log_two_pi;
}

}  // namespace

Likelihood log_likelihood(const Covariance& covariance, MeanFunction mean, const Hyperparameters& at, const MatrixXd& x,
                          const VectorXd& y, bool with_gradient, double jitter) {
  const Index p = at.theta.size();
  Likelihood result{-std::numeric_limits<double>::infinity(), VectorXd::Zero(p + 1)};
  const MatrixXd values = covariance.lower(at.theta, x);
  MatrixXd factor = values;
  const VectorXd noise = covariance.noise_weight(x);
  factor.diagonal() += at.v0 * noise;
  factor.diagonal().array() += jitter;
  look_up();
  if (!factorise(factor)) return result;
  look_up();
  const VectorXd r = residual(mean, fit_mean(mean, factor, x, y), x, y);
  const VectorXd alpha = solved(factor, r);
  result.value = value_of(factor, r, alpha);
  if (!with_gradient || !std::isfinite(result.value)) return result;
  // 1/2 tr[(alpha alpha' - K^-1) dK/dlog theta]; the matrix is made once, in the factor's place.
  invert_factored(factor);
  look_up();
  for (Index j = 0; j < r.size(); ++j) {
    auto column = factor.col(j).tail(r.size() - j);
    column = 0.5 * (alpha[j] * alpha.tail(r.size() - j) - column);
  }
  result.gradient.head(p) = covariance.gradient(at.theta, x, values, factor);
  result.gradient[p] = at.v0 * factor.diagonal().dot(noise);
  return result;
}

GaussianProcess::GaussianProcess(std::shared_ptr<const Covariance> covariance, MeanFunction mean,
                                 Hyperparameters hyperparameters, MatrixXd x, VectorXd y)
    : GpPosterior(std::move(covariance), mean, std::move(hyperparameters), std::move(x)), y_(std::move(y)) {
  check_data(x_, y_);
  MatrixXd k = covariance_->lower(hyperparameters_.theta, x_);
  k.diagonal() += hyperparameters_.v0 * covariance_->noise_weight(x_);
  if (!k.allFinite())
    throw IdentifyError("a covariance is not a finite number: hyperparameters or inputs are too large");
  if (!factorise_with_jitter(k, 0, 1e-4))
    fail(
        "the covariances of the {} points are not positive definite, even with a jitter of 1e-4 of their mean; "
        "a greater noise variance v0 (now {:g}) would help",
        size(), hyperparameters_.v0);
  coefficients_ = fit_mean(mean_, factor_, x_, y_);
  solve_alpha();
}

void GaussianProcess::solve_alpha() {
  whitened_ = residual(mean_, coefficients_, x_, y_);
  solve_lower(factor_, whitened_);
  alpha_ = whitened_;
  solve_lower_transposed(factor_, alpha_);
}

double GaussianProcess::log_likelihood() const {
  const VectorXd r = residual(mean_, coefficients_, x_, y_);
  return value_of(factor_, r, alpha_);
}

Likelihood GaussianProcess::likelihood() const {
  return plantloop::identify::log_likelihood(*covariance_, mean_, hyperparameters_, x_, y_, true, jitter_);
}

LeaveOneOut GaussianProcess::leave_one_out() const {
  MatrixXd inverse = factor_;
  invert_factored(inverse);
  LeaveOneOut result;
  result.variance = inverse.diagonal().cwiseInverse();
  result.mean = y_ - alpha_.cwiseProduct(result.variance);
  result.log_density = log_densities(y_, result.mean, result.variance);
  result.log_probability = result.log_density.sum();
  return result;
}

void GaussianProcess::add(const VectorXd& x, double y) {
  check_data(x.transpose(), VectorXd::Constant(1, y));
  if (x.size() != x_.cols()) fail("the new point has {} inputs, the model {}", x.size(), x_.cols());
  const Index n = x_.rows();
  VectorXd row = covariance_->between(hyperparameters_.theta, x_, x.transpose());
  solve_lower(factor_, row);
  const double own = covariance_->at(hyperparameters_.theta, x.transpose())[0] +
                     covariance_->noise_variances(x.transpose(), hyperparameters_.v0)[0] + jitter_;
  const double square = own - row.squaredNorm();
  if (!(square > 1e-14 * own))
    throw IdentifyError(
        "the new point lies where the function is already known exactly; it adds nothing without noise");
  factor_.conservativeResize(n + 1, n + 1);
  factor_.col(n).setZero();
  factor_.row(n).head(n) = row.transpose();
  factor_(n, n) = std::sqrt(square);
  x_.conservativeResize(n + 1, Eigen::NoChange);
  x_.row(n) = x.transpose();
  y_.conservativeResize(n + 1);
  y_[n] = y;
  solve_alpha();
}

}  // namespace plantloop::identify
