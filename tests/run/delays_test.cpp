// S13: delay equations against the method of steps, delays that change, and where what happened comes out again.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "tests/blocks/diagrams.h"
#include "tests/run/method_of_steps.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

// x' = -x(t - 1) with x = 1 before 0: the sum of (-1)^k (t - k + 1)^k / k! for k up to t + 1.
double linear_delay_equation(double t) {
  double x = 0, factorial = 1;
  for (int k = 0; k <= std::floor(t) + 1; factorial *= ++k) x += std::pow(k - 1 - t, k) / factorial;
  return x;
}

const std::vector<std::string> adaptive_solvers{"dopri5", "bogacki_shampine", "adams", "bdf", "ida"};

// How far the solver's own error may be from its tolerance: what its steps commit adds up along the run, and the
// multistep methods control it less closely.
double times_tolerance(const std::string& solver) {
  return solver == "bdf" || solver == "ida" ? 100 : solver == "adams" ? 30 : 10;
}

TEST(S13Delays, OfALinearEquationFollowTheMethodOfStepsAtEveryTolerance) {
  for (const std::string& solver : adaptive_solvers) {
    for (const double rtol : {1e-4, 1e-6, 1e-8, 1e-10}) {
      if (solver == "bogacki_shampine" && rtol < 1e-8) continue;
      const Signals r = run(R"(
blocks:
  late: {type: transport_delay, in: x, delay: 1, initial: 1}
  x: {type: integrator, in: -late, initial: 1}
simulation: {stop: 8}
record: [x]
)",
                            {.rtol = rtol, .atol = rtol, .solver = solver});
      double most = 0;
      const std::vector<double> x = r.column("x");
      for (std::size_t i = 0; i < x.size(); ++i)
        most = std::max(most, std::fabs(x[i] - linear_delay_equation(r.recording().time()[i])));
      EXPECT_LT(most, times_tolerance(solver) * rtol) << solver << " at " << rtol;
    }
  }
}

TEST(S13Delays, OfAFixedStepKeepFourthOrderAcrossTheBreaks) {
  const auto exact = method_of_steps([](double, double, double late) { return -std::sin(late); }, 1, 1, 5);
  const auto error = [&](double step) {
    const Signals r = run(R"(
blocks:
  late: {type: transport_delay, in: x, delay: 1, initial: 1}
  x: {type: integrator, in: -sin(late), initial: 1}
simulation: {stop: 4.5}
record: [x]
)",
                          {.step = step, .solver = "rk4"});
    return std::fabs(r.last("x") - exact(4.5));
  };
  EXPECT_NEAR(error(0.1) / error(0.05), 16, 1);
  EXPECT_NEAR(error(0.05) / error(0.025), 16, 1);
  // With breaks between the grid's points, where steps are shortened.
  for (const double step : {0.3, 0.15, 0.075, 0.0375}) EXPECT_LT(error(step), 2e-4 * std::pow(step, 4)) << step;
}

TEST(S13Delays, OfHutchinsonsEquationAreAsAccurateAsTheTolerance) {
  // x' = 1.8 x (1 - x(t - 1)), x = 0.1 before 0: a growth that overshoots and swings (G. E. Hutchinson, Circular causal
  // systems in ecology, 1948).
  const auto exact = method_of_steps([](double, double x, double late) { return 1.8 * x * (1 - late); }, 0.1, 1, 20);
  for (const std::string& solver : adaptive_solvers) {
    for (const double rtol : {1e-6, 1e-9}) {
      if (solver == "bogacki_shampine" && rtol < 1e-8) continue;
      const Signals r = run(R"(
blocks:
  late: {type: transport_delay, in: x, delay: 1}
  x: {type: integrator, in: 1.8*x*(1 - late), initial: 0.1}
simulation: {stop: 20}
record: [x]
)",
                            {.rtol = rtol, .atol = rtol, .solver = solver});
      double most = 0;
      const std::vector<double> x = r.column("x");
      for (std::size_t i = 0; i < x.size(); ++i)
        most = std::max(most, std::fabs(x[i] - exact(r.recording().time()[i])));
      // Errors grow with the swings: twenty times those of the linear equation.
      EXPECT_LT(most, 20 * times_tolerance(solver) * rtol) << solver << " at " << rtol;
    }
  }
}

