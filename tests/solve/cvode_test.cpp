// SUNDIALS behind the integrator's interface: stiff problems, dense and sparse Jacobians, failures in plain words.

#include <gtest/gtest.h>

#include "tests/solve/systems.h"

namespace plantloop {
namespace {

using testing::Chain;
using testing::HandWritten;

// Van der Pol's oscillator with mu = 1000, and its exact Jacobian.
class VanDerPol final : public OdeSystem {
 public:
  int size() const override { return 2; }
  double* state() override { return x; }
  const double* derivatives(double) override {
    rate_[0] = x[1];
    rate_[1] = 1000 * (1 - x[0] * x[0]) * x[1] - x[0];
    return rate_;
  }
  const SparsityPattern* pattern() const override { return &pattern_; }
  const double* jacobian(double) override {
    entries_[0] = -2000 * x[0] * x[1] - 1;  // column 0, row 1
    entries_[1] = 1;                        // column 1, rows 0 and 1
    entries_[2] = 1000 * (1 - x[0] * x[0]);
    return entries_;
  }
  double x[2] = {2, 0};

 private:
  double rate_[2] = {}, entries_[3] = {};
  SparsityPattern pattern_{2, {0, 1, 3}, {1, 0, 1}};
};

TEST(Bdf, SolvesVanDerPolsOscillator) {
  VanDerPol system;
  const auto integrator = make_integrator(system, {.solver = "bdf", .stop = 2000, .rtol = 1e-10, .atol = 1e-13});
  for (double t = 0; t < 2000;) t = integrator->step(2000);
  // Test set for IVP solvers (Mazzia, Magherini, 2008), problem vdpol; each jump multiplies errors by some hundreds.
  EXPECT_NEAR(system.x[0], 1.706167732170469, 1e-7);
  EXPECT_NEAR(system.x[1], -8.928097010248125e-4, 1e-10);
  EXPECT_LT(integrator->statistics().steps, 10000);  // an explicit method needs millions
  EXPECT_GT(integrator->statistics().jacobians, 10);
}

TEST(Bdf, SolvesTheRobertsonReaction) {
  HandWritten system({1, 0, 0}, [](double, const std::vector<double>& x, std::vector<double>& rate) {
    rate[0] = -0.04 * x[0] + 1e4 * x[1] * x[2];
    rate[2] = 3e7 * x[1] * x[1];
    rate[1] = -rate[0] - rate[2];
  });
  const auto integrator = make_integrator(system, {.solver = "bdf", .stop = 40, .rtol = 1e-9, .atol = 1e-13});
  for (double t = 0; t < 40;) t = integrator->step(40);
  // Hairer, Wanner II, IV.10; differenced Jacobian.
  EXPECT_NEAR(system.x[0], 0.7158270688, 1e-7);
  EXPECT_NEAR(system.x[1], 0.9185534765e-5, 1e-11);
  EXPECT_NEAR(system.x[2], 0.2841637457, 1e-7);
}

TEST(Bdf, GivesTheSameWithSparseDenseAndDifferencedJacobians) {
  // 64 states are solved densely, 65 sparsely: the first 64 lags of both chains are the same problem.
  std::vector<std::vector<double>> ends;
  for (const auto& [n, with_pattern] : {std::pair(64, true), std::pair(65, true), std::pair(65, false)}) {
    Chain chain(n, 0.01, with_pattern);
    const auto integrator = make_integrator(chain, {.solver = "bdf", .stop = 1, .rtol = 1e-8, .atol = 1e-10});
    for (double t = 0; t < 1;) t = integrator->step(1);
    EXPECT_EQ(chain.jacobians > 0, with_pattern);
    EXPECT_NEAR(chain.x[63], chain.exact(64, 1), 1e-6);
    ends.push_back(chain.x);
  }
  for (std::size_t i = 0; i < 64; ++i) {
    EXPECT_NEAR(ends[0][i], ends[1][i], 1e-6);
    EXPECT_NEAR(ends[1][i], ends[2][i], 1e-6);
  }
}

TEST(Bdf, TakesAPatternWithoutDiagonal) {
  // 70 oscillators x' = v, v' = -x: no state feeds its own derivative but the velocities of damped ones.
  class Oscillators final : public OdeSystem {
   public:
    Oscillators() : x(140), rate_(140) {
      pattern_.size = 140;
      for (int i = 0; i < 140; ++i) {
        pattern_.column_start.push_back(static_cast<int>(pattern_.row.size()));
        pattern_.row.push_back(i ^ 1);
        values_.push_back(i % 2 == 0 ? -1 : 1);
        x[static_cast<std::size_t>(i)] = i % 2 == 0 ? 1 : 0;
      }
      pattern_.column_start.push_back(140);
    }
    int size() const override { return 140; }
    double* state() override { return x.data(); }
    const double* derivatives(double) override {
      for (std::size_t i = 0; i < 140; i += 2) {
        rate_[i] = x[i + 1];
        rate_[i + 1] = -x[i];
      }
      return rate_.data();
    }
    const SparsityPattern* pattern() const override { return &pattern_; }
    const double* jacobian(double) override { return values_.data(); }
    std::vector<double> x;

   private:
    std::vector<double> rate_, values_;
    SparsityPattern pattern_;
  } system;
  const auto integrator = make_integrator(system, {.solver = "bdf", .stop = 3, .rtol = 1e-9, .atol = 1e-11});
  for (double t = 0; t < 3;) t = integrator->step(3);
  EXPECT_NEAR(system.x[0], std::cos(3.0), 1e-6);
  EXPECT_NEAR(system.x[139], -std::sin(3.0), 1e-6);
}

TEST(Bdf, StepsOverAStiffChainInFewSteps) {
  Chain chain(1000, 1e-3);  // time constants of 1 ms over 100 s
  const auto integrator = make_integrator(chain, {.solver = "bdf", .stop = 100});
  for (double t = 0; t < 100;) t = integrator->step(100);
  EXPECT_NEAR(chain.x.back(), 1, 1e-5);
  EXPECT_LT(integrator->statistics().steps, 3000);
}

TEST(Adams, NeedsFewEvaluationsAtTightTolerances) {
  HandWritten system({1, 0}, [](double, const std::vector<double>& x, std::vector<double>& rate) {
    rate = {x[1], -x[0]};
  });
  const auto integrator = make_integrator(system, {.solver = "adams", .stop = 50, .rtol = 1e-10, .atol = 1e-12});
  for (double t = 0; t < 50;) t = integrator->step(50);
  EXPECT_NEAR(system.x[0], std::cos(50.0), 1e-7);  // the error grows with time: some thousand tolerances
  EXPECT_LT(integrator->statistics().evaluations, 4000);
}

TEST(Cvode, ManyRestartsNearEachOtherAreNoTrouble) {
  for (const char* solver : {"adams", "bdf"}) {
    HandWritten system({0}, [](double, const auto&, std::vector<double>& rate) { rate[0] = 1; });
    const auto integrator = make_integrator(system, {.solver = solver, .stop = 1});
    double t = 0;
    for (const double stop : {0.1, std::nextafter(0.1, 1), 0.1 + 1e-15, 0.1 + 1e-13, 0.1 + 1e-10, 0.2}) {
      integrator->restart(t);
      while (t < stop) t = integrator->step(stop);
      EXPECT_EQ(t, stop);
      std::vector<double> x(1);
      integrator->interpolate(t, x.data());
      EXPECT_NEAR(x[0], t, 1e-15);
    }
    EXPECT_EQ(integrator->statistics().cold_restarts, 6);
  }
}

TEST(Cvode, SaysInPlainWordsWhereItFailed) {
  for (const char* solver : {"adams", "bdf"}) {
    HandWritten system({1},
                       [](double, const std::vector<double>& x, std::vector<double>& rate) { rate[0] = x[0] * x[0]; });
    const auto integrator = make_integrator(system, {.solver = solver, .stop = 2});
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    try {
      for (double t = 0; t < 2;) t = integrator->step(2);
      ADD_FAILURE() << "the state escaped";
    } catch (const RunError& error) {
      EXPECT_NEAR(error.time(), 1, 1e-3);
      EXPECT_NE(std::string(error.what()).find("at t = "), std::string::npos) << error.what();
      EXPECT_TRUE(std::isfinite(system.x[0]));
    }
    EXPECT_EQ(::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr(), "");
  }
}

TEST(Cvode, PassesOnTheReasonWhenDerivativesCannotBeComputed) {
  for (const char* solver : {"adams", "bdf"}) {
    HandWritten system({0}, [](double t, const auto&, std::vector<double>& rate) {
      if (t > 0.5) throw RunError("loop 'a' has no solution", t, "a");
      rate[0] = std::cos(t);
    });
    const auto integrator = make_integrator(system, {.solver = solver, .stop = 1});
    try {
      for (double t = 0; t < 1;) t = integrator->step(1);
      ADD_FAILURE();
    } catch (const RunError& error) {
      EXPECT_STREQ(error.what(), "loop 'a' has no solution");
      EXPECT_EQ(error.place(), "a");
    }
  }
}

TEST(Cvode, LetsACancelledRunGo) {
  HandWritten system({0}, [](double t, const auto&, std::vector<double>& rate) {
    if (t > 0.5) throw LimitError("cancelled", t);
    rate[0] = std::cos(t);
  });
  const auto integrator = make_integrator(system, {.solver = "bdf", .stop = 1});
  EXPECT_THROW(
      {
        for (double t = 0; t < 1;) t = integrator->step(1);
      },
      LimitError);
}

TEST(Cvode, NamesADerivativeThatIsNotFinite) {
  HandWritten system({1, -1}, [](double, const std::vector<double>& x, std::vector<double>& rate) {
    rate = {0, std::sqrt(x[1])};
  });
  const auto integrator = make_integrator(system, {.solver = "bdf", .stop = 1});
  try {
    integrator->step(1);
    FAIL();
  } catch (const StateError& error) {
    EXPECT_EQ(error.state(), 1);
  }
}

}  // namespace
}  // namespace plantloop
