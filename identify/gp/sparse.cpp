// FITC through two small Cholesky factors.

#include "identify/gp/sparse.h"

#include <fmt/format.h>

#include <algorithm>

#include "identify/dense/dense.h"
#include "identify/error.h"
#include "identify/gp/stationary.h"
#include "identify/random.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<Index> spread_subset(const MatrixXd& x, int count, std::uint64_t seed) {
  const Index n = x.rows();
  if (count < 1 || count > n) fail("a subset of {} of {} rows; there must be from 1 to {}", count, n, n);
  const MatrixXd scaled = x * column_variances(x).cwiseSqrt().cwiseInverse().asDiagonal();
  VectorXd distance = VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  std::vector<Index> chosen;
  auto next = static_cast<Index>(Random(seed).index(static_cast<std::uint64_t>(n)));
  for (int i = 0; i < count; ++i) {
    chosen.push_back(next);
    distance = distance.cwiseMin((scaled.rowwise() - scaled.row(next)).rowwise().squaredNorm());
    distance[next] = -1;  // never again, also where rows repeat
    distance.maxCoeff(&next);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

SparseGaussianProcess::SparseGaussianProcess(std::shared_ptr<const Covariance> covariance,
                                             Hyperparameters hyperparameters, const MatrixXd& x, const VectorXd& y,
                                             MatrixXd inducing)
    : covariance_(std::move(covariance)), hyperparameters_(std::move(hyperparameters)), inducing_(std::move(inducing)) {
  check_data(x, y);
  if (inducing_.rows() == 0 || inducing_.cols() != x.cols())
    fail("the inducing inputs are {} x {}; there must be at least one, with {} columns", inducing_.rows(),
         inducing_.cols(), x.cols());
  const VectorXd& theta = hyperparameters_.theta;
  if (!(hyperparameters_.v0 > 0))
    throw IdentifyError(
        fmt::format("the noise variance v0 is {:g}; a sparse process needs one greater than 0", hyperparameters_.v0));
  const MatrixXd k = covariance_->lower(theta, inducing_);
  double jitter = 1e-13 * k.diagonal().mean();
  do {
    jitter *= 10;
    factor_ = k;
    factor_.diagonal().array() += jitter;
  } while (!factorise(factor_) && jitter < 1e-5 * k.diagonal().mean());
  if (!(jitter < 1e-5 * k.diagonal().mean()))
    fail("the covariances of the inducing inputs are not positive definite; choose fewer of them, or farther apart");
  MatrixXd v = covariance_->between(theta, inducing_, x);
  solve_lower(factor_, v);
  const VectorXd own = covariance_->at(theta, x) - v.colwise().squaredNorm().transpose();
  const VectorXd g = own.cwiseMax(0.0).array() + hyperparameters_.v0;
  const VectorXd root = g.cwiseSqrt().cwiseInverse(), target = y.cwiseProduct(root);
  v = v * root.asDiagonal();
  inner_ = MatrixXd::Identity(inducing_.rows(), inducing_.rows());
  inner_.selfadjointView<Eigen::Lower>().rankUpdate(v);
  if (!factorise(inner_)) throw IdentifyError("the sparse process cannot be computed: numbers are too large");
  weights_ = v * target;
  solve_lower(inner_, weights_);
  log_likelihood_ = -0.5 * (target.squaredNorm() - weights_.squaredNorm()) - 0.5 * g.array().log().sum() -
                    inner_.diagonal().array().log().sum() - 0.5 * static_cast<double>(y.size()) * 1.8378770664093453;
}

Prediction SparseGaussianProcess::predict(const MatrixXd& x) const {
  Prediction result;
  MatrixXd k = covariance_->between(hyperparameters_.theta, inducing_, x);
  solve_lower(factor_, k);
  const VectorXd known = k.colwise().squaredNorm();
  solve_lower(inner_, k);
  result.mean = k.transpose() * weights_;
  result.variance =
      (covariance_->at(hyperparameters_.theta, x) - known + k.colwise().squaredNorm().transpose()).cwiseMax(0.0);
  return result;
}

}  // namespace plantloop::identify
