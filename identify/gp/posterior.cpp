// Predictions from a Cholesky factor, or from two.

#include "identify/gp/posterior.h"

#include <fmt/format.h>

#include <cmath>

#include "identify/dense/dense.h"
#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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

void check_hyperparameters(const Covariance& covariance, int inputs, const Hyperparameters& at) {
  const std::vector<std::string> names = covariance.names(inputs);
  if (at.theta.size() != static_cast<Index>(names.size()))
    fail("covariance '{}' with {} inputs has {} hyperparameters ({}), but {} are given", covariance.name(), inputs,
         names.size(), fmt::join(names, ", "), at.theta.size());
  for (Index i = 0; i < at.theta.size(); ++i) {
    if (!(at.theta[i] > 0) || !std::isfinite(at.theta[i]))
      fail("hyperparameter {} is {:g}; it must be greater than 0", names[static_cast<std::size_t>(i)], at.theta[i]);
  }
  if (!(at.v0 >= 0) || !std::isfinite(at.v0)) fail("the noise variance v0 is {:g}; it must be 0 or greater", at.v0);
}

VectorXd log_densities(const VectorXd& y, const VectorXd& mean, const VectorXd& variance) {
  constexpr double log_two_pi = 1.8378770664093453;
  return -0.5 * (variance.array().log() + (y - mean).array().square() / variance.array() + log_two_pi);
}

GpPosterior::GpPosterior(std::shared_ptr<const Covariance> covariance, MeanFunction mean,
                         Hyperparameters hyperparameters, MatrixXd x)
    : covariance_(std::move(covariance)), mean_(mean), hyperparameters_(std::move(hyperparameters)), x_(std::move(x)) {
  check_hyperparameters(*covariance_, inputs(), hyperparameters_);
}

bool GpPosterior::factorise_with_jitter(const MatrixXd& k, double least, double most) {
  const double scale = k.diagonal().mean();
  for (double jitter = least; jitter <= 1.1 * most; jitter = jitter == 0 ? 1e-12 : 10 * jitter) {
    jitter_ = jitter * scale;
    factor_ = k;
    factor_.diagonal().array() += jitter_;
    if (factorise(factor_)) return true;
  }
  return false;
}

void GpPosterior::add_mean(const MatrixXd& x, VectorXd& values) const {
  if (coefficients_.size() > 0) values += mean_basis(mean_, x) * coefficients_;
}

VectorXd GpPosterior::weighted(MatrixXd a) const {
  if (inner_.size() == 0) return a.transpose() * alpha_;
  // Inducing inputs stand close together, so beta is large where w is not.
  solve_lower(factor_, a);
  return a.transpose() * whitened_;
}

VectorXd GpPosterior::predict_mean(const MatrixXd& x) const {
  VectorXd mean = weighted(covariance_->between(hyperparameters_.theta, x_, x));
  add_mean(x, mean);
  return mean;
}

Prediction GpPosterior::predict(const MatrixXd& x) const {
  Prediction result;
  MatrixXd k = covariance_->between(hyperparameters_.theta, x_, x);
  if (inner_.size() == 0) result.mean = k.transpose() * alpha_;
  solve_lower(factor_, k);
  if (inner_.size() > 0) result.mean = k.transpose() * whitened_;
  add_mean(x, result.mean);
  result.variance = covariance_->at(hyperparameters_.theta, x) - k.colwise().squaredNorm().transpose();
  if (inner_.size() > 0) {
    solve_lower(inner_, k);
    result.variance += k.colwise().squaredNorm().transpose();
  }
  // Rounding may leave a tiny negative number where the function is known.
  result.variance = result.variance.cwiseMax(0.0);
  return result;
}

VectorXd GpPosterior::mean_gradient(const VectorXd& x) const {
  VectorXd gradient = weighted(covariance_->input_gradient(hyperparameters_.theta, x, x_));
  if (mean_ == MeanFunction::linear) gradient += coefficients_.tail(x.size());
  return gradient;
}

VectorXd GpPosterior::variance_gradient(const VectorXd& x) const {
  VectorXd k = covariance_->between(hyperparameters_.theta, x_, x.transpose());
  MatrixXd dk = covariance_->input_gradient(hyperparameters_.theta, x, x_);
  // k(x, x) depends on x through both arguments alike: twice the slope at equal points.
  const VectorXd own = 2 * covariance_->input_gradient(hyperparameters_.theta, x, x.transpose()).row(0).transpose();
  solve_lower(factor_, k);
  if (inner_.size() == 0) {
    solve_lower_transposed(factor_, k);
    return own - 2 * dk.transpose() * k;
  }
  solve_lower(factor_, dk);
  const VectorXd gradient = own - 2 * dk.transpose() * k;
  solve_lower(inner_, k);
  solve_lower(inner_, dk);
  return gradient + 2 * dk.transpose() * k;
}

double GpPosterior::known(MatrixXd whitened) const {
  const double all = whitened.squaredNorm();
  if (inner_.size() == 0) return all;
  solve_lower(inner_, whitened);
  return all - whitened.squaredNorm();
}

MatrixXd GpPosterior::precision() const {
  if (inner_.size() == 0) {
    MatrixXd inverse = factor_;
    invert_factored(inverse);
    mirror_lower(inverse);
    return inverse;
  }
  MatrixXd spread = MatrixXd::Identity(x_.rows(), x_.rows());
  solve_lower(inner_, spread);
  MatrixXd middle = MatrixXd::Identity(x_.rows(), x_.rows()) - spread.transpose() * spread;
  solve_lower_transposed(factor_, middle);
  middle.transposeInPlace();
  solve_lower_transposed(factor_, middle);
  return middle;
}

}  // namespace plantloop::identify
