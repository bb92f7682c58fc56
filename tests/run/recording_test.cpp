// The table of a run: looking up, taking back, values between rows and at jumps.

#include <gtest/gtest.h>

#include "tests/run/recordings.h"

namespace plantloop {
namespace {

TEST(Recording, InterpolatesContinuousColumnsAndHoldsDiscreteOnes) {
  const Recording r = testing::mixed();
  EXPECT_DOUBLE_EQ(r.value(0, 0.4), 0.4);
  EXPECT_EQ(r.value(1, 0.4), 1);
  EXPECT_EQ(r.value(1, 0.5), 2);
  EXPECT_DOUBLE_EQ(r.value(0, 0.75), 0.75);
  EXPECT_EQ(r.value(1, 0.999), 2);
}

TEST(Recording, HasTwoValuesAtAJump) {
  const Recording r = testing::mixed();
  EXPECT_EQ(r.value(0, 1), 11);
  EXPECT_EQ(r.value(0, 1, true), 1);
  EXPECT_EQ(r.value(1, 1), 3);
  EXPECT_EQ(r.value(1, 1, true), 2);
}

TEST(Recording, HoldsItsEndsOutside) {
  const Recording r = testing::mixed();
  EXPECT_EQ(r.value(0, -1), 0);
  EXPECT_EQ(r.value(0, 5), 11.1);
  EXPECT_EQ(r.value(0, 0, true), 0);
}

TEST(Recording, TakesBackARowAndItsHits) {
  Recording r = testing::mixed();
  r.remove_last_row();
  r.remove_last_row();
  EXPECT_EQ(r.rows(), 4U);
  EXPECT_EQ(r.hits[1], (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(r.value(0, 1), 1);
}

TEST(Recording, FindsColumnsByName) {
  const Recording r = testing::mixed();
  EXPECT_EQ(r.find("held"), 1);
  EXPECT_EQ(r.find("inner"), 2);
  EXPECT_EQ(r.find("hel"), -1);
  EXPECT_EQ(r.column(1), (std::vector<double>{1, 1, 2, 2, 3, 3}));
}

TEST(Recording, GrowsByDoubling) {
  Recording r;
  r.columns = {{.name = "a"}, {.name = "b"}};
  const std::vector<double> row{1, 2};
  for (int k = 0; k < 100000; ++k) r.append(k, 0, row);
  EXPECT_EQ(r.rows(), 100000U);
  EXPECT_EQ(r.at(99999, 1), 2);
}

}  // namespace
}  // namespace plantloop
