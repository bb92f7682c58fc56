// Term by term, and pair by pair of terms.

#include "identify/gp/gaussian_terms.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/gp/pivoted_root.h"

namespace plantloop::identify {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// E prod_i l_i of jointly normal l with these means and covariances; those in `left`, one bit each.
template <typename Number>
struct Product {
  std::vector<Number> mean;
  std::vector<std::vector<Number>> covariance;  // [f][g] for f < g
  Number one;
  Number expectation(unsigned left) const {
    if (left == 0) return one;
    std::size_t first = 0;
    while ((left >> first & 1U) == 0) ++first;
    const unsigned rest = left & ~(1U << first);
    Number sum = mean[first] * expectation(rest);
    for (std::size_t other = first + 1; other < mean.size(); ++other) {
      if ((rest >> other & 1U) != 0) sum = sum + covariance[first][other] * expectation(rest & ~(1U << other));
    }
    return sum;
  }
};

// A number and what another one exceeds it by: sums and products without loss where that is small.
struct Changed {
  ArrayXd was, change;
  friend Changed operator+(const Changed& a, const Changed& b) { return {a.was + b.was, a.change + b.change}; }
  friend Changed operator*(const Changed& a, const Changed& b) {
    return {a.was * b.was, a.was * b.change + a.change * b.was + a.change * b.change};
  }
};

// Of each row of a with the row of b beside it, or with the only one.
ArrayXd products(const MatrixXd& a, const MatrixXd& b) {
  if (b.rows() == 1) return (a * b.transpose()).array();
  return (a.array() * b.array()).rowwise().sum();
}
// One number for each of n rows, where it is one for all of them.
ArrayXd along(const ArrayXd& x, Index n) { return x.size() == n ? x : ArrayXd::Constant(n, x[0]); }

MatrixXd cholesky(const MatrixXd& a) { return a.llt().matrixL(); }
// a L'^-1 for the factor L.
MatrixXd over(const MatrixXd& a, const MatrixXd& l) {
  return l.triangularView<Eigen::Lower>().solve(a.transpose()).transpose();
}
MatrixXd one_plus(MatrixXd a) {
  a.diagonal().array() += 1;
  return a;
}
// a L^-1.
MatrixXd over_transposed(const MatrixXd& a, const MatrixXd& l) {
  return l.transpose().triangularView<Eigen::Upper>().solve(a.transpose()).transpose();
}
double log_determinant(const MatrixXd& factor) { return 2 * factor.diagonal().array().log().sum(); }

// S = G G'. Of a covariance that is singular up to rounding the rounding is left out.
MatrixXd root_of(const MatrixXd& s) {
  bool finished = true;
  return pivoted_root(
      s.diagonal().cwiseMax(0.0), 1e-15 * s.diagonal().cwiseAbs(), s.rows(), [&](Index j) { return s.col(j); },
      finished);
}

// E k(x, x): of factors b + x'A x; of two of them with the covariance 2 tr(A S B S) + 4 mu'A S B mu.
double own(const GaussianTerm& term, const UncertainPoint& x) {
  const MatrixXd& s = x.covariance;
  std::vector<double> mean;
  for (const GaussianTerm::Affine& f : term.factors)
    mean.push_back(f.b + f.a.dot(x.mean.cwiseAbs2() + VectorXd(s.diagonal())));
  if (mean.empty()) return term.c;
  if (mean.size() == 1) return term.c * mean[0];
  const MatrixXd as = term.factors[0].a.asDiagonal() * s, bs = term.factors[1].a.asDiagonal() * s;
  const VectorXd am = term.factors[0].a.cwiseProduct(x.mean), bm = term.factors[1].a.cwiseProduct(x.mean);
  return term.c * (mean[0] * mean[1] + 2 * (as * bs).trace() + 4 * am.dot(s * bm));
}

// Adds the term's share of q and g.
TermMoments moments_of(const GaussianTerm& term, const UncertainPoint& x, KernelMoments& sum) {
  const MatrixXd &s = x.covariance, &z = sum.z;
  const VectorXd r = term.w.cwiseSqrt();
  TermMoments m;
  m.n = (z.rowwise() - x.mean.transpose()) * r.asDiagonal();
  const MatrixXd factor = cholesky(one_plus(r.asDiagonal() * s * r.asDiagonal()));
  const MatrixXd half = over(m.n, factor);
  m.log_base = std::log(term.c) - 0.5 * log_determinant(factor) - 0.5 * half.rowwise().squaredNorm().array();
  m.base = m.log_base.exp();
  m.less = over(s * r.asDiagonal(), factor);
  m.shift = half * m.less.transpose();
  m.root = over(sum.root, cholesky(one_plus(sum.root.transpose() * term.w.asDiagonal() * sum.root)));

  const std::size_t count = term.factors.size();
  Product<ArrayXd> product{{}, std::vector(count, std::vector<ArrayXd>(count)), ArrayXd::Ones(z.rows())};
  for (const GaussianTerm::Affine& f : term.factors) {
    m.slope.emplace_back(z * f.a.asDiagonal());
    product.mean.emplace_back((m.slope.back() * x.mean).array() + f.b + products(m.slope.back(), m.shift));
  }
  for (std::size_t f = 0; f < count; ++f) {
    for (std::size_t g = f + 1; g < count; ++g)
      product.covariance[f][g] = products(m.slope[f] * m.root, m.slope[g] * m.root);
  }
  const unsigned all = (1U << count) - 1;
  m.mean = product.mean;
  m.product = product.expectation(all);
  sum.q.array() += m.base * m.product;

  // (I + W S)^-1 (W nu E prod + sum_f slope_f E prod of the others)
  MatrixXd g = m.product.matrix().asDiagonal() * MatrixXd(over_transposed(half, factor) * r.asDiagonal());
  if (count > 0) {
    MatrixXd slopes = MatrixXd::Zero(z.rows(), z.cols());
    for (std::size_t f = 0; f < count; ++f)
      slopes += product.expectation(all & ~(1U << f)).matrix().asDiagonal() * m.slope[f];
    g += one_plus(term.w.asDiagonal() * s).partialPivLu().solve(slopes.transpose()).transpose();
  }
  sum.g += m.base.matrix().asDiagonal() * g;
  return m;
}

}  // namespace

