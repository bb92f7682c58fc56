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
