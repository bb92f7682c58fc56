// The squared exponential: very smooth functions, with a length scale for each input.

#include <Eigen/Eigenvalues>
#include <cmath>

#include "identify/gp/gaussian_terms.h"
#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

// k = v1 exp(-1/2 sum_d w_d (x_d - x'_d)^2); the length scale of input d is 1/sqrt(w_d).
class SquaredExponential final : public Stationary {
 public:
  std::string name() const override { return "se_ard"; }

  // Closed forms over x ~ N(mu, S) (A. Girard, C. Rasmussen, J. Quinonero-Candela, R. Murray-Smith 2003), in the
  // coordinates n = U' W^1/2 (x_i - mu) in which W^1/2 S W^1/2 = U diag(l) U' is diagonal:
  //   q_i = v1 prod_d (1 + l_d)^-1/2 exp(-1/2 n_id^2/(1 + l_d)),  E dk_i/dx = q_i W^1/2 U [n_i/(1 + l)]
  //   log(E k_i k_j/(q_i q_j)) = sum_d 1/2 log(1 + l^2/(1 + 2l)) - 1/2 l^2/((1 + l)(1 + 2l)) (n_id^2 + n_jd^2)
  //                              + l/(1 + 2l) n_id n_jd
  // The logarithm is of the order of S, so C = q_i q_j (ratio - 1) keeps its digits where S is small, and no inverse of
  // S is needed: inputs that are known exactly are rows of zeros.
  bool moments(const Vector& theta, const Matrix& z, const Vector& mu, const Matrix& s,
               KernelMoments& result) const override {
    const Eigen::Index count = z.rows(), d = z.cols();
    const Vector root = theta.head(d).cwiseSqrt();
    const double v1 = theta[d];
    const Eigen::SelfAdjointEigenSolver<Matrix> axes(Matrix(root.asDiagonal() * s * root.asDiagonal()));
    const Eigen::ArrayXd l = axes.eigenvalues().array().max(0.0), one = 1 + l, two = 1 + 2 * l;
    const Matrix turn = root.asDiagonal() * axes.eigenvectors();
    const Matrix n = (z.rowwise() - mu.transpose()) * turn;
    const Eigen::ArrayXd log_q =
        std::log(v1) - 0.5 * one.log().sum() - 0.5 * (n.array().square().rowwise() / one.transpose()).rowwise().sum();
    result.k = v1;
    result.q = log_q.exp();
    result.g = result.q.asDiagonal() * Matrix(n * Vector(one.inverse()).asDiagonal() * turn.transpose());

    const double constant = 0.5 * (l.square() / two).log1p().sum();
    const Eigen::ArrayXd own =
        -0.5 * (n.array().square().rowwise() * (l.square() / (one * two)).transpose()).rowwise().sum();
    result.C.noalias() = n * Vector(l / two).asDiagonal() * n.transpose();
    for (Eigen::Index j = 0; j < count; ++j) {
      for (Eigen::Index i = j; i < count; ++i) {
        const double ratio = constant + own[i] + own[j] + result.C(i, j);
        const double product = result.q[i] * result.q[j];
        // Far from all points the product is too small for a double, and its ratio too large.
        result.C(i, j) =
            std::fabs(ratio) < 0.5 ? product * std::expm1(ratio) : std::exp(log_q[i] + log_q[j] + ratio) - product;
        result.C(j, i) = result.C(i, j);
      }
    }
    return true;
  }

  bool terms(const Vector& theta, int inputs, std::vector<GaussianTerm>& list) const override {
    list.push_back({theta[inputs], theta.head(inputs), {}});
    return true;
  }

 protected:
  void shape(const Vector&, Eigen::Ref<Array> s) const override { s = (-0.5 * s).exp(); }
  void slope(const Vector&, const Eigen::Ref<const Array>&, const Eigen::Ref<const Array>& f,
             Eigen::Ref<Array> result) const override {
    result = -0.5 * f;
  }
  bool slope_reads_distance() const override { return false; }
  bool series(const Vector&, double s, Series& f, std::vector<Series>&) const override {
    const double e = std::exp(-0.5 * s);
    f = {e, -0.5 * e, 0.25 * e, -0.125 * e};
    return true;
  }
};

}  // namespace

PLANTLOOP_COVARIANCE(se_ard, SquaredExponential)

}  // namespace plantloop::identify
