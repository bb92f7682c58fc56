// S10: events that follow each other without end, and long chains of events against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string ball(const std::string& policy) {
  return R"yaml(
parameters: {g: 9.81, c: 0.8, h0: 1}
blocks:
  h: {type: integrator, in: v, initial: h0, reset: {when: h <= 0, to: 0}}
  v: {type: integrator, in: -g, initial: 0, reset: {when: h <= 0, to: -c*v}}
simulation: {stop: 10, rtol: 1e-9, atol: 1e-11, max_step: 0.1, zeno: )yaml" +
         policy + "}\nrecord: [h, v]\n";
}

// Of the ball: falls in t1, and bounces c^k as long.
double time_of_bounce(int n) {
  const double t1 = std::sqrt(2 / 9.81);
  double t = t1, flight = 2 * t1;
  for (int k = 1; k < n; ++k) t += flight *= 0.8;
  return t;
}

TEST(S10Zeno, OfABallEndsTheRunWhereItsBouncesAccumulate) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1" + ball("error"), "test.yaml", report);
  ASSERT_TRUE(diagram) << to_text(report);
  DiagramRun partial;
  try {
    diagram->run({}, report, {}, &partial);
    FAIL() << "the run ends";
  } catch (const RunError& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("events follow each other without end: h.reset"), HasSubstr("zeno: hold")));
    EXPECT_NEAR(e.time(), std::sqrt(2 / 9.81) * (1 + 2 * 0.8 / 0.2), 1e-7);
  }
  const auto& bounces = partial.recording.events.at("h.reset");
  ASSERT_GT(bounces.size(), 60u);
  for (int n = 1; n <= 60; ++n) EXPECT_NEAR(bounces[static_cast<std::size_t>(n) - 1], time_of_bounce(n), 1e-9) << n;
}

TEST(S10Zeno, IsHeldOnRequestSoThatTheBallRests) {
  const Signals r = run(ball("hold"));
  EXPECT_EQ(r.recording().time().back(), 10);
  EXPECT_EQ(r.last("h"), 0);
  EXPECT_NEAR(r.last("v"), 0, 1e-9);
  ASSERT_FALSE(r.whole().statistics.warnings.empty());
  EXPECT_THAT(r.whole().statistics.warnings.front(),
              AllOf(HasSubstr("h.reset"), HasSubstr("stands still until the next event of something else")));
}

TEST(S10Zeno, IsIgnoredOnRequestForTheTimeBetweenRows) {
  const Signals r = run(ball("ignore"));
  EXPECT_EQ(r.recording().time().back(), 10);
  // Unseen for 0.02 s at a time the ball falls by g/2 (0.02 s)^2 at most.
  EXPECT_LT(std::fabs(r.last("h")), 0.01);
  EXPECT_THAT(r.whole().statistics.warnings.front(), HasSubstr("it is not looked at for 0.02 s"));
}

TEST(S10Events, OfARelayLoopRepeatWithThePeriodOfItsLimitCycle) {
  // x' = -x + u, u = -1 above 0.5 until below -0.5: half a period is ln((1 + 0.5)/(1 - 0.5)) = ln 3.
  const Signals r = run(R"yaml(
blocks:
  u: {type: relay, in: x, on: 0.5, off: -0.5, on_value: -1, off_value: 1}
  x: {type: first_order, in: u, initial: 0}
  count: {type: integrator, in: 0, reset: {when: x >= 0.5, to: 1}}
simulation: {stop: 20, rtol: 1e-11, atol: 1e-13}
record: [x]
)yaml");
  const auto& ups = r.recording().events.at("count.reset");
  ASSERT_GE(ups.size(), 8u);
  for (std::size_t k = 0; k < ups.size(); ++k)
    EXPECT_NEAR(ups[k], std::numbers::ln2 + 2 * static_cast<double>(k) * std::log(3.0), 1e-9) << k;
}

TEST(S10Events, OfStickSlipStandWhereTheSpringBreaksTheStaticFriction) {
  // A block on a belt of speed 1, held by a spring: it goes with the belt until the spring's x = 1.5 breaks static
  // friction, and slides against a friction of 1 from then on: x = 1 + 0.5 cos(s) + sin(s), s the time since.
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: "where(loose > 0.5, v, 1)"}
  v: {type: integrator, in: "where(loose > 0.5, 1 - x, 0)", initial: 1}
  loose: {type: relay, in: x, on: 1.5, off: 0.5, on_value: 1, off_value: 0}
simulation: {stop: 6, rtol: 1e-11, atol: 1e-13}
expect: [{signal: x, at: 3, value: 0}]
)yaml");
  const double s = 1.5;
  EXPECT_NEAR(r.sampled("x", 3), 1 + 0.5 * std::cos(s) + std::sin(s), 1e-9);
}

TEST(S10Events, OfPulseWidthModulationStandWhereTheSawtoothMeetsTheSignal) {
  // A carrier of period 0.1 s against 0.25 + 0.5 t/1 s: the pulse of period k ends at (k/10 + 0.025)/(1 - 0.05).
  const Signals r = run(R"yaml(
blocks:
  carrier: 10*mod(time, 0.1)
  level: 0.25 + 0.5*time
  pulse: where(carrier < level, 1, 0)
  x: {type: integrator, in: pulse, reset: {when: carrier > level, to: x}}
simulation: {stop: 1, rtol: 1e-10}
record: [x]
)yaml");
  const auto& ends = r.recording().events.at("x.reset");
  ASSERT_EQ(ends.size(), 10u);
  for (std::size_t k = 0; k < ends.size(); ++k)
    EXPECT_NEAR(ends[k], (static_cast<double>(k) / 10 + 0.025) / (1 - 0.05), 1e-9) << k;
}

TEST(S10Events, OfACascadeAllHappenAtOneInstant) {
  // The first reset moves x across the threshold of the second, that one y across the threshold of the third.
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: 1, reset: {when: x >= 1, to: 5}}
  y: {type: integrator, in: 0, reset: {when: x >= 4, to: 7}}
  z: {type: integrator, in: 0, reset: {when: y >= 6, to: 9}}
simulation: {stop: 2}
)yaml");
  EXPECT_THAT(r.recording().events.at("x.reset"), ElementsAre(r.recording().events.at("y.reset").front()));
  EXPECT_THAT(r.recording().events.at("z.reset"), ElementsAre(r.recording().events.at("y.reset").front()));
  EXPECT_NEAR(r.recording().events.at("z.reset").front(), 1, 1e-11);
  EXPECT_EQ(r.last("z"), 9);
}

TEST(S9Edges, OfAPulseOfAMicrosecondAreSeenInAStepOfAThousandSeconds) {
  const Signals r = run(R"yaml(
blocks:
  u: {type: pulse, amplitude: 1e6, period: 5000, width: 1e-6, delay: 1234.5}
  x: {type: integrator, in: u}
simulation: {stop: 4000}
)yaml");
  EXPECT_NEAR(r.last("x"), 1, 1e-6);  // the width as two doubles near 1234.5 has it
}

}  // namespace
}  // namespace plantloop::testing_diagrams
