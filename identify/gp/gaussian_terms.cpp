// Term by term, and pair by pair of terms.

#include "identify/gp/gaussian_terms.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "identify/gp/pivoted_root.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// E prod_i l_i of jointly normal l with these means and covariances; those in `left`, one bit each.
template <typename Number>
struct Product {
  std::size_t count;
  Number one;
  // Not set to zero: this is made for each pair of points.
  std::array<Number, 2 * most_factors> mean;
  std::array<std::array<Number, 2 * most_factors>, 2 * most_factors> covariance;  // [f][g] for f < g
  Product(std::size_t factors, Number unit) : count(factors), one(unit) {}        // NOLINT
  Number expectation(unsigned left) const {
    if (left == 0) return one;
    std::size_t first = 0;
    while ((left >> first & 1U) == 0) ++first;
    const unsigned rest = left & ~(1U << first);
    Number sum = mean[first] * expectation(rest);
    for (std::size_t other = first + 1; other < count; ++other) {
      if ((rest >> other & 1U) != 0) sum = sum + covariance[first][other] * expectation(rest & ~(1U << other));
    }
    return sum;
  }
};

// A number and what another one exceeds it by: sums and products without loss where that is small.
struct Changed {
  double was, change;
  friend Changed operator+(Changed a, Changed b) { return {a.was + b.was, a.change + b.change}; }
  friend Changed operator*(Changed a, Changed b) {
    return {a.was * b.was, a.was * b.change + a.change * b.was + a.change * b.change};
  }
};

MatrixXd cholesky(const MatrixXd& a) { return a.llt().matrixL(); }
// L^-1 a, and a L'^-1, for the factor L.
MatrixXd under(const MatrixXd& l, const MatrixXd& a) { return l.triangularView<Eigen::Lower>().solve(a); }
MatrixXd over(const MatrixXd& a, const MatrixXd& l) { return under(l, a.transpose()).transpose(); }
MatrixXd one_plus(MatrixXd a) {
  a.diagonal().array() += 1;
  return a;
}
double log_determinant(const MatrixXd& factor) { return 2 * factor.diagonal().array().log().sum(); }

// Of two columns; they are short.
double dot(const MatrixXd& a, Index i, const MatrixXd& b, Index j) {
  const double *x = a.data() + i * a.rows(), *y = b.data() + j * a.rows();
  double sum = 0;
  for (Index d = 0; d < a.rows(); ++d) sum += x[d] * y[d];
  return sum;
}

