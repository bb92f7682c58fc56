// The step sizes of the adaptive methods: no waste, no stubs, and a plain word when they come to nothing.

#include <gtest/gtest.h>

#include "tests/solve/systems.h"

namespace plantloop {
namespace {

using testing::HandWritten;

class EveryEmbeddedMethod : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryEmbeddedMethod, UsesTheLastDerivativeOfAStepForTheNext) {
  HandWritten system = testing::logistic_and_bell();
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 10});
  for (double t = 0; t < 10;) t = integrator->step(10);
  const SolverStatistics& count = integrator->statistics();
  const int stages = GetParam() == "dopri5" ? 6 : 3;
  EXPECT_EQ(count.evaluations, 2 + stages * (count.steps + count.rejected));  // 2: the first, and the starting step
}

TEST_P(EveryEmbeddedMethod, LeavesNoTinyLastStep) {
  HandWritten system = testing::logistic_and_bell();
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 10});
  double before_last = 0, last = 0;
  for (double t = 0; t < 10;) {
    before_last = last;
    last = integrator->step(10) - t;
    t += last;
  }
  EXPECT_GT(last, 0.4 * before_last);
}

TEST_P(EveryEmbeddedMethod, DoesNotForgetItsStepSizeWhenStopsAreNear) {
  // Between stops 0.01 apart each step is cut; afterwards the length wanted before is taken at once.
  HandWritten system({1}, [](double, const std::vector<double>& x, std::vector<double>& rate) { rate[0] = -x[0]; });
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 10, .rtol = 1e-4, .atol = 1e-6});
  double t = 0;
  while (t < 1) t = integrator->step(1);
  const std::int64_t steps = integrator->statistics().steps;
  for (int k = 1; k <= 20; ++k) {
    while (t < 1 + 0.01 * k) t = integrator->step(1 + 0.01 * k);
  }
  EXPECT_EQ(integrator->statistics().steps, steps + 20);  // one step to each stop
  const double before = t;
  t = integrator->step(10);
  EXPECT_GT(t - before, 0.05);
}

TEST_P(EveryEmbeddedMethod, NamesTheStateThatEscapes) {
  // x' = x^2 from 1 is 1 / (1 - t): no solution beyond t = 1.
  HandWritten system({0, 1, 0}, [](double, const std::vector<double>& x, std::vector<double>& rate) {
    rate = {1, x[1] * x[1], -1};
  });
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 2});
  try {
    for (double t = 0; t < 2;) t = integrator->step(2);
    FAIL() << "the state escaped";
  } catch (const StateError& error) {
    EXPECT_EQ(error.state(), 1);
    EXPECT_NEAR(error.time(), 1, 1e-3);
    EXPECT_NE(std::string(error.what()).find("the step size collapsed to"), std::string::npos);
    EXPECT_TRUE(std::isfinite(system.x[1]));
  }
}

TEST_P(EveryEmbeddedMethod, SaysWhichDerivativeIsNotFiniteAtTheStart) {
  HandWritten system({0, -1}, [](double, const std::vector<double>& x, std::vector<double>& rate) {
    rate = {1, std::sqrt(x[1])};
  });
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 1});
  try {
    integrator->step(1);
    FAIL();
  } catch (const StateError& error) {
    EXPECT_STREQ(error.what(), "the derivative of state 1 is not finite at t = 0 s");
  }
}

TEST_P(EveryEmbeddedMethod, ShortensAStepWhoseTrialLeavesTheDomain) {
  // x' = -sqrt(x) reaches zero at t = 2 with slope zero; a long trial step looks below it.
  HandWritten system(
      {1}, [](double, const std::vector<double>& x, std::vector<double>& rate) { rate[0] = -std::sqrt(x[0]); });
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 1.99, .rtol = 1e-3, .atol = 1e-6});
  for (double t = 0; t < 1.99;) t = integrator->step(1.99);
  EXPECT_NEAR(system.x[0], 0.005 * 0.005, 1e-4);  // (1 - t / 2)^2, and a few tolerances of 1e-3 * x
}

TEST_P(EveryEmbeddedMethod, PassesOnTheReasonWhenDerivativesCannotBeComputed) {
  HandWritten system({0}, [](double t, const auto&, std::vector<double>& rate) {
    if (t > 0.5) throw RunError("loop 'a' has no solution", t, "a");
    rate[0] = 1;
  });
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 1});
  try {
    for (double t = 0; t < 1;) t = integrator->step(1);
    FAIL();
  } catch (const RunError& error) {
    EXPECT_STREQ(error.what(), "loop 'a' has no solution");
    EXPECT_NEAR(error.time(), 0.5, 1e-9);
    EXPECT_NEAR(system.x[0], 0.5, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryEmbeddedMethod, ::testing::Values("dopri5", "bogacki_shampine"),
                         [](const auto& about) { return about.param; });

}  // namespace
}  // namespace plantloop
