// The order of every explicit method and of its dense output, measured.

#include <gtest/gtest.h>

#include <numeric>

#include "engine/solve/tableau.h"
#include "tests/solve/systems.h"

namespace plantloop {
namespace {

using testing::HandWritten;

class EveryExplicitMethod : public ::testing::TestWithParam<Tableau> {};

SolverOptions with_step(std::string_view solver, double step, double stop) {
  return {.solver = std::string(solver), .stop = stop, .step = step};
}

// The error at t = 2 of the logistic equation and the bell with n steps from t = -3.
double error_at_end(const Tableau& method, int n) {
  HandWritten system = testing::logistic_and_bell();
  system.x = testing::logistic_and_bell_at(-3);
  SolverOptions options = with_step(method.name, 5.0 / n, 2);
  options.start = -3;
  const auto integrator = make_integrator(system, options);
  for (double t = -3; t < 2;) t = integrator->step(2);
  const std::vector<double> exact = testing::logistic_and_bell_at(2);
  return std::hypot(system.x[0] - exact[0], system.x[1] - exact[1]);
}

// The largest error of the dense output of one step of size h from the closed form at t = 0.3.
double error_inside(const Tableau& method, double h) {
  HandWritten system = testing::logistic_and_bell();
  system.x = testing::logistic_and_bell_at(0.3);
  SolverOptions options = with_step(method.name, h, 0.3 + h);
  options.start = 0.3;
  const auto integrator = make_integrator(system, options);
  const double end = integrator->step(0.3 + h);
  double worst = 0;
  for (int k = 1; k < 10; ++k) {
    const double t = 0.3 + (end - 0.3) * k / 10;
    std::vector<double> x(2);
    integrator->interpolate(t, x.data());
    const std::vector<double> exact = testing::logistic_and_bell_at(t);
    worst = std::max(worst, std::hypot(x[0] - exact[0], x[1] - exact[1]));
  }
  return worst;
}

TEST_P(EveryExplicitMethod, HasItsOrderOnNonlinearProblems) {
  const Tableau& method = GetParam();
  const int n = 256;  // short enough for the leading term; errors of dopri5 are 1e-12 to 1e-14, above rounding
  const double order = std::log2(error_at_end(method, n) / error_at_end(method, 2 * n));
  EXPECT_NEAR(order, method.order, 0.1);
}

TEST_P(EveryExplicitMethod, InterpolatesWithTheOrderItTells) {
  const Tableau& method = GetParam();
  // The error inside one step: one power more than over a whole run, at most what the polynomial can do.
  const double h = method.order < 5 ? 0.005 : 0.02;  // errors of 1e-13 and more, above rounding
  const double order = std::log2(error_inside(method, h) / error_inside(method, h / 2));
  const int local = std::min(method.order + 1, method.bubble.empty() ? 4 : 5);
  EXPECT_NEAR(order, local, 0.1);
  EXPECT_GE(local, method.dense_order());
}

TEST_P(EveryExplicitMethod, InterpolatesTheEndsOfAStepExactly) {
  HandWritten system = testing::logistic_and_bell();
  const auto integrator = make_integrator(system, with_step(GetParam().name, 0.1, 1));
  const std::vector<double> before = system.x;
  const double t = integrator->step(1);
  const std::vector<double> after = system.x;
  std::vector<double> x(2);
  integrator->interpolate(0, x.data());
  EXPECT_EQ(x, before);
  integrator->interpolate(t, x.data());
  EXPECT_EQ(x, after);
}

TEST_P(EveryExplicitMethod, ContinuesAfterInterpolationIntoTheState) {
  HandWritten plain = testing::logistic_and_bell();
  HandWritten looked_at = testing::logistic_and_bell();
  const auto a = make_integrator(plain, with_step(GetParam().name, 0.1, 1));
  const auto b = make_integrator(looked_at, with_step(GetParam().name, 0.1, 1));
  for (int k = 0; k < 5; ++k) {
    a->step(1);
    const double t = b->step(1);
    b->interpolate(t - 0.05, looked_at.state());
  }
  b->interpolate(0.5, looked_at.state());
  EXPECT_EQ(plain.x, looked_at.x);  // the same bits
}

// What the order conditions and the row sums ask of the numbers, whatever the problem.
TEST_P(EveryExplicitMethod, HasAConsistentTable) {
  const Tableau& method = GetParam();
  const auto sum = [](const std::vector<double>& list) { return std::accumulate(list.begin(), list.end(), 0.0); };
  ASSERT_EQ(method.a.size() + 1, method.b.size());
  ASSERT_EQ(method.a.size(), method.c.size());
  for (std::size_t i = 0; i < method.a.size(); ++i) {
    ASSERT_EQ(method.a[i].size(), i + 1);
    EXPECT_NEAR(sum(method.a[i]), method.c[i], 4e-15);  // rounding of entries of size 10
  }
  EXPECT_NEAR(sum(method.b), 1, 1e-15);
  EXPECT_NEAR(sum(method.error), 0, 1e-15);
  EXPECT_NEAR(sum(method.bubble), 0, 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Tableaus, EveryExplicitMethod, ::testing::ValuesIn(tableaus()),
                         [](const auto& about) { return std::string(about.param.name); });

}  // namespace
}  // namespace plantloop
