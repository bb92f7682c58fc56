// Facts about the numbers at axes.

#include "render/layout/ticks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace plantloop {
namespace {

using testing::ElementsAre;

std::vector<std::string> labels(const Ruler& ruler) {
  std::vector<std::string> result;
  for (const Tick& tick : ruler.ticks) result.push_back(tick.label);
  return result;
}

double parsed(std::string text) {
  for (std::size_t at; (at = text.find("−")) != std::string::npos;)
    text.replace(at, std::string_view("−").size(), 1, '-');
  return std::strtod(text.c_str(), nullptr);
}

TEST(Ticks, EncloseTheDataAndEndAtRoundNumbers) {
  const Ruler r = make_ruler({.data_lower = 0.02, .data_upper = 1.52, .length = 360, .spacing = 60});
  EXPECT_THAT(labels(r), ElementsAre("0", "0.2", "0.4", "0.6", "0.8", "1", "1.2", "1.4", "1.6"));
  EXPECT_EQ(r.lower, 0);
  EXPECT_DOUBLE_EQ(r.upper, 1.6);
}

TEST(Ticks, OfATimeAxisLeaveItsEndsWhereTheDataEnd) {
  const Ruler r = make_ruler({.data_lower = 0, .data_upper = 33, .length = 1000, .spacing = 110, .tight = true});
  EXPECT_EQ(r.lower, 0);
  EXPECT_EQ(r.upper, 33);
  EXPECT_THAT(labels(r), ElementsAre("0", "5", "10", "15", "20", "25", "30"));
}

TEST(Ticks, ObeyLimitsGivenByTheUser) {
  const Ruler r = make_ruler({.limits = {-1, 4}, .data_lower = 0, .data_upper = 100});
  EXPECT_EQ(r.lower, -1);
  EXPECT_EQ(r.upper, 4);
}

TEST(Ticks, GivenAtOneEndOnlyRoundTheOther) {
  const Ruler r = make_ruler({.limits = {0.5, {}}, .data_lower = 1, .data_upper = 9.3});
  EXPECT_EQ(r.lower, 0.5);
  EXPECT_GE(r.upper, 9.3);
  EXPECT_DOUBLE_EQ(r.upper, r.ticks.back().value);
}

TEST(Ticks, UseTheRealMinusSign) {
  const Ruler r = make_ruler({.data_lower = -1, .data_upper = 1});
  EXPECT_TRUE(r.ticks.front().label.starts_with("−")) << r.ticks.front().label;
}

TEST(Ticks, ShareOneExponentWhenNumbersAreLong) {
  const Ruler r = make_ruler({.data_lower = 0, .data_upper = 4.7e-3, .tight = true});
  EXPECT_EQ(r.exponent, -3);
  EXPECT_EQ(r.note, "×10^{-3}");
  EXPECT_EQ(r.ticks.back().label.find('e'), std::string::npos);
}

TEST(Ticks, SubtractALargeMean) {
  const Ruler r = make_ruler({.data_lower = 1e6, .data_upper = 1e6 + 0.02});
  EXPECT_EQ(r.offset, 1e6);
  EXPECT_EQ(r.note, "+ 1000000");
}

TEST(Ticks, OfAnAngleInDegreesAreFortyFives) {
  const Ruler r = make_ruler({.data_lower = -268, .data_upper = -92, .length = 300, .spacing = 60, .degrees = true});
  EXPECT_THAT(labels(r), ElementsAre("−270", "−225", "−180", "−135", "−90"));
}

TEST(Ticks, OfATwinAxisHaveAsManyIntervalsAsTheOther) {
  for (int intervals = 2; intervals <= 10; ++intervals) {
    const Ruler r = make_ruler({.data_lower = -3.1, .data_upper = 17, .intervals = intervals});
    EXPECT_EQ(r.ticks.size(), static_cast<std::size_t>(intervals) + 1) << intervals;
    EXPECT_LE(r.lower, -3.1);
    EXPECT_GE(r.upper, 17);
  }
}

TEST(Ticks, OfATwinAxisPutZeroAtTheSameHeight) {
  const Ruler r = make_ruler({.data_lower = -5, .data_upper = 16, .intervals = 8, .intervals_below_zero = 2});
  EXPECT_NEAR(position(r, 0), 0.25, 1e-12);
}

TEST(Ticks, OnALogarithmicAxisAreDecadesWithLinesBetween) {
  const Ruler r = make_ruler({.scale = Scale::log, .data_lower = 0.13, .data_upper = 77});
  EXPECT_THAT(labels(r), ElementsAre("10^{-1}", "10^{0}", "10^{1}", "10^{2}"));
  EXPECT_EQ(r.minor.size(), 24u);  // 2 to 9 in three decades
}

TEST(Ticks, OnALogarithmicAxisIgnoreWhatIsNotPositive) {
  const Ruler r = make_ruler({.scale = Scale::log, .limits = {-1, {}}, .data_lower = 0.1, .data_upper = 10});
  EXPECT_GT(r.lower, 0);
  EXPECT_TRUE(std::isnan(position(r, -1)));
}

// Whatever the data: rising, evenly spaced, few, and saying what their place means.
TEST(Ticks, AreEvenAndTrueForRangesOfAllSizes) {
  for (int exponent = -300; exponent <= 298; exponent += 13)
    for (const double low : {-7.3, -1.0, 0.0, 0.37, 3.14159, 9.99})
      for (const double width : {0.011, 0.5, 1.0, 7.77}) {
        const double scale = std::pow(10.0, exponent);
        for (const bool tight : {false, true}) {
          const Ruler r = make_ruler(
              {.data_lower = low * scale, .data_upper = (low + width) * scale, .length = 600, .tight = tight});
          ASSERT_GE(r.ticks.size(), 2u) << exponent << ' ' << low << ' ' << width;
          ASSERT_LE(r.ticks.size(), 11u);
          EXPECT_LE(r.lower, low * scale + 1e-9 * width * scale);
          EXPECT_GE(r.upper, (low + width) * scale - 1e-9 * width * scale);
          const double step = r.ticks[1].value - r.ticks[0].value;
          for (std::size_t i = 0; i + 1 < r.ticks.size(); ++i)
            EXPECT_NEAR((r.ticks[i + 1].value - r.ticks[i].value) / step, 1, 1e-6);
          // A label times the shared exponent is its value up to the rounding of the product.
          for (const Tick& t : r.ticks) {
            const double power =
                r.exponent < -300 ? 1e-300 * std::pow(10.0, r.exponent + 300) : std::pow(10.0, r.exponent);
            const double said = parsed(t.label) * power + r.offset;
            EXPECT_NEAR(said / step, t.value / step, 1e-6) << t.label << ' ' << r.note;
          }
        }
      }
}

TEST(Ticks, ShowAConstantAgainstZero) {
  const Ruler r = make_ruler({.data_lower = 20, .data_upper = 20});
  EXPECT_EQ(r.lower, 0);
  EXPECT_GT(r.upper, 20);
  const Ruler negative = make_ruler({.data_lower = -20, .data_upper = -20});
  EXPECT_LT(negative.lower, -20);
  EXPECT_EQ(negative.upper, 0);
}

TEST(Ticks, ExistWithoutAnyData) {
  const Ruler r = make_ruler({.data_lower = 1, .data_upper = -1});
  EXPECT_LT(r.lower, r.upper);
  EXPECT_GE(r.ticks.size(), 3u);
}

TEST(Ticks, OfManyTurnsAreMultiplesOfWholeTurns) {
  for (const double lowest : {-1900.0, -5700.0, -57000.0}) {
    const Ruler r = make_ruler({.data_lower = lowest, .data_upper = -90, .degrees = true});
    ASSERT_GE(r.ticks.size(), 3u);
    for (const Tick& t : r.ticks) EXPECT_EQ(std::fmod(t.value, 180), 0) << t.value;
  }
}

}  // namespace
}  // namespace plantloop
