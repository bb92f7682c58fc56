// Continuous blocks against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

// The runs below use rtol 1e-9, atol 1e-11 and signals of size 1; a hundred times the error of one step.
constexpr double tolerance = 1e-7;
const std::string accurate = "simulation: {stop: 4, rtol: 1e-9, atol: 1e-11}\n";

TEST(Integrator, IntegratesElementByElement) {
  const Signals r = run(R"(
blocks:
  u: {type: sine, frequency: 2}
  x: {type: integrator, in: [u, 2*u, 1], initial: [1, 0, 0]}
  difference: x - [1 + (1 - cos(2*time))/2, 1 - cos(2*time), time]
)" + accurate);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
  EXPECT_LT(r.greatest("difference.3"), tolerance);
}

TEST(Integrator, StandsStillAtALimitAndLeavesAtOnce) {
  // u = cos t: x would be sin t; with upper 0.5 it stops at asin 0.5 and falls from pi/2 on: 0.5 + sin t - 1; the lower
  // limit -0.8 holds it from sin t = -0.3 until 3 pi/2.
  const Signals r = run(R"(
blocks:
  u: {type: sine, phase: pi/2}
  x: {type: integrator, in: u, lower: -0.8, upper: 0.5}
simulation: {stop: 7, rtol: 1e-9, atol: 1e-11}
expect: [{signal: x, at: 0.4, value: 0}, {signal: x, at: 1.2, value: 0}, {signal: x, at: 2.5, value: 0},
         {signal: x, at: 4.5, value: 0}, {signal: x, at: 6, value: 0}]
record: [x]
)");
  for (const double v : r.column("x")) {
    EXPECT_LE(v, 0.5 + 1e-12);  // the time of the event is exact to 3e-13 s
    EXPECT_GE(v, -0.8 - 1e-12);
  }
  const auto x = [&](double t) { return r.sampled("x", t); };
  EXPECT_NEAR(x(0.4), std::sin(0.4), tolerance);
  EXPECT_EQ(x(1.2), 0.5);
  EXPECT_NEAR(x(2.5), std::sin(2.5) - 0.5, tolerance);
  EXPECT_EQ(x(4.5), -0.8);
  EXPECT_NEAR(x(6), -0.8 + std::sin(6) + 1, tolerance);
}

TEST(Integrator, IsResetToAValue) {
  const Signals r = run(R"(
blocks:
  tick: {type: pulse, period: 1, width: 0.5, delay: 1}
  x: {type: integrator, in: 1, reset: {when: tick > 0.5, to: 10*x}}
simulation: {stop: 2.5}
)");
  EXPECT_NEAR(r.at("x", 1), 10, 1e-12);
  EXPECT_NEAR(r.at("x", 2), 110, 1e-12);
  EXPECT_NEAR(r.last("x"), 110.5, 1e-12);
}