TEST(S13Delays, ThatMeetEndStepsWhereSumsOfThemFall) {
  // Two delays: a kink at 0 comes out at 0.7, 1, 1.4, 1.7, 2, ...; the reference meets them all on its grid of tenths.
  const auto exact = method_of_steps_of_two(
      [](double x, double late, double later) { return -0.8 * late + 0.4 * later - 0.1 * x; }, 1, 0.7, 1, 6);
  const Signals r = run(R"(
blocks:
  late: {type: transport_delay, in: x, delay: 0.7, initial: 1}
  later: {type: transport_delay, in: x, delay: 1, initial: 1}
  x: {type: integrator, in: -0.8*late + 0.4*later - 0.1*x, initial: 1}
simulation: {stop: 6}
record: [x]
)",
                        {.rtol = 1e-10, .atol = 1e-10});
  double most = 0;
  const std::vector<double> x = r.column("x");
  for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::fabs(x[i] - exact(r.recording().time()[i])));
  EXPECT_LT(most, 1e-9);
  const auto& time = r.recording().time();
  for (const double t : {0.7, 1.0, 1.4, 1.7, 2.0, 2.1, 2.4, 2.7}) {
    EXPECT_TRUE(std::any_of(time.begin(), time.end(), [&](double at) { return std::fabs(at - t) < 1e-14; })) << t;
  }
}

TEST(S13Delays, OfAnEdgeComeOutWhereTheyShouldThroughTwoDelays) {
  // An edge at 1, a kink (the ramp's start) at 1.3; through 0.5 and 0.25 s.
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 1}
  v: {type: ramp, start: 1.3}
  first: {type: transport_delay, in: u + v, delay: 0.5, initial: 0}
  second: {type: transport_delay, in: first, delay: 0.25, initial: 0}
  x: {type: integrator, in: second}
simulation: {stop: 3, rtol: 1e-4}
record: [first, second, x]
)");
  EXPECT_EQ(r.at("second", 1.75, true), 0);
  EXPECT_EQ(r.at("second", 1.75), 1);
  // A loose tolerance, but every piece is a polynomial, so only rounding is left.
  EXPECT_NEAR(r.last("x"), (3 - 1.75) + (3 - 2.05) * (3 - 2.05) / 2, 1e-12);
}

TEST(S13Delays, OnAnOutputGridAndAtTheStopTheValueAfterTheJumpIsShown) {
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 0.5}
  late: {type: transport_delay, in: u, delay: 0.25, initial: 0}
  last: {type: transport_delay, in: u, delay: 0.5, initial: 0}
  x: {type: integrator, in: late}
simulation: {stop: 1, output_interval: 0.25}
record: [u, late, last, x]
)");
  EXPECT_THAT(r.column("u"), ::testing::ElementsAre(0, 0, 1, 1, 1));
  EXPECT_THAT(r.column("late"), ::testing::ElementsAre(0, 0, 0, 1, 1));
  EXPECT_THAT(r.column("last"), ::testing::ElementsAre(0, 0, 0, 0, 1));
}

TEST(S13Delays, AnEventComesOutOfADelayToo) {
  // A ball's bounces, 0.3 s late: the speed jumps there.
  const Signals r = run(R"(
blocks:
  h: {type: integrator, in: v, initial: 1}
  v: {type: integrator, in: -9.81, reset: {when: h < 0, to: -0.8*v}}
  late: {type: transport_delay, in: v, delay: 0.3, initial: 0}
  way: {type: integrator, in: late}
simulation: {stop: 2, rtol: 1e-9, atol: 1e-10}
record: [h, late, way]
)");
  const double bounce = std::sqrt(2 / 9.81);
  EXPECT_NEAR(r.at("late", bounce + 0.3, true), -9.81 * bounce, 1e-6);
  // The way is the height 0.3 s ago.
  EXPECT_NEAR(1 + r.last("way"), r.at("h", 1.7), 2e-5);  // h is read between rows
}

