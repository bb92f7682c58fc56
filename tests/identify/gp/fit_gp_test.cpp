// Maximum likelihood on known optima, and what the report says.

#include "identify/gp/fit_gp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>

#include "identify/error.h"
#include "tests/identify/gp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;

TEST(FitGp, FindsTheMaximumOfTheStaticExample) {
  for (const Descent method : {Descent::quasi_newton, Descent::conjugate_gradient}) {
    GpOptions options;
    options.method = method;
    const GpFit fit = fit_gp(eight_x(), eight_y(), options);
    const Hyperparameters& at = fit.model.hyperparameters();
    EXPECT_NEAR(at.theta[0], 4.3239, 1e-4 * 4.3239);
    EXPECT_NEAR(at.theta[1], 1.58117, 1e-4 * 1.58117);
    EXPECT_NEAR(at.v0, 0.0100724, 1e-4 * 0.0100724);
    EXPECT_NEAR(fit.report.reached, -1.868180, 1e-6);
    EXPECT_NEAR(fit.report.reached, fit.optima.front().log_likelihood, 1e-12);
  }
}

TEST(FitGp, IsTheSameForAnyNumberOfThreads) {
  const MatrixXd x = random_points(60, 2, 71);
  const VectorXd y = first_order_targets(x, 0.05, 72);
  GpOptions options;
  options.starts = 4;
  options.threads = 1;
  const GpFit one = fit_gp(x, y, options);
  options.threads = 3;
  const GpFit three = fit_gp(x, y, options);
  EXPECT_EQ(one.model.hyperparameters().theta, three.model.hyperparameters().theta);
  EXPECT_EQ(one.model.hyperparameters().v0, three.model.hyperparameters().v0);
  EXPECT_EQ(one.report.tried, three.report.tried);
}

TEST(FitGp, RecoversTheNoiseAndIgnoresAnInputWithoutInfluence) {
  MatrixXd x(200, 3);
  x << random_points(200, 2, 81), random_points(200, 1, 83);
  const VectorXd y = first_order_targets(x.leftCols(2), 0.05, 82);
  GpOptions options;
  options.starts = 3;
  const GpFit fit = fit_gp(x, y, options);
  EXPECT_NEAR(std::sqrt(fit.model.hyperparameters().v0), 0.05, 0.01);
  EXPECT_LT(fit.model.hyperparameters().theta[2], 0.05 * fit.model.hyperparameters().theta[1]);
}

TEST(FitGp, ReportsEveryStartAndWhyItStopped) {
  const GpFit fit = fit_gp(eight_x(), eight_y());
  ASSERT_EQ(fit.report.tried.size(), 10U);
  EXPECT_THAT(fit.report.tried, Each(MatchesRegex("start .*: log likelihood .* after .* iterations; .+")));
  EXPECT_THAT(fit.report.stopped, Not(IsEmpty()));
  EXPECT_THAT(to_text(fit.report), HasSubstr("reached: -1.86818"));
}

TEST(FitGp, WarnsOfDataThatCannotTeach) {
  GpOptions options;
  options.starts = 2;
  EXPECT_THAT(fit_gp(eight_x(), VectorXd::Constant(8, 2.0), options).report.warnings,
              Contains("All targets are equal, so nothing can be learned from them."));
  MatrixXd constant(8, 2);
  constant << eight_x(), VectorXd::Ones(8);
  EXPECT_THAT(fit_gp(constant, eight_y(), options).report.warnings,
              Contains("Input 2 is constant, so its weight is not determined."));
  MatrixXd twice(16, 1);
  twice << eight_x(), eight_x();
  VectorXd y(16);
  y << eight_y(), eight_y();
  EXPECT_THAT(
      fit_gp(twice, y, options).report.warnings,
      Contains("8 of 16 points repeat an earlier one; they tell about the noise only, so it cannot become zero."));
}

TEST(FitGp, CopesWithTinyAndHugeNumbers) {
  GpOptions options;
  options.starts = 3;
  const GpFit plain = fit_gp(eight_x(), eight_y(), options);
  for (const double scale : {1e-9, 1e9}) {
    const GpFit fit = fit_gp(scale * eight_x(), scale * eight_y(), options);
    EXPECT_NEAR(fit.model.hyperparameters().theta[1] / (scale * scale), plain.model.hyperparameters().theta[1], 1e-3);
  }
}

