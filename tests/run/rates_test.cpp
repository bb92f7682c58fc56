// S6 and S7: rates that are inherited, mixed and crossed; loops of several rates against their exact recursions.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// ---- S6: what a block without a rate inherits

int rate_of(const Signals& r, const std::string& column) {
  return r.recording().columns[static_cast<std::size_t>(r.recording().find(column))].rate;
}
std::pair<double, double> clock_of(const Signals& r, const std::string& column) {
  return r.recording().rates[static_cast<std::size_t>(rate_of(r, column))];
}

TEST(S6Rates, OfOneClockAreInheritedAndOfSeveralTheFastestThatAllFit) {
  // Rules (b) and (c), with offsets that differ by whole periods of the fastest.
  const Signals r = run(R"(
blocks:
  t: {type: clock}
  a: {type: zero_order_hold, in: t, rate: {period: 0.1, offset: 0.05}}
  b: {type: zero_order_hold, in: t, rate: {period: 0.3, offset: 0.25}}
  one: 2*a
  both: a - b
simulation: {stop: 1}
record: [one, both]
)");
  EXPECT_EQ(clock_of(r, "one"), std::pair(0.1, 0.05));
  EXPECT_EQ(clock_of(r, "both"), std::pair(0.1, 0.05));
  EXPECT_EQ(r.samples("both").size(), 10u);
}

TEST(S6Rates, ThatDoNotFitAreErrorsWhichNameTheRateThatSeesBoth) {
  // Rule (d): periods, and offsets, that are no multiples.
  EXPECT_THAT(findings(R"(
blocks:
  t: {type: clock}
  a: {type: zero_order_hold, in: t, rate: 0.2}
  b: {type: zero_order_hold, in: t, rate: 0.3}
  d: a - b
simulation: {stop: 1}
)"),
              AllOf(HasSubstr("'d' reads signals of mixed rates: 0.2 s and 0.3 s"), HasSubstr("rate: 0.1 sees every")));
  EXPECT_THAT(findings(R"(
blocks:
  t: {type: clock}
  a: {type: zero_order_hold, in: t, rate: 0.2}
  b: {type: zero_order_hold, in: t, rate: {period: 0.2, offset: 0.05}}
  d: a - b
simulation: {stop: 1}
)"),
              HasSubstr("mixed rates: 0.2 s and 0.2 s with offset 0.05 s"));
}

TEST(S7Rates, ThatAreReadAcrossAreANoteThatAFileMayRaise) {
  const std::string text = R"(
blocks:
  t: {type: clock}
  fast: {type: zero_order_hold, in: t, rate: 0.1}
  slow: {type: unit_delay, in: fast, rate: 0.2}
  both: fast + slow
simulation: {stop: 1}
)";
  EXPECT_THAT(findings(text),
              AllOf(HasSubstr("note: 'slow' runs every 0.2 s and samples 'fast', which runs every 0.1 s"),
                    HasSubstr("note: 'both' runs every 0.1 s and holds 'slow', which runs every 0.2 s")));
  EXPECT_THAT(findings(text + "checks: {rate-mix: error}\n"), HasSubstr("error: 'both' runs every 0.1 s and holds"));
  EXPECT_THAT(findings(text + "checks: {rate-mix: off}\n"), Not(HasSubstr("runs every")));
}

TEST(S6Rates, OfContinuousAndSampledInputsTogetherAreContinuousWithHeldValues) {
  // Rule (e): x - z is a sawtooth between the hits.
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: 1}
  z: {type: zero_order_hold, in: x, rate: 0.25}
  e: x - z
simulation: {stop: 1, max_step: 0.05}
record: [e]
)");
  EXPECT_EQ(rate_of(r, "e"), 0);
  EXPECT_NEAR(r.at("e", 0.25, true), 0.25, 1e-12);
  EXPECT_EQ(r.at("e", 0.25), 0);
}