TEST(S13Delays, ShorterThanTheStepLimitItOrReadThePresent) {
  // x' = -x(t - 0.001): steps of the delay, or long ones. The root of s = -exp(-0.001 s) is s = W(-0.001)/0.001.
  const std::string text = R"(
blocks:
  late: {type: transport_delay, in: x, delay: 0.001, initial: 1, short_delay: SHORT}
  x: {type: integrator, in: -late, initial: 1}
simulation: {stop: 2, rtol: 1e-6, atol: 1e-8, max_rows: 1e6}
record: [x]
)";
  const auto with = [&](const std::string& word) {
    std::string diagram = text;
    return run(diagram.replace(diagram.find("SHORT"), 5, word));
  };
  double rate = -1;
  for (int i = 0; i < 50; ++i) rate = -std::exp(-0.001 * rate);
  // The initial value counts with 1 + s/(...) to first order in the delay; the answer starts as 1 - t for one delay.
  const double exact = method_of_steps([](double, double, double late) { return -late; }, 1, 0.001, 2)(2);
  EXPECT_NEAR(exact, std::exp(2 * rate), 1e-6);
  const Signals limited = with("limit"), free = with("feedthrough");
  EXPECT_NEAR(limited.last("x"), exact, 1e-9);
  EXPECT_NEAR(free.last("x"), exact, 2e-6);
  EXPECT_GE(limited.whole().statistics.solver.steps, 2000);
  EXPECT_LT(free.whole().statistics.solver.steps, 100);
}

TEST(S13Delays, ShortOnesWithFeedthroughCloseALoopWithoutStates) {
  // w = 1 + w(t - 0.001)/2 goes to 2; with steps of 0.01 s the delay is read inside the step.
  const Signals r = run(R"(
blocks:
  late: {type: transport_delay, in: w, delay: 0.001, initial: 0, short_delay: feedthrough}
  w: 1 + 0.5*late
  x: {type: integrator, in: w}
simulation: {stop: 1, solver: rk4, step: 0.01}
record: [w, x]
)");
  EXPECT_NEAR(r.last("w"), 2, 1e-9);
}

TEST(S13VariableDelay, ReadsAsFarBackAsItIsTold) {
  const Signals r = run(R"(
blocks:
  d: 0.6 + 0.4*sin(3*time)
  late: {type: variable_delay, in: {u: 'sin(2*time) + x', delay: d}, shortest: 0.1, longest: 1, initial: 0}
  x: {type: integrator, in: cos(time)}
  exact: where(time > d, sin(2*(time - d)) + sin(time - d), 0)
  difference: late - exact
simulation: {stop: 8, rtol: 1e-9, atol: 1e-11}
record: [difference]
)");
  EXPECT_LT(r.greatest("difference"), 1e-8);
}

TEST(S13VariableDelay, LocatesWhereAJumpComesOutForwardsAndBackwards) {
  // t - d = 1 + sin(t)/2: it passes the edge at 1 upwards at whole turns and downwards half a turn later.
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 1, before: 2, after: 5}
  late: {type: variable_delay, in: {u: u, delay: time - 1 - 0.5*sin(time)}, shortest: 0.001, initial: 2}
  area: {type: integrator, in: late - 2}
simulation: {stop: 12.6, rtol: 1e-6}
record: [late, area]
)");
  constexpr double pi = std::numbers::pi;
  // Until 1.9 s the delay is at its lower bound, so the edge comes out at 1.001 s first; at 1.5 s the bound is left.
  const auto up = [&](double t) { return r.at("late", t); };
  EXPECT_EQ(up(0.99), 2);
  EXPECT_EQ(up(2), 5);
  EXPECT_EQ(up(4), 2);
  EXPECT_EQ(up(8), 5);
  EXPECT_EQ(up(11), 2);
  EXPECT_EQ(up(12.59), 5);
  const double begin = 1.001;
  EXPECT_NEAR(r.at("area", 12.5), 3 * (pi - begin) + 3 * pi, 1e-9);
}

TEST(S13VariableDelay, MayJump) {
  const Signals r = run(R"(
blocks:
  d: {type: staircase, times: [0, 2, 3], values: [1, 0.25, 1.5]}
  late: {type: variable_delay, in: {u: sin(time), delay: d}, shortest: 0.2, longest: 2, initial: 0}
  x: {type: integrator, in: late}
simulation: {stop: 4, rtol: 1e-8, atol: 1e-10}
record: [late, x]
)");
  EXPECT_NEAR(r.at("late", 2, true), std::sin(1.0), 1e-7);
  EXPECT_NEAR(r.at("late", 2), std::sin(1.75), 1e-7);
  EXPECT_NEAR(r.at("late", 3), std::sin(1.5), 1e-7);
  EXPECT_NEAR(r.last("x"), (1 - std::cos(1)) + (std::cos(1.75) - std::cos(2.75)) + (std::cos(1.5) - std::cos(2.5)),
              1e-7);
}

