// Folds of cross-validation cover the rows once.

#include "identify/validation/folds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;

TEST(Folds, TestEachRowOnceAndNeverTrainOnIt) {
  for (const auto& folds : {blocked_folds(103, 5), shuffled_folds(103, 5, 1)}) {
    std::set<Index> seen;
    for (const Fold& fold : folds) {
      EXPECT_EQ(fold.train.size() + fold.test.size(), 103U);
      for (const Index i : fold.test) {
        EXPECT_TRUE(seen.insert(i).second);
        EXPECT_FALSE(std::binary_search(fold.train.begin(), fold.train.end(), i));
      }
    }
    EXPECT_EQ(seen.size(), 103U);
  }
}

TEST(Folds, BlocksAreThoseOfTheBookAndKeepTheirDistance) {
  const auto folds = blocked_folds(103, 5);
  for (Index f = 0; f < 5; ++f) {
    for (const Index i : folds[static_cast<std::size_t>(f)].test) EXPECT_EQ(i * 5 / 103, f);
  }
  for (const Fold& fold : blocked_folds(100, 4, 6)) {
    for (const Index i : fold.train) {
      EXPECT_TRUE(i < fold.test.front() - 6 || i > fold.test.back() + 5);
    }
  }
}

TEST(Folds, OfDataTestEachSampleOnceAndKeepTheirTimes) {
  const Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(23, 0, 22);
  const auto folds = data_folds(make_data_set(y, y, 0.5), 4);
  double sum = 0;
  for (const auto& [train, test] : folds) {
    EXPECT_EQ(train.samples() + test.samples(), 23);
    const Experiment& tested = test.experiments[0];
    EXPECT_EQ(tested.start, 0.5 * tested.y(0, 0));
    for (const Experiment& e : train.experiments) {
      EXPECT_TRUE(e.y.maxCoeff() < tested.y.minCoeff() || e.y.minCoeff() > tested.y.maxCoeff());
    }
    sum += tested.y.sum();
  }
  EXPECT_EQ(sum, y.sum());
}

TEST(Folds, RefuseMoreFoldsThanRows) {
  EXPECT_THROW(blocked_folds(3, 4), IdentifyError);
  EXPECT_THROW(shuffled_folds(3, 1, 1), IdentifyError);
}

}  // namespace
}  // namespace plantloop::identify
