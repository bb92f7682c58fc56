// A periodic function of each input.

#include <cmath>

#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

constexpr double pi = 3.141592653589793;

// k = v1 exp(-2 sum_d w_d sin^2(pi (x_d - x'_d)/period_d)) (D. MacKay 1998).
class Periodic final : public Covariance {
 public:
  std::string name() const override { return "periodic"; }
  std::vector<std::string> names(int inputs) const override {
    std::vector<std::string> all = numbered("w", inputs);
    for (std::string& name : numbered("period", inputs)) all.push_back(std::move(name));
    all.emplace_back("v1");
    return all;
  }
  Vector guess(const Matrix& x, double variance) const override {
    const Eigen::Index d = x.cols();
    Vector theta(2 * d + 1);
    theta.head(d).setConstant(0.5 / static_cast<double>(d));
    theta.segment(d, d) = 2 * column_variances(x).cwiseSqrt();
    theta[2 * d] = variance;
    return theta;
  }
  Matrix between(const Vector& theta, const Matrix& x, const Matrix& z) const override {
    Matrix k(x.rows(), z.rows());
    for (Eigen::Index j = 0; j < z.rows(); ++j) k.col(j) = column(theta, x, 0, z.row(j));
    return k;
  }
  Matrix lower(const Vector& theta, const Matrix& x) const override {
    Matrix k = Matrix::Zero(x.rows(), x.rows());
    for (Eigen::Index j = 0; j < x.rows(); ++j) k.col(j).tail(x.rows() - j) = column(theta, x, j, x.row(j));
    return k;
  }
  Vector at(const Vector& theta, const Matrix& x) const override {
    return Vector::Constant(x.rows(), theta[2 * x.cols()]);
  }
  Vector gradient(const Vector& theta, const Matrix& x, const Matrix& values, const Matrix& weight) const override {
    const Eigen::Index n = x.rows(), d = x.cols();
    Vector sums = Vector::Zero(theta.size());
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::ArrayXd m = weight.col(j).tail(n - j).array() * values.col(j).tail(n - j).array();
      sums[2 * d] += 2 * m.sum() - m[0];
      for (Eigen::Index c = 0; c < d; ++c) {
        const double w = theta[c], period = theta[d + c];
        const Eigen::ArrayXd angle = pi / period * (x.col(c).tail(n - j).array() - x(j, c));
        // On the diagonal the angle is zero and so are both.
        sums[c] += 2 * (m * (-2 * w * angle.sin().square())).sum();
        sums[d + c] += 2 * (m * (2 * w * angle * (2 * angle).sin())).sum();
      }
    }
    return sums;
  }
  Vector cross_gradient(const Vector& theta, const Matrix& x, const Matrix& z, const Matrix& values,
                        const Matrix& weight, Matrix* by_z) const override {
    const Eigen::Index d = x.cols();
    Vector sums = Vector::Zero(theta.size());
    if (by_z != nullptr) by_z->resize(z.rows(), d);
    for (Eigen::Index j = 0; j < z.rows(); ++j) {
      const Eigen::ArrayXd m = weight.col(j).array() * values.col(j).array();
      sums[2 * d] += m.sum();
      for (Eigen::Index c = 0; c < d; ++c) {
        const double w = theta[c], period = theta[d + c];
        const Eigen::ArrayXd angle = pi / period * (x.col(c).array() - z(j, c)), twice = (2 * angle).sin();
        sums[c] -= 2 * w * (m * angle.sin().square()).sum();
        sums[d + c] += 2 * w * (m * angle * twice).sum();
        if (by_z != nullptr) (*by_z)(j, c) = 2 * w * pi / period * (m * twice).sum();
      }
    }
    return sums;
  }
  Vector own_gradient(const Vector& theta, const Matrix& x, const Vector& weight) const override {
    return Vector::Unit(theta.size(), 2 * x.cols()) * theta[2 * x.cols()] * weight.sum();
  }
  Matrix input_gradient(const Vector& theta, const Vector& x, const Matrix& z) const override {
    const Eigen::Index d = z.cols();
    const Eigen::ArrayXd k = column(theta, z, 0, x.transpose());
    Matrix gradient(z.rows(), d);
    for (Eigen::Index c = 0; c < d; ++c) {
      const Eigen::ArrayXd angle = 2 * pi / theta[d + c] * (x[c] - z.col(c).array());
      gradient.col(c) = -2 * theta[c] * pi / theta[d + c] * k * angle.sin();
    }
    return gradient;
  }

 private:
  static Vector column(const Vector& theta, const Matrix& x, Eigen::Index first, const Eigen::RowVectorXd& point) {
    const Eigen::Index d = x.cols(), rows = x.rows() - first;
    Eigen::ArrayXd s = Eigen::ArrayXd::Zero(rows);
    for (Eigen::Index c = 0; c < d; ++c)
      s += theta[c] * (pi / theta[d + c] * (x.col(c).tail(rows).array() - point[c])).sin().square();
    return theta[2 * d] * (-2 * s).exp();
  }
};

}  // namespace

PLANTLOOP_COVARIANCE(periodic, Periodic)

}  // namespace plantloop::identify
