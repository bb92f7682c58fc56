// Farthest points, and centres of clusters.

#include "identify/gp/inducing.h"

#include <algorithm>
#include <limits>

#include "identify/error.h"
#include "identify/gp/stationary.h"
#include "identify/random.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// In units of the columns' standard deviations.
MatrixXd scaled(const MatrixXd& x) { return x * column_variances(x).cwiseSqrt().cwiseInverse().asDiagonal(); }

// Farthest points first, each row once; with `different`, until all others lie on one that was chosen.
std::vector<Index> farthest(const MatrixXd& points, int count, std::uint64_t seed, bool different) {
  const Index n = points.rows();
  VectorXd distance = VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  std::vector<Index> chosen;
  auto next = static_cast<Index>(Random(seed).index(static_cast<std::uint64_t>(n)));
  for (int i = 0; i < count; ++i) {
    chosen.push_back(next);
    distance = distance.cwiseMin((points.rowwise() - points.row(next)).rowwise().squaredNorm());
    distance[next] = -1;  // never again, also where rows repeat
    if (distance.maxCoeff(&next) <= 0 && different) break;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

// The nearest centre of each point.
std::vector<Index> nearest(const MatrixXd& points, const MatrixXd& centres) {
  std::vector<Index> of(static_cast<std::size_t>(points.rows()));
  const VectorXd half = 0.5 * centres.rowwise().squaredNorm();
  for (Index i = 0; i < points.rows(); ++i)
    (half - centres * points.row(i).transpose()).minCoeff(&of[static_cast<std::size_t>(i)]);
  return of;
}

}  // namespace

std::vector<Index> spread_subset(const MatrixXd& x, int count, std::uint64_t seed) {
  const Index n = x.rows();
  if (count < 1 || count > n) fail("a subset of {} of {} rows; there must be from 1 to {}", count, n, n);
  return farthest(scaled(x), count, seed, false);
}

MatrixXd clustered_inputs(const MatrixXd& x, int count, std::uint64_t seed) {
  const MatrixXd points = scaled(x);
  const std::vector<Index> chosen = farthest(points, static_cast<int>(std::min<Index>(count, x.rows())), seed, true);
  MatrixXd centres = points(chosen, Eigen::all), own = x(chosen, Eigen::all);
  if (own.rows() < count || own.rows() == x.rows()) return own;
  std::vector<Index> of;
  for (int round = 0; round < 20; ++round) {
    std::vector<Index> now = nearest(points, centres);
    if (now == of) break;
    of = std::move(now);
    MatrixXd sums = MatrixXd::Zero(centres.rows(), x.cols()), own_sums = sums;
    VectorXd members = VectorXd::Zero(centres.rows());
    for (Index i = 0; i < x.rows(); ++i) {
      const Index k = of[static_cast<std::size_t>(i)];
      sums.row(k) += points.row(i);
      own_sums.row(k) += x.row(i);
      members[k] += 1;
    }
    for (Index k = 0; k < centres.rows(); ++k) {
      if (members[k] == 0) continue;
      centres.row(k) = sums.row(k) / members[k];
      own.row(k) = own_sums.row(k) / members[k];
    }
  }
  return own;
}

}  // namespace plantloop::identify
