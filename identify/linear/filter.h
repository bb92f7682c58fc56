// Polynomials in the delay operator q^-1: filtering, roots, stability.
//
// A polynomial is the vector of its coefficients, lowest delay first: {1, -1.5, 0.7} is 1 - 1.5 q^-1 + 0.7 q^-2.

#pragma once

#include <Eigen/Core>

namespace plantloop::identify {

// (B/A) x from rest: y(k) = (sum b_i x(k-i) - sum_{i>0} a_i y(k-i)) / a_0. a_0 must not be 0.
Eigen::VectorXd filter(const Eigen::VectorXd& B, const Eigen::VectorXd& A, const Eigen::VectorXd& x);
// x delayed by `samples`, zeros before its start.
Eigen::VectorXd delayed(const Eigen::VectorXd& x, Eigen::Index samples);
Eigen::VectorXd multiply(const Eigen::VectorXd& P, const Eigen::VectorXd& Q);

// The first `count` values of the response of B/A to a unit impulse.
Eigen::VectorXd impulse_response(const Eigen::VectorXd& B, const Eigen::VectorXd& A, Eigen::Index count);

// The roots in the z plane, z^n P(1/z) = 0, by the eigenvalues of the companion matrix; sorted by real, then imaginary
// part. Leading coefficients must not be 0.
Eigen::VectorXcd roots(const Eigen::VectorXd& P);
// All roots inside the circle of this radius.
bool is_stable(const Eigen::VectorXd& P, double radius = 1);
// A monic polynomial with each root outside of the unit circle replaced by its mirror image 1/conj(root).
Eigen::VectorXd reflected(const Eigen::VectorXd& P);
// With each root outside of the unit circle moved straight onto it.
Eigen::VectorXd clamped(const Eigen::VectorXd& P);

}  // namespace plantloop::identify