TEST(S6Rates, OfASourceAreThoseOfItsReadersWhenTheyAgree) {
  // Rule (f): through a gain too; a second reader of another rate, or none, leaves it continuous.
  const Signals r = run(R"(
blocks:
  alone: {type: sine}
  twice: {type: gain, k: 2, in: alone}
  z: {type: unit_delay, in: twice, rate: 0.1}
  shared: {type: sine}
  a: {type: unit_delay, in: shared, rate: 0.1}
  b: {type: unit_delay, in: shared, rate: 0.2}
  unread: {type: sine}
simulation: {stop: 1}
record: [alone, twice, shared, unread]
)");
  EXPECT_EQ(clock_of(r, "alone"), std::pair(0.1, 0.0));
  EXPECT_EQ(clock_of(r, "twice"), std::pair(0.1, 0.0));
  EXPECT_EQ(rate_of(r, "shared"), 0);
  EXPECT_EQ(rate_of(r, "unread"), 0);
}

TEST(S6Rates, OfParametersAloneAreConstant) {
  // Rule (a): evaluated once, and no obstacle to a rate.
  const Signals r = run(R"(
blocks:
  c: {type: constant, value: 3}
  t: {type: clock}
  z: {type: zero_order_hold, in: t, rate: 0.5}
  total: z + 2*c
simulation: {stop: 1}
record: [total]
)");
  EXPECT_EQ(clock_of(r, "total"), std::pair(0.5, 0.0));
  EXPECT_THAT(r.samples("total"), ElementsAre(6, 6.5, 7));
}

// ---- S7: transitions

TEST(S7Transitions, FromAFasterRateSample) {
  for (const char* mode : {"protected", "direct"}) {
    const Signals r = run(R"(
blocks:
  t: {type: clock}
  fast: {type: zero_order_hold, in: t, rate: 0.1}
  y: {type: rate_transition, in: fast, rate: 0.3, initial: -1, mode: )" +
                          std::string(mode) + R"(}
simulation: {stop: 1}
record: [y]
)");
    EXPECT_THAT(r.samples("y"), ElementsAre(0, 0.3, 0.6, 0.9)) << mode;
    EXPECT_EQ(clock_of(r, "y"), std::pair(0.3, 0.0));
  }
}

TEST(S7Transitions, FromASlowerRateAreOneSlowPeriodLateOrDirect) {
  const Signals r = run(R"(
blocks:
  t: {type: clock}
  slow: {type: zero_order_hold, in: 10*t, rate: {period: 0.3, offset: 0.1}}
  late: {type: rate_transition, in: slow, rate: 0.1, initial: -1}
  now: {type: rate_transition, in: slow, rate: 0.1, mode: direct}
simulation: {stop: 1}
record: [late, now]
)");
  EXPECT_THAT(r.samples("late"), ElementsAre(-1, -1, -1, -1, 1, 1, 1, 4, 4, 4, 7));
  EXPECT_THAT(r.samples("now"), ElementsAre(0, 1, 1, 1, 4, 4, 4, 7, 7, 7, 10));
}

TEST(S7Transitions, BetweenRatesThatDoNotFitTakeTheLastHitStrictlyBeforeNow) {
  const Signals r = run(R"(
blocks:
  t: {type: clock}
  u: {type: zero_order_hold, in: 10*t, rate: 0.2}
  y: {type: rate_transition, in: u, rate: 0.3, initial: -1}
  direct: {type: rate_transition, in: u, rate: 0.3, mode: direct}
simulation: {stop: 1.5}
record: [y, direct]
)");
  // At 0.3 the hit before is 0.2; at 0.6 it is 0.4, for 0.6 is a hit of both.
  EXPECT_THAT(r.samples("y"), ElementsAre(-1, 2, 4, 8, 10, 14));
  EXPECT_THAT(r.samples("direct"), ElementsAre(0, 2, 6, 8, 12, 14));
}

