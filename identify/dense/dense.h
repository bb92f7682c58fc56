// Cholesky factors and inverses of large dense matrices.
//
// OpenBLAS does the work when it is installed; it is loaded when the first large matrix comes, so that no other command
// pays for it, and it runs on one thread, so that results do not depend on the number of cores. Without it Eigen does.

#pragma once

#include <Eigen/Core>

namespace plantloop::identify {

// Replaces the lower triangle of the symmetric `a` by its factor L, a = L L'. The strictly upper triangle is neither
// read nor written. False when `a` is not positive definite to working precision; `a` is then of no use.
bool factorise(Eigen::MatrixXd& a);

// Replaces the factor L (lower triangle) by the lower triangle of (L L')^-1.
void invert_factored(Eigen::MatrixXd& l);

// Replaces b by L^-1 b, or by L'^-1 b.
void solve_lower(const Eigen::MatrixXd& l, Eigen::Ref<Eigen::MatrixXd> b);
void solve_lower_transposed(const Eigen::MatrixXd& l, Eigen::Ref<Eigen::MatrixXd> b);

// Copies the lower triangle to the upper one.
void mirror_lower(Eigen::MatrixXd& a);

}  // namespace plantloop::identify
