// FITC and the variational bound through small factors, and their derivatives.

#include "identify/gp/sparse.h"

#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "identify/dense/dense.h"
#include "identify/error.h"
#include "identify/gp/gp_file.h"
#include "identify/linear/least_squares.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double log_two_pi = 1.8378770664093453;

// The relative jitter, from `least` on, with which `factor` is that of k; -1: there is none.
double factorise_inducing(const MatrixXd& k, double least, MatrixXd& factor) {
  const double scale = k.diagonal().mean();
  for (double jitter = least; jitter <= 1.1e-5; jitter = jitter == 0 ? 1e-12 : 10 * jitter) {
    factor = k;
    factor.diagonal().array() += jitter * scale;
    // Without jitter only where it would change nothing that can be seen.
    if (factorise(factor) && (jitter > 0 || factor.diagonal().minCoeff() > 1e-4 * std::sqrt(scale))) return jitter;
  }
  return -1;
}

// The data seen through U; names as in the header.
struct Seen {
  MatrixXd kuu, kfu;    // lower triangle; N x M
  MatrixXd L, V, B, R;  // M x M, M x N, M x M, M x M
  VectorXd missed, g;   // diag(K_ff - Q), diag G
  VectorXd b, r, w, e;  // e = r - V'w
  double jitter = -1;   // relative
  double value = -std::numeric_limits<double>::infinity();
};

// In the least-squares problem min |G^-1/2 (y - H b - V'w)|^2 + |w|^2, V is projected out of H.
VectorXd fit_mean(const MatrixXd& H, const VectorXd& y, const MatrixXd& scaled, const MatrixXd& R,
                  const VectorXd& root) {
  const Index n = H.rows(), m = R.rows();
  const MatrixXd hs = root.asDiagonal() * H;
  MatrixXd z = scaled * hs;
  solve_lower(R, z);
  solve_lower_transposed(R, z);
  MatrixXd projected(n + m, H.cols());
  projected.topRows(n) = hs - scaled.transpose() * z;
  projected.bottomRows(m) = -z;
  VectorXd target = VectorXd::Zero(n + m);
  target.head(n) = root.cwiseProduct(y);
  if (!projected.allFinite() || !target.allFinite()) return VectorXd::Zero(projected.cols());
  return least_squares(projected, target).theta;
}

Seen see(SparseMethod method, const Covariance& covariance, MeanFunction mean, const Hyperparameters& at,
         const MatrixXd& x, const VectorXd& y, const MatrixXd& u) {
  Seen s;
  s.kuu = covariance.lower(at.theta, u);
  s.jitter = factorise_inducing(s.kuu, 0, s.L);
  if (s.jitter < 0 || !(at.v0 > 0)) return s;
  s.kfu = covariance.between(at.theta, x, u);
  s.V = s.kfu.transpose();
  solve_lower(s.L, s.V);
  s.missed = (covariance.at(at.theta, x) - s.V.colwise().squaredNorm().transpose()).cwiseMax(0.0);
  s.g = VectorXd::Constant(x.rows(), at.v0);
  if (method == SparseMethod::fitc) s.g += s.missed;
  const VectorXd root = s.g.cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = s.V * root.asDiagonal();
  s.B = MatrixXd::Identity(u.rows(), u.rows());
  s.B.selfadjointView<Eigen::Lower>().rankUpdate(scaled);
  s.R = s.B;
  if (!factorise(s.R)) return s;
  s.r = y;
  const MatrixXd H = mean_basis(mean, x);
  if (H.cols() > 0) {
    s.b = fit_mean(H, y, scaled, s.R, root);
    s.r -= H * s.b;
  }
  s.w = scaled * root.cwiseProduct(s.r);
  solve_lower(s.R, s.w);
  solve_lower_transposed(s.R, s.w);
  s.e = s.r - s.V.transpose() * s.w;
  s.value = -0.5 * (root.cwiseProduct(s.e).squaredNorm() + s.w.squaredNorm()) - 0.5 * s.g.array().log().sum() -
            s.R.diagonal().array().log().sum() - 0.5 * static_cast<double>(y.size()) * log_two_pi;
  if (method == SparseMethod::vfe) s.value -= s.missed.sum() / (2 * at.v0);
  return s;
}

