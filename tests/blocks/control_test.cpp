// Controllers against closed forms, and against what their limits promise.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

// The runs below use rtol 1e-9, atol 1e-11 and signals of size 1 to 100.
constexpr double tolerance = 1e-6;
const std::string accurate = "simulation: {stop: 3, rtol: 1e-9, atol: 1e-11}\n";

TEST(Pi, AnswersAStepWithAStepAndARamp) {
  const Signals r = run(R"(
blocks:
  c: {type: pi, in: 2, kp: 3, ki: 0.5, initial: 1}
  difference: c - (6 + 1 + time)
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
}

TEST(Pi, TakesScheduledGains) {
  // kp = 1 + t, ki = t, e = 1: u = 1 + t + t^2/2
  const Signals r = run(R"(
blocks:
  c: {type: pi, in: {e: 1, kp: 1 + time, ki: time}}
  difference: c - (1 + time + time^2/2)
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
}

TEST(Pi, FollowsItsLimitWithTheTrackingTime) {
  // kp = 0, ki = 1, e = 1, upper 1: after t = 1, raw - 1 = t_track (1 - exp(-(t - 1)/t_track)).
  const Signals r = run(R"(
blocks:
  c: {type: pi, in: 1, kp: 0, ki: 1, upper: 1, t_track: 0.25}
  difference: c.integral - where(c < 1, time, 1 + 0.25*(1 - exp(-4*(time - 1))))
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
  EXPECT_EQ(r.last("c.u"), 1);
}

TEST(Pi, LeavesALimitAtOnceWhenItsIntegralIsClamped) {
  const Signals r = run(R"(
blocks:
  e: {type: staircase, times: [0, 2], values: [1, -1]}
  clamped: {type: pi, in: e, kp: 0, ki: 1, upper: 1, anti_windup: clamp}
  wound_up: {type: pi, in: e, kp: 0, ki: 1, upper: 1, anti_windup: none}
)" + accurate);
  EXPECT_NEAR(r.last("clamped.u"), 0, tolerance);
  EXPECT_NEAR(r.last("wound_up.u"), 1, tolerance);
}

TEST(Pi, FollowsWhatTheActuatorDid) {
  // Under manual control at 2: I' = (2 - I)/t_track with e = 0; switched over, u goes on from there.
  const Signals r = run(R"(
blocks:
  c: {type: pi, in: {e: 0, track: 2}, kp: 5, ki: 1, t_track: 0.5}
  full: {type: pid, in: {e: 0, track: 2}, kp: 5, ki: 1, kd: 1, t_track: 0.5}
  sampled: {type: discrete_pid, in: {e: 0, track: 2}, kp: 5, t_track: 0.5, rate: 0.125}
  difference: [c - 2*(1 - exp(-2*time)), full - 2*(1 - exp(-2*time))]
record: [difference, sampled.u]
)" + accurate);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
  for (std::size_t k = 0; k < 20; ++k)
    EXPECT_NEAR(r.samples("sampled.u")[k], 2 * (1 - std::pow(0.75, static_cast<double>(k))), 1e-12);
}

TEST(Pi, FollowsALimitThatStandsOutside) {
  const Signals r = run(R"(
blocks:
  inside: {type: pi, in: 1, kp: 0, ki: 1, upper: 1, t_track: 0.25}
  outside: {type: pi, in: {e: 1, track: actuator}, kp: 0, ki: 1, t_track: 0.25}
  actuator: {type: saturation, in: outside, upper: 1}
  difference: inside.integral - outside.integral
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
}

TEST(Pid, AnswersARampAsItsTransferFunction) {
  // e = t: kp t + ki t^2/2 + kd (1 - exp(-N t))
  const Signals r = run(R"(
blocks:
  c: {type: pid, in: time, kp: 2, ki: 3, kd: 0.5, N: 20}
  difference: c - (2*time + 1.5*time^2 + 0.5*(1 - exp(-20*time)))
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
}

TEST(Pid, RefusesAGainGivenTwice) {
  EXPECT_THAT(findings("blocks: {c: {type: pid, in: {e: 1, kp: 2}, kp: 3}}\n" + accurate), ::testing::HasSubstr("kp"));
}

TEST(VelocityPi, IsTheClosedFormOfTheBook) {
  // dynamics.md section 7: u(t) = K0 (1 - exp(-p t)) + K1 (t - (1 - exp(-p t))/p).
  const Signals r = run(R"(
blocks:
  c: {type: velocity_pi, in: {e: 1, k0: 11, k1: 55}, p: 100}
  difference: c - (11*(1 - exp(-100*time)) + 55*(time - (1 - exp(-100*time))/100))
simulation: {stop: 1, rtol: 1e-9, atol: 1e-11}
)");
  EXPECT_LT(r.greatest("difference"), tolerance);
  EXPECT_NEAR(r.last("c.u"), 65.45, 1e-5);
}

TEST(VelocityPi, DoesNotJumpWhenItsGainsDo) {
  const Signals r = run(R"(
blocks:
  k: {type: staircase, times: [0, 1], values: [1, 5]}
  c: {type: velocity_pi, in: {e: 1, k0: k, k1: k}, p: 50}
  conventional: k*(c.z + 1)
)" + accurate);
  EXPECT_NEAR(r.at("c.u", 1), r.at("c.u", 1, true), 1e-12);
  EXPECT_GT(r.at("conventional", 1) - r.at("conventional", 1, true), 3);
}

TEST(VelocityPi, DoesNotWindUpAtItsLimits) {
  const Signals r = run(R"(
blocks:
  e: {type: staircase, times: [0, 2], values: [1, -1]}
  c: {type: velocity_pi, in: e, k0: 0, k1: 2, p: 1000, upper: 1}
)" + accurate);
  EXPECT_NEAR(r.at("c.u", 1.5), 1, 1e-12);
  // From t = 2 on z turns from 1 to -1 within some ms, then u falls with -2 per second.
  EXPECT_NEAR(r.last("c.u"), 1 - 2 * 1 + 0.004, 0.002);
}

TEST(VelocityIntegrator, LimitsItsSpeedAndItsValue) {
  const Signals r = run(R"(
blocks:
  v: {type: staircase, times: [0, 1, 2], values: [10, -10, -1]}
  u: {type: velocity_integrator, in: v, upper: 1.5, slowest: -3, fastest: 2, initial: -0.25}
)" + accurate);
  EXPECT_NEAR(r.at("u", 0.5), 0.75, 1e-9);
  EXPECT_EQ(r.at("u", 0.99), 1.5);
  EXPECT_NEAR(r.at("u", 2), -1.5, 1e-9);
  EXPECT_NEAR(r.last("u"), -2.5, 1e-9);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
