// Prediction from a Cholesky factor.

#include "identify/gp/gaussian_process.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <cmath>

#include "identify/dense/dense.h"
#include "identify/error.h"

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
  return h.colPivHouseholderQr().solve(target);
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

MeanFunction find_mean_function(const std::string& name) {
  if (name == "zero") return MeanFunction::zero;
  if (name == "constant") return MeanFunction::constant;
  if (name == "linear") return MeanFunction::linear;
  fail("there is no mean function '{}'; there are zero, constant, linear", name);
}

std::string name_of(MeanFunction mean) {
  return mean == MeanFunction::zero ? "zero" : mean == MeanFunction::constant ? "constant" : "linear";
}

MatrixXd mean_basis(MeanFunction mean, const MatrixXd& x) {
  if (mean == MeanFunction::zero) return MatrixXd(x.rows(), 0);
  if (mean == MeanFunction::constant) return MatrixXd::Ones(x.rows(), 1);
  MatrixXd h(x.rows(), x.cols() + 1);
  h << VectorXd::Ones(x.rows()), x;
  return h;
}

void check_data(const MatrixXd& x, const VectorXd& y) {
  if (x.rows() == 0 || y.size() == 0) throw IdentifyError("the data has no rows");
  if (x.rows() != y.size()) fail("the inputs have {} rows and the targets {}; they must agree", x.rows(), y.size());
  for (Index i = 0; i < x.rows(); ++i) {
    if (!std::isfinite(y[i])) fail("the target in row {} is {}, not a finite number", i + 1, y[i]);
    for (Index d = 0; d < x.cols(); ++d) {
      if (!std::isfinite(x(i, d))) fail("input {} in row {} is {}, not a finite number", d + 1, i + 1, x(i, d));
    }
  }
}

Likelihood log_likelihood(const Covariance& covariance, MeanFunction mean, const Hyperparameters& at, const MatrixXd& x,
                          const VectorXd& y, bool with_gradient) {
  const Index p = at.theta.size();
  Likelihood result{-std::numeric_limits<double>::infinity(), VectorXd::Zero(p + 1)};
  const MatrixXd values = covariance.lower(at.theta, x);
  MatrixXd factor = values;
  const VectorXd noise = covariance.noise_weight(x);
  factor.diagonal() += at.v0 * noise;
  if (!factorise(factor)) return result;
  const VectorXd r = residual(mean, fit_mean(mean, factor, x, y), x, y);
  const VectorXd alpha = solved(factor, r);
  result.value = value_of(factor, r, alpha);
  if (!with_gradient || !std::isfinite(result.value)) return result;
  // 1/2 tr[(alpha alpha' - K^-1) dK/dlog theta]; the matrix is made once, in the factor's place.
  invert_factored(factor);
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
    : covariance_(std::move(covariance)),
      mean_(mean),
      hyperparameters_(std::move(hyperparameters)),
      x_(std::move(x)),
      y_(std::move(y)) {
  check_data(x_, y_);
  const std::vector<std::string> names = covariance_->names(inputs());
  const VectorXd& theta = hyperparameters_.theta;
  if (theta.size() != static_cast<Index>(names.size()))
    fail("covariance '{}' with {} inputs has {} hyperparameters ({}), but {} are given", covariance_->name(), inputs(),
         names.size(), fmt::join(names, ", "), theta.size());
  for (Index i = 0; i < theta.size(); ++i) {
    if (!(theta[i] > 0) || !std::isfinite(theta[i]))
      fail("hyperparameter {} is {:g}; it must be greater than 0", names[static_cast<std::size_t>(i)], theta[i]);
  }
  if (!(hyperparameters_.v0 >= 0) || !std::isfinite(hyperparameters_.v0))
    fail("the noise variance v0 is {:g}; it must be 0 or greater", hyperparameters_.v0);
  MatrixXd k = covariance_->lower(theta, x_);
  k.diagonal() += hyperparameters_.v0 * covariance_->noise_weight(x_);
  const double scale = k.diagonal().mean();
  for (double jitter = 0; jitter <= 1.1e-4; jitter = jitter == 0 ? 1e-12 : 10 * jitter) {
    jitter_ = jitter * scale;
    factor_ = k;
    factor_.diagonal().array() += jitter_;
    if (!factorise(factor_)) continue;
    coefficients_ = fit_mean(mean_, factor_, x_, y_);
    solve_alpha();
    return;
  }
  fail(
      "the covariances of the {} points are not positive definite, even with a jitter of 1e-4 of their mean; "
      "a greater noise variance v0 (now {:g}) would help",
      size(), hyperparameters_.v0);
}

void GaussianProcess::solve_alpha() { alpha_ = solved(factor_, residual(mean_, coefficients_, x_, y_)); }

double GaussianProcess::log_likelihood() const {
  const VectorXd r = residual(mean_, coefficients_, x_, y_);
  return value_of(factor_, r, alpha_);
}

VectorXd GaussianProcess::predict_mean(const MatrixXd& x) const {
  VectorXd mean = covariance_->between(hyperparameters_.theta, x_, x).transpose() * alpha_;
  if (coefficients_.size() > 0) mean += mean_basis(mean_, x) * coefficients_;
  return mean;
}

Prediction GaussianProcess::predict(const MatrixXd& x) const {
  Prediction result;
  MatrixXd k = covariance_->between(hyperparameters_.theta, x_, x);
  result.mean = k.transpose() * alpha_;
  if (coefficients_.size() > 0) result.mean += mean_basis(mean_, x) * coefficients_;
  solve_lower(factor_, k);
  // Rounding may leave a tiny negative number where the function is known.
  result.variance = (covariance_->at(hyperparameters_.theta, x) - k.colwise().squaredNorm().transpose()).cwiseMax(0.0);
  return result;
}

VectorXd GaussianProcess::mean_gradient(const VectorXd& x) const {
  VectorXd gradient = covariance_->input_gradient(hyperparameters_.theta, x, x_).transpose() * alpha_;
  if (mean_ == MeanFunction::linear) gradient += coefficients_.tail(x.size());
  return gradient;
}

VectorXd GaussianProcess::variance_gradient(const VectorXd& x) const {
  const VectorXd k = covariance_->between(hyperparameters_.theta, x_, x.transpose());
  const MatrixXd dk = covariance_->input_gradient(hyperparameters_.theta, x, x_);
  // k(x, x) depends on x through both arguments alike: twice the slope at equal points.
  const VectorXd own = 2 * covariance_->input_gradient(hyperparameters_.theta, x, x.transpose()).row(0).transpose();
  return own - 2 * dk.transpose() * solved(factor_, k);
}

LeaveOneOut GaussianProcess::leave_one_out() const {
  MatrixXd inverse = factor_;
  invert_factored(inverse);
  LeaveOneOut result;
  result.variance = inverse.diagonal().cwiseInverse();
  const VectorXd error = alpha_.cwiseProduct(result.variance);
  result.mean = y_ - error;
  result.log_probability =
      -0.5 * (result.variance.array().log() + error.array().square() / result.variance.array() + log_two_pi).sum();
  return result;
}

void GaussianProcess::add(const VectorXd& x, double y) {
  check_data(x.transpose(), VectorXd::Constant(1, y));
  if (x.size() != x_.cols()) fail("the new point has {} inputs, the model {}", x.size(), x_.cols());
  const Index n = x_.rows();
  VectorXd row = covariance_->between(hyperparameters_.theta, x_, x.transpose());
  solve_lower(factor_, row);
  const double own = covariance_->at(hyperparameters_.theta, x.transpose())[0] + hyperparameters_.v0 + jitter_;
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