TEST(Integrator, RefusesLimitsInTheWrongOrder) {
  EXPECT_THAT(findings("blocks: {x: {type: integrator, in: 1, lower: 2, upper: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("'upper' must be greater than 'lower', but they are 1 and 2"));
}

TEST(FirstOrder, AnswersAStepWithAnExponential) {
  const Signals r = run(R"(
blocks:
  x: {type: first_order, in: 1, k: [2, 3], tau: 0.5, initial: 1}
  difference: x - [2 - exp(-2*time), 3 - 2*exp(-2*time)]
)" + accurate);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
}

TEST(LeadLag, AnswersAStepWithAJumpAndAnExponential) {
  // k (1 + (lead/lag - 1) exp(-t/lag)), and at rest k where the lag has seen the input for long.
  const Signals r = run(R"(
blocks:
  y: {type: lead_lag, in: 1, k: 2, lead: [3, 0.1], lag: 0.5}
  rest: {type: lead_lag, in: 1, k: 2, lead: 3, lag: 0.5, initial: 1}
  difference: y - 2*(1 + [5, -0.8]*exp(-2*time))
)" + accurate);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
  for (const double v : r.column("rest")) EXPECT_NEAR(v, 2, 1e-12);
}

TEST(TransferFunction, OfSecondOrderAnswersAStep) {
  // (s + 3)/(s^2 + 2 s + 1): step response 3 - 3 exp(-t) - 2 t exp(-t).
  const Signals r = run(R"(
blocks:
  y: {type: transfer_function, in: 1, num: [2, 6], den: [2, 4, 2]}
  difference: y - (3 - 3*exp(-time) - 2*time*exp(-time))
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
}

TEST(TransferFunction, WithEqualDegreesPassesTheInputOn) {
  // (2 s + 1)/(s + 4) = 2 - 7/(s + 4)
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 1, after: [1, -1]}
  y: {type: transfer_function, in: u, num: [2, 1], den: [1, 4]}
  exact: where(u.1 > 0.5, 2 - 7/4*(1 - exp(-4*(time - 1))), 0)
  difference: y - [exact, -exact]
)" + accurate);
  EXPECT_EQ(r.at("y.1", 1, true), 0);
  EXPECT_EQ(r.at("y.1", 1), 2);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
}

TEST(TransferFunction, WithoutFeedthroughMayStandInALoop) {
  // A leading zero of num is no path: the loop is not algebraic.
  const Signals r = run(R"(
blocks:
  y: {type: transfer_function, in: 1 - y, num: [0, 1], den: [1, 1]}
  difference: y - (1 - exp(-2*time))/2
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
  EXPECT_THAT(findings("blocks: {y: {type: transfer_function, in: 1 - y, num: [1, 1], den: [1, 2]}}\n" + accurate),
              HasSubstr("algebraic loop"));
}

TEST(TransferFunction, StartsAtRestAtItsInitialOutput) {
  const Signals r = run(R"(
blocks:
  y: {type: transfer_function, in: 2, num: [1, 4, 6], den: [1, 5, 3], initial: 4}
)" + accurate);
  for (const double v : r.column("y")) EXPECT_NEAR(v, 4, 1e-12);
}

TEST(TransferFunction, OfDegreeZeroIsAGain) {
  EXPECT_EQ(run("blocks: {y: {type: transfer_function, in: 3, num: 4, den: [2]}}\n" + accurate).last("y"), 6);
}

TEST(TransferFunction, RefusesWhatCannotBeBuilt) {
  EXPECT_THAT(findings("blocks: {y: {type: transfer_function, in: 1, num: [1, 0], den: [1]}}\n" + accurate),
              HasSubstr("num has degree 1 and den 0"));
  EXPECT_THAT(findings("blocks: {y: {type: transfer_function, in: 1, num: [1], den: [0, 1]}}\n" + accurate),
              HasSubstr("the first coefficient of den is 0"));
}

TEST(StateSpace, OfAnOscillatorIsASine) {
  const Signals r = run(R"(
blocks:
  y: {type: state_space, in: [0, 0], A: [[0, 1], [-4, 0]], B: [[0, 0], [1, 1]], C: [[1, 0], [0, 1]], initial: [1, 0]}
  difference: y - [cos(2*time), -2*sin(2*time)]
)" + accurate);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
}

TEST(StateSpace, TakesVectorsForOneInputAndOneOutput) {
  // 1/(s^2 + 2 s + 1) + 3
  const Signals r = run(R"(
blocks:
  y: {type: state_space, in: 1, A: [[0, 1], [-1, -2]], B: [0, 1], C: [1, 0], D: 3}
  one: {type: state_space, in: 1, A: -2, B: 4, C: 0.5}
  difference: [y - (4 - exp(-time) - time*exp(-time)), one - (1 - exp(-2*time))]
)" + accurate);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
}

TEST(StateSpace, TakesAVectorDForOneInputOrOneOutput) {
  const Signals r = run(R"(
blocks:
  one_output: {type: state_space, in: [1, time], A: -1, B: [[1, 0]], C: 1, D: [2, 3]}
  one_input: {type: state_space, in: time, A: -1, B: 0, C: [[1], [0]], D: [2, 3], initial: 1}
  difference: [one_output - (3 - exp(-time) + 3*time), one_input.1 - (exp(-time) + 2*time), one_input.2 - 3*time]
)" + accurate);
  for (const char* d : {"difference.1", "difference.2", "difference.3"}) EXPECT_LT(r.greatest(d), tolerance) << d;
}

TEST(TransferFunction, MayHaveLeadingZerosAndNoNumeratorAtAll) {
  const Signals r = run(R"(
blocks:
  same: {type: transfer_function, in: 1, num: [0, 0, 0, 2], den: [1, 1]}
  none: {type: transfer_function, in: 1, num: [0], den: [1, 1]}
  difference: same - 2*(1 - exp(-time))
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
  EXPECT_EQ(r.greatest("none"), 0);
}

TEST(Integrator, MayStartAtALimit) {
  // Moved to its limits at the start; there it stands still while the rate points outwards.
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 2], values: [1, -1, 1]}
  x: {type: integrator, in: u, initial: 3, lower: -1, upper: 0.5}
  v: {type: integrator, in: [1, -2], lower: [-9, -1], upper: [0.25, 9]}
)" + accurate);
  EXPECT_EQ(r.at("x", 0), 0.5);
  EXPECT_EQ(r.at("x", 0.99), 0.5);
  EXPECT_NEAR(r.at("x", 2), -0.5, 1e-12);
  EXPECT_NEAR(r.at("x", 2.5), 0, 1e-9);
  EXPECT_EQ(r.last("x"), 0.5);
  EXPECT_EQ(r.last("v.1"), 0.25);
  EXPECT_EQ(r.last("v.2"), -1);
}

