// Poles, zeros, responses and margins of linear models, against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/analysis/linear_model.h"

namespace plantloop {
namespace {

DenseMatrix matrix(std::size_t rows, std::size_t columns, std::vector<double> values) {
  DenseMatrix m(rows, columns);
  m.values = std::move(values);
  return m;
}

// k (s + 3) / ((s + 1) (s + 2) (s + 4)) in controllable form: den s^3 + 7 s^2 + 14 s + 8.
LinearModel third_order(double k) {
  LinearModel m;
  m.A = matrix(3, 3, {0, 1, 0, 0, 0, 1, -8, -14, -7});
  m.B = matrix(3, 1, {0, 0, 1});
  m.C = matrix(1, 3, {3 * k, k, 0});
  m.D = matrix(1, 1, {0});
  return m;
}

TEST(LinearModel, HasThePolesAndZerosOfItsTransferFunction) {
  const LinearModel m = third_order(5);
  const auto p = poles(m);
  ASSERT_EQ(p.size(), 3u);
  EXPECT_NEAR(p[0].real(), -4, 1e-12);
  EXPECT_NEAR(p[1].real(), -2, 1e-12);
  EXPECT_NEAR(p[2].real(), -1, 1e-12);
  const auto z = zeros(m);
  ASSERT_EQ(z.size(), 1u);
  EXPECT_NEAR(std::abs(z[0] + 3.0), 0, 1e-12);
}

TEST(LinearModel, AnswersAFrequencyAsItsTransferFunctionDoes) {
  const LinearModel m = third_order(5);
  for (const double w : {0.01, 1.0, 30.0}) {
    const std::complex<double> s(0, w);
    const std::complex<double> g = 5.0 * (s + 3.0) / ((s + 1.0) * (s + 2.0) * (s + 4.0));
    EXPECT_NEAR(std::abs(response(m, w)[0] - g), 0, 1e-13 * std::abs(g) + 1e-15) << w;
  }
  EXPECT_NEAR(gains_at_rest(m)[0], 15.0 / 8, 1e-14);
}

// s^2 (s + 3)/(s^2 (s + 1)(s + 2)): what is cancelled at rest leaves a limit; what is not leaves infinity.
TEST(LinearModel, HasAGainAtRestWherePolesAtRestAreCancelled) {
  LinearModel m;
  m.A = matrix(4, 4, {0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -2, -3});
  m.B = matrix(4, 1, {0, 0, 0, 1});
  m.C = matrix(1, 4, {0, 0, 3, 1});
  m.D = matrix(1, 1, {0});
  EXPECT_NEAR(gains_at_rest(m)[0], 1.5, 1e-8);
  m.C = matrix(1, 4, {0, 3, 1, 0});
  EXPECT_TRUE(std::isinf(gains_at_rest(m)[0])) << gains_at_rest(m)[0];
}

// Without direct path from input to output, and with one: as many zeros as the numerator has.
TEST(LinearModel, ZerosAtInfinityDoNotShow) {
  LinearModel m = third_order(1);
  m.C = matrix(1, 3, {1, 0, 0});
  EXPECT_TRUE(zeros(m).empty());
  m.D = matrix(1, 1, {2});
  EXPECT_EQ(zeros(m).size(), 3u);
}

// k / (s (s + 1) (s + 2)): gain margin 6/k at sqrt(2) rad/s.
TEST(Margins, OfThreeLagsAreThoseOfTheBook) {
  LinearModel m;
  m.A = matrix(3, 3, {0, 1, 0, 0, 0, 1, 0, -2, -3});
  m.B = matrix(3, 1, {0, 0, 1});
  m.C = matrix(1, 3, {2, 0, 0});
  m.D = matrix(1, 1, {0});
  const Margins found = margins(m);
  ASSERT_TRUE(found.gain && found.phase);
  EXPECT_NEAR(*found.gain, 3, 1e-9);
  EXPECT_NEAR(*found.phase_crossover, std::numbers::sqrt2, 1e-9);
  // |L| = 1: w^2 (w^2 + 1) (w^2 + 4) = 4; the phase follows from it.
  const double w = *found.gain_crossover;
  EXPECT_NEAR(w * w * (w * w + 1) * (w * w + 4), 4, 1e-8);
  EXPECT_NEAR(*found.phase, (std::numbers::pi / 2 - std::atan(w) - std::atan(w / 2)) * 180 / std::numbers::pi, 1e-8);
}

TEST(Margins, ALagHasNone) {
  LinearModel m;
  m.A = matrix(1, 1, {-1});
  m.B = m.C = matrix(1, 1, {1});
  m.D = matrix(1, 1, {0});
  EXPECT_FALSE(margins(m).gain);
  EXPECT_FALSE(margins(m).phase);
}

// x[k+1] = 0.5 x + u with negative feedback: L(z) = k/(z - 0.5) reaches -1 at z = -1 for k = 1.5.
TEST(Margins, OfASampledLagEndAtHalfTheSamplingFrequency) {
  LinearModel m;
  m.period = 0.1;
  m.A = matrix(1, 1, {0.5});
  m.B = m.C = matrix(1, 1, {1});
  m.D = matrix(1, 1, {0});
  ASSERT_TRUE(margins(m).gain);
  EXPECT_NEAR(*margins(m).gain, 1.5, 1e-12);
  EXPECT_NEAR(*margins(m).phase_crossover, std::numbers::pi / 0.1, 1e-9);
}

}  // namespace
}  // namespace plantloop
