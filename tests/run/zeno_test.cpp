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

// Only its speed is set where it is below the floor: the last bounces are shorter than two instants can be told apart.
std::string simple_ball(const std::string& more) {
  return R"yaml(
parameters: {c: 0.5, h0: 1, ground: 0}
blocks:
  h: {type: integrator, in: v, initial: ground + h0}
  v: {type: integrator, in: -9.81, reset: {when: h < ground, to: -c*v}}
simulation: {stop: 5, )yaml" +
         more + "}\nrecord: [h, v]\n";
}

std::string with(std::string text, const std::string& what, const std::string& by) {
  return text.replace(text.find(what), what.size(), by);
}

TEST(S10Zeno, OfABallWithBouncesTooShortToBeSeenEndsTheRun) {
  for (const char* how : {"rtol: 1e-6", "solver: bdf", "solver: adams", "solver: ida", "solver: rk4, step: 0.013",
                          "rtol: 1e-9, max_step: 0.01"}) {
    Report report;
    const auto diagram = Diagram::from_text("plantloop: 1" + simple_ball(how), "test.yaml", report);
    ASSERT_TRUE(diagram) << to_text(report);
    try {
      diagram->run({}, report);
      FAIL() << "the run ends: " << how;
    } catch (const RunError& e) {
      EXPECT_THAT(e.what(), HasSubstr("events follow each other without end: v.reset")) << how;
      EXPECT_NEAR(e.time(), 3 * std::sqrt(2 / 9.81), std::string(how).find("solver: ") == 0 ? 1e-3 : 1e-6)
          << how;  // t1 (1 + 2 (1/2 + 1/4 + ...))
    }
  }
}

TEST(S10Zeno, OfABallThatRestsLeavesItOnTheFloor) {
  for (const char* c : {"c: 0.1", "c: 0.3", "c: 0.5", "c: 0.8", "c: 0.9", "c: 0.95"}) {
    for (const char* condition : {"h < ground", "h <= ground", "ground > h"}) {
      for (const char* height : {"ground: 0", "ground: 1", "ground: -3"}) {
        std::string text = with(with(simple_ball("zeno: hold"), "c: 0.5", c), "h < ground", condition);
        const Signals r = run(with(with(text, "ground: 0", height), "stop: 5", "stop: 30"));
        const double ground = std::stod(height + 8);
        // Beside a number the height is rounded: the last speed that is seen is sqrt(2 g eps), and what is held drifts.
        const double near = ground == 0 ? 1e-6 : 1e-5;
        EXPECT_NEAR(r.last("h"), ground, near) << c << ' ' << condition << ' ' << height;
        EXPECT_NEAR(r.last("v"), 0, 1e-6);
        for (const double h : r.column("h")) ASSERT_GT(h, ground - near);
        EXPECT_EQ(r.whole().statistics.warnings.size(), 1u);
      }
    }
  }
}

TEST(S10Zeno, OfABallThatRestsIsHeldByEverySolver) {
  for (const char* solver : {"dopri5", "bogacki_shampine", "bdf", "adams", "ida", "rk4, step: 0.05"}) {
    for (const char* c : {"c: 0.2", "c: 0.5", "c: 0.8"}) {
      const std::string how = std::string("zeno: hold, solver: ") + solver;
      const Signals r = run(with(with(simple_ball(how), "c: 0.5", c), "stop: 5", "stop: 10"));
      EXPECT_NEAR(r.last("h"), 0, 1e-6) << solver << ' ' << c;
      EXPECT_NEAR(r.last("v"), 0, 1e-12) << solver << ' ' << c;  // the limit of v, -c v, c^2 v, ...
    }
  }
}

TEST(S10Zeno, OfOneBallIsHeldWhileAnotherBounces) {
  const Signals r = run(R"yaml(
blocks:
  h1: {type: integrator, in: v1, initial: 1}
  v1: {type: integrator, in: -9.81, reset: {when: h1 < 0, to: -0.5*v1}}
  h2: {type: integrator, in: v2, initial: 2}
  v2: {type: integrator, in: -9.81, reset: {when: h2 < 0, to: -0.8*v2}}
simulation: {stop: 10, zeno: hold}
record: [h1, h2]
)yaml");
  for (const char* h : {"h1", "h2"}) {
    EXPECT_NEAR(r.last(h), 0, 1e-6);
    for (const double height : r.column(h)) ASSERT_GT(height, -1e-6) << h;
  }
}