// With C = Q + G the value changes by sum_ij W_ij dC_ij, W = (C^-1 r r'C^-1 - C^-1)/2, of the bound besides by that of
// the trace. Both are
//   tr((W + S) dQ) + sum_i -S_ii dk_ii + ... dv0,  S = -diag(W) (fitc) or I/(2 v0) (vfe),
// and dQ = A'dK_uf + dK_fu A - A'dK_uu A with A = K_uu^-1 K_uf, so that A (W + S) is all that is needed:
//   C^-1 r = G^-1 e,  A C^-1 = L'^-1 B^-1 V G^-1,  V C^-1 r = w.
Likelihood derivatives(const Seen& s, SparseMethod method, const Covariance& covariance, const Hyperparameters& at,
                       const MatrixXd& x, const MatrixXd& u) {
  const Index p = at.theta.size(), m = u.rows();
  const VectorXd alpha = s.e.cwiseQuotient(s.g);
  MatrixXd T = s.V;
  solve_lower(s.R, T);
  const VectorXd inverse = s.g.cwiseInverse() - T.colwise().squaredNorm().transpose().cwiseQuotient(s.g.cwiseAbs2());
  const VectorXd W = 0.5 * (alpha.cwiseAbs2() - inverse);
  const VectorXd S = method == SparseMethod::fitc ? VectorXd(-W) : VectorXd::Constant(x.rows(), 0.5 / at.v0);
  solve_lower_transposed(s.R, T);
  T = T * (-0.5 * s.g.cwiseInverse()).asDiagonal();
  T.noalias() += s.V * S.asDiagonal();
  T.noalias() += 0.5 * s.w * alpha.transpose();

  // L'^-1 (...) L^-1 of what A (W + S) A' is between the factors.
  MatrixXd E = s.R;
  invert_factored(E);
  mirror_lower(E);
  E = 0.5 * (E - MatrixXd::Identity(m, m) + s.w * s.w.transpose()) + s.V * S.asDiagonal() * s.V.transpose();
  solve_lower_transposed(s.L, E);
  E.transposeInPlace();
  solve_lower_transposed(s.L, E);
  E = -0.5 * (E + E.transpose()).eval();
  E.diagonal().array() += s.jitter * E.trace() / static_cast<double>(m);
  solve_lower_transposed(s.L, T);

  Likelihood result;
  result.value = s.value;
  MatrixXd kuu = s.kuu, by_u, by_own;
  mirror_lower(kuu);
  result.gradient = VectorXd::Zero(p + 1);
  result.gradient.head(p) = covariance.cross_gradient(at.theta, x, u, s.kfu, 2 * T.transpose(), &by_u) +
                            covariance.cross_gradient(at.theta, u, u, kuu, E, &by_own) +
                            covariance.own_gradient(at.theta, x, -S);
  result.gradient[p] = at.v0 * W.sum();
  if (method == SparseMethod::vfe) result.gradient[p] += s.missed.sum() / (2 * at.v0);
  // u stands on both sides of K_uu.
  result.by_inducing = by_u + 2 * by_own;
  return result;
}

}  // namespace

SparseMethod find_sparse_method(const std::string& name) {
  if (name == "fitc") return SparseMethod::fitc;
  if (name == "vfe") return SparseMethod::vfe;
  fail("there is no sparse approximation '{}'; there are fitc, vfe", name);
}

std::string name_of(SparseMethod method) { return method == SparseMethod::fitc ? "fitc" : "vfe"; }

Likelihood sparse_likelihood(SparseMethod method, const Covariance& covariance, MeanFunction mean,
                             const Hyperparameters& at, const MatrixXd& x, const VectorXd& y, const MatrixXd& inducing,
                             bool with_gradient) {
  const Seen s = see(method, covariance, mean, at, x, y, inducing);
  if (with_gradient && std::isfinite(s.value)) return derivatives(s, method, covariance, at, x, inducing);
  const double value = std::isfinite(s.value) ? s.value : -std::numeric_limits<double>::infinity();
  return {value, VectorXd::Zero(at.theta.size() + 1), MatrixXd::Zero(inducing.rows(), inducing.cols())};
}

SparseGaussianProcess::SparseGaussianProcess(SparseMethod method, std::shared_ptr<const Covariance> covariance,
                                             MeanFunction mean, Hyperparameters hyperparameters, MatrixXd x, VectorXd y,
                                             MatrixXd inducing)
    : GpPosterior(std::move(covariance), mean, std::move(hyperparameters), std::move(inducing)) {
  check_data(x, y);
  if (x_.rows() == 0 || x_.cols() != x.cols())
    fail("the inducing inputs are {} x {}; there must be at least one, with {} columns", x_.rows(), x_.cols(),
         x.cols());
  if (!x_.allFinite()) throw IdentifyError("an inducing input is not a finite number");
  if (!(hyperparameters_.v0 > 0))
    fail("the noise variance v0 is {:g}; a sparse process needs one greater than 0", hyperparameters_.v0);
  Seen s = see(method, *covariance_, mean_, hyperparameters_, x, y, x_);
  if (!s.kuu.allFinite())
    throw IdentifyError("a covariance is not a finite number: hyperparameters or inputs are too large");
  if (s.jitter < 0)
    throw IdentifyError(
        "the covariances of the inducing inputs are not positive definite; choose fewer of them, or farther apart");
  if (!std::isfinite(s.value)) throw IdentifyError("the sparse process cannot be computed: numbers are too large");
  content_.method = method;
  content_.jitter = s.jitter;
  content_.samples = y.size();
  content_.log_likelihood = s.value;
  content_.precision = std::move(s.B);
  mirror_lower(content_.precision);
  coefficients_ = std::move(s.b);
  whitened_ = std::move(s.w);
  data_ = std::make_shared<const Data>(Data{std::move(x), std::move(y)});
  prepare();
}

