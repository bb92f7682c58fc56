// Parts of data for cross-validation.

#include "identify/validation/folds.h"

#include <algorithm>
#include <numeric>

#include "identify/error.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;

void check_folds(Index rows, int folds) {
  if (folds < 2 || folds > rows) fail("{} rows are cut into 2 to {} folds, not into {}", rows, rows, folds);
}

Index fold_of(Index i, Index rows, int folds) { return i * folds / rows; }

}  // namespace

std::vector<Fold> blocked_folds(Index rows, int folds, Index gap) {
  check_folds(rows, folds);
  std::vector<Fold> result(static_cast<std::size_t>(folds));
  for (Index f = 0; f < folds; ++f) {
    Fold& fold = result[static_cast<std::size_t>(f)];
    // The first row of fold f is the least i with floor(i k/n) = f.
    const Index begin = (f * rows + folds - 1) / folds;
    const Index end = ((f + 1) * rows + folds - 1) / folds;
    for (Index i = 0; i < rows; ++i) {
      if (i >= begin && i < end) {
        fold.test.push_back(i);
      } else if (i < begin - gap || i >= end + gap) {
        fold.train.push_back(i);
      }
    }
    if (fold.train.empty()) fail("a gap of {} rows leaves nothing to train on", gap);
  }
  return result;
}

std::vector<Fold> shuffled_folds(Index rows, int folds, std::uint64_t seed) {
  check_folds(rows, folds);
  std::vector<Index> order(static_cast<std::size_t>(rows));
  std::iota(order.begin(), order.end(), Index{0});
  Random random(seed);
  for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random.index(i + 1)]);
  std::vector<Fold> result(static_cast<std::size_t>(folds));
  for (Index place = 0; place < rows; ++place) {
    const Index own = fold_of(place, rows, folds);
    for (Index f = 0; f < folds; ++f) {
      Fold& fold = result[static_cast<std::size_t>(f)];
      (f == own ? fold.test : fold.train).push_back(order[static_cast<std::size_t>(place)]);
    }
  }
  for (Fold& fold : result) {
    std::sort(fold.train.begin(), fold.train.end());
    std::sort(fold.test.begin(), fold.test.end());
  }
  return result;
}

std::vector<std::pair<DataSet, DataSet>> data_folds(const DataSet& data, int folds) {
  check(data);
  if (folds < 2) fail("data are cut into 2 folds or more, not into {}", folds);
  std::vector<std::pair<DataSet, DataSet>> result;
  for (Index f = 0; f < folds; ++f) {
    DataSet train{data.Ts, data.inputs, data.outputs, {}};
    DataSet test = train;
    for (const Experiment& e : data.experiments) {
      const Index begin = (f * e.samples() + folds - 1) / folds;
      const Index end = ((f + 1) * e.samples() + folds - 1) / folds;
      const auto add = [&](DataSet& to, Index from, Index until) {
        if (until <= from) return;
        to.experiments.push_back({e.name, e.start + static_cast<double>(from) * data.Ts,
                                  e.u.middleRows(from, until - from), e.y.middleRows(from, until - from)});
      };
      add(train, 0, begin);
      add(test, begin, end);
      add(train, end, e.samples());
    }
    if (train.experiments.empty() || test.experiments.empty()) {
      fail("{} samples are too few for {} folds", data.samples(), folds);
    }
    result.emplace_back(std::move(train), std::move(test));
  }
  return result;
}

}  // namespace plantloop::identify