TEST(S10Zeno, OfABallOnAGroundThatRisesIsSeenThroughRounding) {
  // Beside the moving ground the ball falls as beside one at rest: v(0) = -0.1, t1 = (sqrt(0.01 + 2 g) - 0.1)/g, and it
  // hits with w = sqrt(0.01 + 2 g): the end is at t1 + 2 w/g.
  Report report;
  const auto diagram = Diagram::from_text(R"yaml(plantloop: 1
blocks:
  ground: 0.1*time
  h: {type: integrator, in: v, initial: 1}
  v: {type: integrator, in: -9.81, reset: {when: h < ground, to: 0.1 - 0.5*(v - 0.1)}}
simulation: {stop: 5}
)yaml",
                                          "test.yaml", report);
  ASSERT_TRUE(diagram) << to_text(report);
  try {
    diagram->run({}, report);
    FAIL() << "the run ends";
  } catch (const RunError& e) {
    const double w = std::sqrt(0.01 + 2 * 9.81);
    EXPECT_NEAR(e.time(), (w - 0.1) / 9.81 + 2 * w / 9.81, 1e-6) << e.what();
  }
}

TEST(S10Zeno, CountsTheBouncesOfABallToTheLastThatCanBeSeen) {
  // Bounce n is at t1 (1 + 2 (c + ... + c^(n-1))), and an instant is known to 3e-13 s.
  const Signals r = run(simple_ball("zeno: hold, rtol: 1e-9, atol: 1e-12"));
  const auto& bounces = r.recording().events.at("v.reset");
  ASSERT_GE(bounces.size(), 30u);
  ASSERT_LE(bounces.size(), 60u);
  const double t1 = std::sqrt(2 / 9.81);
  double t = t1;
  for (std::size_t n = 0; n < bounces.size(); ++n) {
    EXPECT_NEAR(bounces[n], t, 1e-9) << n;
    t += 2 * t1 * std::pow(0.5, static_cast<double>(n) + 1);
  }
}

TEST(S10Zeno, HoldsAgainAfterEachSample) {
  std::string text =
      with(simple_ball("zeno: hold"), "blocks:", "blocks:\n  s: {type: zero_order_hold, in: h, rate: 0.1}");
  const Signals r = run(text);
  EXPECT_NEAR(r.last("h"), 0, 1e-6);
  for (const double h : r.column("h")) ASSERT_GT(h, -1e-6);
}

TEST(S10Zeno, OfABallThatIsPutOnTheFloorIsSeenAtOnce) {
  const Signals r = run(with(simple_ball("zeno: hold"), "h0: 1", "h0: 0"));
  EXPECT_NEAR(r.last("h"), 0, 1e-6);
}

TEST(S10Zeno, IgnoredActsAgainAndAgain) {
  // It falls for 0.01 s at a time and is turned back each time.
  const Signals r = run(simple_ball("zeno: ignore"));
  EXPECT_LT(std::fabs(r.last("h")), 0.2);
  EXPECT_GT(r.recording().events.at("v.reset").size(), 300u);
}

TEST(S10Events, OfAConditionThatStaysTrueAreNotZenos) {
  // A bounce that hardly turns it back, a reset that changes nothing of its condition, a parachute, short pulses.
  const Signals r = run(R"yaml(
blocks:
  a: {type: integrator, in: 1, reset: {when: time > 1, to: 0}}
  h: {type: integrator, in: v, initial: 10}
  v: {type: integrator, in: -9.81, reset: {when: h < 5, to: 0}}
  w: {type: integrator, in: -1, initial: 1, reset: {when: y > 2, to: 0.5*w}}
  y: {type: integrator, in: 1 - 0.001*w}
  chirp: sin(0.1*exp(time))
  n: {type: integrator, in: 0, reset: {when: chirp > 0, to: n + 1}}
simulation: {stop: 8, rtol: 1e-8, max_step: 0.002}
record: [a, h, n]
)yaml");
  EXPECT_NEAR(r.last("a"), 7, 1e-9);
  EXPECT_NEAR(r.last("h"), 5 - 9.81 / 2 * std::pow(8 - std::sqrt(10 / 9.81), 2), 1e-6);
  EXPECT_TRUE(r.whole().statistics.warnings.empty());
  EXPECT_EQ(r.last("n"), std::floor(0.1 * std::exp(8.0) / (2 * std::numbers::pi)));
}

TEST(S10Events, OfAShortFlightAreSeenInALongStep) {
  // With fixed steps a bounce is shorter than a step: each is seen all the same.
  const Signals r = run(simple_ball("zeno: hold, solver: rk4, step: 0.2"));
  const auto& bounces = r.recording().events.at("v.reset");
  ASSERT_GE(bounces.size(), 25u);
  const double t1 = std::sqrt(2 / 9.81);
  for (std::size_t n = 1; n < 20; ++n)
    EXPECT_NEAR(bounces[n], t1 * (3 - std::pow(2.0, 1 - static_cast<double>(n))), 1e-9) << n;
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
