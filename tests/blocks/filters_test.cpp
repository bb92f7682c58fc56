// Filters and estimators by design parameters, against closed forms and against the same systems written out.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/error.h"
#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

const double pi = std::acos(-1);
constexpr double tolerance = 1e-7;  // a hundred times the error of a step
const std::string accurate = "simulation: {stop: 6, rtol: 1e-9, atol: 1e-11}\n";

std::string wrong(const std::string& block) {
  return findings("blocks: {y: {" + block + "}}\nsimulation: {stop: 1}\n");
}

TEST(ZeroPoleGain, IsTheProductOfItsFactors) {
  // 2 (s + 3)/((s + 1) (s^2 + 2 s + 5))
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 2.5], values: [1, -2, 0.5]}
  y: {type: zero_pole_gain, in: [u, -u], zeros: -3, poles: [[-1, 2], [-1, 0], [-1, -2]], k: 2}
  same: {type: transfer_function, in: u, num: [2, 6], den: [1, 3, 7, 5]}
  difference: y - [same, -same]
)" + accurate);
  EXPECT_LT(r.greatest("difference.1"), tolerance);
  EXPECT_LT(r.greatest("difference.2"), tolerance);
}

TEST(ZeroPoleGain, PassesTheInputOnWithAsManyZerosAsPoles) {
  // 3 (s + 2)/(s + 1) = 3 + 3/(s + 1)
  const Signals r = run(R"(
blocks:
  y: {type: zero_pole_gain, in: 1, zeros: -2, poles: -1, k: 3}
  difference: y - (6 - 3*exp(-time))
  rest: {type: zero_pole_gain, in: 1, zeros: -2, poles: -1, k: 3, initial: 6}
)" + accurate);
  EXPECT_LT(r.greatest("difference"), tolerance);
  for (const double v : r.column("rest")) EXPECT_NEAR(v, 6, 1e-12);
}

TEST(ZeroPoleGain, SaysWhatIsWrongWithItsRoots) {
  EXPECT_THAT(wrong("type: zero_pole_gain, in: 1, zeros: [1, 2], poles: 3"),
              HasSubstr("there are more zeros, 2, than poles, 1: a filter whose output would need derivatives"));
  EXPECT_THAT(wrong("type: zero_pole_gain, in: 1, poles: [[-1, 2], [-1, -3]]"),
              HasSubstr("beside [-1, 2] there must be [-1, -2]"));
  EXPECT_THAT(wrong("type: zero_pole_gain, in: 1, poles: [[-1, 2, 3]]"), HasSubstr("there are 3 columns"));
}

TEST(DiscreteZeroPoleGain, IsItsRecursion) {
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 2, 3], values: [1, 4, 2, 8]}
  y: {type: discrete_zero_pole_gain, in: u, zeros: [-1, 0.5], poles: [[0.5, 0.5], [0.5, -0.5]], k: 2, rate: 0.5}
  same: {type: discrete_transfer_function, in: u, num: [2, 1, -1], den: [1, -1, 0.5], rate: 0.5}
  difference: y - same
simulation: {stop: 20}
)");
  EXPECT_LT(r.greatest("difference"), 1e-12);
}

TEST(Butterworth, AnswersAStepAsItsPolesSay) {
  // Order 2: poles (-1 +- i)/sqrt 2;  order 3: -1 and (-1 +- i sqrt 3)/2, in units of the cut-off.
  const Signals r = run(R"(
parameters: {w: 3}
blocks:
  a: w/sqrt(2)*time
  second: {type: butterworth, in: [1, -2], frequency: w}
  third: {type: butterworth, in: 1, order: 3, frequency: w}
  high: {type: butterworth, in: 1, kind: highpass, frequency: w}
  d2: second - [1, -2]*(1 - exp(-a)*(cos(a) + sin(a)))
  d3: third - (1 - exp(-w*time) - 2/sqrt(3)*exp(-w*time/2)*sin(sqrt(3)/2*w*time))
  dh: high - exp(-a)*(cos(a) - sin(a))
)" + accurate);
  for (const char* difference : {"d2.1", "d2.2", "d3", "dh"})
    EXPECT_LT(r.greatest(difference), tolerance) << difference;
}

