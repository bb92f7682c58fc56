// Random numbers against their distributions.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/block_random.h"
#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

// The distribution function of the normal distribution.
double below(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

TEST(NormalNumbers, AreTheQuantilesOfTheDistribution) {
  // Abramowitz and Stegun, table 26.5, and the smallest numbers that 53 bits can give.
  EXPECT_EQ(normal_quantile(0.5), 0);
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 4e-15);
  EXPECT_NEAR(normal_quantile(0.9995), 3.290526731491926, 1e-12);  // 1 - p has lost digits
  EXPECT_NEAR(normal_quantile(1e-9), -5.997807015007687, 1e-14);
  EXPECT_DOUBLE_EQ(normal_quantile(0.025), -normal_quantile(0.975));
  for (double x = -8; x <= 0; x += 0.0625) EXPECT_NEAR(normal_quantile(below(x)), x, 1e-13 + 1e-14 * std::fabs(x)) << x;
}

TEST(UniformNumbers, AreFunctionsOfTheirCounters) {
  EXPECT_EQ(uniform_number(1, 2, 3, 4), uniform_number(1, 2, 3, 4));
  double sum = 0;
  for (std::uint64_t k = 0; k < 10000; ++k) {
    const double u = uniform_number(1, 2, 0, k);
    EXPECT_GT(u, 0);
    EXPECT_LT(u, 1);
    sum += u;
  }
  EXPECT_NEAR(sum / 10000, 0.5, 5 * 0.2887 / 100);  // five standard deviations
}

TEST(WhiteNoise, HasItsMomentsAndNoMemory) {
  const Signals r = run(R"(
blocks:
  a: {type: white_noise, mean: 3, deviation: 2, rate: 0.1}
  b: {type: white_noise, rate: 0.1}
  v: {type: white_noise, deviation: [1, 0], rate: 0.1}
simulation: {stop: 1999.9}
)");
  const std::vector<double> a = r.samples("a"), b = r.samples("b");
  const double n = static_cast<double>(a.size());
  ASSERT_EQ(n, 20000);
  double mean = 0, variance = 0, third = 0, fourth = 0, next = 0, cross = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double z = (a[k] - 3) / 2;
    mean += z / n;
    variance += z * z / n;
    third += z * z * z / n;
    fourth += z * z * z * z / n;
    if (k > 0) next += z * (a[k - 1] - 3) / 2 / n;
    cross += z * b[k] / n;
  }
  // Five standard deviations of each estimate: sqrt of 1, 2, 15, 96 and 1 over n.
  const double five = 5 / std::sqrt(n);
  EXPECT_NEAR(mean, 0, five);
  EXPECT_NEAR(variance, 1, std::sqrt(2) * five);
  EXPECT_NEAR(third, 0, std::sqrt(15) * five);
  EXPECT_NEAR(fourth, 3, std::sqrt(96) * five);
  EXPECT_NEAR(next, 0, five);
  EXPECT_NEAR(cross, 0, five);
  EXPECT_EQ(r.greatest("v.2"), 0);
}

TEST(WhiteNoise, DoesNotDependOnTheRestOfTheDiagram) {
  const std::string noise = "  n: {type: white_noise, rate: 0.1}\n", end = "simulation: {stop: 2}\nrecord: [n]\n";
  const Signals alone = run("blocks:\n" + noise + end);
  const Signals later =
      run("blocks:\n  a: {type: white_noise, rate: 0.05}\n" + noise + "  x: {type: integrator, in: a}\n" + end);
  EXPECT_EQ(alone.samples("n"), later.samples("n"));
  EXPECT_NE(alone.samples("n"), run("blocks:\n  n: {type: white_noise, seed: 2, rate: 0.1}\n" + end).samples("n"));
  EXPECT_THAT(findings("blocks: {n: {type: white_noise, seed: 0.5, rate: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("a seed is a whole number"));
  EXPECT_THAT(findings("blocks: {n: {type: white_noise}}\nsimulation: {stop: 1}\n"), HasSubstr("needs a rate"));
}

TEST(BandLimitedNoise, HasThePowerThatItIsToldAtAnyPeriod) {
  // The variance of a sample is power/T: at a tenth of the period it is ten times as large.
  const Signals r = run(R"(
blocks:
  coarse: {type: band_limited_noise, power: 0.5, rate: 0.1}
  fine: {type: band_limited_noise, power: 0.5, rate: 0.01}
simulation: {stop: 400}
)");
  const auto variance = [&](const std::string& name) {
    double sum = 0;
    const std::vector<double> samples = r.samples(name);
    for (const double v : samples) sum += v * v / static_cast<double>(samples.size());
    return sum;
  };
  EXPECT_NEAR(variance("coarse"), 5, 5 * 5 * std::sqrt(2.0 / 4000));
  EXPECT_NEAR(variance("fine"), 50, 5 * 50 * std::sqrt(2.0 / 40000));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
