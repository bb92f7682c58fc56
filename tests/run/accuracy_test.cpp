// Orders of convergence and accuracy of whole diagrams.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

// The pendulum of the format page as two integrators; its force steps at `edge`.
Signals pendulum(const std::string& simulation, const std::string& edge) {
  return run(R"(
parameters: {Q: 29.46, b: {value: 1.21}, theta0: pi/4, F0: Q/b*sin(theta0)}
blocks:
  force: {type: staircase, times: [0, )" +
             edge + R"(, 1.7], values: [F0 + 1, F0 - 2, F0 + 0.5]}
  theta: {type: integrator, in: omega, initial: theta0}
  omega: {type: integrator, in: b*force - Q*omega - Q*sin(theta)}
record: [theta, omega]
simulation: {stop: 3, )" +
             simulation + "}\n");
}

double distance(const Signals& a, const Signals& b) {
  return std::max(std::fabs(a.last("theta") - b.last("theta")), std::fabs(a.last("omega") - b.last("omega")));
}

TEST(S9Orders, OfFixedStepMethodsHoldWithEdgesOnAndOffTheGrid) {
  struct Method {
    const char* name;
    double order;
  };
  for (const char* edge : {"1", "0.7123456"}) {
    const Signals reference = pendulum("rtol: 1e-13, atol: 1e-15", edge);
    for (const Method& method : {Method{"euler", 1}, {"heun", 2}, {"rk4", 4}}) {
      const auto error = [&](const char* step) {
        return distance(pendulum(std::string("solver: ") + method.name + ", step: " + step, edge), reference);
      };
      // |lambda| is 29 1/s: below 1/50 s the first term of the error leads.
      const double order = std::log2(error("0.01") / error("0.005"));
      EXPECT_NEAR(order, method.order, 0.35) << method.name << ", edge at " << edge;
    }
  }
}

TEST(S9Accuracy, AtTightTolerancesIsThatOfTheReference) {
  for (const char* edge : {"1", "0.7123456"}) {
    const Signals reference = pendulum("rtol: 1e-13, atol: 1e-15", edge);
    for (const char* solver : {"dopri5", "bdf", "adams"}) {
      const Signals r = pendulum(std::string("rtol: 1e-10, atol: 1e-12, solver: ") + solver, edge);
      EXPECT_LT(distance(r, reference), 1e-6) << solver;
      const auto& time = r.recording().time();
      const auto theta = r.column("theta");
      const auto omega = r.column("omega");
      for (std::size_t i = 0; i < time.size(); ++i) {
        // Along straight lines between rows 0.006 s apart the reference is known to a few 1e-5 only.
        EXPECT_NEAR(theta[i], reference.at("theta", time[i]), 1e-4) << solver << " at " << time[i];
      }
    }
  }
}

TEST(S9Accuracy, OfRowsInsideStepsIsThatOfTheSteps) {
  // x'' = -x: rows between the accepted steps come from dense output.
  for (const char* solver : {"dopri5", "bogacki_shampine", "adams", "bdf"}) {
    const Signals r = run(std::string(R"(
blocks:
  x: {type: integrator, in: v}
  v: {type: integrator, in: -x, initial: 1}
record: [x]
simulation: {stop: 10, rtol: 1e-9, atol: 1e-11, solver: )") +
                          solver + "}\n");
    const auto x = r.column("x");
    for (std::size_t i = 0; i < x.size(); ++i)
      ASSERT_NEAR(x[i], std::sin(r.recording().time()[i]), 2e-6) << solver << " at " << r.recording().time()[i];
  }
}

TEST(S9Accuracy, AStiffDiagramTakesFewStepsWithItsExactJacobian) {
  // Van der Pol with mu = 1000 (Hairer, Wanner II, IV.10): x(2000) = 1.7061677321048.
  const Signals r = run(R"(
parameters: {mu: 1000}
blocks:
  x: {type: integrator, in: y, initial: 2}
  y: {type: integrator, in: mu*(1 - x^2)*y - x}
record: [x]
simulation: {stop: 2000, rtol: 1e-8, atol: 1e-10, solver: bdf}
)");
  EXPECT_NEAR(r.last("x"), 1.7061677321048, 1e-5);
  EXPECT_LT(r.whole().statistics.solver.steps, 5000);
  EXPECT_GT(r.whole().statistics.solver.jacobians, 0);
}

TEST(S9Steps, CalledAndUnrolledAgreeToRounding) {
  // A diagram with an event function is stepped by calls, one without in one list.
  const std::string blocks = R"(
blocks:
  x: {type: integrator, in: v, initial: 1}
  v: {type: integrator, in: -sin(x)*4 - 0.2*v}
)";
  const std::string rest = "simulation: {stop: 10, solver: rk4, step: 0.01}\nrecord: [x]\n";
  const Signals in_one_list = run(blocks + rest);
  const Signals by_calls = run(blocks + "  never: {type: integrator, in: 0, reset: {when: x > 50, to: 1}}\n" + rest);
  const auto a = in_one_list.column("x"), b = by_calls.column("x");
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-12);  // a thousand steps of a few roundings
}

}  // namespace
}  // namespace plantloop::testing_diagrams
