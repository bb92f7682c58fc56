// The squared exponential: very smooth functions, with a length scale for each input.

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

// k = v1 exp(-1/2 sum_d w_d (x_d - x'_d)^2); the length scale of input d is 1/sqrt(w_d).
class SquaredExponential final : public Stationary {
 public:
  std::string name() const override { return "se_ard"; }

  // Closed forms over x ~ N(mu, S) (A. Girard, C. Rasmussen, J. Quinonero-Candela, R. Murray-Smith 2003):
  //   q_i = v1 |I + S W|^-1/2 exp(-1/2 nu_i' (S + W^-1)^-1 nu_i),  nu_i = x_i - mu
  //   Q_ij = k_i k_j |I + 2 S W|^-1/2 exp(1/2 (a_i + a_j)' M (a_i + a_j)),  a_i = W nu_i,  M = (I + 2 S W)^-1 S
  //   E dk_i/dx = q_i (S + W^-1)^-1 nu_i
  // without an inverse of S, so inputs that are known exactly are rows of zeros.
  bool moments(const Vector& theta, const Matrix& z, const Vector& mu, const Matrix& s,
               KernelMoments& result) const override {
    const Eigen::Index n = z.rows(), d = z.cols();
    const Vector w = theta.head(d);
    const double v1 = theta[d];
    const Matrix nu = z.rowwise() - mu.transpose();
    const Matrix unit = Matrix::Identity(d, d);
    // (S + W^-1)^-1 = (I + W S)^-1 W.
    const Eigen::PartialPivLU<Matrix> one(unit + w.asDiagonal() * s);
    const Matrix precision = one.solve(Matrix(w.asDiagonal()));
    const Matrix turned = nu * precision.transpose();
    const Eigen::ArrayXd exponent = -0.5 * (turned.array() * nu.array()).rowwise().sum();
    result.k = v1;
    result.q = v1 / std::sqrt(one.determinant()) * exponent.exp();
    result.g = result.q.asDiagonal() * turned;

    const Eigen::PartialPivLU<Matrix> two(unit + 2 * s * w.asDiagonal());
    Matrix m = two.solve(s);
    m = 0.5 * (m + m.transpose()).eval();
    const Matrix a = nu * w.asDiagonal();
    const Matrix am = a * m;
    const Eigen::ArrayXd own = -0.5 * (nu.array().square().rowwise() * w.transpose().array()).rowwise().sum() +
                               0.5 * (am.array() * a.array()).rowwise().sum();
    const double factor = v1 * v1 / std::sqrt(two.determinant());
    result.Q.noalias() = am * a.transpose();
    for (Eigen::Index j = 0; j < n; ++j) result.Q.col(j) = factor * (result.Q.col(j).array() + own + own[j]).exp();
    return true;
  }

 protected:
  void shape(const Vector&, Eigen::Ref<Array> s) const override { s = (-0.5 * s).exp(); }
  void slope(const Vector&, const Eigen::Ref<const Array>&, const Eigen::Ref<const Array>& f,
             Eigen::Ref<Array> result) const override {
    result = -0.5 * f;
  }
  bool slope_reads_distance() const override { return false; }
};

}  // namespace

PLANTLOOP_COVARIANCE(se_ard, SquaredExponential)

}  // namespace plantloop::identify
