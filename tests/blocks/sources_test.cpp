// Sources: values before, at and after every edge, and sequences against their definitions.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

// Time in s up to which `at` is asked between rows: straight lines between rows need none.
constexpr double rounding = 1e-13;

TEST(Constant, GivesNumbersVectorsAndMatrices) {
  const Signals r = run(R"(
blocks:
  a: {type: constant, value: 2.5}
  b: {type: constant, value: [1, -2]}
  m: {type: constant, value: [[1, 2], [3, 4]]}
simulation: {stop: 1}
)");
  EXPECT_EQ(r.last("a"), 2.5);
  EXPECT_EQ(r.last("b.2"), -2);
  EXPECT_EQ(r.last("m.2.1"), 3);
}

TEST(Step, JumpsAtItsTimeAndHasBothSides) {
  const Signals r = run(R"(
blocks:
  y: {type: step, time: 0.3, before: 1, after: [2, 3]}
  early: {type: step, time: 0, after: 5}
  x: {type: integrator, in: y.1}
simulation: {stop: 1}
)");
  EXPECT_EQ(r.at("y.1", 0.3, true), 1);
  EXPECT_EQ(r.at("y.1", 0.3), 2);
  EXPECT_EQ(r.at("y.2", 0.3), 3);
  EXPECT_EQ(r.at("early", 0), 5);  // time <= start: after from the start
  EXPECT_NEAR(r.last("x"), 0.3 + 2 * 0.7, rounding);
}

TEST(Ramp, RisesFromItsStart) {
  const Signals r = run(R"(
blocks:
  y: {type: ramp, start: 0.25, slope: 4, initial: 1}
  x: {type: integrator, in: y}
simulation: {stop: 1.25}
)");
  EXPECT_EQ(r.at("y", 0.1), 1);
  EXPECT_NEAR(r.last("y"), 5, rounding);
  EXPECT_NEAR(r.last("x"), 1.25 + 2, 1e-12);  // the kink is a stop, so a polynomial of degree 2 is exact
}

TEST(Sine, IsASineInRadiansPerSecond) {
  const Signals r = run(R"(
blocks:
  y: {type: sine, amplitude: 2, frequency: 3, phase: 0.5, bias: 1}
  difference: y - (1 + 2*sin(3*time + 0.5))
simulation: {stop: 4}
)");
  EXPECT_LT(r.greatest("difference"), rounding);
}

TEST(Pulse, HasEdgesAtDelayAndWidth) {
  const Signals r = run(R"(
blocks:
  y: {type: pulse, amplitude: 3, period: 0.5, width: 0.2, delay: 0.1, bias: 1}
  x: {type: integrator, in: y - 1}
simulation: {stop: 2.1}
)");
  EXPECT_EQ(r.at("y", 0.05), 1);
  EXPECT_EQ(r.at("y", 0.1, true), 1);
  EXPECT_EQ(r.at("y", 0.1), 4);
  EXPECT_EQ(r.at("y", 0.1 + 0.2, true), 4);
  EXPECT_EQ(r.at("y", 0.1 + 0.2), 1);
  EXPECT_NEAR(r.last("x"), 4 * 3 * 0.2, 1e-12);  // four whole pulses
}

TEST(Pulse, AsWideAsItsPeriodStaysUp) {
  const Signals r = run(R"(
blocks:
  y: {type: pulse, period: 0.1, width: 0.1, delay: 0.3}
  x: {type: integrator, in: y}
simulation: {stop: 10.3}
)");
  EXPECT_NEAR(r.last("x"), 10, 1e-12);
}

TEST(Pulse, MayBeginBeforeTheStart) {
  // Edges at -0.3, 0.7, 1.7, ...; a width of 0 is no pulse at all.
  const Signals r = run(R"(
blocks:
  y: {type: pulse, period: 1, width: 0.5, delay: -0.3}
  s: {type: square, period: 1, width: 0.25, delay: -0.5}
  none: {type: pulse, period: 1, width: 0}
simulation: {stop: 2}
)");
  EXPECT_EQ(r.at("y", 0), 1);
  EXPECT_EQ(r.at("y", 0.2), 0);
  EXPECT_EQ(r.at("y", 0.7), 1);
  EXPECT_EQ(r.at("s", 0), -1);
  EXPECT_EQ(r.at("s", 0.5), 1);
  EXPECT_EQ(r.at("s", 0.75), -1);
  EXPECT_EQ(r.greatest("none"), 0);
}