TEST(S7Transitions, ThatAreProtectedOpenALoopAndDirectOnesDoNot) {
  const std::string loop = R"(
blocks:
  fast: {type: sum, in: [1, back], rate: 0.1}
  slow: {type: gain, k: 0.5, in: fast, rate: 0.2}
  back: {type: rate_transition, in: slow, rate: 0.1, mode: MODE}
simulation: {stop: 1}
record: [slow]
)";
  const auto with = [&](const std::string& mode) {
    std::string text = loop;
    return text.replace(text.find("MODE"), 4, mode);
  };
  EXPECT_THAT(findings(with("protected")), Not(HasSubstr("loop")));
  EXPECT_THAT(findings(with("direct")), HasSubstr("loop"));
  // s[k] = (1 + s[k-1])/2.
  const Signals r = run(with("protected"));
  EXPECT_THAT(r.samples("slow"), ElementsAre(0.5, 0.75, 0.875, 0.9375, 0.96875, 0.984375));
}

TEST(S7Transitions, CarryVectorsAndSampleContinuousSignals) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: [1, -2], initial: [0, 3]}
  slow: {type: zero_order_hold, in: x, rate: 0.4}
  late: {type: rate_transition, in: slow, rate: 0.2, initial: [7, 8]}
  sampled: {type: rate_transition, in: x, rate: 0.5}
simulation: {stop: 1, rtol: 1e-10}
record: [late, sampled]
)");
  EXPECT_THAT(r.samples("late.1"),
              ElementsAre(7, 7, 0, 0, testing::DoubleNear(0.4, 1e-12), testing::DoubleNear(0.4, 1e-12)));
  EXPECT_EQ(r.samples("late.2")[1], 8);
  EXPECT_NEAR(r.samples("sampled.2")[2], 1, 1e-12);
}

TEST(S7Transitions, WithoutABlockASlowReaderSamplesAndAFastOneHolds) {
  const Signals r = run(R"(
blocks:
  t: {type: clock}
  fast: {type: zero_order_hold, in: t, rate: 0.1}
  slow: {type: gain, k: 1, in: fast, rate: 0.4}
  again: {type: gain, k: 1, in: slow, rate: 0.2}
simulation: {stop: 1}
record: [slow, again]
)");
  EXPECT_THAT(r.samples("slow"), ElementsAre(0, 0.4, 0.8));
  EXPECT_THAT(r.samples("again"), ElementsAre(0, 0, 0.4, 0.4, 0.8, 0.8));
}

// ---- loops of several rates

// exp(A h) and the integral of exp(A s) b ds for x' = -a x + b u: the exact step of a first-order lag.
struct Lag {
  double decay, gain;
  Lag(double a, double b, double h) : decay(std::exp(-a * h)), gain(b * -std::expm1(-a * h) / a) {}
  double operator()(double x, double u) const { return decay * x + gain * u; }
};

TEST(S8Multirate, AFastInnerAndASlowOuterPiLoopFollowTheirRecursion) {
  // x' = -2 x + 3 u; the inner controller at 10 ms, the outer one at 50 ms, both PI, with held outputs.
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: -2*x + 3*u}
  y: {type: integrator, in: x - 0.5*y}
  outer_error: {type: zero_order_hold, in: 1 - y, rate: 0.05}
  outer_sum: {type: discrete_integrator, in: outer_error, rate: 0.05}
  wanted: 1.5*outer_error + 0.8*outer_sum
  inner_error: {type: zero_order_hold, in: wanted - x, rate: 0.01}
  inner_sum: {type: discrete_integrator, in: inner_error, rate: 0.01}
  u: 2*inner_error + 6*inner_sum
