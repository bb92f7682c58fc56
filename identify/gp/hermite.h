// Covariances as series in Hermite's polynomials of the uncertain input.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "identify/gp/gaussian_terms.h"

namespace plantloop::identify {

// Exponents k of monomials of r variables, degree by degree from 0 to degrees() + most_factors, and where those with
// one more and one less of a variable are; -1: nowhere.
class MultiIndices {
 public:
  // As many degrees, one at least, as have `most` indices from degree 1 on.
  MultiIndices(int variables, Eigen::Index most);
  int variables() const { return static_cast<int>(power_.rows()); }
  int degrees() const { return degrees_; }
  Eigen::Index begin(int degree) const { return begin_[static_cast<std::size_t>(degree)]; }
  Eigen::Index end(int degree) const { return begin_[static_cast<std::size_t>(degree) + 1]; }
  double power(Eigen::Index index, int variable) const { return power_(variable, index); }
  Eigen::Index up(Eigen::Index index, int variable) const { return up_(variable, index); }
  Eigen::Index down(Eigen::Index index, int variable) const { return down_(variable, index); }

 private:
  int degrees_ = 0;
  std::vector<Eigen::Index> begin_;
  Eigen::MatrixXi power_, up_, down_;  // variables x indices
};

// With x = mu + root xi, xi ~ N(0, I), and the orthonormal polynomials h_k of Hermite,
//   k(x, z_i) = sum_k c_ki h_k(xi),  c_ki = E k(x, z_i) h_k(xi),
// so cov(k_i, k_j) is the sum of c_ki c_kj over all k but 0: a root of it, whose columns are small where the covariance
// hardly bends over the spread of x, and keep their digits there. With the shift t of the mean of xi the means of a
// Gaussian are base exp(p't - 1/2 t'Q t), p = root'R (I + R S R)^-1 n, Q = root'R (I + R S R)^-1 R root, so
//   sqrt(k_d + 1) c_(k + e_d) = p_d c_k - sum_e Q_de sqrt(k_e) c_(k - e_e),
// and an affine factor a + s'xi makes of c_k: a c_k + sum_d s_d (sqrt(k_d + 1) c_(k + e_d) + sqrt(k_d) c_(k - e_d)).
class HermiteSeries {
 public:
  // The indices are of as many variables as moments.root has columns.
  HermiteSeries(const KernelMoments& moments, const MultiIndices& indices);
  // The coefficients of a degree, N x indices of it; degrees in order, from 1.
  Eigen::MatrixXd next();

 private:
  struct Term {
    Eigen::MatrixXd p, Q;                // N x r, r x r
    std::vector<Eigen::MatrixXd> level;  // after each factor: N x indices
    std::vector<int> done;               // degrees of each that are known, from 0
  };
  void advance(Term& term, const TermMoments& part, std::size_t level, int degree) const;

  const KernelMoments& moments_;
  const MultiIndices& indices_;
  std::vector<Term> terms_;
  int degree_ = 0;
};

}  // namespace plantloop::identify
