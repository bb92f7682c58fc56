// Straight lines and planes.

#include "identify/gp/gaussian_terms.h"
#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

// k = b + sum_d a_d x_d x'_d: the prior variance of the offset and of each slope.
class Linear final : public Covariance {
 public:
  std::string name() const override { return "linear"; }
  std::vector<std::string> names(int inputs) const override {
    std::vector<std::string> all = numbered("a", inputs);
    all.emplace_back("b");
    return all;
  }
  Vector guess(const Matrix& x, double variance) const override {
    Vector theta(x.cols() + 1);
    theta.head(x.cols()) = variance / static_cast<double>(x.cols() + 1) * column_variances(x).cwiseInverse();
    theta[x.cols()] = variance / static_cast<double>(x.cols() + 1);
    return theta;
  }
  Matrix between(const Vector& theta, const Matrix& x, const Matrix& z) const override {
    const Eigen::Index d = x.cols();
    return ((x * theta.head(d).asDiagonal() * z.transpose()).array() + theta[d]).matrix();
  }
  Matrix lower(const Vector& theta, const Matrix& x) const override {
    return between(theta, x, x).triangularView<Eigen::Lower>();
  }
  Vector at(const Vector& theta, const Matrix& x) const override {
    return ((x.array().square().matrix() * theta.head(x.cols())).array() + theta[x.cols()]).matrix();
  }
  Vector gradient(const Vector& theta, const Matrix& x, const Matrix&, const Matrix& weight) const override {
    const Eigen::Index d = x.cols();
    const auto w = weight.selfadjointView<Eigen::Lower>();
    const Matrix wx = w * x;
    Vector sums(d + 1);
    for (Eigen::Index c = 0; c < d; ++c) sums[c] = theta[c] * x.col(c).dot(wx.col(c));
    sums[d] = theta[d] * (w * Vector::Ones(x.rows())).sum();
    return sums;
  }
  Vector cross_gradient(const Vector& theta, const Matrix& x, const Matrix& z, const Matrix&, const Matrix& weight,
                        Matrix* by_z) const override {
    const Eigen::Index d = x.cols();
    const Matrix wx = weight.transpose() * x;
    Vector sums(d + 1);
    for (Eigen::Index c = 0; c < d; ++c) sums[c] = theta[c] * z.col(c).dot(wx.col(c));
    sums[d] = theta[d] * weight.sum();
    if (by_z != nullptr) *by_z = wx * theta.head(d).asDiagonal();
    return sums;
  }
  Vector own_gradient(const Vector& theta, const Matrix& x, const Vector& weight) const override {
    const Eigen::Index d = x.cols();
    Vector sums(d + 1);
    sums.head(d) = theta.head(d).cwiseProduct(x.cwiseAbs2().transpose() * weight);
    sums[d] = theta[d] * weight.sum();
    return sums;
  }
  Matrix input_gradient(const Vector& theta, const Vector&, const Matrix& z) const override {
    return z * theta.head(z.cols()).asDiagonal();
  }
  Matrix slope_covariance(const Vector& theta, const Vector& x) const override {
    return theta.head(x.size()).asDiagonal();
  }
  bool terms(const Vector& theta, int inputs, std::vector<GaussianTerm>& list) const override {
    list.push_back({1, Vector::Zero(inputs), {{theta.head(inputs), theta[inputs]}}});
    return true;
  }
  bool slopes(const Vector& theta, const Vector& x, const Vector& z, Matrix& block,
              std::vector<Matrix>* by_theta) const override {
    const Eigen::Index d = x.size();
    const Vector a = theta.head(d);
    block = Matrix::Zero(d + 1, d + 1);
    block(0, 0) = theta[d] + (a.array() * x.array() * z.array()).sum();
    block.row(0).tail(d) = a.cwiseProduct(x).transpose();
    block.col(0).tail(d) = a.cwiseProduct(z);
    block.bottomRightCorner(d, d) = a.asDiagonal();
    if (by_theta == nullptr) return true;
    by_theta->assign(static_cast<std::size_t>(d + 1), Matrix::Zero(d + 1, d + 1));
    for (Eigen::Index c = 0; c < d; ++c) {
      Matrix& m = (*by_theta)[static_cast<std::size_t>(c)];
      m(0, 0) = a[c] * x[c] * z[c];
      m(0, c + 1) = a[c] * x[c];
      m(c + 1, 0) = a[c] * z[c];
      m(c + 1, c + 1) = a[c];
    }
    by_theta->back()(0, 0) = theta[d];
    return true;
  }
};

}  // namespace

PLANTLOOP_COVARIANCE(linear, Linear)

}  // namespace plantloop::identify