KernelMoments::KernelMoments(const std::vector<GaussianTerm>& terms_, const MatrixXd& z_, const UncertainPoint& x)
    : q(VectorXd::Zero(z_.rows())),
      g(MatrixXd::Zero(z_.rows(), z_.cols())),
      terms(terms_),
      z(z_),
      root(root_of(x.covariance)) {
  for (const GaussianTerm& term : terms) {
    parts.push_back(moments_of(term, x, *this));
    k += own(term, x);
  }
}

// With h = W nu of each term, M of the weights of both, and one Gaussian's shift t:
//   log(E k_i k_j/(q_i q_j)) = 1/2 log(|I + S W_a| |I + S W_b|/|I + S W_a + S W_b|)
//                              - 1/2 h_i'M W_b t_i - 1/2 h_j'M W_a t_j + h_i'M h_j,
// and a factor's mean changes by its slope times M (h_j - W_b t_i), its covariances by -M W_b M_a, and by M with
// factors of the other term. All of it is of the order of S. Where it is not small, the difference is taken of
//   E k_i k_j = c |I + R S R|^-1/2 exp(-1/2 (z_i - z_j)' W_a W_b/(W_a + W_b) (z_i - z_j) - 1/2 n'(I + R S R)^-1 n),
//   R^2 = W_a + W_b,  R n = h_i + h_j,
// whose exponents all have one sign.
class TermPair {
 public:
  TermPair(const GaussianTerm& a, const TermMoments& one, const MatrixXd& z_a, const GaussianTerm& b,
           const TermMoments& two, const MatrixXd& z_b, const MatrixXd& root) {
    const VectorXd w = a.w + b.w, r = w.cwiseSqrt();
    const MatrixXd both = over(root, cholesky(one_plus(root.transpose() * w.asDiagonal() * root)));  // M = both both'
    const MatrixXd factor = cholesky(one_plus(r.asDiagonal() * root * root.transpose() * r.asDiagonal()));
    constant_ = excess(one, b.w);
    log_factor_ = std::log(a.c) + std::log(b.c) - 0.5 * log_determinant(factor);
    const VectorXd apart = (a.w.array() * b.w.array() / (w.array() > 0).select(w.array(), 1.0)).sqrt();
    const VectorXd inverse = (r.array() > 0).select(r.array().inverse(), 0.0);
    const auto side = [&](const GaussianTerm& term, const TermMoments& m, const VectorXd& other, const MatrixXd& z) {
      Side result;
      const VectorXd rt = term.w.cwiseSqrt();
      result.u = m.n * rt.asDiagonal() * both;
      result.v = m.shift * other.asDiagonal() * both;
      result.own = -products(result.u, result.v);
      result.centre = over(m.n * rt.cwiseProduct(inverse).asDiagonal(), factor);
      result.z = z * apart.asDiagonal();
      result.base = m.base;
      result.product = m.product;
      result.mean = m.mean;
      for (const MatrixXd& slope : m.slope) result.slope.emplace_back(slope * both);
      if (m.slope.size() == 2) {
        const MatrixXd f = m.slope[0] * m.root, g = m.slope[1] * m.root;
        result.within = {products(f, g),
                         -products(result.slope[0] * (both.transpose() * other.asDiagonal() * m.root), g)};
      }
      return result;
    };
    first_ = side(a, one, b.w, z_a);
    second_ = side(b, two, a.w, z_b);
  }

  ArrayXd column(Index j) const { return covariances(first_, second_.row(j)); }
  ArrayXd diagonal() const { return covariances(first_, second_); }