TEST(Square, AlternatesWithHalfAPeriodByDefault) {
  const Signals r = run(R"(
blocks:
  y: {type: square, amplitude: 2, period: 1, bias: 0.5}
  x: {type: integrator, in: y - 0.5}
simulation: {stop: 3}
)");
  EXPECT_EQ(r.at("y", 0), 2.5);
  EXPECT_EQ(r.at("y", 0.5), -1.5);
  EXPECT_NEAR(r.at("x", 2.5), 1, 1e-12);
  EXPECT_NEAR(r.last("x"), 0, 1e-12);
}

TEST(Pulse, RefusesAWidthBeyondThePeriod) {
  EXPECT_THAT(findings("blocks: {y: {type: pulse, period: 1, width: 2}}\nsimulation: {stop: 1}\n"),
              HasSubstr("the width is longer than the period"));
}

TEST(Staircase, IsContinuousFromTheRight) {
  const Signals r = run(R"(
blocks:
  y: {type: staircase, times: [0, 1, 2.5], values: [1, 3, -1]}
  rows: {type: staircase, times: [1, 2], values: [[1, 10], [2, 20]]}
simulation: {stop: 3}
)");
  EXPECT_EQ(r.at("y", 1, true), 1);
  EXPECT_EQ(r.at("y", 1), 3);
  EXPECT_EQ(r.at("y", 2.5), -1);
  EXPECT_EQ(r.at("rows.2", 0.5), 10);
  EXPECT_EQ(r.at("rows.1", 2), 2);
}

TEST(Staircase, SaysWhatIsWrongWithItsLists) {
  EXPECT_THAT(findings("blocks: {y: {type: staircase, times: [0, 1, 2], values: [1, 2]}}\nsimulation: {stop: 1}\n"),
              HasSubstr("3 times need as many values, but there are 2"));
  EXPECT_THAT(findings("blocks: {y: {type: staircase, times: [0, 2, 1], values: [1, 2, 3]}}\nsimulation: {stop: 1}\n"),
              HasSubstr("must ascend"));
}

TEST(Clock, GivesTheTime) {
  const Signals r = run("blocks: {y: {type: clock}}\nsimulation: {start: 1, stop: 3}\n");
  EXPECT_EQ(r.at("y", 1), 1);
  EXPECT_EQ(r.last("y"), 3);
}

TEST(RandomLevels, OfLcgAreTheNumbersOfTheBook) {
  // dynamics.md section 6: u(k) uniform in [-1.2, 1.2] from lcg(12345).
  const Signals r = run(R"(
blocks:
  u: {type: random_levels, generator: lcg, seed: 12345, lower: -1.2, upper: 1.2, rate: 1}
  held: {type: random_levels, generator: lcg, seed: 12345, lower: -1.2, upper: 1.2, hold: 3, rate: 1}
simulation: {stop: 23}
)");
  const std::vector<double> u = r.samples("u");
  ASSERT_EQ(u.size(), 24U);
  EXPECT_NEAR(u[0], -0.96812033, 5e-9);
  EXPECT_NEAR(u[1], 0.80158711, 5e-9);
  EXPECT_NEAR(u[2], 1.07448599, 5e-9);
  EXPECT_NEAR(u[3], -1.11389137, 5e-9);
  const std::vector<double> held = r.samples("held");
  for (std::size_t k = 0; k < held.size(); ++k) EXPECT_EQ(held[k], u[k / 3]);
}