TEST(Butterworth, MakesBandsOfResonators) {
  // Cut-offs 1 and 4: centre 2, width B = 3. With p = (s^2 + 4)/(3 s): 1/(p^2 + sqrt 2 p + 1) and p^2/(...).
  const Signals r = run(R"(
parameters: {q: sqrt(2)}
blocks:
  u: {type: staircase, times: [0, 1, 2.5], values: [1, -2, 0.5]}
  pass: {type: butterworth, in: u, kind: bandpass, lower: 1, upper: 4}
  stop: {type: butterworth, in: u, kind: bandstop, lower: 1, upper: 4}
  pass_1: {type: butterworth, in: u, order: 1, kind: bandpass, lower: 1, upper: 4}
  same_pass: {type: transfer_function, in: u, num: [9, 0, 0], den: [1, 3*q, 17, 12*q, 16]}
  same_stop: {type: transfer_function, in: u, num: [1, 0, 8, 0, 16], den: [1, 3*q, 17, 12*q, 16]}
  same_1: {type: transfer_function, in: u, num: [3, 0], den: [1, 3, 4]}
  difference: [pass - same_pass, stop - same_stop, pass_1 - same_1]
)" + accurate);
  for (const char* d : {"difference.1", "difference.2", "difference.3"}) EXPECT_LT(r.greatest(d), tolerance) << d;
}

TEST(Butterworth, StartsSettled) {
  const Signals r = run(R"(
blocks:
  low: {type: butterworth, in: 2, order: 5, initial: 2}
  high: {type: butterworth, in: 2, order: 5, kind: highpass, initial: 2}
  pass: {type: butterworth, in: 2, order: 3, kind: bandpass, lower: 1, upper: 2, initial: 2}
  stop: {type: butterworth, in: [2, 4], order: 3, kind: bandstop, lower: 1, upper: 2, initial: [2, 4]}
)" + accurate);
  for (const double v : r.column("low")) EXPECT_NEAR(v, 2, 1e-12);
  for (const double v : r.column("high")) EXPECT_NEAR(v, 0, 1e-12);
  for (const double v : r.column("pass")) EXPECT_NEAR(v, 0, 1e-12);
  for (const double v : r.column("stop.2")) EXPECT_NEAR(v, 4, 1e-12);
}

TEST(Butterworth, SaysWhichCutOffsItNeeds) {
  EXPECT_THAT(wrong("type: butterworth, in: 1, kind: bandpass, lower: 1"),
              HasSubstr("a bandpass needs `lower` and `upper`"));
  EXPECT_THAT(wrong("type: butterworth, in: 1, lower: 1"), HasSubstr("a lowpass has one cut-off, `frequency`"));
  EXPECT_THAT(wrong("type: butterworth, in: 1, kind: bandstop, lower: 2, upper: 1"),
              HasSubstr("'upper' must be greater than 'lower', but they are 1 and 2"));
}

TEST(DiscreteButterworth, IsTheBilinearTransformOfItsPoles) {
  // At a quarter of the sampling frequency tan(w T/2) = 1: (z + 1)^3/(6 z^3 + 2 z), and its mirror image in z -> -z.
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 2.5], values: [1, -2, 0.5]}
  low: {type: discrete_butterworth, in: [u, 2*u], order: 3, frequency: pi/2/0.1, rate: 0.1}
  high: {type: discrete_butterworth, in: u, order: 3, kind: highpass, frequency: pi/2/0.1, rate: 0.1}
  same_low: {type: discrete_transfer_function, in: u, num: [1, 3, 3, 1], den: [6, 0, 2, 0], rate: 0.1}
  same_high: {type: discrete_transfer_function, in: u, num: [1, -3, 3, -1], den: [6, 0, 2, 0], rate: 0.1}
  difference: [low.1 - same_low, low.2 - 2*same_low, high - same_high]
simulation: {stop: 5}
)");
  for (const char* d : {"difference.1", "difference.2", "difference.3"}) EXPECT_LT(r.greatest(d), 1e-12) << d;
}

TEST(DiscreteButterworth, HasItsGainAtItsCutOffs) {
  // Of A sin(w k + f): A^2 = (y0^2 + y1^2 - 2 y0 y1 cos w)/sin^2 w.
  const auto gain = [](const std::string& kind, double w) {
    const Signals r = run("blocks:\n  u: {type: sine, frequency: " + std::to_string(w) +
                          "}\n  y: {type: discrete_butterworth, in: u, order: 4, kind: " + kind +
                          ", rate: 1}\nsimulation: {stop: 600}\n");
    const std::vector<double> y = r.samples("y");
    const double y0 = y[y.size() - 2], y1 = y.back(), c = std::cos(w);
    return std::sqrt((y0 * y0 + y1 * y1 - 2 * y0 * y1 * c) / (1 - c * c));
  };
  const double half = std::sqrt(0.5), exact = 1e-5;  // frequencies are written with six digits
  EXPECT_NEAR(gain("lowpass, frequency: 0.7", 0.7), half, exact);
  EXPECT_NEAR(gain("highpass, frequency: 0.7", 0.7), half, exact);
  const std::string band = "bandpass, lower: 2*atan(0.5), upper: 2*atan(2)";  // centre pi/2
  EXPECT_NEAR(gain(band, 2 * std::atan(0.5)), half, exact);
  EXPECT_NEAR(gain(band, pi / 2), 1, exact);
  EXPECT_NEAR(gain("bandstop, lower: 2*atan(0.5), upper: 2*atan(2)", pi / 2), 0, exact);
  EXPECT_NEAR(gain("bandstop, lower: 2*atan(0.5), upper: 2*atan(2)", 2 * std::atan(2)), half, exact);
}

