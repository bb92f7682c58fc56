// The door to Eigen for the analyses.

#include "engine/analysis/matrix.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <unsupported/Eigen/MatrixFunctions>

namespace plantloop {

namespace {

using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Column = Eigen::VectorXd;

Eigen::Map<const Dense> view(const DenseMatrix& m) {
  return {m.values.data(), static_cast<Eigen::Index>(m.rows), static_cast<Eigen::Index>(m.columns)};
}
Eigen::Map<const Column> view(const std::vector<double>& v) { return {v.data(), static_cast<Eigen::Index>(v.size())}; }

DenseMatrix matrix_of(const Dense& dense) {
  DenseMatrix m(static_cast<std::size_t>(dense.rows()), static_cast<std::size_t>(dense.cols()));
  Eigen::Map<Dense>(m.values.data(), dense.rows(), dense.cols()) = dense;
  return m;
}

std::vector<double> vector_of(const Column& c) { return {c.data(), c.data() + c.size()}; }

constexpr double relative_zero = 1e-13;  // of singular values

Eigen::Index rank_of(const Eigen::JacobiSVD<Eigen::MatrixXd>& svd, double scale) {
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > relative_zero * scale) ++rank;
  return rank;
}

struct System {
  Eigen::MatrixXd a, b, c, d;
};

// Makes D of full row rank: outputs that inputs do not reach at once force states to zero, and are replaced by the
// derivatives of those states.
void reduce_rows(System& s, double scale) {
  while (s.c.rows() > 0) {
    // Of a matrix without columns Eigen knows no singular values.
    Eigen::JacobiSVD<Eigen::MatrixXd> of_d;
    if (s.d.cols() > 0) of_d.compute(s.d, Eigen::ComputeFullU);
    const Eigen::Index sigma = s.d.cols() == 0 ? 0 : rank_of(of_d, scale);
    if (sigma == s.c.rows()) return;
    const Eigen::Index rest = s.c.rows() - sigma;
    if (s.d.cols() > 0) {
      const auto& u = of_d.matrixU();
      s.c = u.transpose() * s.c;
      s.d = u.transpose() * s.d;
    }
    const Eigen::MatrixXd c2 = s.c.bottomRows(rest);
    const Eigen::MatrixXd c1 = s.c.topRows(sigma), d1 = s.d.topRows(sigma);
    Eigen::JacobiSVD<Eigen::MatrixXd> of_c;
    if (s.a.rows() > 0) of_c.compute(c2, Eigen::ComputeFullV);
    const Eigen::Index rho = s.a.rows() == 0 ? 0 : rank_of(of_c, scale);
    if (rho == 0) {
      s.c = c1, s.d = d1;
      return;
    }
    // x = Q [x1; x2] with C2 x = 0 exactly when x2 = 0.
    const Eigen::Index n = s.a.rows(), keep = n - rho;
    Eigen::MatrixXd q(n, n);
    q << of_c.matrixV().rightCols(keep), of_c.matrixV().leftCols(rho);
    const Eigen::MatrixXd a = q.transpose() * s.a * q, b = q.transpose() * s.b, c = c1 * q;
    System smaller;
    smaller.a = a.topLeftCorner(keep, keep);
    smaller.b = b.topRows(keep);
    smaller.c.resize(sigma + rho, keep);
    smaller.c << c.leftCols(keep), a.bottomLeftCorner(rho, keep);
    smaller.d.resize(sigma + rho, s.d.cols());
    smaller.d << d1, b.bottomRows(rho);
    s = std::move(smaller);
  }
}

System dual(const System& s) { return {s.a.transpose(), s.c.transpose(), s.b.transpose(), s.d.transpose()}; }

std::vector<std::complex<double>> sorted(const Eigen::VectorXcd& values) {
  std::vector<std::complex<double>> list(values.data(), values.data() + values.size());
  std::sort(list.begin(), list.end(), [](const auto& x, const auto& y) {
    return x.real() != y.real() ? x.real() < y.real() : x.imag() < y.imag();
  });
  return list;
}

}  // namespace

DenseMatrix DenseMatrix::identity(std::size_t n) {
  DenseMatrix m(n, n);
  for (std::size_t i = 0; i < n; ++i) m(i, i) = 1;
  return m;
}

DenseMatrix DenseMatrix::block(std::size_t i, std::size_t j, std::size_t r, std::size_t c) const {
  DenseMatrix part(r, c);
  for (std::size_t row = 0; row < r; ++row) {
    for (std::size_t column = 0; column < c; ++column) part(row, column) = (*this)(i + row, j + column);
  }
  return part;
}

DenseMatrix product(const DenseMatrix& a, const DenseMatrix& b) {
  assert(a.columns == b.rows);
  return matrix_of(view(a) * view(b));
}
DenseMatrix sum(const DenseMatrix& a, const DenseMatrix& b) { return matrix_of(view(a) + view(b)); }
DenseMatrix transposed(const DenseMatrix& a) { return matrix_of(view(a).transpose()); }

