// Parts of data for cross-validation.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace plantloop::identify {

struct Fold {
  std::vector<Eigen::Index> train, test;  // rows, ascending
};

// Contiguous folds: row i is tested in fold floor(i k/n). Rows within `gap` of a tested one are not trained on either
// (blocked cross-validation: neighbouring rows of a time series share samples). Raises IdentifyError unless 2 <= k <=
// n.
std::vector<Fold> blocked_folds(Eigen::Index rows, int folds, Eigen::Index gap = 0);
// Folds of rows shuffled by a seed; for rows without order in time.
std::vector<Fold> shuffled_folds(Eigen::Index rows, int folds, std::uint64_t seed);

}  // namespace plantloop::identify