simulation: {stop: 3, rtol: 1e-13, atol: 1e-15}
record: [x, y, u, wanted]
)");
  // x and y over 10 ms with u held: x' = -2x + 3u, y' = x - y/2, in closed form.
  const double h = 0.01, e2 = std::exp(-2 * h), e5 = std::exp(-0.5 * h);
  double x = 0, y = 0, outer_sum = 0, inner_sum = 0, wanted = 0, outer_error = 0;
  double most = 0;
  for (int k = 0; k <= 300; ++k) {
    if (k % 5 == 0) {
      outer_error = 1 - y;
      wanted = 1.5 * outer_error + 0.8 * outer_sum;
    }
    const double inner_error = wanted - x, u = 2 * inner_error + 6 * inner_sum;
    const double t = k / 100.0;
    most = std::max({most, std::fabs(r.at("x", t) - x), std::fabs(r.at("y", t) - y), std::fabs(r.at("u", t) - u),
                     std::fabs(r.at("wanted", t) - wanted)});
    if (k % 5 == 0) outer_sum += 0.05 * outer_error;
    inner_sum += h * inner_error;
    // x(s) = r + (x0 - r) e^{-2 s} with r = 3u/2; y = 2 r + c e^{-s/2} - (x0 - r)/1.5 e^{-2 s}.
    const double rest = 1.5 * u, d = x - rest;
    const double c = y - 2 * rest + d / 1.5;
    x = rest + d * e2;
    y = 2 * rest + c * e5 - d / 1.5 * e2;
  }
  EXPECT_LT(most, 1e-12);
}

TEST(S8Multirate, ClocksWithOffsetsTakeTurnsExactly) {
  // Two samplers of one period, a third of it apart, drive one lag in turns: between hits the lag's exact step.
  const Signals r = run(R"(
blocks:
  a: {type: zero_order_hold, in: 1 - x, rate: {period: 0.3, offset: 0.1}}
  b: {type: zero_order_hold, in: 0.5*x, rate: {period: 0.3, offset: 0.2}}
  x: {type: integrator, in: -1.5*x + 2*a - b, initial: 0.4}
simulation: {stop: 6, rtol: 1e-13, atol: 1e-15}
record: [x]
)");
  const Lag step(1.5, 1, 0.1);
  // Before their first hits the samples are those of the start.
  double x = 0.4, a = 1 - x, b = 0.5 * x, most = 0;
  for (int k = 0; k <= 60; ++k) {
    if (k % 3 == 1) a = 1 - x;
    if (k % 3 == 2) b = 0.5 * x;
    if (k % 3 != 0) most = std::max(most, std::fabs(r.at("x", k / 10.0) - x));
    x = step(x, 2 * a - b);
  }
  EXPECT_LT(most, 1e-12);
}

TEST(S8Multirate, ASlowFastSlowChainWithDelaysFollowsItsRecursion) {
  // Slow (0.6) -> fast (0.2) -> slow (0.6), closed by the slow delay; sampled parts only.
  const Signals r = run(R"(
blocks:
  slow: {type: discrete_transfer_function, num: [0.5, 0.1], den: [1, -0.4], in: 1 - back, rate: 0.6}
  up: {type: rate_transition, in: slow, rate: 0.2}
  fast: {type: discrete_integrator, in: up - 0.8*fast, rate: 0.2}
  down: {type: rate_transition, in: fast, rate: 0.6}
  back: {type: unit_delay, in: down, rate: 0.6}
simulation: {stop: 60}
record: [slow, fast, back]
)");
  double w = 0, held = 0, before = 0, fast = 0, back = 0, most = 0, slow = 0;
  for (int k = 0; k <= 300; ++k) {
    double down = 0;
    const bool is_slow = k % 3 == 0;
    if (is_slow) {
      // num = 0.5 z + 0.1 over z - 0.4, as 0.5 + 0.3/(z - 0.4): w[k+1] = 0.4 w + u.
      slow = 0.5 * (1 - back) + 0.3 * w;
      held = before;
      before = slow;
      down = fast;
    }
    const double t = k / 5.0;
    most = std::max({most, std::fabs(r.at("slow", t) - slow), std::fabs(r.at("fast", t) - fast)});
    if (is_slow) most = std::max(most, std::fabs(r.at("back", t) - back));
    fast += 0.2 * (held - 0.8 * fast);
    if (is_slow) {
      w = 0.4 * w + (1 - back);
      back = down;
    }
  }
  EXPECT_LT(most, 1e-12);
}

