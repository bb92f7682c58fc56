// Errors against tolerances, for every solver that controls its error; the same results whatever the width.

#include <gtest/gtest.h>

#include "engine/solve/tableau.h"
#include "tests/solve/systems.h"

namespace plantloop {
namespace {

using testing::Chain;
using testing::HandWritten;

std::vector<std::string> adaptive_solvers() {
  std::vector<std::string> names;
  for (const SolverInfo& info : solvers()) {
    if (info.adaptive) names.emplace_back(info.name);
  }
  return names;
}

class EveryAdaptiveSolver : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryAdaptiveSolver, MeetsItsTolerance) {
  for (const double rtol : {1e-4, 1e-6, 1e-8, 1e-10}) {
    HandWritten system = testing::logistic_and_bell();
    const auto integrator =
        make_integrator(system, {.solver = GetParam(), .stop = 10, .rtol = rtol, .atol = rtol * 1e-2});
    const double error = run_to(*integrator, system, 10, testing::logistic_and_bell_at);
    // Local errors add up over the steps and the problem grows by e before it saturates: some tens of tolerances.
    EXPECT_LT(error, 60 * rtol) << rtol;
    EXPECT_GT(error, 0) << rtol;
  }
}

TEST_P(EveryAdaptiveSolver, InterpolatesAsWellAsItSteps) {
  HandWritten system = testing::logistic_and_bell();
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 5, .rtol = 1e-7, .atol = 1e-9});
  double worst = 0;
  std::vector<double> x(2);
  for (double t = 0; t < 5;) {
    const double before = t;
    t = integrator->step(5);
    for (int k = 0; k <= 8; ++k) {
      const double at = k == 8 ? t : before + (t - before) * k / 8;
      integrator->interpolate(at, x.data());
      const std::vector<double> exact = testing::logistic_and_bell_at(at);
      worst = std::max(worst, std::hypot(x[0] - exact[0], x[1] - exact[1]));
    }
  }
  // The error of dopri5's interpolant has one power of h less than the step, so a little more than MeetsItsTolerance.
  EXPECT_LT(worst, 200 * 1e-7);
}

TEST_P(EveryAdaptiveSolver, GivesTheSameBitsTwice) {
  std::vector<std::vector<double>> results;
  for (int run = 0; run < 2; ++run) {
    HandWritten system = testing::logistic_and_bell();
    const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 3});
    for (double t = 0; t < 3;) t = integrator->step(3);
    results.push_back(system.x);
  }
  EXPECT_EQ(results[0], results[1]);
}

TEST_P(EveryAdaptiveSolver, ReachesEveryStopExactlyAndGoesOn) {
  HandWritten system = testing::logistic_and_bell();
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 2, .rtol = 1e-8, .atol = 1e-10});
  double t = 0;
  for (const double stop : {0.1, 0.1 + 1e-9, 0.3, 0.30000000000000004, 1.0, 2.0}) {
    while (t < stop) {
      const double before = t;
      t = integrator->step(stop);
      ASSERT_GT(t, before);
      ASSERT_LE(t, stop);
    }
    EXPECT_EQ(t, stop);
    EXPECT_NEAR(system.x[0], testing::logistic_and_bell_at(t)[0], 60 * 1e-8);
  }
}

TEST_P(EveryAdaptiveSolver, ForgetsThePastAtARestart) {
  // x' = u: the slope changes at t = 1, the solution is a broken line, which every method integrates exactly.
  double slope = 1;
  HandWritten system({0}, [&](double, const auto&, std::vector<double>& rate) { rate[0] = slope; });
  const auto integrator = make_integrator(system, {.solver = GetParam(), .stop = 2});
  for (double t = 0; t < 1;) t = integrator->step(1);
  slope = -3;
  system.x[0] += 10;
  integrator->restart(1);
  for (double t = 1; t < 2;) t = integrator->step(2);
  EXPECT_NEAR(system.x[0], 1 + 10 - 3, 1e-12);  // rounding of a few dozen additions
  EXPECT_EQ(integrator->statistics().cold_restarts, 1);
  EXPECT_GT(integrator->statistics().steps, 1);
}

TEST_P(EveryAdaptiveSolver, TakesNoStepBeyondItsLimit) {
  HandWritten system = testing::logistic_and_bell();
  const auto integrator =
      make_integrator(system, {.solver = GetParam(), .stop = 4, .rtol = 1e-3, .atol = 1e-3, .max_step = 0.25});
  double limit = 0.25;
  for (double t = 0; t < 4;) {
    const double before = t;
    if (t > 2) integrator->limit_step(limit = 0.01);
    t = integrator->step(4);
    EXPECT_LE(t - before, limit * (1 + 1e-12));
  }
}

