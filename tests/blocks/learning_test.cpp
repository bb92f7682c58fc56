// Networks that learn while the plant runs, against least squares and against plants that drift.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using testing::HasSubstr;

double rms(const std::vector<double>& x, std::size_t from) {
  double sum = 0;
  for (std::size_t k = from; k < x.size(); ++k) sum += x[k] * x[k];
  return std::sqrt(sum / static_cast<double>(x.size() - from));
}

// Where the network is linear in what it learns, the weights minimise sum lambda^(N-k) (y_k - psi_k' w)^2 + lambda^N
// |w|^2/P over all samples; here from the normal equations.
TEST(RecursiveGaussNewton, IsLeastSquaresWhereTheNetworkIsLinearInItsWeights) {
  const Signals r = run(R"(
blocks:
  u: {type: random_levels, lower: -1, upper: 1, rate: 1}
  y: {type: white_noise, rate: 1, mean: 0.3}
  net: {type: recursive_gauss_newton, network: rbf, in: {y: y, x: u}, centres: [-0.7, 0.6], widths: [0.5, 0.8],
        forgetting: 0.95, P: 7}
simulation: {stop: 60}
)");
  const auto u = r.samples("u"), y = r.samples("y"), trace = r.samples("net.trace");
  std::vector<std::vector<double>> w;
  for (const char* name : {"net.w.1", "net.w.2", "net.w.3"}) w.push_back(r.samples(name));
  double A[3][3] = {{1 / 7.0, 0, 0}, {0, 1 / 7.0, 0}, {0, 0, 1 / 7.0}}, b[3] = {0, 0, 0};
  for (std::size_t k = 0; k + 1 < u.size(); ++k) {
    const double psi[3] = {std::exp(-(u[k] + 0.7) * (u[k] + 0.7) / 0.5), std::exp(-(u[k] - 0.6) * (u[k] - 0.6) / 1.28),
                           1};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) A[i][j] = 0.95 * A[i][j] + psi[i] * psi[j];
      b[i] = 0.95 * b[i] + psi[i] * y[k];
    }
    // The solution of A x = b, and the trace of A's inverse, by cofactors.
    const auto minor = [&](int i, int j) {
      const int a = (i + 1) % 3, c = (i + 2) % 3, d = (j + 1) % 3, f = (j + 2) % 3;
      return A[a][d] * A[c][f] - A[a][f] * A[c][d];
    };
    const double det = A[0][0] * minor(0, 0) + A[0][1] * minor(0, 1) + A[0][2] * minor(0, 2);
    for (std::size_t i = 0; i < 3; ++i) {
      double x = 0;
      for (int j = 0; j < 3; ++j) x += minor(j, static_cast<int>(i)) * b[j] / det;
      EXPECT_NEAR(w[i][k + 1], x, 1e-9) << k;
    }
    EXPECT_NEAR(trace[k + 1], (minor(0, 0) + minor(1, 1) + minor(2, 2)) / det, 1e-9) << k;
  }
}

TEST(RecursiveGaussNewton, LearnsTheOutputWeightsOfAPerceptronAsLeastSquaresDoes) {
  const Signals r = run(R"(
blocks:
  u: {type: random_levels, lower: -2, upper: 2, rate: 1}
  y: sin(u)
  net: {type: recursive_gauss_newton, in: {y: y, x: u}, hidden: 2, learned: output, initial: [0, 0, 0, 1.5, -1, 0.8, 0.4],
        P: 50}
  rls: {type: recursive_least_squares, in: {y: y, phi: "[tanh(1.5*u - 1), tanh(0.8*u + 0.4), 1]"}, P: 50}
simulation: {stop: 80}
)");
  for (int i = 1; i <= 3; ++i) {
    const auto net = r.samples("net.w." + std::to_string(i)), rls = r.samples("rls.theta." + std::to_string(i));
    for (std::size_t k = 0; k + 1 < net.size(); ++k) EXPECT_NEAR(net[k + 1], rls[k], 1e-9) << k;
  }
  EXPECT_EQ(r.last("net.w.4"), 1.5);
}

// y(k+1) = 0.6 y(k) + g tanh(2 u(k)), whose gain g drifts by a factor of three: with forgetting the network follows,
// without it does not.
TEST(RecursiveGaussNewton, FollowsAPlantThatDrifts) {
  const Signals r = run(R"(
blocks:
  u: {type: random_levels, lower: -1, upper: 1, hold: 2, rate: 1}
  g: {type: ramp, slope: 0.001, initial: 0.5, rate: 1}
  y: {type: unit_delay, in: 0.6*y + g*tanh(2*u), rate: 1}
  before: {type: unit_delay, in: "[y, u]", initial: [0, 0], rate: 1}
  forgets: {type: recursive_gauss_newton, in: {y: y, x: before}, hidden: 4, forgetting: 0.98, max_trace: 5000}
  keeps: {type: recursive_gauss_newton, in: {y: y, x: before}, hidden: 4}
simulation: {stop: 1000}
)");
  const auto forgets = r.samples("forgets.error"), keeps = r.samples("keeps.error"), y = r.samples("y");
  EXPECT_LT(rms(forgets, 700), 0.03 * rms(y, 700));
  EXPECT_GT(rms(keeps, 700), 2 * rms(forgets, 700));
}