TEST(StateSpace, SaysWhichMatrixDoesNotFit) {
  const auto with = [](const std::string& matrices) {
    return findings("blocks: {y: {type: state_space, in: 1, " + matrices + "}}\nsimulation: {stop: 1}\n");
  };
  EXPECT_THAT(with("A: [[1, 2]], B: 1, C: 1"), HasSubstr("A must be square, but it is a 1 by 2 matrix"));
  EXPECT_THAT(with("A: [[1, 2], [3, 4]], B: [1, 2, 3], C: [1, 0]"), HasSubstr("B has 3 rows, A has 2"));
  EXPECT_THAT(with("A: [[1, 2], [3, 4]], B: [1, 2], C: [1, 0, 0]"), HasSubstr("C has 3 columns, A has 2"));
  EXPECT_THAT(with("A: [[1, 2], [3, 4]], B: [1, 2], C: [1, 0], D: [1, 2]"), HasSubstr("D must be 1 by 1"));
  EXPECT_THAT(with("A: [[1, 2], [3, 4]], B: [[1, 2], [3, 4]], C: [1, 0]"), testing::IsEmpty());
  EXPECT_THAT(with("A: [[1, 2], [3, 4]], B: [1, 2], C: [1, 0], initial: [1, 2, 3]"),
              HasSubstr("initial must have 2 elements"));
}

TEST(FilteredDerivative, OfARampSettlesAtItsSlope) {
  const Signals r = run(R"(
blocks:
  u: {type: ramp, start: 0, slope: 3, initial: 5}
  d: {type: filtered_derivative, in: u, N: 10}
  difference: d - 3*(1 - exp(-10*time))
  jump: {type: filtered_derivative, in: 1, N: 10, initial: 0}
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
  EXPECT_NEAR(r.at("jump.y", 0), 10, 1e-12);
}

TEST(TransportDelay, ShiftsASignal) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: cos(time)}
  late: {type: transport_delay, in: [x, 2*x], delay: 0.7}
  difference: late - where(time > 0.7, sin(time - 0.7), 0)*[1, 2]
)" + accurate);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
}

TEST(TransportDelay, BringsJumpsOutOneDelayLater) {
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 1.2], values: [2, 5, 3]}
  late: {type: transport_delay, in: u, delay: 0.5}
  x: {type: integrator, in: late}
)" + accurate);
  EXPECT_EQ(r.at("late", 1.4), 2);
  EXPECT_EQ(r.at("late", 1.5, true), 2);
  EXPECT_EQ(r.at("late", 1.5), 5);
  EXPECT_EQ(r.at("late", 1.2 + 0.5, true), 5);
  EXPECT_EQ(r.at("late", 1.2 + 0.5), 3);
  // Both edges are stops, so the integral of constants is exact but for rounding.
  EXPECT_NEAR(r.last("x"), 2 * 1.5 + 5 * 0.2 + 3 * 2.3, 1e-11);
}

TEST(TransportDelay, OfZeroIsTheSignalItself) {
  const Signals r = run("blocks: {y: {type: transport_delay, in: time, delay: 0}}\n" + accurate);
  EXPECT_EQ(r.last("y"), 4);
  EXPECT_THAT(
      findings("blocks: {y: {type: transport_delay, in: time, delay: 0}}\n" + accurate),
      HasSubstr("note: 'y' (transport_delay): a delay of 0 s is none: the output is the input at the same instant"));
  EXPECT_THAT(findings("blocks: {y: {type: transport_delay, in: 1, delay: -1}}\n" + accurate),
              HasSubstr("must be at least 0 s"));
}