// S = G G'. Of a covariance that is singular up to rounding the rounding is left out.
MatrixXd root_of(const MatrixXd& s) {
  bool finished = true;
  return pivoted_root(
      MatrixXd(s.rows(), 0), s.diagonal().cwiseMax(0.0), 1e-15 * s.diagonal().cwiseAbs(), s.rows(),
      [&](Index j) { return s.col(j); }, finished);
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
  m.n = r.asDiagonal() * (z.colwise() - x.mean);
  const MatrixXd factor = cholesky(one_plus(r.asDiagonal() * s * r.asDiagonal()));
  const MatrixXd half = under(factor, m.n);
  const double constant = std::log(term.c) - 0.5 * log_determinant(factor);
  m.base = (constant - 0.5 * half.colwise().squaredNorm().transpose().array()).exp();
  m.less = over(s * r.asDiagonal(), factor);
  m.shift = m.less * half;
  m.root = over(sum.root, cholesky(one_plus(sum.root.transpose() * term.w.asDiagonal() * sum.root)));
  // (I + W S)^-1 (W nu E prod + sum_f slope_f E prod of the others)
  m.pull = r.asDiagonal() * factor.transpose().triangularView<Eigen::Upper>().solve(half);
  const MatrixXd scaled = under(factor, r.asDiagonal().toDenseMatrix());
  m.bend = scaled.transpose() * scaled;
  MatrixXd g = m.pull;

  const std::size_t count = term.factors.size();
  std::vector<MatrixXd> spread;
  for (const GaussianTerm::Affine& f : term.factors) {
    m.slope.emplace_back(f.a.asDiagonal() * z);
    const MatrixXd& slope = m.slope.back();
    m.value.emplace_back((slope.transpose() * x.mean).array() + f.b);
    m.mean.emplace_back(m.value.back() + slope.cwiseProduct(m.shift).colwise().sum().transpose());
    spread.emplace_back(m.root.transpose() * slope);
  }
  if (count == 0) {
    sum.q += m.base;
    sum.g += m.base.asDiagonal() * g.transpose();
    return m;
  }
  MatrixXd slopes = MatrixXd::Zero(z.rows(), z.cols());
  for (Index i = 0; i < z.cols(); ++i) {
    Product<double> product(count, 1);
    for (std::size_t f = 0; f < count; ++f) product.mean[f] = m.mean[f][i];
    if (count == 2) product.covariance[0][1] = spread[0].col(i).dot(spread[1].col(i));
    const unsigned all = (1U << count) - 1;
    const double whole = product.expectation(all);
    sum.q[i] += m.base[i] * whole;
    g.col(i) *= whole;
    for (std::size_t f = 0; f < count; ++f) slopes.col(i) += product.expectation(all & ~(1U << f)) * m.slope[f].col(i);
  }
  g += one_plus(term.w.asDiagonal() * s).partialPivLu().solve(slopes);
  sum.g += m.base.asDiagonal() * g.transpose();
  return m;
}

}  // namespace

