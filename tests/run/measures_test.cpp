// Measures against the closed forms of a second-order system, a ramp, a sine and stairs.

#include <gtest/gtest.h>

#include <numbers>

#include "engine/run/measures.h"
#include "tests/run/recordings.h"

namespace plantloop {
namespace {

using std::numbers::pi;

// The answer to a step from `from` to `to` at t = 1 of 1 / (s^2 + 2 zeta s + 1), with rows every 1 ms. Straight lines
// between them are off by at most 1e-3^2 / 8 of the height.
Recording second_order(double zeta, double from = 0, double to = 1) {
  const double wd = std::sqrt(1 - zeta * zeta);
  return testing::sampled(1e-3, 41, [=](double t) {
    if (t < 1) return from;
    const double s = 1 - std::exp(-zeta * (t - 1)) * (std::cos(wd * (t - 1)) + zeta / wd * std::sin(wd * (t - 1)));
    return from + (to - from) * s;
  });
}

TEST(Measures, OvershootOfASecondOrderSystemIsItsClosedForm) {
  const MeasureOptions step{.step = {.at = 1, .from = 0, .to = 1}};
  for (const double zeta : {0.2, 0.5, 0.8}) {
    const double exact = 100 * std::exp(-pi * zeta / std::sqrt(1 - zeta * zeta));
    EXPECT_NEAR(measure(second_order(zeta), 0, "overshoot", step), exact, 2e-5) << zeta;
  }
}

TEST(Measures, AreTheSameForAStepDownwardsAndAnyHeight) {
  const double exact = 100 * std::exp(-pi * 0.5 / std::sqrt(0.75));
  const MeasureOptions down{.step = {.at = 1, .from = 3, .to = -2}};
  const Recording r = second_order(0.5, 3, -2);
  EXPECT_NEAR(measure(r, 0, "overshoot", down), exact, 2e-5);
  EXPECT_NEAR(measure(r, 0, "rise_time", down),
              measure(second_order(0.5), 0, "rise_time", {.step = {.at = 1, .from = 0, .to = 1}}), 1e-9);
}

TEST(Measures, TakeWhatAStepDoesNotSayFromTheSignal) {
  const MeasureOptions at_only{.step = {.at = 1}};
  const double exact = 100 * std::exp(-pi * 0.5 / std::sqrt(0.75));
  EXPECT_NEAR(measure(second_order(0.5, 2, 5), 0, "overshoot", at_only), exact, 1e-4);  // exp(-20) is left at the end
}

TEST(Measures, RiseTimeOfALagIsItsTimeConstantTimesTheLogarithmOfNine) {
  const Recording r = testing::sampled(1e-3, 20, [](double t) { return 1 - std::exp(-t / 0.7); });
  EXPECT_NEAR(measure(r, 0, "rise_time", {.step = {.at = 0, .from = 0, .to = 1}}), 0.7 * std::log(9.0), 1e-6);
}

TEST(Measures, SettlingTimeOfALagIsWhereItEntersTheBand) {
  const Recording r = testing::sampled(1e-3, 20, [](double t) { return 1 - std::exp(-t / 0.7); });
  for (const double band : {0.02, 0.05}) {
    const MeasureOptions options{.step = {.at = 0, .from = 0, .to = 1}, .band = band};
    // The line between two rows is off by 2.5e-7, the slope at the band is band / 0.7.
    EXPECT_NEAR(measure(r, 0, "settling_time", options), -0.7 * std::log(band), 2.5e-7 * 0.7 / band);
  }
}

TEST(Measures, SettlingTimeOfAnOscillationIsItsLastPassageOfTheBand) {
  // 1 - exp(-0.2 t) cos(5 t), 2 %: the last time with exp(-0.2 t) |cos(5 t)| = 0.02, found by bisection in its last
  // arc.
  const auto distance = [](double t) { return std::exp(-0.2 * t) * std::abs(std::cos(5 * t)); };
  double last = 0;
  for (double t = 0; t < 30; t += 1e-4) {
    if (distance(t) > 0.02) last = t;
  }
  double a = last, b = last + 1e-4;
  while (b - a > 1e-13) (distance((a + b) / 2) > 0.02 ? a : b) = (a + b) / 2;
  const Recording r = testing::sampled(1e-3, 30, [](double t) { return 1 - std::exp(-0.2 * t) * std::cos(5 * t); });
  EXPECT_NEAR(measure(r, 0, "settling_time", {.step = {.at = 0, .from = 0, .to = 1}}), a, 1e-5);
}

TEST(Measures, NeverSettlingAndNeverRisingAreInfinite) {
  const Recording sine = testing::sampled(0.01, 10, [](double t) { return std::sin(t); });
  const MeasureOptions step{.step = {.at = 0, .from = 0, .to = 2}};
  EXPECT_TRUE(std::isinf(measure(sine, 0, "settling_time", step)));
  EXPECT_TRUE(std::isinf(measure(sine, 0, "rise_time", step)));
}

TEST(Measures, UndershootIsHowFarTheAnswerFirstGoesTheWrongWay) {
  // (1 - s) / (s + 1)^2 answers 1 - exp(-t) - 2 t exp(-t): lowest at t = 1/2.
  const Recording r = testing::sampled(1e-3, 20, [](double t) { return 1 - std::exp(-t) - 2 * t * std::exp(-t); });
  const double lowest = 1 - 2 * std::exp(-0.5);
  EXPECT_NEAR(measure(r, 0, "undershoot", {.step = {.at = 0, .from = 0, .to = 1}}), -100 * lowest, 1e-4);
}

TEST(Measures, ExtremesAndRootMeanSquareOfASine) {
  const Recording r = testing::sampled(pi / 1000, 2 * pi, [](double t) { return 3 * std::sin(t) - 1; });
  EXPECT_NEAR(measure(r, 0, "max", {}), 2, 1e-5);
  EXPECT_NEAR(measure(r, 0, "min", {}), -4, 1e-5);
  EXPECT_NEAR(measure(r, 0, "max_abs", {}), 4, 1e-5);
  EXPECT_NEAR(measure(r, 0, "rms", {}), std::sqrt(4.5 + 1), 1e-5);
  EXPECT_NEAR(measure(r, 0, "final", {}), -1, 1e-12);
}

TEST(Measures, RootMeanSquareWeighsTimeNotRows) {
  Recording r;
  r.columns = {{.name = "ramp"}};
  for (const double t : {0.0, 0.1, 0.11, 0.12, 2.0}) r.append(t, 0, {&t, 1});
  EXPECT_NEAR(measure(r, 0, "rms", {}), 2 / std::sqrt(3.0), 1e-14);  // of a straight line, exactly
}

TEST(Measures, AWindowBeginsAndEndsBetweenRows) {
  const Recording r = testing::sampled(1, 10, [](double t) { return t; });
  const MeasureOptions window{.from = 2.5, .until = 4.25};
  EXPECT_EQ(measure(r, 0, "min", window), 2.5);
  EXPECT_EQ(measure(r, 0, "max", window), 4.25);
  EXPECT_EQ(measure(r, 0, "final", window), 4.25);
  EXPECT_NEAR(measure(r, 0, "rms", window), std::sqrt((std::pow(4.25, 3) - std::pow(2.5, 3)) / 3 / 1.75), 1e-14);
}

TEST(Measures, TheJumpAtAWindowsEdgeCountsInside) {
  const Recording r = testing::mixed();  // ramp jumps from 1 to 11 at t = 1
  EXPECT_EQ(measure(r, 0, "max", {.until = 1}), 1);
  EXPECT_EQ(measure(r, 0, "min", {.from = 1}), 11);
  EXPECT_EQ(measure(r, 0, "max", {}), 11.1);
}

TEST(Measures, ADiscreteColumnIsAStair) {
  const Recording r = testing::mixed();  // held: 1 until 0.5, 2 until 1, 3 until 1.1
  EXPECT_NEAR(measure(r, 1, "rms", {}), std::sqrt((0.5 * 1 + 0.5 * 4 + 0.1 * 9) / 1.1), 1e-14);
  EXPECT_EQ(measure(r, 1, "final", {.until = 0.9}), 2);
  EXPECT_EQ(measure(r, 1, "max", {.until = 0.9}), 2);
  EXPECT_NEAR(measure(r, 1, "rise_time", {.step = {.at = 0, .from = 1, .to = 3}}), 0.5, 1e-14);
}

TEST(Measures, AreNotANumberWhereThereIsNothingToMeasure) {
  const Recording r = testing::mixed();
  EXPECT_TRUE(std::isnan(measure(r, 0, "max", {.from = 5})));
  EXPECT_TRUE(std::isnan(measure(Recording(), 0, "max", {})));
  EXPECT_TRUE(std::isnan(measure(r, 0, "overshoot", {.step = {.at = 0, .from = 1, .to = 1}})));
  EXPECT_THROW(measure(r, 0, "mean", {}), std::invalid_argument);
  for (const MeasureInfo& info : measures()) EXPECT_NO_THROW(measure(r, 0, info.name, {})) << info.name;
}

}  // namespace
}  // namespace plantloop
