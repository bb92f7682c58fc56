// Polynomials in the delay operator.

#include "identify/linear/filter.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>

namespace plantloop::identify {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd filter(const VectorXd& B, const VectorXd& A, const VectorXd& x) {
  assert(A.size() > 0 && A[0] != 0);
  VectorXd y(x.size());
  for (Index k = 0; k < x.size(); ++k) {
    double sum = 0;
    for (Index i = 0; i < std::min(B.size(), k + 1); ++i) sum += B[i] * x[k - i];
    for (Index i = 1; i < std::min(A.size(), k + 1); ++i) sum -= A[i] * y[k - i];
    y[k] = sum / A[0];
  }
  return y;
}

VectorXd delayed(const VectorXd& x, Index samples) {
  VectorXd y = VectorXd::Zero(x.size());
  if (samples < x.size()) y.tail(x.size() - samples) = x.head(x.size() - samples);
  return y;
}

VectorXd multiply(const VectorXd& P, const VectorXd& Q) {
  if (P.size() == 0 || Q.size() == 0) return {};
  VectorXd R = VectorXd::Zero(P.size() + Q.size() - 1);
  for (Index i = 0; i < P.size(); ++i) R.segment(i, Q.size()) += P[i] * Q;
  return R;
}

VectorXd impulse_response(const VectorXd& B, const VectorXd& A, Index count) {
  return filter(B, A, VectorXd::Unit(count, 0));
}

Eigen::VectorXcd roots(const VectorXd& P) {
  const Index n = P.size() - 1;
  if (n < 1) return {};
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  companion.row(0) = -P.tail(n).transpose() / P[0];
  companion.diagonal(-1).setOnes();
  Eigen::VectorXcd values = Eigen::EigenSolver<Eigen::MatrixXd>(companion, false).eigenvalues();
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) {
    return a.real() != b.real() ? a.real() < b.real() : a.imag() < b.imag();
  });
  return values;
}

bool is_stable(const VectorXd& P, double radius) {
  if (!P.allFinite()) return false;
  const Eigen::VectorXcd z = roots(P);
  return z.size() == 0 || z.cwiseAbs().maxCoeff() < radius;
}

namespace {

// A monic polynomial with the roots outside of the unit circle moved.
template <typename Move>
VectorXd with_moved_roots(const VectorXd& P, Move move) {
  if (!P.allFinite() || is_stable(P)) return P;
  Eigen::VectorXcd product = Eigen::VectorXcd::Zero(P.size());
  product[0] = 1;
  Index degree = 0;
  for (std::complex<double> z : roots(P)) {
    if (std::abs(z) > 1) z = move(z);
    ++degree;
    for (Index i = degree; i > 0; --i) product[i] -= z * product[i - 1];
  }
  return product.real();
}

}  // namespace

VectorXd reflected(const VectorXd& P) {
  return with_moved_roots(P, [](std::complex<double> z) { return 1.0 / std::conj(z); });
}

// Just inside, so that it counts as stable.
VectorXd clamped(const VectorXd& P) {
  return with_moved_roots(P, [](std::complex<double> z) { return z / std::abs(z) * (1 - 1e-9); });
}

}  // namespace plantloop::identify