DenseMatrix exponential(const DenseMatrix& a, double t) {
  if (a.rows == 0) return a;
  const Eigen::MatrixXd scaled = view(a) * t;
  return matrix_of(scaled.exp());
}

std::vector<std::complex<double>> eigenvalues(const DenseMatrix& a) {
  if (a.rows == 0) return {};
  const Eigen::MatrixXd dense = view(a);
  return sorted(Eigen::EigenSolver<Eigen::MatrixXd>(dense, false).eigenvalues());
}

std::vector<std::complex<double>> invariant_zeros(DenseMatrix a, DenseMatrix b, DenseMatrix c, DenseMatrix d) {
  System s{view(a), view(b), view(c), view(d)};
  const double scale = std::max({s.a.norm(), s.b.norm(), s.c.norm(), s.d.norm()});
  reduce_rows(s, scale);
  s = dual(s);
  reduce_rows(s, scale);
  s = dual(s);
  // D is square and invertible now, or empty: zeros are the poles of the inverse.
  if (s.a.rows() == 0) return {};
  if (s.d.rows() == 0 || s.d.cols() == 0 || s.d.rows() != s.d.cols())
    return s.d.size() == 0 && s.b.cols() == 0 && s.c.rows() == 0
               ? sorted(Eigen::EigenSolver<Eigen::MatrixXd>(s.a, false).eigenvalues())
               : std::vector<std::complex<double>>{};
  const Eigen::MatrixXd zeros = s.a - s.b * s.d.fullPivLu().solve(s.c);
  return sorted(Eigen::EigenSolver<Eigen::MatrixXd>(zeros, false).eigenvalues());
}

std::vector<std::complex<double>> transfer(const DenseMatrix& a, const DenseMatrix& b, const DenseMatrix& c,
                                           const DenseMatrix& d, std::complex<double> s) {
  Eigen::MatrixXcd g = view(d).cast<std::complex<double>>();
  if (a.rows > 0) {
    Eigen::MatrixXcd m = -view(a).cast<std::complex<double>>();
    m.diagonal().array() += s;
    g += view(c).cast<std::complex<double>>() * m.partialPivLu().solve(view(b).cast<std::complex<double>>());
  }
  std::vector<std::complex<double>> values;
  for (Eigen::Index i = 0; i < g.rows(); ++i) {
    for (Eigen::Index j = 0; j < g.cols(); ++j) {
      const bool finite = std::isfinite(g(i, j).real()) && std::isfinite(g(i, j).imag());
      values.push_back(finite ? g(i, j) : std::complex<double>(std::numeric_limits<double>::infinity(), 0));
    }
  }
  return values;
}

std::vector<double> least_squares(const DenseMatrix& a, const std::vector<double>& b) {
  if (a.columns == 0) return {};
  const Eigen::MatrixXd dense = view(a);
  Eigen::BDCSVD<Eigen::MatrixXd> svd(dense, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(relative_zero);
  return vector_of(svd.solve(view(b)));
}

DenseMatrix covariance_of(const DenseMatrix& a) {
  const Eigen::MatrixXd dense = view(a);
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(dense, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Column& s = svd.singularValues();
  const Eigen::MatrixXd& v = svd.matrixV();
  DenseMatrix covariance(a.columns, a.columns);
  const double largest = s.size() > 0 ? s[0] : 0;
  for (Eigen::Index k = 0; k < v.cols(); ++k) {
    const bool matters = k < s.size() && s[k] > relative_zero * largest;
    for (std::size_t i = 0; i < a.columns; ++i) {
      for (std::size_t j = 0; j < a.columns; ++j) {
        const double part = v(static_cast<Eigen::Index>(i), k) * v(static_cast<Eigen::Index>(j), k);
        if (matters) {
          covariance(i, j) += part / (s[k] * s[k]);
        } else if (std::fabs(part) > relative_zero) {
          covariance(i, j) = std::copysign(std::numeric_limits<double>::infinity(), part);
        }
      }
    }
  }
  return covariance;
}

WeakDirection weakest_direction(const DenseMatrix& a) {
  WeakDirection weak;
  if (a.columns == 0 || a.rows < a.columns) return weak;
  const Eigen::MatrixXd dense = view(a);
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(dense, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Column& s = svd.singularValues();
  const Eigen::Index last = svd.matrixV().cols() - 1;
  for (Eigen::Index i = 0; i < svd.matrixV().rows(); ++i) weak.direction.push_back(svd.matrixV()(i, last));
  weak.ratio = s[0] > 0 ? s[last] / s[0] : 0;
  return weak;
}

std::vector<double> damped_least_squares(const DenseMatrix& a, const std::vector<double>& damping,
                                         const std::vector<double>& b) {
  // As one QR decomposition of [a; diag(damping)], which does not square the condition number.
  const auto m = static_cast<Eigen::Index>(a.rows), n = static_cast<Eigen::Index>(a.columns);
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(m + n, n);
  both.topRows(m) = view(a);
  both.bottomRows(n).diagonal() = view(damping);
  Column right = Column::Zero(m + n);
  right.head(m) = view(b);
  return vector_of(both.colPivHouseholderQr().solve(right));
}

}  // namespace plantloop
