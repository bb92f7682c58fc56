// Correlations of residuals against their sums, and what the verdicts say.

#include "identify/validation/correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/data/excitation.h"
#include "identify/error.h"
#include "identify/linear/filter.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

TEST(Correlation, IsTheSumOfTheBook) {
  const VectorXd e = white_noise(40, 1, 1);
  const VectorXd u = white_noise(40, 2, 2);
  const Correlation ee = autocorrelation({e}, 6);
  const Correlation eu = cross_correlation({e}, {u}, 6);
  const VectorXd ec = e.array() - e.mean();
  const VectorXd uc = u.array() - u.mean();
  EXPECT_DOUBLE_EQ(ee.r[0], 1);
  for (int tau = -6; tau <= 6; ++tau) {
    double r_ee = 0;
    double r_eu = 0;
    for (Index k = 0; k < 40; ++k) {
      if (k + tau < 0 || k + tau >= 40) continue;
      r_ee += ec[k + tau] * ec[k];
      r_eu += ec[k + tau] * uc[k];
    }
    if (tau >= 0) {
      EXPECT_NEAR(ee.r[tau], r_ee / ec.squaredNorm(), 1e-14);
    }
    EXPECT_EQ(eu.lag[tau + 6], tau);
    EXPECT_NEAR(eu.r[tau + 6], r_eu / (ec.norm() * uc.norm()), 1e-14);
  }
  EXPECT_NEAR(ee.band95, 1.96 / std::sqrt(40.0), 1e-5);
  EXPECT_NEAR(ee.band99, 2.576 / std::sqrt(40.0), 1e-4);
}

TEST(Correlation, DoesNotReachFromOneExperimentIntoTheNext) {
  const VectorXd e = white_noise(30, 1, 1);
  const Correlation whole = autocorrelation({e.head(10), e.tail(20)}, 3);
  const VectorXd ec = e.array() - e.mean();
  const double sum = ec.segment(1, 9).dot(ec.head(9)) + ec.tail(19).dot(ec.segment(10, 19));
  EXPECT_NEAR(whole.r[1], sum / ec.squaredNorm(), 1e-14);
}

TEST(Correlation, MissingValuesContributeNothing) {
  VectorXd e = white_noise(30, 1, 1);
  e[4] = std::numeric_limits<double>::quiet_NaN();
  const Correlation c = autocorrelation({e}, 3);
  EXPECT_TRUE(c.r.allFinite());
  EXPECT_NEAR(c.band95, 1.96 / std::sqrt(29.0), 1e-5);
}

TEST(ResidualTests, PassForWhiteNoiseAndFindWhatIsMissing) {
  const VectorXd e = white_noise(2000, 1, 3);
  const VectorXd u = staircase(2000, 1, 3, -1, 1, 4);
  for (const Verdict& v : residual_tests({e}, {u}).verdicts) EXPECT_TRUE(v.passed) << v.name << v.largest;

  const VectorXd coloured = filter(Eigen::Vector2d(1, 0.7), VectorXd::Ones(1), e);
  const Verdict white = whiteness(autocorrelation({coloured}));
  EXPECT_FALSE(white.passed);
  EXPECT_NEAR(white.largest, 0.7 / 1.49, 0.05);  // r(1) = c/(1 + c^2)
  EXPECT_EQ(white.meaning, "the residuals are predictable from their own past");

  const Verdict dynamic = independence(cross_correlation({e + delayed(u, 4)}, {u}));
  EXPECT_FALSE(dynamic.passed);
  EXPECT_EQ(dynamic.meaning, "the residuals depend on past inputs: dynamics are missing");
  const Verdict feedback = independence(cross_correlation({e}, {VectorXd(u + delayed(e, 4))}));
  EXPECT_EQ(feedback.meaning,
            "the residuals do not depend on past inputs; the input depends on past residuals, as feedback makes it");

  // A square is invisible to the linear test of a symmetric input and seen by the nonlinear one.
  const VectorXd square = e + VectorXd(3 * delayed(u, 2).array().square());
  const ResidualTests tests = residual_tests({square}, {u});
  EXPECT_TRUE(tests.verdicts[1].passed);
  EXPECT_FALSE(tests.verdicts[2].passed);
}

