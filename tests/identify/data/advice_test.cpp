// What is said about data with known defects, and that it is not said about good ones.

#include "identify/data/advice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "identify/data/excitation.h"
#include "identify/linear/filter.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using ::testing::Contains;
using ::testing::HasSubstr;

const VectorXd input = staircase(600, 1, 4, -1, 1, 1);

VectorXd respond(const VectorXd& u, int delay = 0) {
  VectorXd B = VectorXd::Zero(delay + 2);
  B[delay + 1] = 0.5;
  return filter(B, Eigen::Vector2d(1, -0.8), u) + white_noise(u.size(), 0.05, 2);
}

TEST(Advice, OnGoodDataNamesTheDelayAndNoDefect) {
  const auto lines = advice(make_data_set(input, respond(input, 3), 0.1));
  ASSERT_EQ(lines.size(), 2U) << ::testing::PrintToString(lines);
  EXPECT_EQ(lines[0], "600 samples of 1 input and 1 output in 1 experiment, one each 0.1 s");
  EXPECT_EQ(lines[1], "'u' acts on 'y' after about 4 samples");
}

TEST(Advice, SeesConstantBinaryAndPoorInputs) {
  EXPECT_THAT(advice(make_data_set(VectorXd::Ones(200), white_noise(200, 1, 1), 1)),
              Contains("'u' does not vary: its effect cannot be identified; leave it out"));
  const VectorXd binary = prbs(9);
  EXPECT_THAT(advice(make_data_set(binary, respond(binary), 1)), Contains(HasSubstr("'u' has two levels")));
  const VectorXd sine = chirp(500, 1, 0.3, 0.3, 1);
  EXPECT_THAT(advice(make_data_set(sine, respond(sine), 1)), Contains(HasSubstr("'u' excites only 2 parameters")));
}

TEST(Advice, SeesLimitsOutliersDriftAndGaps) {
  VectorXd y = respond(input);
  EXPECT_THAT(advice(make_data_set(input, y.cwiseMin(0.5), 1)),
              Contains(HasSubstr("'y' stays at its greatest value 0.5")));
  VectorXd spoiled = y;
  spoiled[300] += 30;
  EXPECT_THAT(advice(make_data_set(input, spoiled, 1)), Contains(HasSubstr("stand far from their neighbours")));
  EXPECT_THAT(advice(make_data_set(input, y + VectorXd::LinSpaced(600, 0, 20), 1)), Contains(HasSubstr("'y' drifts")));
  y[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(advice(make_data_set(input, y, 1)), Contains(HasSubstr("1 value is missing")));
}

TEST(Advice, FindsLongDelays) {
  const VectorXd long_input = staircase(2000, 1, 4, -1, 1, 5);
  EXPECT_THAT(advice(make_data_set(long_input, respond(long_input, 69), 0.1)),
              Contains("'u' acts on 'y' after about 70 samples"));
  // None is made up where there is no effect at all.
  EXPECT_THAT(advice(make_data_set(long_input, white_noise(2000, 1, 11), 0.1)),
              Contains("no effect of 'u' on 'y' is seen within 240 samples"));
}

TEST(Advice, SeesOffsetsAndInputsThatAreOne) {
  EXPECT_THAT(advice(make_data_set(input, respond(input).array() + 100, 1)),
              Contains(HasSubstr("a linear model needs a constant for that, offset = true")));
  Eigen::MatrixXd both(600, 2);
  both << input, -2 * input;
  EXPECT_THAT(
      advice(make_data_set(both, respond(input), 1)),
      Contains("'u1' and 'u2' carry the same signal: their effects cannot be told apart; leave one of them out"));
}

TEST(Advice, ARampHasNoTimeConstant) {
  const auto lines = advice(make_data_set(prbs(8, 1, 1, 200), VectorXd::LinSpaced(200, 16777217, 16777416), 1));
  EXPECT_THAT(lines, Contains(HasSubstr("'y' integrates or drifts"))) << ::testing::PrintToString(lines);
  EXPECT_THAT(lines, Not(Contains(HasSubstr("keep every"))));
}

TEST(Advice, SeesFastSamplingAndFeedback) {
  const VectorXd slow = staircase(3000, 300, 600, -1, 1, 3);
  const VectorXd y = filter(Eigen::Vector2d(0, 0.005), Eigen::Vector2d(1, -0.995), slow) + white_noise(3000, 1e-4, 1);
  EXPECT_THAT(advice(make_data_set(slow, y, 0.01)), Contains(HasSubstr("'y' is sampled fast")));
  // u(k) = -0.6 y(k-1) + r(k)
  const VectorXd r = white_noise(1000, 0.5, 7);
  const VectorXd e = white_noise(1000, 0.5, 8);
  VectorXd u = VectorXd::Zero(1000);
  VectorXd closed = VectorXd::Zero(1000);
  for (Index k = 1; k < 1000; ++k) {
    closed[k] = 0.8 * closed[k - 1] + 0.5 * u[k - 1] + e[k];
    u[k] = r[k] - 0.6 * closed[k];
  }
  EXPECT_THAT(advice(make_data_set(u, closed, 1)), Contains(HasSubstr("the data come from a closed loop")));
  for (Index k = 2; k < 1000; ++k) {
    closed[k] = 0.8 * closed[k - 1] + 0.5 * u[k - 1] + e[k];
    u[k] = r[k] - 0.6 * closed[k - 1];
  }
  EXPECT_THAT(advice(make_data_set(u, closed, 1)), Contains(HasSubstr("'u' follows what 'y' did before")));
}

TEST(ExcitationOrder, IsTwoForEachSine) {
  const VectorXd one = chirp(400, 1, 0.5, 0.5, 1);
  const VectorXd two = one + chirp(400, 1, 1.3, 1.3, 1);
  EXPECT_EQ(excitation_order(make_data_set(one, one, 1), 0, 12), 2);
  EXPECT_EQ(excitation_order(make_data_set(two, two, 1), 0, 12), 4);
  EXPECT_EQ(excitation_order(make_data_set(prbs(8), prbs(8), 1), 0, 12), 12);
}

}  // namespace
}  // namespace plantloop::identify