TEST(S13VariableDelay, OfAConstantSignalIsATransportDelay) {
  for (const std::string& solver : adaptive_solvers) {
    const Signals r = run(R"(
blocks:
  late: {type: variable_delay, in: {u: x, delay: 1}, shortest: 0.5, longest: 2, initial: 1}
  x: {type: integrator, in: -late, initial: 1}
simulation: {stop: 5}
record: [x]
)",
                          {.rtol = 1e-7, .atol = 1e-7, .solver = solver});
    EXPECT_NEAR(r.last("x"), linear_delay_equation(5), times_tolerance(solver) * 1e-7) << solver;
  }
}

TEST(S13VariableDelay, OfThePantographEquationBeginsAtNothing) {
  // x' = -x(t/2): the sum of (-1)^n t^n / (2^(n (n-1)/2) n!). The delay is zero at the start, so the present is read.
  const Signals r = run(R"(
blocks:
  late: {type: variable_delay, in: {u: x, delay: time/2}}
  x: {type: integrator, in: -late, initial: 1}
simulation: {stop: 4, rtol: 1e-8, atol: 1e-8}
record: [x]
)");
  const auto exact = [](double t) {
    double sum = 0, term = 1;
    for (int n = 0; n < 40; ++n) {
      sum += term;
      term *= -t / ((n + 1) * std::pow(2.0, n));
    }
    return sum;
  };
  EXPECT_NEAR(r.last("x"), exact(4), 2e-6);
}

TEST(S13VariableDelay, MayDependOnTheState) {
  // x = ln(1 + t), read at t - d with d = t (1 - exp(-x)) = t^2/(1 + t): ln(1 + t/(1 + t)). Near the start the delay is
  // shorter than a step, so a cubic through the present is read.
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: exp(-x)}
  late: {type: variable_delay, in: {u: x, delay: time*(1 - exp(-x))}}
  difference: late - log(1 + time/(1 + time))
simulation: {stop: 5, rtol: 1e-9, atol: 1e-10}
record: [difference]
)");
  EXPECT_LT(r.greatest("difference"), 1e-6);
}

TEST(S13VariableDelay, OfVectorsAreTakenElementByElement) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: 1}
  late: {type: variable_delay, in: {u: [x, 2*x], delay: [0.5, 0.25]}, shortest: 0.1, longest: 1}
simulation: {stop: 2}
record: [late]
)");
  EXPECT_NEAR(r.last("late.1"), 1.5, 1e-12);
  EXPECT_NEAR(r.last("late.2"), 3.5, 1e-12);
}

TEST(S13VariableDelay, SaysWhatIsWrongWithItsBounds) {
  EXPECT_THAT(findings("blocks: {y: {type: variable_delay, in: {u: time, delay: 1}, shortest: 2, longest: 1}}\n"
                       "simulation: {stop: 1}\n"),
              HasSubstr("must not be greater than 'longest'"));
}

TEST(S13Delays, InsideAnEnabledSubsystemHoldWhileItIsOff) {
  // Off between 1 and 2: what comes out afterwards is what went in until 1, then the value held, then the new one.
  const Signals r = run(R"(
blocks:
  on: {type: staircase, times: [0, 1, 2], values: [1, 0, 1]}
  t: {type: clock}
  late: {type: transport_delay, in: t, delay: 0.5, enable: {when: on, initial: 0}}
simulation: {stop: 4, max_step: 0.01}
record: [late]
)");
  EXPECT_NEAR(r.at("late", 0.9), 0.4, 1e-9);
  EXPECT_NEAR(r.at("late", 1.5), 0.5, 1e-9);
  EXPECT_NEAR(r.at("late", 2.3), 1, 1e-9);
  EXPECT_NEAR(r.at("late", 2.7), 2.2, 1e-9);
}