// Records without anything to find, of the kinds that made false alarms: residuals of coloured noise beside inputs that
// are slow, held or periodic. Each test finds fault with one in a hundred; more than 3 % of 400 happens by chance once
// in a thousand times.
TEST(ResidualTests, FindFaultWithOneRecordInAHundredWhereThereIsNothing) {
  constexpr int records = 400;
  constexpr Index n = 800;
  const VectorXd one = VectorXd::Ones(1);
  for (const double pole : {0.0, 0.9}) {
    for (int kind = 0; kind < 3; ++kind) {
      int white = 0, dynamic = 0, feedback = 0;
      std::vector<int> nonlinear(3, 0);
      for (std::uint64_t i = 0; i < records; ++i) {
        const VectorXd u = kind == 0   ? white_noise(n, 1, 10'000 + i)
                           : kind == 1 ? staircase(n, 5, 20, -1, 1, 20'000 + i)
                                       : VectorXd(filter(one, Eigen::Vector2d(1, -0.8), white_noise(n, 1, 30'000 + i)));
        const VectorXd e = filter(one, Eigen::Vector2d(1, -pole), white_noise(n, 0.1, i));
        const ResidualTests tests = residual_tests({e}, {u});
        white += tests.verdicts[0].passed ? 0 : 1;
        dynamic += tests.verdicts[1].passed ? 0 : 1;
        feedback += tests.verdicts[1].meaning.find("feedback") != std::string::npos ? 1 : 0;
        for (std::size_t t = 0; t < 3; ++t) nonlinear[t] += tests.verdicts[2 + t].passed ? 0 : 1;
      }
      SCOPED_TRACE(fmt::format("pole {}, input {}: {} {} {} {}", pole, kind, white, dynamic, feedback,
                               fmt::join(nonlinear, " ")));
      if (pole > 0) {
        EXPECT_EQ(white, records);
      } else {
        EXPECT_LE(white, 0.03 * records);
      }
      EXPECT_LE(dynamic, 0.03 * records);
      EXPECT_LE(feedback, 0.03 * records);
      for (const int count : nonlinear) EXPECT_LE(count, 0.03 * records);
    }
  }
}

// Two slow signals that do not depend on each other: the scatter of r over records is what the band says.
TEST(Correlation, TheBandOfTwoSignalsIsThatOfTheirScatter) {
  double squares = 0, bands = 0;
  constexpr int records = 500;
  for (std::uint64_t i = 0; i < records; ++i) {
    const VectorXd e = filter(VectorXd::Ones(1), Eigen::Vector2d(1, -0.9), white_noise(2000, 1, i));
    const Correlation c = cross_correlation({e}, {staircase(2000, 10, 10, -1, 1, 1000 + i)}, 5);
    squares += c.r[5] * c.r[5] / records;
    bands += c.band95 / 1.959963984540054 / records;
  }
  EXPECT_NEAR(bands / std::sqrt(squares), 1, 0.1);  // 500 records: 3 % of a standard deviation
  EXPECT_GT(bands * std::sqrt(2000), 2);
}

TEST(ResidualTests, DoNotJudgeASquareThatDoesNotVary) {
  const ResidualTests tests =
      residual_tests({white_noise(500, 1, 1)}, {prbs(8, 1, 2, 500).array() - prbs(8, 1, 2, 500).mean()});
  VectorXd balanced = VectorXd::Ones(500);
  for (Index k = 0; k < 500; k += 2) balanced[k] = -1;
  const ResidualTests two = residual_tests({white_noise(500, 1, 1)}, {balanced});
  EXPECT_TRUE(two.verdicts[2].passed);
  EXPECT_EQ(two.verdicts[2].meaning, "the square of the input does not vary, so this is not tested");
  EXPECT_TRUE(tests.verdicts[2].passed);
}

TEST(Histogram, CountsEveryValueAndDrawsTheNormalDensity) {
  const VectorXd x = white_noise(4000, 2, 5);
  const Histogram h = histogram(x);
  EXPECT_EQ(h.edges.size(), 21);
  EXPECT_EQ(h.counts.sum(), 4000);
  EXPECT_DOUBLE_EQ(h.edges[0], x.minCoeff());
  EXPECT_NEAR(h.deviation, 2, 0.1);
  EXPECT_NEAR(h.normal.sum(), 4000, 10);
  EXPECT_LT((h.counts - h.normal).cwiseAbs().maxCoeff(), 100);
  const Histogram constant = histogram(VectorXd::Constant(7, 3.0), 4);
  EXPECT_EQ(constant.counts.sum(), 7);
}

}  // namespace
}  // namespace plantloop::identify
