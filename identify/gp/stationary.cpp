// Covariances of the weighted distance, column by column.

#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Inputs in units of their length scales.
MatrixXd scaled(const VectorXd& theta, const MatrixXd& x) { return x * theta.head(x.cols()).cwiseSqrt().asDiagonal(); }

// The distances s of the rows from `first` on to the point.
template <typename Point>
void distances(const MatrixXd& x, Index first, const Point& point, Eigen::Ref<ArrayXd> s) {
  const Index rows = x.rows() - first;
  if (x.cols() == 0) {
    s.setZero();
    return;
  }
  s = (x.col(0).tail(rows).array() - point[0]).square();
  for (Index d = 1; d < x.cols(); ++d) s += (x.col(d).tail(rows).array() - point[d]).square();
}

}  // namespace

VectorXd column_variances(const MatrixXd& x) {
  VectorXd variances(x.cols());
  for (Index d = 0; d < x.cols(); ++d) {
    const double v = (x.col(d).array() - x.col(d).mean()).square().mean();
    variances[d] = v > 0 ? v : 1;
  }
  return variances;
}

std::vector<std::string> Stationary::names(int inputs) const {
  std::vector<std::string> all = numbered("w", inputs);
  all.emplace_back("v1");
  for (std::string& name : own_names()) all.push_back(std::move(name));
  return all;
}

VectorXd Stationary::guess(const MatrixXd& x, double variance) const {
  const Index d = x.cols();
  const VectorXd own = own_guess();
  VectorXd theta(d + 1 + own.size());
  theta.head(d) = column_variances(x).cwiseInverse() / static_cast<double>(d);
  theta[d] = variance;
  theta.tail(own.size()) = own;
  return theta;
}

MatrixXd Stationary::between(const VectorXd& theta, const MatrixXd& x, const MatrixXd& z) const {
  const Index d = x.cols();
  const MatrixXd xs = scaled(theta, x), zs = scaled(theta, z);
  const VectorXd own = theta.tail(theta.size() - d - 1);
  MatrixXd k(x.rows(), z.rows());
  for (Index j = 0; j < z.rows(); ++j) {
    distances(xs, 0, zs.row(j), k.col(j).array());
    shape(own, k.col(j).array());
    k.col(j) *= theta[d];
  }
  return k;
}

MatrixXd Stationary::lower(const VectorXd& theta, const MatrixXd& x) const {
  const Index n = x.rows(), d = x.cols();
  const MatrixXd xs = scaled(theta, x);
  const VectorXd own = theta.tail(theta.size() - d - 1);
  MatrixXd k(n, n);
  for (Index j = 0; j < n; ++j) {
    k.col(j).head(j).setZero();
    auto column = k.col(j).tail(n - j).array();
    distances(xs, j, xs.row(j), column);
    shape(own, column);
    column *= theta[d];
  }
  return k;
}

VectorXd Stationary::at(const VectorXd& theta, const MatrixXd& x) const {
  return VectorXd::Constant(x.rows(), theta[x.cols()]);
}

VectorXd Stationary::gradient(const VectorXd& theta, const MatrixXd& x, const MatrixXd& values,
                              const MatrixXd& weight) const {
  const Index n = x.rows(), d = x.cols();
  const MatrixXd xs = scaled(theta, x);
  const VectorXd own = theta.tail(theta.size() - d - 1);
  const double v1 = theta[d];
  VectorXd sums = VectorXd::Zero(theta.size());
  ArrayXd s_all(n), f_all(n), slope_all(n), square(n);
  const bool with_distance = slope_reads_distance() || own.size() > 0;
  for (Index j = 0; j < n; ++j) {
    const Index rows = n - j;
    const auto w = weight.col(j).tail(rows).array();
    const auto k = values.col(j).tail(rows).array();
    auto s = s_all.head(rows), f = f_all.head(rows), m = slope_all.head(rows);
    f = k / v1;
    if (with_distance) distances(xs, j, xs.row(j), s);
    // The diagonal counts once, the rest twice; on the diagonal all distances are zero.
    sums[d] += 2 * (w * k).sum() - w[0] * k[0];
    for (Index p = 0; p < own.size(); ++p) {
      own_slope(own, static_cast<int>(p), s, f, m);
      sums[d + 1 + p] += v1 * (2 * (w * m).sum() - w[0] * m[0]);
    }
    slope(own, s, f, m);
    m *= w;
    for (Index c = 0; c < d; ++c) sums[c] += 2 * v1 * (m * (xs.col(c).tail(rows).array() - xs(j, c)).square()).sum();
  }
  return sums;
}