SparseGaussianProcess::SparseGaussianProcess(Content content)
    : GpPosterior(std::move(content.covariance), content.mean, std::move(content.hyperparameters),
                  std::move(content.inducing)),
      content_(std::move(content)) {
  coefficients_ = std::move(content_.mean_coefficients);
  whitened_ = std::move(content_.weights);
  prepare();
}

// The factors that U and B have: the same bits from data and from a file.
void SparseGaussianProcess::prepare() {
  const MatrixXd k = covariance_->lower(hyperparameters_.theta, x_);
  content_.jitter = factorise_inducing(k, content_.jitter, factor_);
  if (content_.jitter < 0) throw IdentifyError("the covariances of the inducing inputs are not positive definite");
  jitter_ = content_.jitter * k.diagonal().mean();
  inner_ = content_.precision;
  if (!factorise(inner_)) throw IdentifyError("the precision is not positive definite");
  alpha_ = whitened_;
  solve_lower_transposed(factor_, alpha_);
}

const SparseGaussianProcess::Data& SparseGaussianProcess::data(const char* what) const {
  if (!data_)
    fail("{} of a sparse process needs its data, which a model file does not hold; ask the model as it was fitted",
         what);
  return *data_;
}

Likelihood SparseGaussianProcess::likelihood() const {
  const Data& seen = data("the gradient");
  return sparse_likelihood(content_.method, *covariance_, mean_, hyperparameters_, seen.x, seen.y, x_);
}

LeaveOneOut SparseGaussianProcess::leave_one_out() const {
  const Data& seen = data("leaving one out");
  const Seen s = see(content_.method, *covariance_, mean_, hyperparameters_, seen.x, seen.y, x_);
  MatrixXd T = s.V;
  solve_lower(s.R, T);
  const VectorXd share = T.colwise().squaredNorm().transpose().cwiseQuotient(s.g);
  LeaveOneOut result;
  // [C^-1]_ii = (1 - share)/g.
  result.variance = s.g.cwiseQuotient((1 - share.array()).matrix());
  result.mean = seen.y - s.e.cwiseQuotient(s.g).cwiseProduct(result.variance);
  if (content_.method == SparseMethod::vfe) result.variance += s.missed;
  result.log_density = log_densities(seen.y, result.mean, result.variance);
  result.log_probability = result.log_density.sum();
  return result;
}

SparseGaussianProcess SparseGaussianProcess::with(const MatrixXd& x, const VectorXd& y) const {
  check_data(x, y);
  if (data_) {
    MatrixXd all_x(data_->x.rows() + x.rows(), x.cols());
    VectorXd all_y(all_x.rows());
    all_x << data_->x, x;
    all_y << data_->y, y;
    return {content_.method, covariance_, mean_, hyperparameters_, std::move(all_x), std::move(all_y), x_};
  }
  SparseGaussianProcess more = *this;
  MatrixXd v = covariance_->between(hyperparameters_.theta, x_, x);
  solve_lower(factor_, v);
  const VectorXd missed =
      (covariance_->at(hyperparameters_.theta, x) - v.colwise().squaredNorm().transpose()).cwiseMax(0.0);
  VectorXd r = y, means = VectorXd::Zero(y.size());
  add_mean(x, means);
  r -= means;
  VectorXd pull = content_.precision * whitened_;  // V G^-1 r
  const double v0 = hyperparameters_.v0;
  for (Index i = 0; i < y.size(); ++i) {
    // The next one given those before it: N(v'w, g + |R^-1 v|^2).
    const VectorXd one = v.col(i);
    const double g = content_.method == SparseMethod::fitc ? v0 + missed[i] : v0;
    VectorXd spread = one;
    solve_lower(more.inner_, spread);
    const double variance = g + spread.squaredNorm(), error = r[i] - one.dot(more.whitened_);
    more.content_.log_likelihood -= 0.5 * (log_two_pi + std::log(variance) + error * error / variance);
    if (content_.method == SparseMethod::vfe) more.content_.log_likelihood -= missed[i] / (2 * v0);
    more.content_.precision += one * one.transpose() / g;
    pull += one * (r[i] / g);
    more.inner_ = more.content_.precision;
    if (!factorise(more.inner_)) throw IdentifyError("the sparse process cannot be computed: numbers are too large");
    more.whitened_ = pull;
    solve_lower(more.inner_, more.whitened_);
    solve_lower_transposed(more.inner_, more.whitened_);
  }
  more.content_.samples += y.size();
  more.prepare();
  return more;
}

void SparseGaussianProcess::write(Item& item) const {
  write_process(*this, item);
  item.set("approximation", name_of(content_.method))
      .set("samples", content_.samples)
      .set("log_likelihood", content_.log_likelihood)
      .set("jitter", content_.jitter);
  if (coefficients_.size() > 0) item.set("mean_coefficients", coefficients_);
  item.set("weights", whitened_).set("inducing", x_).set("precision", content_.precision);
}

}  // namespace plantloop::identify