TEST(RecursiveGaussNewton, RestsWhereNothingExcitesIt) {
  // From 100 s on the inputs stand still. Without a safeguard the trace of P grows as forgetting^-k.
  const Signals r = run(R"(
blocks:
  level: {type: random_levels, lower: -1, upper: 1, rate: 1}
  u: where(time < 100, level, 0.2)
  y: u^2
  free: {type: recursive_gauss_newton, in: {y: y, x: u}, hidden: 3, forgetting: 0.9, rate: 1}
  bounded: {type: recursive_gauss_newton, in: {y: y, x: u}, hidden: 3, forgetting: 0.9, max_trace: 2000, rate: 1}
  frozen: {type: recursive_gauss_newton, in: {y: y, x: u}, hidden: 3, forgetting: 0.9, min_information: 0.12, rate: 1}
  awake: {type: recursive_gauss_newton, in: {y: y, x: u}, hidden: 3, min_trace: 50, rate: 1}
  kept: {type: recursive_gauss_newton, in: {y: y, x: u}, hidden: 3, lower: -0.4, upper: 0.3, rate: 1}
  zone: {type: recursive_gauss_newton, in: {y: y, x: u}, hidden: 3, dead_zone: 10, rate: 1}
simulation: {stop: 400}
)");
  EXPECT_GT(r.last("free.trace"), 1e6);
  const auto bounded = r.samples("bounded.trace"), frozen = r.samples("frozen.trace");
  EXPECT_LE(*std::max_element(bounded.begin(), bounded.end()), 2000 * (1 + 1e-12));
  EXPECT_EQ(frozen.back(), frozen[150]);
  const auto awake = r.samples("awake.trace");
  EXPECT_GE(*std::min_element(awake.begin(), awake.end()), 50 * (1 - 1e-12));
  for (int i = 1; i <= 10; ++i) {
    for (const double w : r.samples("kept.w." + std::to_string(i))) {
      EXPECT_LE(w, 0.3);
      EXPECT_GE(w, -0.4);
    }
    const auto zone = r.samples("zone.w." + std::to_string(i));
    EXPECT_EQ(zone.front(), zone.back());
  }
}

TEST(RecursiveGaussNewton, AnswersAtOtherInputs) {
  const Signals r = run(R"(
blocks:
  net: {type: recursive_gauss_newton, in: {y: 0, x: 1, x_ahead: "-0.5"}, hidden: 1, initial: [2, 0.3, 0.7, -0.1], rate: 1}
simulation: {stop: 0.5}
)");
  EXPECT_NEAR(r.at("net.fitted", 0), 2 * std::tanh(0.6) + 0.3, 1e-15);
  EXPECT_NEAR(r.at("net.ahead", 0), 2 * std::tanh(-0.45) + 0.3, 1e-15);
}

TEST(RecursiveGaussNewton, SaysWhatDoesNotFit) {
  const auto about = [](const std::string& keys) {
    return findings("blocks: {c: {type: recursive_gauss_newton, in: {y: 1, x: [1, 2]}, rate: 1, " + keys +
                    "}}\nsimulation: {stop: 1}\n");
  };
  EXPECT_THAT(about("hidden: 2, initial: [1, 2]"),
              HasSubstr("initial must have 9 elements, one for each weight, but it is a vector of 2"));
  EXPECT_THAT(about("hidden: 100"), HasSubstr("401 weights are learned at once, at most 200 can be"));
  EXPECT_THAT(about("network: rbf"), HasSubstr("network rbf needs 'centres', a row of numbers for each function"));
  EXPECT_THAT(about("centres: [[1, 2]]"), HasSubstr("network mlp has no centres"));
  EXPECT_THAT(about("network: rbf, centres: [1, 2, 3]"),
              HasSubstr("centres must have a row of 2 numbers for each function, as x has, but it is a vector of 3"));
  EXPECT_THAT(about("network: rbf, centres: [[1, 2]], widths: [1, 2, 3]"),
              HasSubstr("widths must be one number or one for each of the 1 functions, but it is a vector of 3"));
  EXPECT_THAT(about("min_trace: 5, max_trace: 4"), HasSubstr("it must not be greater than 'max_trace'"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
