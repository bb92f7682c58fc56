// Where events are found: how near, in which direction, and how often.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/solve/root.h"

namespace plantloop {
namespace {

// Calls of g counted, to see that the search is short.
struct Counted {
  std::function<double(double)> g;
  int calls = 0;
  RootFinder::Functions functions() {
    return [this](double t, double* values) {
      ++calls;
      values[0] = g(t);
    };
  }
};

RootFinder finder_from(double sign, Direction direction = Direction::both, double event_tol = 0) {
  RootFinder finder({direction}, event_tol);
  finder.remember(std::vector{sign});
  return finder;
}

TEST(RootFinder, FindsACrossingToTheToleranceOfTime) {
  Counted sine{[](double t) { return std::sin(t); }};
  RootFinder finder = finder_from(1);
  const auto crossing = finder.first(3, 3.3, sine.functions());
  ASSERT_TRUE(crossing);
  const double tolerance = event_tolerance(3.3, 0);
  EXPECT_LE(crossing->time - crossing->before, tolerance);
  EXPECT_LT(crossing->before, std::numbers::pi);
  EXPECT_GE(crossing->time, std::numbers::pi);
  EXPECT_LE(crossing->values[0], 0);  // the sign has changed
  EXPECT_LT(sine.calls, 12);          // bisection needs 39
}

TEST(RootFinder, IsNeverMuchSlowerThanBisection) {
  // A kink of 1e12 : 1, a jump, and a root of order 9.
  const std::vector<std::function<double(double)>> hard{
      [](double t) { return t < 0.123 ? 1e-12 * (0.123 - t) : 0.123 - t; },
      [](double t) { return t < 0.777 ? 1.0 : -1e-9; },
      [](double t) { return -std::pow(t - 0.3, 9); },
  };
  const std::vector<double> roots{0.123, 0.777, 0.3};
  for (std::size_t i = 0; i < hard.size(); ++i) {
    Counted counted{hard[i]};
    RootFinder finder = finder_from(1);
    const auto crossing = finder.first(0, 1, counted.functions());
    ASSERT_TRUE(crossing);
    EXPECT_NEAR(crossing->time, roots[i], 2 * event_tolerance(1, 0)) << i;
    EXPECT_LE(counted.calls, 45) << i;  // log2(1 / 2.8e-13) = 42, and the two ends
  }
}

TEST(RootFinder, FindsTheFirstOfSeveral) {
  RootFinder finder({Direction::both, Direction::both, Direction::both});
  const auto g = [](double t, double* values) {
    values[0] = 0.7 - t;
    values[1] = t - 0.2;
    values[2] = t * t - 0.04;  // at the same time as the second
  };
  finder.remember(std::vector{0.7, -0.2, -0.04});
  const auto crossing = finder.first(0, 1, g);
  ASSERT_TRUE(crossing);
  EXPECT_NEAR(crossing->time, 0.2, event_tolerance(1, 0));
  EXPECT_EQ(std::vector(crossing->fired.begin(), crossing->fired.end()), (std::vector{1, 2}));
}

TEST(RootFinder, HeedsTheDirection) {
  Counted falling{[](double t) { return 0.5 - t; }};
  EXPECT_TRUE(finder_from(1, Direction::down).first(0, 1, falling.functions()));
  EXPECT_FALSE(finder_from(1, Direction::up).first(0, 1, falling.functions()));
  EXPECT_FALSE(finder_from(-1, Direction::down).first(0, 1, falling.functions()));
}

TEST(RootFinder, FiresAtAZeroOnceAndNotWhenItLeavesOnTheOtherSide) {
  Counted falling{[](double t) { return 1 - t; }};
  RootFinder finder = finder_from(1);
  const auto crossing = finder.first(0, 1, falling.functions());
  ASSERT_TRUE(crossing);
  finder.remember_fired(crossing->fired, crossing->values);
  EXPECT_EQ(finder.signs()[0], -1);
  EXPECT_FALSE(finder.first(1, 2, falling.functions()));
}

TEST(RootFinder, RemembersTheLastSignWhileAFunctionRestsAtZero) {
  // Zero from 1 to 2, then on to the other side: one crossing, when it leaves; or back: none.
  RootFinder finder = finder_from(1, Direction::down);
  finder.remember(std::vector{0.0});
  EXPECT_EQ(finder.signs()[0], 1);
  Counted back{[](double t) { return t - 2; }};
  EXPECT_FALSE(finder.first(2, 3, back.functions()));
}

TEST(RootFinder, DoesNotFireAFunctionThatBeganAtZero) {
  RootFinder finder({Direction::both});
  finder.remember(std::vector{0.0});
  Counted rising{[](double t) { return t; }};
  EXPECT_FALSE(finder.first(0, 1, rising.functions()));
  finder.remember(finder.values());
  EXPECT_EQ(finder.signs()[0], 1);
}

TEST(RootFinder, SeesABallThatDipsBelowTheFloorWhenAskedToLookHalfway) {
  Counted dip{[](double t) { return (t - 0.4) * (t - 0.7); }};
  EXPECT_FALSE(finder_from(1).first(0, 1, dip.functions()));
  RootFinder finder = finder_from(1);
  const auto crossing = finder.first(0, 1, dip.functions(), true);
  ASSERT_TRUE(crossing);
  EXPECT_NEAR(crossing->time, 0.4, event_tolerance(1, 0));
}

TEST(RootFinder, StopsAtAWiderToleranceWhenTold) {
  Counted sine{[](double t) { return std::sin(t); }};
  RootFinder finder = finder_from(1, Direction::both, 1e-3);
  const auto crossing = finder.first(3, 3.3, sine.functions());
  ASSERT_TRUE(crossing);
  EXPECT_LE(crossing->time - crossing->before, 1e-3);
  EXPECT_NEAR(crossing->time, std::numbers::pi, 1e-3);
}

TEST(RootFinder, WorksFarFromZeroInTime) {
  // At t = 1e6 neighbouring numbers are 1.2e-10 apart.
  Counted step{[](double t) { return 1e6 + 0.25 - t; }};
  RootFinder finder = finder_from(1);
  const auto crossing = finder.first(1e6, 1e6 + 1, step.functions());
  ASSERT_TRUE(crossing);
  EXPECT_NEAR(crossing->time, 1e6 + 0.25, event_tolerance(1e6, 0));
}

TEST(RootFinder, DoesNotFireAgainWhileAFunctionStaysAtZero) {
  // As of a state that is put on its limit: up to zero, along it, and away.
  Counted limited{[](double t) { return t < 1 ? t - 1 : t < 2 ? 0 : 2 - t; }};
  RootFinder finder = finder_from(-1);
  const auto reached = finder.first(0, 1.5, limited.functions());
  ASSERT_TRUE(reached);
  finder.remember_fired(reached->fired, reached->values);
  EXPECT_FALSE(finder.first(reached->time, 1.8, limited.functions()));
  finder.remember(finder.values());
  EXPECT_TRUE(finder.first(1.8, 3, limited.functions()));
}

TEST(RootFinder, TakesZeroForTheSignThatItIsTold) {
  RootFinder finder({Direction::both, Direction::both}, 0, {1, -1});
  finder.remember(std::vector{-1.0, -1.0});
  EXPECT_TRUE(finder.fires(0, 0));   // a condition that holds at zero
  EXPECT_FALSE(finder.fires(1, 0));  // one that does not
  EXPECT_TRUE(finder.fires(1, 1e-300));
  // Two at one root, of which a midpoint hits exactly zero: both are beyond it at the time that is found.
  finder.remember(std::vector{-1.0, -1.0});
  const auto crossing = finder.first(0, 1, [](double t, double* values) { values[0] = values[1] = t - 0.5; });
  ASSERT_TRUE(crossing);
  EXPECT_EQ(crossing->fired.size(), 2u);
  EXPECT_GT(crossing->values[0], 0);
  // A function that comes to rest at zero is found where it does so.
  RootFinder resting({Direction::both}, 0, {1});
  resting.remember(std::vector{-1.0});
  const auto rest = resting.first(0, 1, [](double t, double* values) { values[0] = std::min(0.0, t - 0.25); });
  ASSERT_TRUE(rest);
  EXPECT_NEAR(rest->time, 0.25, event_tolerance(1, 0));
}

}  // namespace
}  // namespace plantloop
