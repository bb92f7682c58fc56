// S10: state events, the modes they change and the jumps they make.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

const std::string accurate = "simulation: {stop: 4, rtol: 1e-11, atol: 1e-13}\n";

std::vector<double> event_times(const Signals& r, const std::string& name) {
  const auto found = r.recording().events.find(name);
  return found == r.recording().events.end() ? std::vector<double>{} : found->second;
}

std::string error_of(const std::string& text) {
  try {
    run(text);
  } catch (const std::exception& e) {
    return e.what();
  }
  return {};
}

TEST(S10Events, AreLocatedInTime) {
  // x = sin t crosses 0.5 upwards at pi/6 and 2 pi + pi/6, downwards at 5 pi/6.
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: v}
  v: {type: integrator, in: -x, initial: 1}
  up: {type: integrator, in: 1, reset: {when: x > 0.5, to: 0}}
  down: {type: integrator, in: 1, reset: {when: x < 0.5, to: 0}}
  any: {type: integrator, in: 1, reset: {when: x > 0.5, edge: either, to: 0}}
simulation: {stop: 8, rtol: 1e-12, atol: 1e-14}
record: [x]
)yaml");
  const auto up = event_times(r, "up.reset"), down = event_times(r, "down.reset"), any = event_times(r, "any.reset");
  ASSERT_EQ(up.size(), 2u);
  ASSERT_EQ(down.size(), 1u);
  ASSERT_EQ(any.size(), 3u);
  // The solver's own error; the location adds 1e-12 at most.
  EXPECT_NEAR(up[0], M_PI / 6, 2e-11);
  EXPECT_NEAR(up[1], 2 * M_PI + M_PI / 6, 1e-10);
  EXPECT_NEAR(down[0], 5 * M_PI / 6, 2e-11);
  EXPECT_EQ(any[1], down[0]);
}

TEST(S10Events, OfFunctionsOfTimeAreLocatedToTheTolerance) {
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: 1, reset: {when: sin(time) > 0.5, to: 0}}
simulation: {stop: 8}
record: [x]
)yaml");
  const auto times = event_times(r, "x.reset");
  ASSERT_EQ(times.size(), 2u);
  const double tolerance = 10 * 128 * 2.3e-16;  // times max(1, |t|)
  EXPECT_NEAR(times[0], M_PI / 6, tolerance);
  EXPECT_NEAR(times[1], 2 * M_PI + M_PI / 6, 7 * tolerance);
}

TEST(S10Events, OfABouncingBallStandWhereTheParabolasMeetTheGround) {
  // From h = 1 with restitution 0.8: the first bounce at T = sqrt(2/g), then T + 2 T (0.8 + 0.64 + ...).
  const Signals r = run(R"yaml(
blocks:
  h: {type: integrator, in: v, initial: 1}
  v: {type: integrator, in: -9.81, reset: {when: h < 0, to: -0.8*v}}
simulation: {stop: 2.7, rtol: 1e-10, atol: 1e-12}
record: [h, v]
)yaml");
  const auto times = event_times(r, "v.reset");
  ASSERT_GE(times.size(), 5u);
  const double fall = std::sqrt(2 / 9.81);
  double expected = fall, share = 1;
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(times[i], expected, 1e-10);
    share *= 0.8;
    expected += 2 * fall * share;
  }
  for (const double h : r.column("h")) EXPECT_GE(h, -1e-10);
}

TEST(S10Events, AreSeenWhenAFunctionChangesItsSignTwiceInOneStep) {
  // The rate is constant between events, so the solver would take any step.
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: "where(sin(time) > 0, 1, -1)"}
simulation: {stop: 20}
record: [x]
)yaml");
  EXPECT_NEAR(r.last("x"), 20 - 6 * M_PI, 1e-11);  // up and down three times, then up
  EXPECT_NEAR(r.greatest("x"), M_PI, 1e-11);
}

TEST(S10Events, InsideOneStepComeInTheRightOrder) {
  // x = t; three comparisons that one long step spans; each counts the ones before it.
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: 1}
  a: {type: integrator, in: 0, reset: {when: x > 0.3, to: 1}}
  b: {type: integrator, in: 0, reset: {when: x > 0.2, to: a + 10}}
  c: {type: integrator, in: 0, reset: {when: x > 0.4, to: a + b}}
