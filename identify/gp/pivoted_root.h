// The root of a positive semidefinite matrix of which only columns are known.

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace plantloop::identify {

// C = G G' + rest by Cholesky's method with pivots, until no diagonal element of the rest exceeds that of `enough` or
// `most` columns have been added to those that G begins with, N x any. `left` is the diagonal of what these leave of C,
// N; column(j) gives column j of C; returns G. `finished` tells whether the rest is below `enough` everywhere.
template <typename Column>
Eigen::MatrixXd pivoted_root(Eigen::MatrixXd G, Eigen::VectorXd left, const Eigen::VectorXd& enough, Eigen::Index most,
                             const Column& column, bool& finished) {
  using Eigen::Index;
  const Index n = left.size(), end = G.cols() + most;
  Index columns = G.cols();
  const auto next_pivot = [&] {
    Index pivot = -1;
    double greatest = 1;
    for (Index i = 0; i < n; ++i) {
      if (left[i] > greatest * enough[i]) {
        greatest = enough[i] > 0 ? left[i] / enough[i] : std::numeric_limits<double>::infinity();
        pivot = i;
      }
    }
    return pivot;
  };
  Index pivot = next_pivot();
  for (; columns < end && pivot >= 0; ++columns) {
    if (columns == G.cols()) G.conservativeResize(n, std::min(end, 2 * columns + 8));
    G.col(columns) = column(pivot);
    G.col(columns) -= G.leftCols(columns) * G.row(pivot).head(columns).transpose();
    G.col(columns) /= std::sqrt(left[pivot]);
    left -= G.col(columns).cwiseAbs2();
    left[pivot] = 0;
    pivot = next_pivot();
  }
  finished = pivot < 0;
  G.conservativeResize(n, columns);
  return G;
}

}  // namespace plantloop::identify
