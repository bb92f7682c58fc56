// Dense matrices of the analyses, and the linear algebra that they need.

#pragma once

#include <complex>
#include <cstddef>
#include <vector>

namespace plantloop {

struct DenseMatrix {
  DenseMatrix() = default;
  DenseMatrix(std::size_t r, std::size_t c) : rows(r), columns(c), values(r * c, 0.0) {}
  static DenseMatrix identity(std::size_t n);
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;  // by rows
  double& operator()(std::size_t i, std::size_t j) { return values[i * columns + j]; }
  double operator()(std::size_t i, std::size_t j) const { return values[i * columns + j]; }
  // The block of r rows and c columns from (i, j).
  DenseMatrix block(std::size_t i, std::size_t j, std::size_t r, std::size_t c) const;
  friend bool operator==(const DenseMatrix&, const DenseMatrix&) = default;
};

DenseMatrix product(const DenseMatrix& a, const DenseMatrix& b);
DenseMatrix sum(const DenseMatrix& a, const DenseMatrix& b);
DenseMatrix transposed(const DenseMatrix& a);
// exp(a t), by Pade approximation with scaling and squaring (Eigen).
DenseMatrix exponential(const DenseMatrix& a, double t);

// Sorted by real part, then by imaginary part.
std::vector<std::complex<double>> eigenvalues(const DenseMatrix& a);
// The numbers s where [A - s I, B; C, D] has less than its usual rank: the zeros of the transfer matrix and what cannot
// be reached or seen. By reduction to a system with invertible D (Emami-Naeini and Van Dooren, Automatica 18, 1982), so
// that zeros at infinity do not disturb the finite ones.
std::vector<std::complex<double>> invariant_zeros(DenseMatrix a, DenseMatrix b, DenseMatrix c, DenseMatrix d);
// C (s I - A)^-1 B + D, by rows; infinite at a pole.
std::vector<std::complex<double>> transfer(const DenseMatrix& a, const DenseMatrix& b, const DenseMatrix& c,
                                           const DenseMatrix& d, std::complex<double> s);

// The x that minimises |a x - b|^2, of those the shortest (singular values below 1e-13 of the largest count as zero).
std::vector<double> least_squares(const DenseMatrix& a, const std::vector<double>& b);
// (a' a)^-1 by singular values; entries are infinite when a column does not matter.
DenseMatrix covariance_of(const DenseMatrix& a);
// The direction x of length 1 in which a x is shortest, and how short: |a x| over the largest such length.
struct WeakDirection {
  std::vector<double> direction;
  double ratio = 1;
};
WeakDirection weakest_direction(const DenseMatrix& a);
// The solution of (a' a + diag(damping)^2) x = a' b.
std::vector<double> damped_least_squares(const DenseMatrix& a, const std::vector<double>& damping,
                                         const std::vector<double>& b);

}  // namespace plantloop