 private:
  // What belongs to the points of one term; rows, all of them or one.
  struct Side {
    MatrixXd u, v;                // M = both both': h both, t W both with the other's W
    MatrixXd centre, z;           // of the exponents of E k_i k_j
    ArrayXd own, base, product;   // -h'M W t; of the term alone
    std::vector<ArrayXd> mean;    // of each factor, by the term alone
    std::vector<MatrixXd> slope;  // of each factor, times both
    Changed within;               // covariance of the term's two factors
    Side row(Index j) const {
      Side one{
          u.row(j), v.row(j), centre.row(j), z.row(j), own.segment(j, 1), base.segment(j, 1), product.segment(j, 1), {},
          {},       {}};
      for (const ArrayXd& each : mean) one.mean.emplace_back(each.segment(j, 1));
      for (const MatrixXd& each : slope) one.slope.emplace_back(each.row(j));
      if (within.was.size() > 0) one.within = {within.was.segment(j, 1), within.change.segment(j, 1)};
      return one;
    }
  };

  // 1/2 log(|I + S W_a| |I + S W_b|/|I + S W_a + S W_b|) = 1/2 log(|I + R_b S R_b|/|I + R_b M_a R_b|).
  static double excess(const TermMoments& one, const VectorXd& b) {
    const VectorXd r = b.cwiseSqrt();
    const MatrixXd left = r.asDiagonal() * one.root;
    const MatrixXd factor = cholesky(one_plus(left * left.transpose()));
    const MatrixXd more = factor.triangularView<Eigen::Lower>().solve(MatrixXd(r.asDiagonal() * one.less));
    const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(more * more.transpose(), Eigen::EigenvaluesOnly);
    return 0.5 * axes.eigenvalues().array().max(0.0).log1p().sum();
  }

  // The product of all factors: by the terms apart, and what it exceeds that by.
  Changed factors(const Side& a, const Side& b) const {
    const Index n = a.u.rows();
    const std::size_t first = a.mean.size(), count = first + b.mean.size();
    Product<Changed> product{{}, std::vector(count, std::vector<Changed>(count)), {ArrayXd::Ones(n), ArrayXd::Zero(n)}};
    for (std::size_t f = 0; f < first; ++f)
      product.mean.push_back({a.mean[f], products(a.slope[f], b.u) - products(a.slope[f], a.v)});
    for (std::size_t f = 0; f < b.mean.size(); ++f) {
      const ArrayXd its = products(b.slope[f], b.v);
      product.mean.push_back({along(b.mean[f], n), products(a.u, b.slope[f]) - along(its, n)});
    }
    if (first == 2) product.covariance[0][1] = a.within;
    if (b.mean.size() == 2) product.covariance[first][first + 1] = {along(b.within.was, n), along(b.within.change, n)};
    for (std::size_t f = 0; f < first; ++f) {
      for (std::size_t g = first; g < count; ++g)
        product.covariance[f][g] = {ArrayXd::Zero(n), products(a.slope[f], b.slope[g - first])};
    }
    return product.expectation((1U << count) - 1);
  }

  // b has as many rows as a, or one.
  ArrayXd covariances(const Side& a, const Side& b) const {
    const Index n = a.u.rows();
    const ArrayXd cross = products(a.u, b.u), own = a.own + along(b.own, n);
    const ArrayXd log_ratio = constant_ + 0.5 * own + cross, size = constant_ - 0.5 * own + cross.abs();
    const ArrayXd apart = a.base * along(b.base, n);
    const bool plain = a.mean.empty() && b.mean.empty();
    const Changed product = plain ? Changed{ArrayXd::Ones(n), ArrayXd::Zero(n)} : factors(a, b);
    const Index step = b.u.rows() == 1 ? 0 : 1;
    ArrayXd result(n);
    for (Index i = 0; i < n; ++i) {
      if (size[i] < 1) {
        result[i] = apart[i] * (std::expm1(log_ratio[i]) * (product.was[i] + product.change[i]) + product.change[i]);
      } else {
        const double exponent =
            (a.z.row(i) - b.z.row(step * i)).squaredNorm() + (a.centre.row(i) + b.centre.row(step * i)).squaredNorm();
        result[i] =
            std::exp(log_factor_ - 0.5 * exponent) * (product.was[i] + product.change[i]) - apart[i] * product.was[i];
      }
    }
    return result;
  }

  double constant_ = 0, log_factor_ = 0;
  Side first_, second_;
};

KernelPairs::KernelPairs(const KernelMoments& a, const KernelMoments& b) {
  for (std::size_t i = 0; i < a.terms.size(); ++i) {
    for (std::size_t j = 0; j < b.terms.size(); ++j)
      pairs_.emplace_back(a.terms[i], a.parts[i], a.z, b.terms[j], b.parts[j], b.z, a.root);
  }
}
KernelPairs::~KernelPairs() = default;
KernelPairs::KernelPairs(KernelPairs&&) noexcept = default;

VectorXd KernelPairs::column(Index j) const {
  ArrayXd sum = pairs_.front().column(j);
  for (std::size_t p = 1; p < pairs_.size(); ++p) sum += pairs_[p].column(j);
  return sum;
}

VectorXd KernelPairs::diagonal() const {
  ArrayXd sum = pairs_.front().diagonal();
  for (std::size_t p = 1; p < pairs_.size(); ++p) sum += pairs_[p].diagonal();
  return sum;
}

}  // namespace plantloop::identify