VectorXd Stationary::cross_gradient(const VectorXd& theta, const MatrixXd& x, const MatrixXd& z, const MatrixXd& values,
                                    const MatrixXd& weight, MatrixXd* by_z) const {
  const Index n = x.rows(), d = x.cols();
  const MatrixXd xs = scaled(theta, x), zs = scaled(theta, z);
  const VectorXd own = theta.tail(theta.size() - d - 1), root = theta.head(d).cwiseSqrt();
  const double v1 = theta[d];
  VectorXd sums = VectorXd::Zero(theta.size());
  ArrayXd s(n), f(n), m(n), away(n);
  if (by_z != nullptr) by_z->resize(z.rows(), d);
  for (Index j = 0; j < z.rows(); ++j) {
    const auto w = weight.col(j).array();
    f = values.col(j).array() / v1;
    if (slope_reads_distance() || own.size() > 0) distances(xs, 0, zs.row(j), s);
    sums[d] += weight.col(j).dot(values.col(j));
    for (Index p = 0; p < own.size(); ++p) {
      own_slope(own, static_cast<int>(p), s, f, m);
      sums[d + 1 + p] += v1 * (w * m).sum();
    }
    slope(own, s, f, m);
    m *= w;
    for (Index c = 0; c < d; ++c) {
      away = xs.col(c).array() - zs(j, c);
      sums[c] += v1 * (m * away.square()).sum();
      if (by_z != nullptr) (*by_z)(j, c) = -2 * v1 * root[c] * (m * away).sum();
    }
  }
  return sums;
}

VectorXd Stationary::own_gradient(const VectorXd& theta, const MatrixXd& x, const VectorXd& weight) const {
  return VectorXd::Unit(theta.size(), x.cols()) * theta[x.cols()] * weight.sum();
}

MatrixXd Stationary::input_gradient(const VectorXd& theta, const VectorXd& x, const MatrixXd& z) const {
  const Index d = z.cols();
  const MatrixXd zs = scaled(theta, z);
  const VectorXd root = theta.head(d).cwiseSqrt(), point = x.cwiseProduct(root);
  const VectorXd own = theta.tail(theta.size() - d - 1);
  ArrayXd s(z.rows()), f(z.rows()), m(z.rows());
  distances(zs, 0, point, s);
  f = s;
  shape(own, f);
  slope(own, s, f, m);
  MatrixXd gradient(z.rows(), d);
  for (Index c = 0; c < d; ++c) gradient.col(c) = 2 * theta[d] * root[c] * m * (point[c] - zs.col(c).array());
  return gradient;
}

MatrixXd Stationary::slope_covariance(const VectorXd& theta, const VectorXd& x) const {
  const Index d = x.size();
  const VectorXd own = theta.tail(theta.size() - d - 1);
  ArrayXd s = ArrayXd::Zero(1), f = s, m(1);
  shape(own, f);
  slope(own, s, f, m);
  return (-2 * theta[d] * m[0] * theta.head(d)).asDiagonal();
}

// With r = x - z and s = sum w r^2:
//   dk/dz_e = -2 v1 f' w_e r_e = -dk/dx_e,   d2k/dx_d dz_e = -v1 (4 f'' w_d r_d w_e r_e + 2 f' w_d [d = e]).
bool Stationary::slopes(const VectorXd& theta, const VectorXd& x, const VectorXd& z, MatrixXd& block,
                        std::vector<MatrixXd>* by_theta) const {
  const Index d = x.size();
  const VectorXd w = theta.head(d), r = x - z, wr = w.cwiseProduct(r);
  const double v1 = theta[d];
  Series f;
  std::vector<Series> by_own(static_cast<std::size_t>(theta.size() - d - 1));
  if (!series(theta.tail(theta.size() - d - 1), wr.dot(r), f, by_own)) return false;
  const auto blocks = [&](const Series& of) {
    MatrixXd m(d + 1, d + 1);
    m(0, 0) = v1 * of.f;
    m.row(0).tail(d) = -2 * v1 * of.f1 * wr.transpose();
    m.col(0).tail(d) = 2 * v1 * of.f1 * wr;
    m.bottomRightCorner(d, d) = -4 * v1 * of.f2 * wr * wr.transpose();
    m.bottomRightCorner(d, d).diagonal() -= 2 * v1 * of.f1 * w;
    return m;
  };
  block = blocks(f);
  if (by_theta == nullptr) return true;
  by_theta->clear();
  for (Index c = 0; c < d; ++c) {
    // By log w_c: through s, ds = w_c r_c^2, and where w_c stands itself.
    MatrixXd m = wr[c] * r[c] * blocks({f.f1, f.f2, f.f3, 0});
    m(0, c + 1) -= 2 * v1 * f.f1 * wr[c];
    m(c + 1, 0) += 2 * v1 * f.f1 * wr[c];
    m.row(c + 1).tail(d) -= 4 * v1 * f.f2 * wr[c] * wr.transpose();
    m.col(c + 1).tail(d) -= 4 * v1 * f.f2 * wr[c] * wr;
    m(c + 1, c + 1) -= 2 * v1 * f.f1 * w[c];
    by_theta->push_back(std::move(m));
  }
  by_theta->push_back(block);
  for (const Series& own : by_own) by_theta->push_back(blocks(own));
  return true;
}

}  // namespace plantloop::identify
