// Covariances that are sums of Gaussians times affine factors: their moments over x ~ N(mu, S) in closed form.

#pragma once

#include <Eigen/Core>
#include <vector>

namespace plantloop::identify {

// c exp(-1/2 sum_d w_d (x_d - z_d)^2) prod_f (b_f + sum_d a_fd x_d z_d). Products of such terms are such terms: weights
// add, factors stand beside each other.
struct GaussianTerm {
  struct Affine {
    Eigen::VectorXd a;
    double b = 0;
  };
  double c = 1;
  Eigen::VectorXd w;
  std::vector<Affine> factors;
};

// A term may have so many factors.
inline constexpr std::size_t most_factors = 2;

struct UncertainPoint {
  Eigen::VectorXd mean;        // D
  Eigen::MatrixXd covariance;  // D x D; rows and columns of zeros for inputs that are known exactly
};

// A term at all points, seen from x ~ N(mu, S); W = diag(w), R = W^1/2, nu = z - mu, n = R nu. A Gaussian times N(0, S)
// is
//   c |I + R S R|^-1/2 exp(-1/2 n'(I + R S R)^-1 n)  times  N(S R (I + R S R)^-1 n, M),   M = (I + S W)^-1 S,
// so what is left is the mean of a product of affine functions of normal variables (L. Isserlis 1918). There is no
// inverse of S, and no difference of large numbers where lengths are small beside S.
struct TermMoments {
  Eigen::MatrixXd n;                   // D x N
  Eigen::MatrixXd shift;               // D x N: the mean of the normal density, from mu
  Eigen::VectorXd base;                // N: the number before it
  Eigen::MatrixXd pull;                // D x N: R (I + R S R)^-1 n
  Eigen::MatrixXd bend;                // D x D: R (I + R S R)^-1 R
  std::vector<Eigen::VectorXd> value;  // of each factor at mu: N
  std::vector<Eigen::VectorXd> mean;   // of each factor: N
  std::vector<Eigen::MatrixXd> slope;  // of each factor: D x N
  Eigen::MatrixXd root;                // D x rank of S: M = root root'
  Eigen::MatrixXd less;                // D x D: S - M = less less'
};

// Expectations over x of a sum of terms with the points z.
struct KernelMoments {
  // points: N x D.
  KernelMoments(const std::vector<GaussianTerm>& terms, const Eigen::MatrixXd& points, const UncertainPoint& x);

  Eigen::VectorXd q;  // E k(x, z_i)
  Eigen::MatrixXd g;  // E dk(x, z_i)/dx, one row for each i: N x D; cov(x, k(x, z_i)) is S g_i
  double k = 0;       // E k(x, x)

  std::vector<GaussianTerm> terms;
  std::vector<TermMoments> parts;
  Eigen::MatrixXd z;     // D x N
  Eigen::MatrixXd root;  // S = root root'
};

// A pair of terms, one of each covariance.
class TermPair;

// cov(k_a(x, z_i), k_b(x, z_j)) over the same x, of two covariances, each with its points: what E k_a k_b exceeds
// q_a q_b by. It is made from log(E k_a k_b/(q_a q_b)), which is of the order of S, and so keeps its digits however
// small S is.
class KernelPairs {
 public:
  KernelPairs(const KernelMoments& a, const KernelMoments& b);
  ~KernelPairs();
  KernelPairs(KernelPairs&&) noexcept;
  // For the points of a from number `from` on, and the j-th of b.
  Eigen::VectorXd column(Eigen::Index j, Eigen::Index from = 0) const;
  Eigen::VectorXd diagonal() const;  // for the i-th of both, which have as many

 private:
  std::vector<TermPair> pairs_;
  Eigen::Index points_;  // of a
};

}  // namespace plantloop::identify