TEST(RandomLevels, OfTheCounterAreUniformAndDifferBetweenBlocks) {
  const Signals r = run(R"(
blocks:
  a: {type: random_levels, lower: -1, upper: 1, rate: 1}
  b: {type: random_levels, lower: -1, upper: 1, rate: 1}
  v: {type: random_levels, lower: [0, 0], hold: 2, rate: 1}
simulation: {stop: 9999}
)");
  const std::vector<double> a = r.samples("a"), b = r.samples("b");
  const double n = static_cast<double>(a.size());
  double mean = 0, square = 0, product = 0, next = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    mean += a[k] / n;
    square += a[k] * a[k] / n;
    product += a[k] * b[k] / n;
    if (k > 0) next += a[k] * a[k - 1] / n;
  }
  // Five standard deviations of each estimate: sigma/sqrt(n).
  EXPECT_NEAR(mean, 0, 5 * 0.577 / 100);
  EXPECT_NEAR(square, 1.0 / 3, 5 * 0.298 / 100);
  EXPECT_NEAR(product, 0, 5 / 3.0 / 100);
  EXPECT_NEAR(next, 0, 5 / 3.0 / 100);
  const std::vector<double> v1 = r.samples("v.1"), v2 = r.samples("v.2");
  EXPECT_NE(v1[0], v2[0]);
  EXPECT_EQ(v1[0], v1[1]);
  EXPECT_NE(v1[1], v1[2]);
}

TEST(RandomLevels, OfASeedAreAlwaysTheSame) {
  const std::string text = "blocks: {a: {type: random_levels, seed: SEED, rate: 1}}\nsimulation: {stop: 5}\n";
  const auto with_seed = [&](const std::string& seed) {
    std::string t = text;
    return run(t.replace(t.find("SEED"), 4, seed)).samples("a");
  };
  EXPECT_EQ(with_seed("7"), with_seed("7"));
  EXPECT_NE(with_seed("7"), with_seed("8"));
}

TEST(RandomLevels, NeedARateAndASeedThatFits) {
  EXPECT_THAT(findings("blocks: {a: {type: random_levels}}\nsimulation: {stop: 1}\n"), HasSubstr("needs a rate"));
  EXPECT_THAT(findings("blocks: {a: {type: random_levels, generator: lcg, seed: 0, rate: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("whole number from 1 to 2147483646"));
  EXPECT_THAT(findings("blocks: {a: {type: random_levels, seed: 1.5, rate: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("a seed is a whole number"));
}

TEST(Prbs, OfSevenBitsIsTheSequenceOfTheBook) {
  // dynamics.md section 1: 127 levels of 5 samples, first twelve bits 7 times +1, then 5 times -1.
  const Signals r = run(R"(
blocks:
  u: {type: prbs, bits: 7, hold: 5, amplitude: 1, rate: 0.02}
simulation: {stop: 12.68}
)");
  const std::vector<double> u = r.samples("u");
  ASSERT_EQ(u.size(), 635U);
  for (std::size_t k = 0; k < 60; ++k) EXPECT_EQ(u[k], k < 35 ? 1 : -1) << k;
  EXPECT_NEAR(std::accumulate(u.begin(), u.end(), 0.0) / 635, 0.0078740157, 1e-10);
}

TEST(Prbs, OfEveryLengthHasAllLevels) {
  // A sequence of the greatest length has 2^(n-1) ones, and a circular autocorrelation of -1 at every shift: only then
  // are the taps right. Beyond 12 bits the sums get long; there the taps are those of the same published table.
  for (int bits = 2; bits <= 12; ++bits) {
    const int length = (1 << bits) - 1;
    const Signals r = run("blocks: {u: {type: prbs, bits: " + std::to_string(bits) +
                          ", rate: 1}}\nsimulation: {stop: " + std::to_string(2 * length - 1) + "}\n");
    const std::vector<double> u = r.samples("u");
    const auto n = static_cast<std::size_t>(length);
    ASSERT_EQ(u.size(), 2 * n);
    EXPECT_EQ(std::accumulate(u.begin(), u.begin() + length, 0.0), 1) << bits;
    for (const std::size_t shift : {std::size_t{1}, std::size_t{2}, n / 2, n - 1}) {
      double sum = 0;
      for (std::size_t k = 0; k < n; ++k) sum += u[k] * u[k + shift];
      EXPECT_EQ(sum, -1) << bits << " bits, shift " << shift;
    }
    EXPECT_EQ(std::vector<double>(u.begin(), u.begin() + length), std::vector<double>(u.begin() + length, u.end()));
  }
}

}  // namespace
}  // namespace plantloop::testing_diagrams