TEST(S8Multirate, RatesThatNeverFitMeetEveryCommonMultiple) {
  // 0.07 and 0.11 s around one integrator: its exact value by the sums of what was held.
  const Signals r = run(R"(
blocks:
  a: {type: zero_order_hold, in: 1 - x, rate: 0.07}
  b: {type: zero_order_hold, in: -0.5*x, rate: 0.11}
  x: {type: integrator, in: a + b}
simulation: {stop: 7.7, rtol: 1e-13, atol: 1e-15}
record: [x]
)");
  double x = 0, a = 0, b = 0, most = 0;
  for (int k = 0; k <= 770; ++k) {  // hundredths
    if (k % 7 == 0) a = 1 - x;
    if (k % 11 == 0) b = -0.5 * x;
    if (k % 7 == 0 || k % 11 == 0) most = std::max(most, std::fabs(r.at("x", k / 100.0) - x));
    x += 0.01 * (a + b);
  }
  EXPECT_LT(most, 1e-12);
}

// ---- S1 and S8: many hits, and steps that end on them

TEST(S1Time, TenMillionHitsDoNotDrift) {
  // Rows on a coarse grid only: the clocks count all of the hits, at tenths and at thirds of a millisecond.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr int hits = 100'000;
#else
  constexpr int hits = 10'000'000;
#endif
  const double stop = hits / 10.0;
  const Signals r = run(R"(
blocks:
  n: {type: unit_delay, in: n + 1, rate: 0.1}
  t: {type: zero_order_hold, in: time, rate: 0.1}
  late: {type: zero_order_hold, in: t, rate: {period: 1000, offset: 0.7}}
simulation: {stop: )" + std::to_string(stop) +
                        ", output_interval: 1000, max_steps: 20000000}\nrecord: [n, t, late]\n");
  EXPECT_EQ(r.last("n"), hits);
  EXPECT_EQ(r.last("t"), stop);
  EXPECT_GE(r.whole().statistics.hits, hits);
  const std::vector<double> n = r.column("n"), t = r.column("t");
  for (std::size_t i = 0; i < n.size(); ++i) {
    EXPECT_EQ(n[i], static_cast<double>(i) * 10000);
    EXPECT_EQ(t[i], static_cast<double>(i) * 1000);
  }
  EXPECT_EQ(r.at("late", stop), std::floor((stop - 0.7) / 1000) * 1000 + 0.7);
}

TEST(S8MajorStep, AnEdgeExactlyOnAHitIsSeenByTheHit) {
  // Of a step, an event's reset and a hit at one instant the hit sees what holds after the other two.
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 0.7}
  x: {type: integrator, in: 1, reset: {when: u > 0.5, to: 10}}
  z: {type: zero_order_hold, in: u + x, rate: 0.1}
simulation: {stop: 1}
record: [u, x, z]
)");
  const std::vector<double> z = r.samples("z");
  ASSERT_EQ(z.size(), 11u);
  EXPECT_NEAR(z[6], 0.6, 1e-12);
  EXPECT_NEAR(z[7], 11, 1e-12);
  EXPECT_NEAR(z[8], 11.1, 1e-12);
  // Both sides of the edge stand in the rows, though a hit is there too.
  EXPECT_EQ(r.at("u", 0.7, true), 0);
  EXPECT_EQ(r.at("u", 0.7), 1);
  EXPECT_NEAR(r.at("x", 0.7, true), 0.7, 1e-12);
}

TEST(S9Restarts, AreHotWhereAHitChangesNothingThatDerivativesRead) {
  // The held value stays the same number after the third hit.
  const Signals r = run(R"(
blocks:
  n: {type: unit_delay, in: 'min(n + 1, 3)', rate: 0.1}
  x: {type: integrator, in: n - x}
simulation: {stop: 2}
record: [x]
)");
  EXPECT_EQ(r.whole().statistics.solver.cold_restarts, 3);
  EXPECT_GE(r.whole().statistics.solver.hot_restarts, 16);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