TEST(DiscreteButterworth, StartsSettledAndRefusesCutOffsBeyondHalfTheRate) {
  const Signals r = run(R"(
blocks:
  low: {type: discrete_butterworth, in: 2, order: 5, frequency: 3, initial: 2, rate: 0.1}
  stop: {type: discrete_butterworth, in: [2, 4], order: 3, kind: bandstop, lower: 1, upper: 2, initial: [2, 4], rate: 0.1}
simulation: {stop: 20}
)");
  for (const double v : r.samples("low")) EXPECT_NEAR(v, 2, 1e-10);
  for (const double v : r.samples("stop.2")) EXPECT_NEAR(v, 4, 1e-10);
  try {
    run("blocks: {y: {type: discrete_butterworth, in: 1, frequency: 40, rate: 0.1}}\nsimulation: {stop: 1}\n");
    FAIL() << "the run went on";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the cut-off of block 'y' is 40 rad/s, but it must lie below half the sampling "
                                        "frequency, 31.4159 rad/s"));
  }
}

TEST(KalmanFilter, OfAConstantIsTheWeightedMean) {
  // Without noise in the state, after k + 1 measurements of variance R and a guess of variance P:
  // (sum y + R/P guess)/(k + 1 + R/P).
  const Signals r = run(R"(
blocks:
  y: {type: staircase, times: [0, 1, 2, 3], values: [4, 7, 1, 6]}
  f: {type: kalman_filter, in: {y: y}, A: 1, C: 1, Q: 0, R: 2, P: 4, initial: 3, rate: 1}
  before: {type: kalman_filter, in: {y: y}, A: 1, C: 1, Q: 0, R: 2, P: 4, initial: 3, estimate: predicted, rate: 1}
simulation: {stop: 3}
record: [f.x, before.x]
)");
  const double y[] = {4, 7, 1, 6};
  double sum = 0.5 * 3;
  const std::vector<double> x = r.samples("f.x"), before = r.samples("before.x");
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(before[k], k == 0 ? 3 : x[k - 1], 1e-12);
    sum += y[k];
    EXPECT_NEAR(x[k], sum / (static_cast<double>(k) + 1.5), 1e-12);
  }
}

TEST(KalmanFilter, ReachesItsStationaryGain) {
  // A = C = Q = 1, R = 2: P- = 2 solves its Riccati equation, the gain is 1/2, so the error halves at each sample.
  const Signals r = run(R"(
blocks:
  y: {type: step, time: 30}
  f: {type: kalman_filter, in: {y: y}, A: 1, C: 1, Q: 1, R: 2, P: 10, rate: 1}
simulation: {stop: 33}
record: [f.x]
)");
  const std::vector<double> x = r.samples("f.x");
  EXPECT_NEAR(x[30], 0.5, 1e-9);
  EXPECT_NEAR(x[31], 0.75, 1e-9);
  EXPECT_NEAR(x[33], 0.9375, 1e-9);
}

TEST(KalmanFilter, CombinesTwoSensorsByTheirVariances) {
  // Variances 1 and 3 are one sensor (3 y1 + y2)/4 of variance 3/4.
  const Signals r = run(R"(
blocks:
  a: {type: sine, frequency: 0.3}
  b: {type: sine, frequency: 0.7, phase: 1}
  two: {type: kalman_filter, in: {y: [a, b]}, A: 0.9, C: [[1], [1]], Q: 0.5, R: [1, 3], rate: 1}
  one: {type: kalman_filter, in: {y: (3*a + b)/4}, A: 0.9, C: 1, Q: 0.5, R: 0.75, rate: 1}
  difference: two.x - one.x
simulation: {stop: 40}
)");
  EXPECT_LT(r.greatest("difference"), 1e-12);
}

