// What a network with infinitely many neurons tends to: steps that saturate.

#include <cmath>

#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

constexpr double two_over_pi = 0.6366197723675814;

// k = v1 2/pi asin(2 p(x, x')/sqrt((1 + 2 p(x, x)) (1 + 2 p(x', x')))),  p(x, x') = b + sum_d a_d x_d x'_d
// (C. Williams 1998; C. Rasmussen, C. Williams 2006, (4.29)).
class NeuralNetwork final : public Covariance {
 public:
  std::string name() const override { return "neural_network"; }
  std::vector<std::string> names(int inputs) const override {
    std::vector<std::string> all = numbered("a", inputs);
    all.emplace_back("b");
    all.emplace_back("v1");
    return all;
  }
  Vector guess(const Matrix& x, double variance) const override {
    const Eigen::Index d = x.cols();
    Vector theta(d + 2);
    theta.head(d) = column_variances(x).cwiseInverse();
    theta[d] = 1;
    theta[d + 1] = 2 * variance;
    return theta;
  }
  Matrix between(const Vector& theta, const Matrix& x, const Matrix& z) const override {
    return two_over_pi * theta[x.cols() + 1] * ratio(theta, x, z).array().asin();
  }
  Matrix lower(const Vector& theta, const Matrix& x) const override {
    return between(theta, x, x).triangularView<Eigen::Lower>();
  }
  Vector at(const Vector& theta, const Matrix& x) const override {
    const Eigen::ArrayXd p = own(theta, x);
    return two_over_pi * theta[x.cols() + 1] * (2 * p / (1 + 2 * p)).asin();
  }
  Vector gradient(const Vector& theta, const Matrix& x, const Matrix& values, const Matrix& weight) const override {
    const Eigen::Index n = x.rows(), d = x.cols();
    const double factor = two_over_pi * theta[d + 1];
    const Eigen::ArrayXd root = (1 + 2 * own(theta, x)).sqrt();
    Vector sums = Vector::Zero(theta.size());
    Matrix weighted(n, n);            // weight dk/dz/(root_i root_j), with z the argument of asin
    Vector shrink = Vector::Zero(n);  // what each 1 + 2 p(x_i, x_i) takes away
    const Matrix z = ratio(theta, x, x);
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto w = weight.col(j).tail(n - j).array();
      sums[d + 1] += 2 * (w * values.col(j).tail(n - j).array()).sum() - w[0] * values(j, j);
      const Eigen::ArrayXd dz = w * factor / (1 - z.col(j).tail(n - j).array().square()).sqrt();
      weighted.col(j).tail(n - j) = 2 * dz / (root.tail(n - j) * root[j]);
      Eigen::ArrayXd lost = dz * z.col(j).tail(n - j).array();
      lost[0] /= 2;
      // Each pair off the diagonal stands for two.
      shrink.tail(n - j).array() += 2 * lost / root.tail(n - j).square();
      shrink[j] += 2 * lost.sum() / (root[j] * root[j]);
    }
    const auto full = weighted.selfadjointView<Eigen::Lower>();
    const Matrix wx = full * x;
    for (Eigen::Index c = 0; c < d; ++c)
      sums[c] = theta[c] * (x.col(c).dot(wx.col(c)) - shrink.dot(x.col(c).cwiseAbs2()));
    sums[d] = theta[d] * ((full * Vector::Ones(n)).sum() - shrink.sum());
    return sums;
  }
  // With the argument z = 2 p(x, x')/(r r'), r^2 = 1 + 2 p(x, x):
  //   dz/d log a_c = a_c (2 x_c x'_c/(r r') - z x_c^2/r^2 - z x'_c^2/r'^2),  dz/dx'_c = 2 a_c (x_c/(r r') - z
  //   x'_c/r'^2).
  Vector cross_gradient(const Vector& theta, const Matrix& x, const Matrix& z, const Matrix& values,
                        const Matrix& weight, Matrix* by_z) const override {
    const Eigen::Index d = x.cols();
    const Vector left = 1 + 2 * own(theta, x), right = 1 + 2 * own(theta, z);  // r^2
    const Matrix argument = ratio(theta, x, z);
    Matrix by = two_over_pi * theta[d + 1] * (weight.array() / (1 - argument.array().square()).sqrt()).matrix();
    const Matrix shrink = by.cwiseProduct(argument);
    const Vector shrink_left = shrink.rowwise().sum().cwiseQuotient(left);
    const Vector shrink_right = shrink.colwise().sum().transpose().cwiseQuotient(right);
    by = 2 * (left.cwiseSqrt().cwiseInverse().asDiagonal() * by * right.cwiseSqrt().cwiseInverse().asDiagonal());
    const Matrix bx = by.transpose() * x;
    Vector sums(d + 2);
    for (Eigen::Index c = 0; c < d; ++c)
      sums[c] = theta[c] * (z.col(c).dot(bx.col(c)) - shrink_left.dot(x.col(c).cwiseAbs2()) -
                            shrink_right.dot(z.col(c).cwiseAbs2()));
    sums[d] = theta[d] * (by.sum() - shrink_left.sum() - shrink_right.sum());
    sums[d + 1] = weight.cwiseProduct(values).sum();
    if (by_z != nullptr) *by_z = (bx - 2 * shrink_right.asDiagonal() * z) * theta.head(d).asDiagonal();
    return sums;
  }
  Vector own_gradient(const Vector& theta, const Matrix& x, const Vector& weight) const override {
    const Eigen::Index d = x.cols();
    const Eigen::ArrayXd p = own(theta, x), z = 2 * p / (1 + 2 * p);
    const Vector by = two_over_pi * theta[d + 1] * weight.array() * 2 / (1 + 2 * p).square() / (1 - z.square()).sqrt();
    Vector sums(d + 2);
    sums.head(d) = theta.head(d).cwiseProduct(x.cwiseAbs2().transpose() * by);
    sums[d] = theta[d] * by.sum();
    sums[d + 1] = weight.dot(at(theta, x));
    return sums;
  }
  Matrix input_gradient(const Vector& theta, const Vector& x, const Matrix& z) const override {
    const Eigen::Index d = z.cols();
    const Vector a = theta.head(d);
    const double here = 1 + 2 * own(theta, x.transpose())[0];
    const Eigen::ArrayXd root = (here * (1 + 2 * own(theta, z))).sqrt();
    const Eigen::ArrayXd v = ratio(theta, z, x.transpose()).col(0).array();
    const Eigen::ArrayXd outer = two_over_pi * theta[d + 1] / (1 - v.square()).sqrt();
    Matrix gradient(z.rows(), d);
    for (Eigen::Index c = 0; c < d; ++c)
      gradient.col(c) = outer * (2 * a[c] * z.col(c).array() / root - v * 2 * a[c] * x[c] / here);
    return gradient;
  }

 private:
  static Eigen::ArrayXd own(const Vector& theta, const Matrix& x) {
    return (x.array().square().matrix() * theta.head(x.cols())).array() + theta[x.cols()];
  }
  static Matrix ratio(const Vector& theta, const Matrix& x, const Matrix& z) {
    const Eigen::Index d = x.cols();
    const Vector left = (1 + 2 * own(theta, x)).rsqrt(), right = (1 + 2 * own(theta, z)).rsqrt();
    Matrix p = ((x * theta.head(d).asDiagonal() * z.transpose()).array() + theta[d]).matrix();
    return 2 * (left.asDiagonal() * p * right.asDiagonal());
  }
};

}  // namespace

PLANTLOOP_COVARIANCE(neural_network, NeuralNetwork)

}  // namespace plantloop::identify
