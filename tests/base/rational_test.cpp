// Exact rationals: arithmetic, overflow, and hits that are rounded once.

#include "engine/base/rational.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace plantloop {
namespace {

Rational of(const char* text) {
  const auto value = Rational::from_text(text);
  EXPECT_TRUE(value) << text;
  return value.value_or(Rational());
}

TEST(Rational, ReadsDecimalTexts) {
  EXPECT_EQ(of("0.1").to_string(), "1/10");
  EXPECT_EQ(of("1e-3").to_string(), "1/1000");
  EXPECT_EQ(of("-2.50").to_string(), "-5/2");
  EXPECT_EQ(of("25E2").to_string(), "2500");
  EXPECT_EQ(of("0").to_string(), "0");
  EXPECT_EQ(of("1.5e+1").to_string(), "15");
  for (const char* text : {"", ".", "1e", "x", "1..2", "0x1", "1e99", "--1", "1e-30", "99999999999999999999"}) {
    EXPECT_FALSE(Rational::from_text(text)) << text;
  }
}

TEST(Rational, ComputesExactly) {
  EXPECT_EQ(add(of("0.1"), of("0.2")), of("0.3"));
  EXPECT_EQ(multiply(of("10"), of("0.001")), of("0.01"));
  EXPECT_EQ(divide(of("1"), of("3"))->to_string(), "1/3");
  EXPECT_EQ(subtract(of("0.3"), of("0.1")), of("0.2"));
  EXPECT_EQ(divide(of("1"), of("-3"))->to_string(), "-1/3");
  EXPECT_FALSE(divide(of("1"), of("0")));
  EXPECT_EQ(gcd(of("0.1"), of("0.25")), of("0.05"));
  EXPECT_LT(of("0.333"), *divide(of("1"), of("3")));
}

TEST(Rational, TellsOverflowInsteadOfWrapping) {
  const auto huge = Rational::make(std::numeric_limits<std::int64_t>::max());
  ASSERT_TRUE(huge);
  EXPECT_FALSE(add(*huge, of("1")));
  EXPECT_FALSE(multiply(*huge, of("2")));
  EXPECT_TRUE(multiply(*huge, of("0.5")));
  EXPECT_EQ(subtract(*huge, *huge), of("0"));
}

TEST(Rational, AHitIsTheNearestDouble) {
  // 0.1 * 3 in doubles is 0.30000000000000004; the third hit of a clock of 0.1 s is at 0.3.
  EXPECT_EQ(of("0.1").at(3), 0.3);
  EXPECT_EQ(of("0.001").at(123456789), 123456.789);
  EXPECT_EQ(of("-0.1").at(7), -0.7);
  EXPECT_EQ(of("0").at(5), 0);
}

TEST(Rational, AHitIsTheNearestDoubleAlsoBeyond53Bits) {
  // long double has 64 bits here: when tick*num and den fit, its quotient rounded twice can differ only at ties, so the
  // distance to it is at most half a unit in the last place of the double, plus that of the long double.
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const auto num = static_cast<std::int64_t>(random() >> (1 + random() % 40));
    const auto den = static_cast<std::int64_t>(random() >> (1 + random() % 62)) + 1;
    const auto value = Rational::make(num, den);
    if (!value) continue;
    const double rounded = value->at(1);
    const long double exact = static_cast<long double>(num) / static_cast<long double>(den);
    const double ulp = std::nextafter(std::abs(rounded), INFINITY) - std::abs(rounded);
    EXPECT_LE(std::abs(static_cast<long double>(rounded) - exact), 0.5001L * ulp) << num << "/" << den;
  }
}

TEST(Rational, RoundsHalvesToEven) {
  const std::int64_t two53 = std::int64_t{1} << 53;
  EXPECT_EQ(Rational::make(two53 + 1)->to_double(), 0x1p53);
  EXPECT_EQ(Rational::make(two53 + 3)->to_double(), 0x1p53 + 4);
  EXPECT_EQ(Rational::make(2 * two53 + 3, 2)->to_double(), 0x1p53 + 2);
  EXPECT_EQ(Rational::make(2 * two53 + 1, 2)->to_double(), 0x1p53);
  EXPECT_EQ(Rational::make(1, std::numeric_limits<std::int64_t>::max())->to_double(), 0x1p-63);
}

}  // namespace
}  // namespace plantloop