simulation: {stop: 1, solver: rk4, step: 1}
record: [a, b, c]
)yaml");
  EXPECT_EQ(r.last("a"), 1);
  EXPECT_EQ(r.last("b"), 10);
  EXPECT_EQ(r.last("c"), 11);
}

TEST(S10Events, AtOneInstantUseTheValuesFromBeforeAllOfThem) {
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: 1}
  a: {type: integrator, in: 0, initial: 1, reset: {when: x > 0.5, to: b}}
  b: {type: integrator, in: 0, initial: 2, reset: {when: x > 0.5, to: a}}
simulation: {stop: 1}
record: [a, b]
)yaml");
  EXPECT_EQ(r.last("a"), 2);
  EXPECT_EQ(r.last("b"), 1);
}

// Kinks that a solution passes, each with its mode: the fourth order must survive them.
TEST(S10Events, KeepTheOrderOfAFixedStepMethodAcrossKinks) {
  const std::vector<std::string> rates{
      "abs(sin(3*time)) - 0.3*x",
      "max(min(2*cos(2*time), 1), -0.7) - 0.1*x",
      "where(x > 0.8, 0.3, 1 + 0.1*x)*exp(-time/9) + where(sin(5*time) < 0.2, 0.4, 0.1)",
      "sign(cos(4*time)) - x",
      "floor(3*sin(2*time)) - x",
      "mod(2*time, 1.3)*sin(x) + 0.2",
  };
  for (const std::string& rate : rates) {
    const auto end = [&](const std::string& solver) {
      return run("blocks:\n  x:\n    type: integrator\n    in: " + rate + "\n    initial: 0.1\nsimulation: {stop: 3, " +
                 solver + "}\nrecord: [x]\n")
          .last("x");
    };
    const double reference = end("rtol: 1e-13, atol: 1e-14");
    const double coarse = std::fabs(end("solver: rk4, step: 0.05") - reference);
    const double fine = std::fabs(end("solver: rk4, step: 0.0125") - reference);
    // 4^4 = 256 times smaller on the whole, and more than 4^2 = 16 wherever in a step the kinks fall; below 1e-12 both
    // are rounding.
    EXPECT_LT(fine, coarse / 60 + 1e-12) << rate << ": " << coarse << ", " << fine;
  }
}

TEST(S10Modes, AreRightWhenTheRunStartsOnTheSwitchingSurface) {
  for (const auto& [rate, expected] : {std::pair{"1 + abs(x)", std::exp(1) - 1}, {"-1 - abs(x)", 1 - std::exp(1)}}) {
    const Signals r = run("blocks:\n  x: {type: integrator, in: " + std::string(rate) + "}\n" +
                          "simulation: {stop: 1, rtol: 1e-11, atol: 1e-13}\nrecord: [x]\n");
    EXPECT_NEAR(r.last("x"), expected, 1e-9) << rate;
  }
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: "where(x >= 0, -2, -1)"}
  y: {type: integrator, in: "where(y > 0, 2, 1)"}
  z: {type: integrator, in: "where(z < 0, 1, 3)"}
simulation: {stop: 1}
record: [x, y, z]
)yaml");
  EXPECT_NEAR(r.last("x"), -1, 1e-9);
  EXPECT_NEAR(r.last("y"), 2, 1e-9);
  EXPECT_NEAR(r.last("z"), 3, 1e-12);
}

TEST(S10Modes, OfAStatelessDiagramFollowItsSignals) {
  const Signals r = run(R"yaml(
blocks:
  a: abs(time - 1.0037)
  m: mod(time, 0.3)
  f: floor(2*time)
simulation: {start: -1, stop: 3}
record: [a, m, f]
)yaml");
  const auto a = r.column("a"), m = r.column("m"), f = r.column("f");
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double t = r.recording().time()[i];
    EXPECT_NEAR(a[i], std::fabs(t - 1.0037), 1e-12);
    EXPECT_GE(a[i], -1e-11);
    const double remainder = t - 0.3 * std::floor(t / 0.3);
    // At a jump both sides are shown.
    const double distance = std::min(std::fabs(m[i] - remainder), 0.3 - std::fabs(m[i] - remainder));
    EXPECT_LT(std::fabs(distance), 1e-11) << t;
    EXPECT_LE(std::fabs(f[i] - std::floor(2 * t)), std::fabs(2 * t - std::round(2 * t)) < 1e-11 ? 1 : 0);
  }
}

