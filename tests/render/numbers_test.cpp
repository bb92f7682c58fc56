// The small mathematics of plots against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "render/numbers/contours.h"
#include "render/numbers/frequency.h"
#include "render/numbers/statistics.h"

namespace plantloop {
namespace {

using testing::ElementsAre;

constexpr double pi = 3.14159265358979323846;

TEST(Roots, AreThoseOfTheFactors) {
  const std::vector<Complex> r = roots({1, 3, 3, 1, 0});  // s (s + 1)^3
  ASSERT_EQ(r.size(), 4u);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(std::abs(r[i] + 1.0), 0, 2e-5);  // a triple root: cube root of epsilon
  EXPECT_EQ(r[3], Complex(0));
  const std::vector<Complex> pair = roots({0, 2, 4, 10});  // leading zero; -1 ± 2j
  ASSERT_EQ(pair.size(), 2u);
  EXPECT_NEAR(std::abs(pair[0] - Complex(-1, -2)), 0, 1e-12);
  EXPECT_TRUE(roots({5}).empty());
  EXPECT_TRUE(roots({1, std::nan("")}).empty());
}

// L = k / (s (s+1) (s+2)): the phase is -180 degrees at sqrt(2), where |L| = k / 6.
TEST(Margins, AreTheClosedFormOfAThirdOrderLoop) {
  const Margins m = margins(respond(Transfer{{2}, {1, 3, 2, 0}}, std::nullopt, std::nullopt));
  ASSERT_TRUE(m.phase_crossover && m.gain_margin && m.gain_crossover && m.phase_margin);
  EXPECT_NEAR(*m.phase_crossover, std::sqrt(2), 1e-3);
  EXPECT_NEAR(*m.gain_margin, 20 * std::log10(3), 1e-2);
  const double w = *m.gain_crossover;
  EXPECT_NEAR(w * std::hypot(w, 1) * std::hypot(w, 2), 2, 2e-3);
  EXPECT_NEAR(*m.phase_margin, 90 - (std::atan(w) + std::atan(w / 2)) * 180 / pi, 1e-2);
}

TEST(Response, HasThePhaseOfItsIntegratorsAndDeadTime) {
  const Response r = respond(Transfer{{1}, {1, 0, 0}, 0.5}, 0.01, 100.0);
  for (std::size_t i = 0; i < r.w.size(); ++i) {
    EXPECT_NEAR(r.phase[i], -180 - 0.5 * r.w[i] * 180 / pi, 1e-6 * (1 + r.w[i]));
    EXPECT_NEAR(r.gain[i], -40 * std::log10(r.w[i]), 1e-9);
  }
}

TEST(Response, FollowsASharpResonance) {
  const Response r = respond(Transfer{{1}, {1, 2e-4, 1}}, std::nullopt, std::nullopt);
  double most = 0;
  for (const double g : r.gain) most = std::max(most, g);
  EXPECT_NEAR(most, 20 * std::log10(1 / 2e-4), 0.05);
}

TEST(Contours, OfAConeAreCircles) {
  HeightField field{evenly(-2, 2, 81), evenly(-2, 2, 81), {}};
  for (const double y : field.y)
    for (const double x : field.x) field.z.push_back(std::hypot(x, y));
  const std::vector<Path> lines = contour_lines(field, 1);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].x.front(), lines[0].x.back());  // closed
  for (std::size_t i = 0; i < lines[0].x.size(); ++i) EXPECT_NEAR(std::hypot(lines[0].x[i], lines[0].y[i]), 1, 2e-3);
  // The area above the level is the square less the disc.
  double area = 0;
  for (const Path& p : area_above(field, 1))
    for (std::size_t i = 0; i < p.x.size(); ++i) {
      const std::size_t k = (i + 1) % p.x.size();
      area += (p.x[i] * p.y[k] - p.x[k] * p.y[i]) / 2;
    }
  EXPECT_NEAR(std::abs(area), 16 - pi, 5e-3);
}