KernelMoments::KernelMoments(const std::vector<GaussianTerm>& terms_, const MatrixXd& points, const UncertainPoint& x)
    : q(VectorXd::Zero(points.rows())),
      g(MatrixXd::Zero(points.rows(), points.cols())),
      terms(terms_),
      z(points.transpose()),
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
      const VectorXd own_r = term.w.cwiseSqrt();
      const MatrixXd to_other = both.transpose() * other.asDiagonal();
      result.u = both.transpose() * own_r.asDiagonal() * m.n;
      result.v = to_other * m.shift;
      result.own = -result.u.cwiseProduct(result.v).colwise().sum().transpose();
      result.centre = under(factor, own_r.cwiseProduct(inverse).asDiagonal() * m.n);
      result.z = apart.asDiagonal() * z;
      result.base = m.base;
      result.mean = m.mean;
      for (const MatrixXd& slope : m.slope) result.slope.emplace_back(both.transpose() * slope);
      if (m.slope.size() == 2) {
        const MatrixXd f = m.root.transpose() * m.slope[0], g = m.root.transpose() * m.slope[1];
        const MatrixXd less = (to_other * m.root).transpose() * result.slope[0];
        result.within = f.cwiseProduct(g).colwise().sum().transpose();
        result.within_change = -less.cwiseProduct(g).colwise().sum().transpose();
      }
      return result;
    };
    first_ = side(a, one, b.w, z_a);
    second_ = side(b, two, a.w, z_b);
  }

  double covariance(Index i, Index j) const {
    const Side &a = first_, &b = second_;
    const double cross = dot(a.u, i, b.u, j), own = 0.5 * (a.own[i] + b.own[j]);
    const double apart = a.base[i] * b.base[j];
    const Changed product = factors(i, j);
    const double whole = product.was + product.change;
    if (constant_ - own + std::fabs(cross) < 1)
      return apart * (std::expm1(constant_ + own + cross) * whole + product.change);
    double exponent = 0;
    for (Index d = 0; d < a.z.rows(); ++d) {
      const double between = a.z(d, i) - b.z(d, j), centre = a.centre(d, i) + b.centre(d, j);
      exponent += between * between + centre * centre;
    }
    return std::exp(log_factor_ - 0.5 * exponent) * whole - apart * product.was;
  }

 private:
  // What belongs to the points of one term, one column for each.
  struct Side {
    MatrixXd u, v;                   // M = both both': both'h, and both'W t with the other's W
    MatrixXd centre, z;              // of the exponents of E k_i k_j
    VectorXd own, base;              // -h'M W t; of the term alone
    std::vector<VectorXd> mean;      // of each factor, by the term alone
    std::vector<MatrixXd> slope;     // of each factor, both'slope
    VectorXd within, within_change;  // covariance of the term's two factors
  };

  // 1/2 log(|I + S W_a| |I + S W_b|/|I + S W_a + S W_b|) = 1/2 log(|I + R_b S R_b|/|I + R_b M_a R_b|).
  static double excess(const TermMoments& one, const VectorXd& b) {
    const VectorXd r = b.cwiseSqrt();
    const MatrixXd left = r.asDiagonal() * one.root;
    const MatrixXd more = under(cholesky(one_plus(left * left.transpose())), r.asDiagonal() * one.less);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(more * more.transpose(), Eigen::EigenvaluesOnly);
    return 0.5 * axes.eigenvalues().array().max(0.0).log1p().sum();
  }

  // The product of all factors: by the terms apart, and what it exceeds that by.
  Changed factors(Index i, Index j) const {
    const Side &a = first_, &b = second_;
    const std::size_t first = a.mean.size(), count = first + b.mean.size();
    const auto mean_a = [&](std::size_t f) {
      return Changed{a.mean[f][i], dot(a.slope[f], i, b.u, j) - dot(a.slope[f], i, a.v, i)};
    };
    const auto mean_b = [&](std::size_t f) {
      return Changed{b.mean[f][j], dot(b.slope[f], j, a.u, i) - dot(b.slope[f], j, b.v, j)};
    };
    // Most are these.
    if (count == 0) return {1, 0};
    if (count == 1) return first == 1 ? mean_a(0) : mean_b(0);
    if (first == 1 && count == 2) return mean_a(0) * mean_b(0) + Changed{0, dot(a.slope[0], i, b.slope[0], j)};
    Product<Changed> product(count, {1, 0});
    for (std::size_t f = 0; f < first; ++f) product.mean[f] = mean_a(f);
    for (std::size_t f = first; f < count; ++f) {
      product.mean[f] = mean_b(f - first);
      for (std::size_t g = 0; g < first; ++g) product.covariance[g][f] = {0, dot(a.slope[g], i, b.slope[f - first], j)};
    }
    if (first == 2) product.covariance[0][1] = {a.within[i], a.within_change[i]};
    if (count - first == 2) product.covariance[first][first + 1] = {b.within[j], b.within_change[j]};
    return product.expectation((1U << count) - 1);
  }

  double constant_ = 0, log_factor_ = 0;
  Side first_, second_;
};

KernelPairs::KernelPairs(const KernelMoments& a, const KernelMoments& b) : points_(a.z.cols()) {
  for (std::size_t i = 0; i < a.terms.size(); ++i) {
    for (std::size_t j = 0; j < b.terms.size(); ++j)
      pairs_.emplace_back(a.terms[i], a.parts[i], a.z, b.terms[j], b.parts[j], b.z, a.root);
  }
}
KernelPairs::~KernelPairs() = default;
KernelPairs::KernelPairs(KernelPairs&&) noexcept = default;

VectorXd KernelPairs::column(Index j, Index from) const {
  VectorXd sum = VectorXd::Zero(points_ - from);
  for (const TermPair& pair : pairs_) {
    for (Index i = from; i < points_; ++i) sum[i - from] += pair.covariance(i, j);
  }
  return sum;
}

VectorXd KernelPairs::diagonal() const {
  VectorXd sum = VectorXd::Zero(points_);
  for (const TermPair& pair : pairs_) {
    for (Index i = 0; i < points_; ++i) sum[i] += pair.covariance(i, i);
  }
  return sum;
}

}  // namespace plantloop::identify
