// Numbers as texts: exact both ways, in every locale.

#include "engine/base/numbers.h"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace plantloop {
namespace {

TEST(Numbers, BothFormsReadBackToTheSameBits) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(parse_number(shortest(value)), value);
    EXPECT_EQ(parse_number(digits17(value)), value);
  }
}

TEST(Numbers, AreWrittenAsPeopleWriteThem) {
  EXPECT_EQ(shortest(0.1), "0.1");
  EXPECT_EQ(shortest(3), "3");
  EXPECT_EQ(digits17(0.1), "0.10000000000000001");
  EXPECT_EQ(digits17(1), "1");
  EXPECT_EQ(shortest(-std::numeric_limits<double>::infinity()), "-inf");
}

TEST(Numbers, OnlyWholeTextsAreNumbers) {
  EXPECT_EQ(parse_number("-.5"), -0.5);
  EXPECT_EQ(parse_number("+1e3"), 1000);
  EXPECT_EQ(parse_number("inf"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("1e-999"), 0);
  for (const char* text : {"", "nan", "1 ", " 1", "1x", "--1", "infinity", "0x10", "1e999", ".", "e3", "1,5"}) {
    EXPECT_FALSE(parse_number(text)) << text;
  }
  EXPECT_EQ(parse_integer("-12"), -12);
  for (const char* text : {"", "1.0", "99999999999999999999", "x", "1 "}) EXPECT_FALSE(parse_integer(text)) << text;
}

TEST(Numbers, DoNotDependOnTheLocale) {
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE"}) {
    if (std::setlocale(LC_ALL, name) != nullptr) break;
  }
  EXPECT_EQ(shortest(1.5), "1.5");
  EXPECT_EQ(parse_number("1.5"), 1.5);
  std::setlocale(LC_ALL, "C");
}

}  // namespace
}  // namespace plantloop