TEST(Contours, LeaveOutWhatIsNotFinite) {
  const double nan = std::nan("");
  const HeightField field{{0, 1, 2}, {0, 1}, {0, 1, nan, 0, 1, 2}};
  const std::vector<Path> lines = contour_lines(field, 0.5);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0].x, ElementsAre(0.5, 0.5));
  EXPECT_EQ(area_above(field, -1).size(), 1u);
  EXPECT_TRUE(contour_lines({{0}, {0}, {1}}, 0).empty());
}

TEST(Contours, OfASaddleDoNotCross) {
  // Opposite corners are high; the middle is low, so that each has a line of its own.
  const HeightField field{{0, 1}, {0, 1}, {1, 0, -0.5, 1}};
  EXPECT_EQ(contour_lines(field, 0.6).size(), 2u);
  EXPECT_EQ(area_above(field, 0.6).size(), 2u);
  EXPECT_EQ(area_above(field, 0.1).size(), 1u);
}

TEST(Quantiles, InterpolateBetweenSortedValues) {
  const std::vector<double> v{1, 2, 3, 4};
  EXPECT_EQ(quantile(v, 0), 1);
  EXPECT_EQ(quantile(v, 0.5), 2.5);
  EXPECT_EQ(quantile(v, 0.25), 1.75);  // definition 7
  EXPECT_EQ(quantile(v, 1), 4);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Density, HasAreaOne) {
  std::vector<double> values;
  for (int i = 0; i < 500; ++i) values.push_back(std::sin(0.1 * i * i));
  const std::vector<double> sorted = finite_sorted(values), x = evenly(-4, 4, 4001);
  double area = 0;
  for (const double d : kernel_density(sorted, x)) area += d * 8 / 4000;
  EXPECT_NEAR(area, 1, 1e-6);
}

TEST(Histogram, HasAllValuesBetweenItsEdges) {
  const std::vector<double> sorted = finite_sorted({0.31, 2.2, 1.7, 5.9, 3.3, 3.4, 2.9, std::nan("")});
  const std::vector<double> edges = histogram_edges(sorted, 0);
  EXPECT_LE(edges.front(), sorted.front());
  EXPECT_GE(edges.back(), sorted.back());
  EXPECT_EQ(histogram_edges(sorted, 4).size(), 5u);
  EXPECT_EQ(histogram_edges({2}, 0).size(), 2u);
}

TEST(Correlation, OfASignalWithItsDelayedSelfPeaksAtTheDelay) {
  std::vector<double> u, y;
  std::uint32_t state = 7;
  for (int i = 0; i < 2000; ++i) {
    state = state * 1664525u + 1013904223u;
    u.push_back(static_cast<double>(state >> 8) / 16777216.0 - 0.5);
  }
  for (std::size_t i = 0; i < u.size(); ++i) y.push_back(i < 4 ? 0 : u[i - 4]);
  const std::vector<double> r = correlation(u, y, 10);
  EXPECT_NEAR(r[14], 1, 0.01);
  EXPECT_NEAR(correlation(u, u, 10)[10], 1, 1e-12);
}

// Parseval: the integral of the density is the variance; a sine of amplitude a has a^2 / 2.
TEST(Spectrum, OfASineHoldsItsPower) {
  std::vector<double> y;
  for (int i = 0; i < 8192; ++i) y.push_back(3 * std::sin(2 * pi * 12.5 * i * 0.01));
  const Spectrum s = welch(y, 0.01, 1024);
  double power = 0, at = 0;
  for (std::size_t k = 0; k < s.frequency.size(); ++k) {
    power += s.density[k] * s.frequency[1];
    if (s.density[k] > s.density[static_cast<std::size_t>(at)]) at = static_cast<double>(k);
  }
  EXPECT_NEAR(power, 4.5, 1e-6);
  EXPECT_NEAR(s.frequency[static_cast<std::size_t>(at)], 12.5, s.frequency[1] / 2);
  EXPECT_EQ(s.segments, 15);
}

}  // namespace
}  // namespace plantloop
