// Converters and fixed-point arithmetic, against integers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using testing::HasSubstr;

TEST(Adc, RoundsToTheNearestCodeOfItsRange) {
  const Signals r = run(R"(
blocks:
  u: {type: random_levels, lower: -3, upper: 7, rate: 1}
  ends: {type: adc, in: u, bits: 10, lower: -2, upper: 5}
  steps: {type: adc, in: u, bits: 10, lower: -2, upper: 5, span: steps, rounding: floor}
simulation: {stop: 300}
)");
  const auto u = r.samples("u"), code = r.samples("ends.code"), y = r.samples("ends.y");
  const auto below = r.samples("steps.code");
  for (std::size_t k = 0; k < u.size(); ++k) {
    EXPECT_EQ(code[k], std::clamp(std::round((u[k] + 2) / (7.0 / 1023)), 0.0, 1023.0)) << k;
    EXPECT_EQ(below[k], std::clamp(std::floor((u[k] + 2) / (7.0 / 1024)), 0.0, 1023.0)) << k;
    if (u[k] > -2 && u[k] < 5) {
      EXPECT_LE(std::fabs(y[k] - u[k]), 3.5 / 1023 * (1 + 1e-12)) << k;
    }
  }
  EXPECT_EQ(*std::max_element(code.begin(), code.end()), 1023);
  EXPECT_EQ(*std::min_element(code.begin(), code.end()), 0);
}

TEST(Dac, GivesBackWhatAnAdcOfTheSameRangeRead) {
  const Signals r = run(R"(
blocks:
  u: {type: sine, amplitude: 3, frequency: 0.7}
  read: {type: adc, in: u, bits: 6, lower: -2, upper: 4, rate: 0.1}
  by_value: {type: dac, in: read.y, bits: 6, lower: -2, upper: 4}
  by_code: {type: dac, in: read.code, bits: 6, lower: -2, upper: 4, takes: code}
simulation: {stop: 20}
)");
  const auto read = r.samples("read.y"), value = r.samples("by_value.y"), code = r.samples("by_code.y");
  EXPECT_EQ(value, read);
  EXPECT_EQ(code, read);
}

TEST(Converters, SayWhatRangeTheyNeed) {
  EXPECT_THAT(findings("blocks: {c: {type: adc, in: time, lower: 2, upper: 1, rate: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("upper"));
  EXPECT_THAT(findings("blocks: {c: {type: dac, in: time, lower: 1, upper: 1, rate: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("upper"));
}

std::int64_t wrapped(std::int64_t code, int bits) {
  const std::int64_t range = std::int64_t{1} << bits, half = range / 2;
  return ((code + half) % range + range) % range - half;
}
std::int64_t saturated(std::int64_t code, int bits) {
  const std::int64_t half = std::int64_t{1} << (bits - 1);
  return std::clamp(code, -half, half - 1);
}

TEST(FixedPoint, SaturatesOrWrapsAsTwosComplementDoes) {
  const Signals r = run(R"(
blocks:
  u: {type: random_levels, lower: -40, upper: 40, rate: 1}
  kept: {type: fixed_point, in: u, word_length: 10, fraction_length: 5}
  wrapped: {type: fixed_point, in: u, word_length: 10, fraction_length: 5, overflow: wrap, rounding: floor}
  plain: {type: fixed_point, in: u, word_length: 10, fraction_length: 5, sign: unsigned, rounding: zero}
simulation: {stop: 300}
)");
  const auto u = r.samples("u"), kept = r.samples("kept.code"), lowest = r.samples("wrapped.code");
  const auto plain = r.samples("plain.code"), y = r.samples("wrapped.y");
  for (std::size_t k = 0; k < u.size(); ++k) {
    EXPECT_EQ(kept[k], saturated(std::llround(32 * u[k]), 10)) << k;
    EXPECT_EQ(lowest[k], wrapped(static_cast<std::int64_t>(std::floor(32 * u[k])), 10)) << k;
    EXPECT_EQ(plain[k], std::clamp(std::trunc(32 * u[k]), 0.0, 1023.0)) << k;
    EXPECT_EQ(y[k], lowest[k] / 32) << k;
  }
}

// The controller in 64-bit integers; rounding floor is an arithmetic shift.
TEST(FixedPointPi, GivesTheCodesOfIntegerArithmetic) {
  for (const bool wrap : {false, true}) {
    const std::string overflow = wrap ? "wrap" : "saturate";
    const Signals r = run(R"(
blocks:
  e: {type: random_levels, lower: -1, upper: 1.3, hold: 3, rate: 0.25}
  c: {type: fixed_point_pi, in: e, kp: 1.7, ki: -0.9, word_length: 14, fraction_length: 11, gain_fraction: 10,
      accumulator_length: 24, rounding: floor, anti_windup: none, initial: 0.37, overflow: )" +
                          overflow + R"(}
simulation: {stop: 100}
)");
    const auto e = r.samples("e"), code = r.samples("c.code"), u = r.samples("c.u");
    const auto fit = [&](std::int64_t x, int bits) { return wrap ? wrapped(x, bits) : saturated(x, bits); };
    const auto word = [&](double x) { return fit(static_cast<std::int64_t>(std::floor(x)), 14); };
    const std::int64_t K = word(1.7 * 1024), L = word(-0.9 * 0.25 * 1024);
    std::int64_t I = fit(static_cast<std::int64_t>(std::floor(0.37 * 2048 * 1024)), 24);
    int limits = 0;
    for (std::size_t k = 0; k < e.size(); ++k) {
      const std::int64_t E = word(e[k] * 2048), sum = fit(I + K * E, 24);
      ASSERT_EQ(code[k], fit(sum >> 10, 14)) << k << overflow;
      ASSERT_EQ(u[k], code[k] / 2048) << k;
      limits += (sum >> 10) != fit(sum >> 10, 14) || I + K * E != sum ? 1 : 0;
      I = fit(I + L * E, 24);
    }
    EXPECT_GT(limits, 3) << "the words must overflow for this test to tell anything";
  }
}

// With fine words it is the PI controller of numbers with a point; with limits the integral stays within them.
TEST(FixedPointPi, ComesCloseToTheControllerOfRealNumbers) {
  const Signals r = run(R"(
blocks:
  e: 1 - y
  fine: {type: fixed_point_pi, in: e, kp: 2, ki: 1.5, word_length: 26, fraction_length: 20, gain_fraction: 20,
         accumulator_length: 50, lower: 0, upper: 1.2, rate: 0.1}
  y: {type: first_order, in: fine.u, tau: 2}
  e_real: 1 - y_real
  real: {type: discrete_pid, in: e_real, kp: 2, ki: 1.5, anti_windup: clamp, lower: 0, upper: 1.2, rate: 0.1}
  y_real: {type: first_order, in: real.u, tau: 2}
simulation: {stop: 15, rtol: 1e-9}
)");
  const auto fine = r.samples("fine.u"), real = r.samples("real.u");
  for (std::size_t k = 0; k < fine.size(); ++k) EXPECT_NEAR(fine[k], real[k], 2e-5) << k;  // some twenty steps of 2^-20
  EXPECT_NEAR(r.last("y"), 1, 1e-3);
}

TEST(FixedPointPi, SaysThatItsAccumulatorIsTooShort) {
  EXPECT_THAT(findings("blocks: {c: {type: fixed_point_pi, in: 1, word_length: 16, accumulator_length: 12, rate: 1}}\n"
                       "simulation: {stop: 1}\n"),
              HasSubstr("the accumulator has 12 bits, fewer than a word's 16"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