TEST(FitGp, TellsItsProgressAndEndsWhenToldTo) {
  double last = 0;
  bool ascending = true;
  std::atomic<bool> cancel{false};
  FitControl control;
  control.cancel = &cancel;
  control.progress = [&](double fraction) {
    ascending = ascending && fraction >= last && fraction <= 1;
    last = fraction;
    if (fraction > 0.3) cancel = true;
  };
  GpOptions options;
  options.threads = 1;  // progress is told from this thread, which else may get little of the work
  EXPECT_THROW(fit_gp(eight_x(), eight_y(), options, control), Cancelled);
  EXPECT_TRUE(ascending);
  EXPECT_GT(last, 0.3);
}

TEST(CrossValidation, WithRefitIsAtLeastDefinedEverywhere) {
  GpOptions options;
  options.starts = 3;
  const GpFit fit = fit_gp(eight_x(), eight_y(), options);
  const LeaveOneOut kept = cross_validate(fit.model, 4, false), refit = cross_validate(fit.model, 4, true);
  EXPECT_TRUE(refit.mean.allFinite());
  EXPECT_GT((kept.mean - refit.mean).norm(), 1e-6);  // the hyperparameters did change
  try {
    cross_validate(fit.model, 9);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "9 folds of 8 rows; there must be from 2 to 8 folds");
  }
}

TEST(Minimise, StopsAtBoundsAndSaysWhy) {
  const Objective bowl = [](const VectorXd& x, VectorXd* g) {
    if (g != nullptr) *g = 2 * (x - VectorXd::Constant(2, 3.0));
    return (x.array() - 3).square().sum();
  };
  MinimiseOptions options;
  options.upper = VectorXd::Constant(2, 5.0);
  options.upper[0] = 1;
  options.lower = VectorXd::Constant(2, -5.0);
  const Minimum end = minimise(bowl, VectorXd::Zero(2), options);
  EXPECT_NEAR(end.x[0], 1, 1e-12);
  EXPECT_NEAR(end.x[1], 3, 1e-6);
  EXPECT_THAT(end.stop, HasSubstr("the gradient is below"));
}

TEST(Minimise, FindsTheValleyOfRosenbrock) {
  const Objective valley = [](const VectorXd& x, VectorXd* g) {
    const double a = 1 - x[0], b = x[1] - x[0] * x[0];
    if (g != nullptr) *g << -2 * a - 400 * x[0] * b, 200 * b;
    return a * a + 100 * b * b;
  };
  VectorXd start(2);
  start << -1.2, 1;
  for (const Descent method : {Descent::quasi_newton, Descent::conjugate_gradient}) {
    MinimiseOptions options;
    options.method = method;
    options.max_iterations = 2000;
    const Minimum end = minimise(valley, start, options);
    EXPECT_LT((end.x - VectorXd::Ones(2)).norm(), 1e-4);
  }
}

TEST(Minimise, TakesBackStepsToWhereTheFunctionIsNotDefined) {
  const Objective log_barrier = [](const VectorXd& x, VectorXd* g) {
    if (!(x[0] > 0)) return std::nan("");
    if (g != nullptr) (*g)[0] = 1 - 1 / x[0];
    return x[0] - std::log(x[0]);
  };
  EXPECT_NEAR(minimise(log_barrier, VectorXd::Constant(1, 30.0)).x[0], 1, 1e-6);
}

// Matrices of 2500 points take seconds each, and ten starts minutes.
TEST(FitGp, EndsSoonAfterItsDeadline) {
  Random random(3);
  MatrixXd x(2500, 3);
  for (double& v : x.reshaped()) v = random.normal();
  const VectorXd y = x.rowwise().sum().array().sin();
  FitControl control;
  const auto start = std::chrono::steady_clock::now();
  control.deadline = start + std::chrono::milliseconds(300);
  EXPECT_THROW(fit_gp(x, y, {}, control), Cancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

}  // namespace
}  // namespace plantloop::identify
