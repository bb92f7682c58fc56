// Points that stand for many: subsets of data and inducing inputs of sparse processes.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace plantloop::identify {

// Rows of x for a subset of data: `count` rows that lie as far from each other as can be, each one the farthest from
// those chosen before it, in units of the columns' standard deviations; the first one is drawn. Ascending.
std::vector<Eigen::Index> spread_subset(const Eigen::MatrixXd& x, int count, std::uint64_t seed = 1);

// The centres of `count` clusters of the rows (S. Lloyd 1982), begun at a spread subset, so that there are more where
// there are more rows: count x D. When no more rows than that differ, they are the different rows themselves.
Eigen::MatrixXd clustered_inputs(const Eigen::MatrixXd& x, int count, std::uint64_t seed = 1);

}  // namespace plantloop::identify
