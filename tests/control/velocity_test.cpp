// Velocity-form models as blocks, and what the velocity form is for: gains that change do not move the control signal.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

TEST(VelocityModel, IsTheLagOfTheFilteredInput) {
  // w' = -2 w + 2 ud, y' = w: y follows uf with the time constant 0.5, and uf follows the step with 1/N.
  const Signals r =
      run("blocks:\n"
          "  u: {type: step, time: 0.5, before: 0, after: 3}\n"
          "  y: {type: velocity_model, model: tests/blocks/models/velocity_model.yaml, in: u, point: 2, N: 40}\n"
          "  uf: {type: first_order, in: u, tau: 1/40}\n"
          "  lag: {type: first_order, in: uf, tau: 0.5}\n"
          "  error: y - lag\n"
          "simulation: {stop: 4, rtol: 1e-9}\nrecord: [error, y]\n");
  EXPECT_LT(r.greatest("error"), 1e-7);
  EXPECT_NEAR(r.last("y"), 3, 1e-2);
}

TEST(VelocityBlend, DividesItsWeightsByTheirSum) {
  const auto last = [](const std::string& weights) {
    return run("blocks:\n  y: {type: velocity_blend, model: tests/blocks/models/velocity_blend.yaml, in: {u: "
               "sin(time), "
               "weights: " +
               weights + "}}\nsimulation: {stop: 3, rtol: 1e-9}\nrecord: [y]\n")
        .last("y");
  };
  EXPECT_NEAR(last("[1, 3]"), last("[0.25, 0.75]"), 1e-9);
  EXPECT_GT(std::abs(last("[1, 0]") - last("[0, 1]")), 0.01);
}

TEST(VelocityForm, GainsThatJumpDoNotMoveTheControlSignal) {
  // A conventional and a velocity controller with equal gains, which are doubled at 2 s while the error is not 0.
  const Signals r =
      run("blocks:\n"
          "  gain: {type: step, time: 2, before: 1, after: 2}\n"
          "  e: 1 + 0.3*sin(3*time)\n"
          "  conventional: {type: pi, in: {e: e, kp: 4*gain, ki: gain}}\n"
          "  velocity: {type: velocity_pi, in: {e: e, k0: 4*gain, k1: gain}, p: 200}\n"
          "simulation: {stop: 4, rtol: 1e-9}\nrecord: [e, conventional, velocity]\n");
  const double error = r.at("e", 2);
  EXPECT_NEAR(r.at("conventional", 2) - r.at("conventional", 2, true), 4 * error, 1e-6);
  EXPECT_NEAR(r.at("velocity", 2) - r.at("velocity", 2, true), 0, 1e-12);
}

// A sampled system of two states and two points; at the second one the gain is doubled.
constexpr const char* sampled_family = "tests/control/models/sampled_family.yaml";

TEST(SampledVelocityModel, OfALinearSystemIsExactAtEverySample) {
  // Other start values, filters and inputs; a start that is no rest is told by what the first sample changes.
  const double starts[][3] = {{0, 0, 0}, {0.7, -1.3, 0.4}, {-5, 2, -1}};  // states, and the input before the start
  for (const auto& [x1, x2, u0] : starts) {
    for (const char* N : {"200", "400"}) {
      const Signals r = run(fmt::format(
          "blocks:\n"
          "  u: {{type: random_levels, lower: -2, upper: 3, seed: 99, generator: lcg, rate: 0.25}}\n"
          "  x: {{type: discrete_state_space, in: u, A: [[0.9, 0.2], [-0.3, 0.6]], B: [1, 0.5], C: [[1, 0], [0, 1]], "
          "rate: 0.25, initial: [{0}, {1}]}}\n"
          "  y: 2*x.1 - x.2\n"
          // The change of the first sample, with the input as it was before the start.
          "  v: {{type: velocity_model, model: {4}, in: u, N: {3}, initial: 2*{0} - {1}, initial_input: {2}, "
          "initial_rates: [0.9*{0} + 0.2*{1} + {2} - {0}, -0.3*{0} + 0.6*{1} + 0.5*{2} - {1}]}}\n"
          "  error: {{type: zero_order_hold, in: v - y, rate: {{period: 0.25, offset: 0.2499}}}}\n"
          "simulation: {{stop: 20, rtol: 1e-10, atol: 1e-12}}\nrecord: [error, y]\n",
          x1, x2, u0, N, sampled_family));
      // exp(-50) at most is left of the filter; what is seen is the solver's error in the dead time's past.
      EXPECT_LT(r.greatest("error"), 1e-6) << x1 << " " << N;
      EXPECT_GT(r.greatest("y"), 5);
    }
  }
}

TEST(SampledVelocityBlend, WeighsTheMatricesOfTheInputByWeightsOfTheirOwn) {
  // Only B differs between the points: 1 and 2 times. Weights 0.25, 0.75 for it make 1.75.
  const Signals r =
      run(fmt::format("blocks:\n"
                      "  u: {{type: square, amplitude: 2, period: 3}}\n"
                      "  one: {{type: velocity_model, model: {0}, in: u, point: 1, initial: 0}}\n"
                      "  blend: {{type: velocity_blend, model: {0}, in: {{u: u, weights: [1, 0], input_weights: [1, "
                      "3]}}, initial: 0}}\n"
                      "  same: {{type: velocity_blend, model: {0}, in: {{u: u, weights: [1, 3]}}, initial: 0}}\n"
                      "  error: blend - 1.75*one\n  other: blend - same\n"
                      "simulation: {{stop: 9, rtol: 1e-9}}\nrecord: [error, other, one]\n",
                      sampled_family));
  EXPECT_LT(r.greatest("error"), 1e-6);
  EXPECT_LT(r.greatest("other"), 1e-6);
  EXPECT_GT(r.greatest("one"), 1);
}

TEST(VelocityBlend, SaysWhatDoesNotFit) {
  EXPECT_THAT(
      findings("blocks:\n  y: {type: velocity_blend, model: tests/blocks/models/velocity_blend.yaml, in: {u: 1, "
               "weights: [1, 2, 3]}}\nsimulation: {stop: 1}\n"),
      HasSubstr("the file has 2 points, but there are 3 weights"));
  EXPECT_THAT(
      findings("blocks:\n  y: {type: velocity_model, model: tests/blocks/models/velocity_model.yaml, in: 1, point: 3}\n"
               "simulation: {stop: 1}\n"),
      HasSubstr("the file has 2 points, there is no number 3"));
  EXPECT_THAT(
      findings(
          "blocks:\n  y: {type: velocity_model, model: tests/blocks/models/narx.yaml, in: 1}\nsimulation: {stop: 1}\n"),
      HasSubstr("a model of type 'mlp' is no velocity_family"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