TEST_P(EveryAdaptiveSolver, FollowsALongChain) {
  Chain chain(40, 0.1);
  const auto integrator = make_integrator(chain, {.solver = GetParam(), .stop = 4, .rtol = 1e-8, .atol = 1e-10});
  for (double t = 0; t < 4;) t = integrator->step(4);
  for (const std::size_t n : {1U, 10U, 40U}) EXPECT_NEAR(chain.x[n - 1], chain.exact(n, 4), 60 * 1e-8) << n;
}

INSTANTIATE_TEST_SUITE_P(Solvers, EveryAdaptiveSolver, ::testing::ValuesIn(adaptive_solvers()),
                         [](const auto& about) { return about.param; });

// Widths on both sides of the border between scalar and vector loops, and all rests of a division by the vector width.
TEST(ExplicitMethods, GiveEachStateTheSameBitsAtEveryWidth) {
  for (const Tableau& method : tableaus()) {
    for (const double step : {0.0, 0.05}) {
      if (step == 0 && !method.adaptive()) continue;
      std::vector<double> reference;
      for (const int n : {1, 2, 15, 16, 17, 19, 33}) {
        HandWritten system(std::vector<double>(static_cast<std::size_t>(n), 0.1),
                           [](double, const std::vector<double>& x, std::vector<double>& rate) {
                             for (std::size_t i = 0; i < x.size(); ++i) rate[i] = x[i] * (1 - x[i]);
                           });
        const auto integrator =
            make_integrator(system, {.solver = std::string(method.name), .stop = 1, .step = step, .first_step = 0.01});
        for (double t = 0; t < 1;) t = integrator->step(1);
        if (reference.empty()) reference = system.x;
        for (const double x : system.x) {
          // Equal states: the mean over them may round differently, and with it an adaptive step, not more.
          EXPECT_NEAR(x, reference[0], step > 0 ? 0 : 1e-14);
        }
      }
    }
  }
}

TEST(ExplicitMethods, LeaveASystemWithoutStatesAlone) {
  for (const double step : {0.0, 0.1}) {
    HandWritten system({}, [](double, const auto&, auto&) {});
    const auto integrator = make_integrator(system, {.stop = 1, .step = step});
    double t = 0;
    while (t < 1) t = integrator->step(1);
    EXPECT_EQ(t, 1);
  }
}

// A whole step of the system's own counts as one of the method; its dense output is the method's.
class OwnSteps final : public OdeSystem {
 public:
  explicit OwnSteps(double step) : step_(step), integrator_(make_integrator(inner, options(step))) {}
  static SolverOptions options(double step) { return {.stop = 100, .step = step}; }
  int size() const override { return inner.size(); }
  double* state() override { return inner.state(); }
  const double* derivatives(double t) override { return inner.derivatives(t); }
  bool fixed_step(std::string_view method, double t, double h) override {
    EXPECT_EQ(method, "dopri5");
    EXPECT_LE(h, step_);
    ++steps;
    const std::vector<double> now = inner.x;
    integrator_ = make_integrator(inner, {.start = t, .stop = t + h, .step = h});
    integrator_->step(t + h);
    return true;
  }
  HandWritten inner = testing::logistic_and_bell();
  int steps = 0;

 private:
  double step_;
  std::unique_ptr<Integrator> integrator_;
};

TEST(ExplicitMethods, UseTheSystemsOwnStepAndInterpolateItAlike) {
  OwnSteps own(0.125);
  HandWritten plain = testing::logistic_and_bell();
  const auto a = make_integrator(own, {.stop = 2, .step = 0.125});
  const auto b = make_integrator(plain, {.stop = 2, .step = 0.125});
  std::vector<double> x(2), y(2);
  for (double t = 0; t < 2;) {
    const double before = t;
    t = a->step(2);
    ASSERT_EQ(t, b->step(2));
    EXPECT_EQ(own.inner.x, plain.x);
    a->interpolate(before + 0.03, x.data());
    b->interpolate(before + 0.03, y.data());
    EXPECT_EQ(x, y);
  }
  EXPECT_EQ(own.steps, 16);
}

}  // namespace
}  // namespace plantloop
