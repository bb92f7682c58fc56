// What learns while it runs, against the least-squares solution of all samples and against geometric series.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using testing::HasSubstr;

// The estimate minimises sum lambda^(N-k) (y_k - phi_k theta)^2 + lambda^N (theta - theta_0)^2/P_0.
TEST(RecursiveLeastSquares, MinimisesTheWeightedSumOfSquares) {
  const Signals r = run(R"(
blocks:
  phi: {type: white_noise, rate: 1, deviation: 2}
  y: {type: white_noise, rate: 1, mean: 0.3}
  one: {type: recursive_least_squares, in: {y: y, phi: phi}, forgetting: 0.9, P: 5, initial: 0.7}
  two: {type: recursive_least_squares, in: {y: y, phi: "[phi, 1]"}, forgetting: 0.9, P: "[5, 2]", initial: "[0.7, -1]"}
simulation: {stop: 25}
)");
  const auto phi = r.samples("phi"), y = r.samples("y"), theta = r.samples("one.theta"), P = r.samples("one.P");
  const auto theta_1 = r.samples("two.theta.1"), theta_2 = r.samples("two.theta.2");
  ASSERT_EQ(phi.size(), 26u);
  double square = 1 / 5.0, cross = 0.7 / 5.0;
  double a = 1 / 5.0, b = 0, c = 1 / 2.0, u = 0.7 / 5.0, v = -1 / 2.0;
  for (std::size_t k = 0; k < phi.size(); ++k) {
    square = 0.9 * square + phi[k] * phi[k];
    cross = 0.9 * cross + phi[k] * y[k];
    EXPECT_NEAR(theta[k], cross / square, 1e-12) << k;
    EXPECT_NEAR(P[k], 1 / square, 1e-12) << k;
    a = 0.9 * a + phi[k] * phi[k], b = 0.9 * b + phi[k], c = 0.9 * c + 1;
    u = 0.9 * u + phi[k] * y[k], v = 0.9 * v + y[k];
    EXPECT_NEAR(theta_1[k], (c * u - b * v) / (a * c - b * b), 1e-11) << k;
    EXPECT_NEAR(theta_2[k], (a * v - b * u) / (a * c - b * b), 1e-11) << k;
  }
}

TEST(RecursiveLeastSquares, ForgetsNothingWhileItsVarianceWouldExceedTheLimit) {
  const Signals r = run(R"(
blocks:
  phi: {type: staircase, times: [0, 5], values: [1, 0]}
  free: {type: recursive_least_squares, in: {y: phi, phi: phi}, forgetting: 0.5, P: 10, rate: 1}
  bounded: {type: recursive_least_squares, in: {y: phi, phi: phi}, forgetting: 0.5, P: 10, rate: 1, max_trace: 10}
simulation: {stop: 30}
)");
  EXPECT_GT(r.last("free.P"), 1e6);
  const auto P = r.samples("bounded.P");
  EXPECT_LE(*std::max_element(P.begin(), P.end()), 10);
  EXPECT_GT(r.last("bounded.P"), 5);
}

TEST(RecursiveLeastSquares, LearnsNothingFromErrorsWithinTheDeadZone) {
  const Signals r = run(R"(
blocks:
  y: {type: staircase, times: [0, 5], values: [0.2, 0.4]}
  c: {type: recursive_least_squares, in: {y: y, phi: 1}, dead_zone: 0.3, rate: 1}
simulation: {stop: 10}
)");
  EXPECT_EQ(r.at("c.theta", 4.5), 0);
  EXPECT_NEAR(r.at("c.theta", 5.5), 0.4, 1e-4);  // of 1/P = 1e-4
}

TEST(RecursiveLeastSquares, SaysWhatDoesNotFit) {
  EXPECT_THAT(findings("blocks: {c: {type: recursive_least_squares, in: {y: 1, phi: [1, 2, 3]}, initial: [1, 2], rate: "
                       "1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("initial must have 3 elements, one for each regressor, but it is a vector of 2"));
  EXPECT_THAT(findings("blocks: {c: {type: recursive_least_squares, in: {y: 1, phi: [1, 2, 3]}, P: [1, 2], rate: 1}}\n"
                       "simulation: {stop: 1}\n"),
              HasSubstr("P must be 3 by 3, its diagonal or one number, but it is a vector of 2"));
}

TEST(DeltaRule, MakesTheErrorAGeometricSeries) {
  // With a constant phi: normalised, the error is (1 - rate)^k of the first; plain, (1 - rate phi^2)^k.
  const Signals r = run(R"(
blocks:
  a: {type: delta_rule, in: {y: 6, phi: 2}, learning_rate: 0.3, offset: 0, rate: 1}
  b: {type: delta_rule, in: {y: 6, phi: 2}, learning_rate: 0.1, step: plain, rate: 1}
  c: {type: delta_rule, in: {y: 6, phi: 2}, learning_rate: 0.3, offset: 0, upper: 2, rate: 1}
  d: {type: delta_rule, in: {y: 6, phi: 2}, learning_rate: 0.3, offset: 0, dead_zone: 1, rate: 1}
  still: {type: delta_rule, in: {y: 6, phi: 0}, offset: 0, initial: 5, rate: 1}
simulation: {stop: 12}
)");
  const auto a = r.samples("a.error"), b = r.samples("b.error"), c = r.samples("c.w"), d = r.samples("d.error");
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_NEAR(a[k], 6 * std::pow(0.7, k), 1e-12);
    EXPECT_NEAR(b[k], 6 * std::pow(0.6, k), 1e-12);
    EXPECT_NEAR(c[k], std::min(2.0, 3 - 3 * std::pow(0.7, k)), 1e-12);
    EXPECT_NEAR(d[k], 6 * std::pow(0.7, std::min<std::size_t>(k, 6)), 1e-12);  // 6 * 0.7^6 is the first below 1
  }
  EXPECT_EQ(r.last("still.w"), 5);
}

// A network of fixed basis functions learns a function of its input: y = sin(u) on 9 Gaussians.
TEST(DeltaRule, TeachesANetworkOfBasisFunctions) {
  const Signals r = run(R"(
blocks:
  u: {type: white_noise, rate: 1, deviation: 1.5, seed: 3}
  at: clamp(u, -3, 3)
  basis: {type: gaussian_weights, in: at, centres: "[-3, -2.25, -1.5, -0.75, 0, 0.75, 1.5, 2.25, 3]", widths: 0.6}
  net: {type: delta_rule, in: {y: sin(at), phi: basis}, learning_rate: 1, rate: 1}
simulation: {stop: 3000}
)");
  const auto errors = r.samples("net.error");
  double late = 0;
  for (std::size_t k = 2500; k < errors.size(); ++k) late = std::max(late, std::abs(errors[k]));
  EXPECT_LT(late, 0.05);
}

TEST(DeltaRule, SaysWhatDoesNotFit) {
  EXPECT_THAT(findings("blocks: {c: {type: delta_rule, in: {y: 1, phi: [1, 2, 3]}, initial: [1, 2], rate: 1}}\n"
                       "simulation: {stop: 1}\n"),
              HasSubstr("initial must have 3 elements, one for each regressor, but it is a vector of 2"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