// An edge comes out of this delay up to four times. What the delay moves does not lead back into it, so what comes out
// makes no kinks of its input, and the events stay as few as the edges.
TEST(S13Delays, ThatGoUpAndDownFastBringEachEdgeOutAFewTimes) {
  const Signals r = run(R"(
blocks:
  u: {type: square, amplitude: 1, period: 0.37}
  d: {type: variable_delay, in: {u: u, delay: abs(sin(3*time))}, initial: 0}
  x: {type: integrator, in: d - x}
simulation: {stop: 10, output_interval: 0.01}
record: [d, x]
)");
  EXPECT_GT(r.whole().statistics.events, 54);
  EXPECT_LT(r.whole().statistics.events, 54 * 4 + 20);
  const std::vector<double> d = r.column("d");
  for (std::size_t i = 0; i < d.size(); ++i) {
    const double at = r.recording().time()[i] - std::fabs(std::sin(3 * r.recording().time()[i]));
    const double phase = std::fmod(at, 0.37) / 0.37;
    if (std::fmin(std::fabs(phase - 0.5), std::fmin(phase, 1 - phase)) < 1e-6) continue;
    EXPECT_NEAR(d[i], at < 0 ? 0 : phase < 0.5 ? 1 : -1, 1e-12) << r.recording().time()[i];
  }
}

// A slope that jumps goes through nine delays without getting smoother, so a step ends where it comes out: the only
// integration is then exact. u = 0 until 1 s, then t - 1; x = (t - 1 - 9*0.3)^2/2.
TEST(S13Delays, OneAfterTheOtherKeepTheOrderOfAKink) {
  std::string text = "blocks:\n  d0: {type: ramp, slope: 1, start: 1}\n";
  for (int i = 1; i <= 9; ++i) {
    text += "  d" + std::to_string(i) + ": {type: transport_delay, in: d" + std::to_string(i - 1) +
            ", delay: 0.3, initial: 0}\n";
  }
  text += "  x: {type: integrator, in: d9}\nsimulation: {stop: 6}\nrecord: [x]\n";
  for (const char* solver : {"dopri5", "bogacki_shampine"}) {
    const Signals r = run(text, {.rtol = 1e-3, .atol = 1e-3, .solver = solver});
    EXPECT_NEAR(r.last("x"), 2.3 * 2.3 / 2, 1e-13) << solver;
  }
}

// Two delays in one loop, one of them varying: each pass makes a kink one order smoother, so those that steps must end
// at come to an end, and all solvers find the same. Until 1.2 s both read x = 1 - 0.35 t.
TEST(S13Delays, OfTwoKindsInOneLoopComeToRest) {
  const std::string text = R"(
blocks:
  d: {type: transport_delay, in: x, delay: 0.77, initial: 0.5}
  vd: {type: variable_delay, in: {u: x, delay: 0.5 + 0.3*sin(time)}, shortest: 0.2, longest: 1, initial: 0}
  x: {type: integrator, in: -0.7*d - 0.3*vd, initial: 1}
simulation: {stop: 10}
record: [x]
)";
  double first = 0.7;  // where t = 0.5 + 0.3 sin t
  for (int i = 0; i < 100; ++i) first = 0.5 + 0.3 * std::sin(first);
  // The integrals of x(t - 0.5 - 0.3 sin t) and of x(t - 0.77).
  const auto varying = [](double t) { return t - 0.35 * (0.5 * t * t - 0.5 * t + 0.3 * std::cos(t)); };
  const auto fixed = [](double t) { return t - 0.35 * (0.5 * t * t - 0.77 * t); };
  const double at_1_2 = 1 - 0.35 * 0.77 - 0.3 * (varying(1.2) - varying(first)) - 0.7 * (fixed(1.2) - fixed(0.77));
  double end = 0;
  for (const std::string& solver : adaptive_solvers) {
    const RunRequest request{.rtol = 1e-10, .atol = 1e-13, .solver = solver};
    RunRequest early = request;
    early.stop = 1.2;
    EXPECT_NEAR(run(text, early).column("x").back(), at_1_2, 1e-9) << solver;
    const Signals r = run(text, request);
    if (solver == "dopri5") end = r.column("x").back();
    EXPECT_NEAR(r.column("x").back(), end, 2e-9) << solver;
    EXPECT_LT(r.whole().statistics.events, 150) << solver;
  }
}

}  // namespace
}  // namespace plantloop::testing_diagrams