TEST(S10Limits, HoldAStateExactlyAndLetItGoInTime) {
  const Signals r = run(R"yaml(
blocks:
  x: {type: integrator, in: cos(time), upper: 0.6}
simulation: {stop: 6, rtol: 1e-10, atol: 1e-12}
expect: [{signal: x, at: 1.5, value: 0}, {signal: x, at: 1.6, value: 0}, {signal: x, at: 3, value: 0}]
record: [x]
)yaml");
  for (const double x : r.column("x")) EXPECT_LE(x, 0.6);
  EXPECT_EQ(r.sampled("x", 1.5), 0.6);
  EXPECT_NEAR(r.sampled("x", 1.6), 0.6 + std::sin(1.6) - 1, 1e-9);
  EXPECT_NEAR(r.sampled("x", 3), 0.6 + std::sin(3) - 1, 1e-9);
}

TEST(S10Limits, ALimitedStateMayStartOnItsLimit) {
  const Signals r = run(R"yaml(
blocks:
  stays: {type: integrator, in: 1, initial: 2, upper: 2}
  leaves: {type: integrator, in: -1, initial: 2, upper: 2}
  clipped: {type: integrator, in: -1, initial: 5, upper: 2, lower: 1.5}
simulation: {stop: 1}
record: [stays, leaves, clipped]
)yaml");
  for (const double v : r.column("stays")) EXPECT_EQ(v, 2);
  EXPECT_NEAR(r.last("leaves"), 1, 1e-12);
  EXPECT_EQ(r.last("clipped"), 1.5);
}

TEST(S10Settling, ChatteringIsAnErrorThatNamesTheBlock) {
  for (const char* solver : {"", ", solver: rk4, step: 0.01", ", solver: bdf", ", solver: bogacki_shampine"}) {
    const std::string text = error_of(std::string(R"yaml(
blocks:
  slider: {type: integrator, in: "where(slider > 0, -1, 1)", initial: 0.5}
simulation: {stop: 2)yaml") + solver + "}\n");
    EXPECT_THAT(text, HasSubstr("slider")) << solver;
    EXPECT_THAT(text, HasSubstr("events follow each other without end")) << solver;
  }
}

TEST(S9Restarts, ColdOnesAreCountedPerEdgeAndEvent) {
  const Signals r = run(R"yaml(
blocks:
  u: {type: staircase, times: [0.1, 0.2, 0.3, 0.4], values: [1, 2, 3, 4]}  # 1 from the start
  x: {type: integrator, in: u}
simulation: {stop: 1}
record: [x]
)yaml");
  EXPECT_EQ(r.whole().statistics.solver.cold_restarts, 3);
  EXPECT_NEAR(r.last("x"), 0.2 + 0.2 + 0.3 + 2.4, 1e-14);
}

TEST(S9Edges, OfSourcesAreStepsEndsHoweverNarrowThePulse) {
  for (const char* solver : {"dopri5", "bogacki_shampine", "adams", "bdf"}) {
    const Signals r = run(std::string(R"yaml(
blocks:
  p: {type: pulse, period: 1, width: 0.0009765625, delay: 0.5, amplitude: 1024}
  x: {type: integrator, in: p}
  n: {type: pulse, period: 100, width: 1e-9, delay: 3, amplitude: 1e9}
  y: {type: integrator, in: n}
record: [x, y]
simulation: {stop: 10, max_step: 100, solver: )yaml") +
                          solver + "}\n");
    EXPECT_NEAR(r.last("x"), 10, 1e-9) << solver;
    EXPECT_NEAR(r.last("y"), 1, 1e-6) << solver;  // 3 + 1e-9 is known to 4e-16 only
  }
}

TEST(S9Edges, AStepThatEndsAtAnEdgeUsesTheSegmentOfItsStart) {
  // Were the value after the edge used at the end of the step before, heun would show it at once.
  const Signals r = run(R"yaml(
blocks:
  u: {type: step, time: 0.5, before: 0, after: 1000}
  x: {type: integrator, in: u}
simulation: {stop: 0.75, solver: heun, step: 0.25}
record: [x]
)yaml");
  EXPECT_EQ(r.at("x", 0.5), 0);
  EXPECT_EQ(r.at("x", 0.75), 250);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