TEST(TransportDelay, SolvesADelayEquation) {
  // x' = -x(t - 1) with x = 1 before 0: 1 - t, then 1 - t + (t-1)^2/2, then - (t-2)^3/6 (method of steps).
  const Signals r = run(R"(
blocks:
  late: {type: transport_delay, in: x, delay: 1}
  x: {type: integrator, in: -late, initial: 1}
  exact: 1 - time + where(time > 1, (time - 1)^2/2, 0) - where(time > 2, (time - 2)^3/6, 0) + where(time > 3, (time - 3)^4/24, 0)
  difference: x - exact
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
}

TEST(TransportDelay, ClosesALoopWithItsInitialValue) {
  // w(t) = 1 + w(t - 1)/2 with w = 0 before the start: 1, 1.5, 1.75, ...: a jump at each whole number.
  const Signals r = run(R"(
blocks:
  w: 1 + 0.5*late
  late: {type: transport_delay, in: w, delay: 1, initial: 0}
  x: {type: integrator, in: w}
)" + accurate);
  EXPECT_EQ(r.at("w", 0.5), 1);
  EXPECT_NEAR(r.at("w", 1.5), 1.5, 1e-14);
  EXPECT_NEAR(r.at("w", 3.5), 1.875, 1e-14);
  EXPECT_NEAR(r.last("x"), 1 + 1.5 + 1.75 + 1.875, 1e-11);
  EXPECT_THAT(findings("blocks: {w: 1 + 0.5*late, late: {type: transport_delay, in: w, delay: 1}}\n" + accurate),
              HasSubstr("initial values depend on each other"));
}

TEST(TransportDelay, KeepsTheOrderOfTheMethod) {
  // A smooth delay equation, x' = -x(t - 0.4) sin(t) + cos(t), with rk4: halving the step divides the error by sixteen.
  const std::string text = R"(
blocks:
  late: {type: transport_delay, in: x, delay: 0.4}
  x: {type: integrator, in: cos(time) - late*sin(time)}
simulation: {stop: 4, rtol: 1e-11, atol: 1e-12}
)";
  const double exact = run(text).last("x");
  const auto error = [&](double step) {
    return std::fabs(run(text, {.step = step, .solver = "rk4"}).last("x") - exact);
  };
  EXPECT_GT(error(0.1) / error(0.05), 12);
  EXPECT_GT(error(0.05) / error(0.025), 12);
}

TEST(TransportDelay, GivesTheVelocityFormOfASampledSystem) {
  // dynamics.md section 6: y(k+1) = y/(1 + y^2) + u^3, and its continuous velocity form with a dead time of one sample.
  // Equal at the end of each interval; the filter's error there is exp(-100), the goal of the book's section is 1e-4.
  const Signals r = run(R"(
blocks:
  u: {type: random_levels, generator: lcg, seed: 12345, lower: -1.2, upper: 1.2, rate: 1}
  y: {type: unit_delay, in: y/(1 + y^2) + u^3, rate: 1}
  d: {type: filtered_derivative, in: u, N: 100, initial: 0}
  w: {type: transport_delay, in: 3*d.filtered^2*d + a*w, delay: 1, initial: 0}
  a: (1 - x^2)/(1 + x^2)^2
  x: {type: integrator, in: w}
simulation: {stop: 25, rtol: 1e-9, atol: 1e-11}
)");
  const std::vector<double> y = r.samples("y");
  EXPECT_NEAR(y[1], -0.90737753, 1e-8);
  EXPECT_NEAR(y[24], 0.24425883, 1e-8);
  for (std::size_t k = 0; k < 25; ++k) {
    EXPECT_NEAR(r.at("x", static_cast<double>(k + 1), true), y[k], 1e-6) << k;
  }
}

TEST(TransportDelay, RunsLongWithABoundedHistory) {
  const Signals r = run(R"(
blocks:
  late: {type: transport_delay, in: x, delay: 0.1}
  x: {type: integrator, in: -5*late + sin(time), initial: 0.3}
  edge: {type: pulse, period: 0.37}
  both: {type: transport_delay, in: edge, delay: 1.1, initial: 0}
  area: {type: integrator, in: both}
simulation: {stop: 111, rtol: 1e-6}
)");
  // 297 whole pulses of half the period have come out by 109.9 + 1.1.
  EXPECT_NEAR(r.at("area", 111), 297 * 0.185 + std::min(0.185, 109.9 - 297 * 0.37), 1e-9);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
