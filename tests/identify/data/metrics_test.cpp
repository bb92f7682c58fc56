// Measures of prediction errors against their formulas on numbers done by hand.

#include "identify/validation/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace plantloop::identify {
namespace {

using Eigen::Vector4d;
using Eigen::VectorXd;

const VectorXd y = Vector4d(1, 2, 3, 4);
const VectorXd prediction = Vector4d(1, 1, 5, 4);  // errors 0, 1, -2, 0; spread 5

TEST(Metrics, AreTheFormulasOfTheBook) {
  EXPECT_DOUBLE_EQ(absolute_error(y, prediction), 0.75);
  EXPECT_DOUBLE_EQ(squared_error(y, prediction), 1.25);
  EXPECT_DOUBLE_EQ(root_mean_square_error(y, prediction), std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(normalised_rmse(y, prediction), 1);
  EXPECT_DOUBLE_EQ(fit_percent(y, prediction), 0);
  EXPECT_DOUBLE_EQ(largest_error(y, prediction), 2);
  const VectorXd variance = Vector4d(1, 4, 1, 4);
  const double ld = (4 * std::log(2 * std::numbers::pi) + 2 * std::log(4.0) + 0.25 + 4) / 8;
  EXPECT_NEAR(log_density_error(y, prediction, variance), ld, 1e-15);
  EXPECT_DOUBLE_EQ(coverage(y, prediction, variance, 1.9), 0.75);
}

TEST(Metrics, CriteriaPenaliseParameters) {
  EXPECT_DOUBLE_EQ(akaike(2, 4, 3), 4 * std::log(0.5) + 6);
  EXPECT_DOUBLE_EQ(minimum_description_length(2, 4, 3), 4 * std::log(0.5) + 3 * std::log(4.0));
  EXPECT_DOUBLE_EQ(final_prediction_error(2, 4, 3), 7.0 * 2 / 8);
  EXPECT_TRUE(std::isnan(final_prediction_error(2, 4, 4)));
}

TEST(Metrics, MissingSamplesAreNotCounted) {
  VectorXd gaps = y;
  gaps[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DOUBLE_EQ(squared_error(gaps, prediction), 1.0 / 3);
  EXPECT_DOUBLE_EQ(largest_error(gaps, prediction), 1);
  for (const Metric& metric : metrics()) {
    EXPECT_TRUE(std::isnan(metric.value(VectorXd::Constant(2, gaps[2]), VectorXd::Zero(2)))) << metric.name;
  }
}

}  // namespace
}  // namespace plantloop::identify
