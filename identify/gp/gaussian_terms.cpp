// Term by term, and pair by pair of terms.

#include "identify/gp/gaussian_terms.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// E prod_i l_i of jointly normal l with these means and covariances; those in `left`, one bit each.
struct Product {
  std::array<double, 2 * most_factors> mean{};
  std::array<std::array<double, 2 * most_factors>, 2 * most_factors> covariance{};
  double expectation(unsigned left) const {
    if (left == 0) return 1;
    std::size_t first = 0;
    while ((left >> first & 1U) == 0) ++first;
    const unsigned rest = left & ~(1U << first);
    double sum = mean[first] * expectation(rest);
    for (std::size_t other = first + 1; other < mean.size(); ++other) {
      if ((rest >> other & 1U) != 0) sum += covariance[first][other] * expectation(rest & ~(1U << other));
    }
    return sum;
  }
};

// What a Gaussian with weights w makes of N(0, S).
struct Tilted {
  MatrixXd m;        // (I + S W)^-1 S
  MatrixXd inverse;  // (I + W S)^-1
  double factor = 1;
  Tilted(const VectorXd& w, const MatrixXd& s) {
    const MatrixXd unit = MatrixXd::Identity(s.rows(), s.cols());
    const Eigen::PartialPivLU<MatrixXd> lu(unit + s * w.asDiagonal());
    m = lu.solve(s);
    m = 0.5 * (m + m.transpose()).eval();
    inverse = unit - w.asDiagonal() * m;
    factor = 1 / std::sqrt(lu.determinant());
  }
};

// A term at all points: its pull W nu and, of each factor, value at mu and slope A z.
struct Part {
  MatrixXd pull;                // N x D
  VectorXd exponent;            // -1/2 nu' W nu
  std::vector<VectorXd> value;  // of each factor: N
  std::vector<MatrixXd> slope;  // of each factor: N x D
  Part(const GaussianTerm& term, const MatrixXd& z, const VectorXd& mu) {
    const MatrixXd nu = z.rowwise() - mu.transpose();
    pull = nu * term.w.asDiagonal();
    exponent = -0.5 * (pull.array() * nu.array()).rowwise().sum();
    for (const GaussianTerm::Affine& f : term.factors) {
      slope.emplace_back(z * f.a.asDiagonal());
      value.emplace_back(((slope.back() * mu).array() + f.b).matrix());
    }
  }
};

void add_single(const GaussianTerm& term, const Part& part, const MatrixXd& s, KernelMoments& result) {
  const Tilted tilted(term.w, s);
  const std::size_t n = term.factors.size();
  const unsigned all = (1U << n) - 1;
  for (Index i = 0; i < part.pull.rows(); ++i) {
    const VectorXd h = part.pull.row(i).transpose(), mh = tilted.m * h;
    const double base = term.c * tilted.factor * std::exp(part.exponent[i] + 0.5 * h.dot(mh));
    Product product;
    for (std::size_t f = 0; f < n; ++f) {
      product.mean[f] = part.value[f][i] + part.slope[f].row(i).dot(mh);
      for (std::size_t g = 0; g < n; ++g)
        product.covariance[f][g] = part.slope[f].row(i) * tilted.m * part.slope[g].row(i).transpose();
    }
    const double whole = product.expectation(all);
    result.q[i] += base * whole;
    VectorXd slope = whole * h;
    for (std::size_t f = 0; f < n; ++f)
      slope += product.expectation(all & ~(1U << f)) * part.slope[f].row(i).transpose();
    result.g.row(i) += base * (tilted.inverse * slope).transpose();
  }
}

// E k_i k_j of the terms a (of i) and b (of j).
MatrixXd pairs(const GaussianTerm& a, const Part& one, const GaussianTerm& b, const Part& two, const MatrixXd& s) {
  const Tilted tilted(a.w + b.w, s);
  const Index n = one.pull.rows();
  const MatrixXd one_m = one.pull * tilted.m, two_m = two.pull * tilted.m;
  const VectorXd own_one = one.exponent + 0.5 * (one_m.array() * one.pull.array()).rowwise().sum().matrix();
  const VectorXd own_two = two.exponent + 0.5 * (two_m.array() * two.pull.array()).rowwise().sum().matrix();
  MatrixXd result = one_m * two.pull.transpose();
  for (Index j = 0; j < n; ++j)
    result.col(j) = a.c * b.c * tilted.factor * (result.col(j).array() + own_one.array() + own_two[j]).exp();
  const std::size_t first = a.factors.size(), count = first + b.factors.size();
  if (count == 0) return result;
  const auto value = [&](std::size_t f, Index i, Index j) {
    return f < first ? one.value[f][i] : two.value[f - first][j];
  };
  const auto slope = [&](std::size_t f, Index i, Index j) {
    return f < first ? one.slope[f].row(i) : two.slope[f - first].row(j);
  };
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < n; ++i) {
      Product product;
      for (std::size_t f = 0; f < count; ++f) {
        product.mean[f] = value(f, i, j) + slope(f, i, j).dot(one_m.row(i) + two_m.row(j));
        for (std::size_t g = f + 1; g < count; ++g)
          product.covariance[f][g] = slope(f, i, j) * tilted.m * slope(g, i, j).transpose();
      }
      result(i, j) *= product.expectation((1U << count) - 1);
    }
  }
  return result;
}

// E k(x, x): of factors b + x'A x; of two of them with the covariance 2 tr(A S B S) + 4 mu'A S B mu.
double own(const GaussianTerm& term, const VectorXd& mu, const MatrixXd& s) {
  std::vector<double> mean;
  for (const GaussianTerm::Affine& f : term.factors)
    mean.push_back(f.b + f.a.dot(mu.cwiseAbs2() + VectorXd(s.diagonal())));
  if (mean.empty()) return term.c;
  if (mean.size() == 1) return term.c * mean[0];
  const MatrixXd as = term.factors[0].a.asDiagonal() * s, bs = term.factors[1].a.asDiagonal() * s;
  const VectorXd am = term.factors[0].a.cwiseProduct(mu), bm = term.factors[1].a.cwiseProduct(mu);
  return term.c * (mean[0] * mean[1] + 2 * (as * bs).trace() + 4 * am.dot(s * bm));
}

}  // namespace

bool moments_of(const std::vector<GaussianTerm>& terms, const MatrixXd& z, const VectorXd& mu, const MatrixXd& s,
                KernelMoments& result) {
  if (std::any_of(terms.begin(), terms.end(), [](const GaussianTerm& t) { return t.factors.size() > most_factors; }))
    return false;
  const Index n = z.rows();
  result = {VectorXd::Zero(n), MatrixXd::Zero(n, n), MatrixXd::Zero(n, z.cols()), 0};
  std::vector<Part> parts;
  for (const GaussianTerm& term : terms) {
    parts.emplace_back(term, z, mu);
    add_single(term, parts.back(), s, result);
    result.k += own(term, mu, s);
  }
  for (std::size_t a = 0; a < terms.size(); ++a) {
    result.C += pairs(terms[a], parts[a], terms[a], parts[a], s);
    for (std::size_t b = 0; b < a; ++b) {
      const MatrixXd mixed = pairs(terms[a], parts[a], terms[b], parts[b], s);
      result.C += mixed + mixed.transpose();
    }
  }
  // Where S is small this difference keeps the digits of the products, not its own.
  result.C -= result.q * result.q.transpose();
  return true;
}

}  // namespace plantloop::identify
