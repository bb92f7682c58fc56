// Parts of data for cross-validation.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "identify/data/data_set.h"

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

// Contiguous folds of each experiment: what is trained on stands before and after what is tested, as experiments of
// their own, so that no lag reaches across. Pairs of training and test data. Raises IdentifyError when a fold would be
// empty.
std::vector<std::pair<DataSet, DataSet>> data_folds(const DataSet& data, int folds);

}  // namespace plantloop::identify
