// Sources that are drawn from lines and sweeps, against their definitions.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

constexpr double rounding = 1e-12;

TEST(Chirp, SweepsLinearly) {
  // w = 1 + 0.4 t: the angle is t + 0.2 t^2.
  const Signals r = run(R"(
blocks:
  y: {type: chirp, amplitude: 2, frequency: 1, final_frequency: 3, final_time: 5, phase: 0.3, bias: 1}
  difference: y - (1 + 2*sin(0.3 + time + 0.2*time^2))
simulation: {stop: 8}
)");
  EXPECT_LT(r.greatest("difference"), rounding);
}

TEST(Chirp, SweepsByEqualFactors) {
  // w = 2^t: the angle is (2^t - 1)/log 2.
  const Signals r = run(R"(
blocks:
  y: {type: chirp, frequency: 1, final_frequency: 8, final_time: 3, sweep: logarithmic}
  difference: y - sin((2^time - 1)/log(2))
simulation: {stop: 4}
)");
  EXPECT_LT(r.greatest("difference"), rounding);
  EXPECT_THAT(findings("blocks: {y: {type: chirp, frequency: 0, sweep: logarithmic}}\nsimulation: {stop: 1}\n"),
              HasSubstr("two different frequencies greater than 0"));
}

TEST(Sawtooth, RisesAndDrops) {
  const Signals r = run(R"(
blocks:
  saw: {type: sawtooth, amplitude: 2, period: 0.5, delay: 0.25, bias: 1}
  falling: {type: sawtooth, period: 1, width: 0}
  skew: {type: sawtooth, period: 1, width: 0.25}
  x: {type: integrator, in: skew}
simulation: {stop: 2.25}
)");
  EXPECT_EQ(r.at("saw", 0.1), -1);
  EXPECT_NEAR(r.at("saw", 0.75, true), 3, rounding);
  EXPECT_NEAR(r.at("saw", 0.75), -1, rounding);
  EXPECT_NEAR(r.at("falling", 1), 1, rounding);
  EXPECT_NEAR(r.at("falling", 1, true), -1, rounding);
  EXPECT_NEAR(r.at("skew", 0.25), 1, rounding);
  EXPECT_NEAR(r.at("skew", 1), -1, rounding);
  EXPECT_NEAR(r.last("x"), 0, rounding);  // the mean of whole periods and of a rise is 0
  EXPECT_THAT(findings("blocks: {y: {type: sawtooth, period: 1, width: 2}}\nsimulation: {stop: 1}\n"),
              HasSubstr("the width is longer than the period"));
}

TEST(SignalBuilder, JoinsPointsAndJumps) {
  const Signals r = run(R"(
blocks:
  y: {type: signal_builder, times: [1, 2, 2, 4], values: [1, 3, -1, 1]}
  x: {type: integrator, in: y}
  on: {type: signal_builder, times: [1, 2, 4], values: [1, 3, 1], outside: linear}
  off: {type: signal_builder, times: [1, 2], values: [[1, 10], [3, 20]], outside: zero}
simulation: {stop: 5}
)");
  EXPECT_EQ(r.at("y", 0), 1);
  EXPECT_EQ(r.at("y", 2, true), 3);
  EXPECT_EQ(r.at("y", 2), -1);
  EXPECT_NEAR(r.last("x"), 1 + 2 + 0 + 1, rounding);
  EXPECT_NEAR(r.at("on", 0), -1, rounding);
  EXPECT_NEAR(r.last("on"), 0, rounding);
  EXPECT_EQ(r.at("off.2", 0), 0);
  EXPECT_EQ(r.at("off.2", 1), 10);
  EXPECT_EQ(r.last("off.1"), 0);
}

TEST(SignalBuilder, SaysWhatIsWrongWithItsPoints) {
  const auto wrong = [](const std::string& points) {
    return findings("blocks: {y: {type: signal_builder, " + points + "}}\nsimulation: {stop: 1}\n");
  };
  EXPECT_THAT(wrong("times: [0, 2, 1], values: [1, 2, 3]"), HasSubstr("must not descend"));
  EXPECT_THAT(wrong("times: [0, 2], values: [1, 2, 3]"), HasSubstr("2 times need as many values, but there are 3"));
  EXPECT_THAT(wrong("times: 0, values: 1"), HasSubstr("at least two points"));
  EXPECT_THAT(wrong("times: [0, 0, 1], values: [1, 2, 3], outside: linear"), HasSubstr("no jump may stand there"));
}

TEST(RepeatingSequence, BeginsAgainAfterItsLastTime) {
  const Signals r = run(R"(
blocks:
  y: {type: repeating_sequence, times: [0, 0.1, 0.4, 0.5], values: [1, 3, 3, 0]}
  x: {type: integrator, in: y}
simulation: {stop: 500}
)");
  EXPECT_NEAR(r.at("y", 0.05), 2, rounding);
  EXPECT_NEAR(r.at("y", 0.5, true), 0, rounding);
  EXPECT_NEAR(r.at("y", 0.5), 1, rounding);
  // One period has the area 0.2 + 0.9 + 0.15; a thousand of them lose nothing but the rounding of a sum.
  EXPECT_NEAR(r.last("x"), 1250, 1e-8);
  EXPECT_THAT(findings("blocks: {y: {type: repeating_sequence, times: [1, 2], values: [1, 2]}}\n"
                       "simulation: {stop: 1}\n"),
              HasSubstr("the first time of a sequence that repeats is 0"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