TEST(KalmanFilter, FollowsAKnownSystemExactly) {
  // Started right and without noise, the estimate is the state, whatever the gain; the input is known.
  const Signals r = run(R"(
parameters: {A: [[0.8, 0.3], [-0.2, 0.9]], B: [0.5, 1], C: [[1, 0]]}
blocks:
  u: {type: sine}
  x: {type: discrete_state_space, in: u, A: A, B: B, C: [[1, 0], [0, 1]], initial: [1, -1], rate: 0.2}
  f: {type: kalman_filter, in: {y: x.1 + 0.5*u, u: u}, A: A, B: B, C: C, D: 0.5, initial: [1, -1], rate: 0.2}
  lost: {type: kalman_filter, in: {y: x.1 + 0.5*u, u: u}, A: A, B: B, C: C, D: 0.5, R: 1e-3, rate: 0.2}
  difference: f.x - x
  late: lost.x - x
  fit: f.fitted - (x.1 + 0.5*u)
simulation: {stop: 20}
)");
  EXPECT_LT(r.greatest("difference.1"), 1e-12);
  EXPECT_LT(r.greatest("difference.2"), 1e-12);
  EXPECT_LT(r.greatest("fit"), 1e-12);
  EXPECT_NEAR(r.last("late.2"), 0, 1e-6);
}

TEST(KalmanFilter, SaysWhichMatrixDoesNotFit) {
  EXPECT_THAT(wrong("type: kalman_filter, in: 1, A: [[1, 2]], C: 1, rate: 1"), HasSubstr("A must be square"));
  EXPECT_THAT(wrong("type: kalman_filter, in: 1, A: [[1, 0], [0, 1]], C: [1, 0, 0], rate: 1"),
              HasSubstr("C has 3 columns, A has 2 rows"));
  EXPECT_THAT(wrong("type: kalman_filter, in: 1, A: [[1, 0], [0, 1]], C: [1, 0], Q: [1, 2, 3], rate: 1"),
              HasSubstr("Q must be 2 by 2, its diagonal or one number, but it is a vector of 3"));
}

TEST(DiscretePid, CountsItsIntegralByItsMethod) {
  const Signals r = run(R"(
blocks:
  f: {type: discrete_pid, in: 2, kp: 3, ki: 0.5, initial: 1, rate: 0.1}
  b: {type: discrete_pid, in: 2, kp: 3, ki: 0.5, initial: 1, method: backward, rate: 0.1}
  t: {type: discrete_pid, in: 2, kp: 3, ki: 0.5, initial: 1, method: trapezoidal, rate: 0.1}
simulation: {stop: 2}
record: [f.u, b.u, t.u]
)");
  for (std::size_t k = 0; k <= 20; ++k) {
    const double n = static_cast<double>(k);
    EXPECT_NEAR(r.samples("f.u")[k], 7 + 0.1 * n, 1e-12);
    EXPECT_NEAR(r.samples("b.u")[k], 7 + 0.1 * (n + 1), 1e-12);
    EXPECT_NEAR(r.samples("t.u")[k], 7 + 0.1 * (n + 0.5), 1e-12);
  }
}

TEST(DiscretePid, SettlesAtTheSlopeOfARamp) {
  // Of e = t, with q = 1/(1 + N T): d = 1 - q^k (backward), with q = 1 - N T (forward).
  const Signals r = run(R"(
blocks:
  b: {type: discrete_pid, in: time, kp: 0, ki: 0, kd: 2, N: 5, rate: 0.1}
  f: {type: discrete_pid, in: time, kp: 0, ki: 0, kd: 2, N: 5, filter_method: forward, rate: 0.1}
simulation: {stop: 2}
record: [b.u, f.u]
)");
  for (std::size_t k = 0; k <= 20; ++k) {
    EXPECT_NEAR(r.samples("b.u")[k], 2 * (1 - std::pow(1 / 1.5, static_cast<double>(k))), 1e-12);
    EXPECT_NEAR(r.samples("f.u")[k], 2 * (1 - std::pow(0.5, static_cast<double>(k))), 1e-12);
  }
}

TEST(DiscretePid, DoesNotWindUp) {
  // e = 1 for 2 s, then -1; ki = 1, limit 1. Clamped, the integral falls at once; tracking with t_track = T takes the
  // whole excess back at each sample but that of the last one; without either it has 1 to lose first.
  const std::string c = ": {type: discrete_pid, in: e, kp: 0, ki: 1, upper: 1, rate: 0.125";
  const Signals r = run("blocks:\n  e: {type: staircase, times: [0, 2], values: [1, -1]}\n  clamped" + c +
                        ", anti_windup: clamp}\n  track" + c + ", t_track: 0.125}\n  none" + c +
                        ", anti_windup: none}\nsimulation: {stop: 3}\nrecord: [clamped.u, track.u, none.u]\n");
  EXPECT_DOUBLE_EQ(r.last("clamped.u"), 0);
  EXPECT_DOUBLE_EQ(r.last("track.u"), 0);
  EXPECT_DOUBLE_EQ(r.last("none.u"), 1);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
