// Fixed steps: the grid start + k step, stops between its points, and what is said when a step is too long.

#include <gtest/gtest.h>

#include "tests/solve/systems.h"

namespace plantloop {
namespace {

using testing::HandWritten;

HandWritten still() {
  return HandWritten({1, 1}, [](double, const auto&, std::vector<double>& rate) { rate = {0, 0}; });
}

SolverOptions steps_of(double step, double start = 0) {
  return {.solver = "rk4", .start = start, .stop = start + 10, .step = step};
}

TEST(FixedStep, TakesGridTimesFromTheirNumberNotFromASum) {
  HandWritten system = still();
  const auto integrator = make_integrator(system, steps_of(0.1, 0.7));
  for (int k = 1; k <= 1000; ++k) ASSERT_EQ(integrator->step(1e9), 0.7 + k * 0.1);
}

TEST(FixedStep, ReachesAStopByAShorterStepAndReturnsToTheGrid) {
  HandWritten system = still();
  const auto integrator = make_integrator(system, steps_of(0.25));
  EXPECT_EQ(integrator->step(0.3), 0.25);
  EXPECT_EQ(integrator->step(0.3), 0.3);
  EXPECT_EQ(integrator->step(10), 0.5);
  EXPECT_EQ(integrator->step(10), 0.75);
}

TEST(FixedStep, ReturnsToTheGridAfterARestartBetweenItsPoints) {
  HandWritten system = still();
  const auto integrator = make_integrator(system, steps_of(0.25));
  EXPECT_EQ(integrator->step(10), 0.25);
  integrator->restart(0.1);  // an event inside the step
  EXPECT_EQ(integrator->step(10), 0.25);
  EXPECT_EQ(integrator->step(10), 0.5);
}

TEST(FixedStep, TakesAStopThatMissesTheGridByRoundingAsAGridPoint) {
  // 3 * 0.1 is 0.30000000000000004, a hit of a clock with period 0.1 stands at 0.3.
  HandWritten system = still();
  const auto integrator = make_integrator(system, steps_of(0.1));
  std::vector<double> times;
  for (const double stop : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}) times.push_back(integrator->step(stop));
  EXPECT_EQ(times, (std::vector{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}));
  EXPECT_EQ(integrator->statistics().steps, 8);
}

TEST(FixedStep, UsesExactlyTheStepOnTheGrid) {
  // x' = 1 from 0 with euler: each full step adds exactly `step`, wherever the clock's rounding puts the times.
  HandWritten system({0}, [](double, const auto&, std::vector<double>& rate) { rate[0] = 1; });
  const auto integrator = make_integrator(system, {.solver = "euler", .stop = 100, .step = 0.1});
  double sum = 0;
  for (int k = 0; k < 500; ++k) {
    integrator->step(100);
    sum += 0.1;
    ASSERT_EQ(system.x[0], sum);
  }
}

TEST(FixedStep, LeavesNoStubBehindAnEventNearTheGrid) {
  HandWritten system = still();
  const auto integrator = make_integrator(system, steps_of(0.5));
  integrator->restart(0.5 - 1e-13);
  EXPECT_EQ(integrator->step(10), 1.0);
}

TEST(FixedStep, DividesAStepThatADelayLimits) {
  HandWritten system = still();
  const auto integrator = make_integrator(system, steps_of(0.3));
  integrator->limit_step(0.11);
  EXPECT_DOUBLE_EQ(integrator->step(10), 0.1);
  EXPECT_DOUBLE_EQ(integrator->step(10), 0.2);
  EXPECT_EQ(integrator->step(10), 0.3);
  integrator->limit_step(std::numeric_limits<double>::infinity());
  EXPECT_EQ(integrator->step(10), 0.6);
}

TEST(FixedStep, NamesTheStateThatIsNotFiniteAndKeepsTheLastGoodOnes) {
  HandWritten system({1, 1}, [](double, const std::vector<double>& x, std::vector<double>& rate) {
    rate = {-x[0], x[1] * x[1] * x[1] * x[1]};
  });
  const auto integrator = make_integrator(system, steps_of(0.5));
  try {
    for (int k = 0; k < 100; ++k) integrator->step(100);
    FAIL() << "the state grew without end";
  } catch (const StateError& error) {
    EXPECT_EQ(error.state(), 1);
    EXPECT_GT(error.time(), 0);
    EXPECT_NE(std::string(error.what()).find("state 1 is not finite at t = "), std::string::npos);
    EXPECT_TRUE(std::isfinite(system.x[1]));
  }
}

TEST(FixedStep, KeepsTheStateWhenTheDerivativesFail) {
  int calls = 0;
  HandWritten system({1, 2}, [&](double t, const auto&, std::vector<double>& rate) {
    if (++calls == 7) throw RunError("no solution", t);
    rate = {1, 1};
  });
  const auto integrator = make_integrator(system, steps_of(0.5));
  integrator->step(10);
  const std::vector<double> before = system.x;
  EXPECT_THROW(integrator->step(10), RunError);
  EXPECT_EQ(system.x, before);
}

TEST(Solvers, AreListedAndMade) {
  HandWritten system = still();
  for (const SolverInfo& info : solvers()) {
    const SolverOptions fixed{.solver = std::string(info.name), .step = 0.1};
    const SolverOptions adaptive{.solver = std::string(info.name)};
    if (info.fixed) {
      EXPECT_NE(make_integrator(system, fixed), nullptr);
    } else {
      EXPECT_THROW(make_integrator(system, fixed), std::invalid_argument);
    }
    if (info.adaptive) {
      EXPECT_NE(make_integrator(system, adaptive), nullptr);
    } else {
      EXPECT_THROW(make_integrator(system, adaptive), std::invalid_argument);
    }
  }
  EXPECT_THROW(make_integrator(system, {.solver = "rk5"}), std::invalid_argument);
}

}  // namespace
}  // namespace plantloop
