// Free runs of Gaussian processes: the dynamic example of the book, and uncertainty against trajectories.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "identify/error.h"
#include "identify/gp/gp_map.h"
#include "identify/model_file/model_file.h"
#include "identify/validation/metrics.h"
#include "tests/identify/mlp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// 100 points of the system (7.20) with noise 0.05.
struct Example {
  DataSet data = first_order_data(150, 4, 301, 0, 0.05, 1.3), fresh = first_order_data(60, 8, 302);
  NarxModel model;
  Example() {
    GpOptions options;
    options.starts = 3;
    model = fit_narx_gp(data, parse_regressors("y(k-1), u(k-1)", data), options);
  }
};
const Example& example() {
  static const Example made;
  return made;
}

TEST(GpSimulation, FollowsTheBooksDynamicExample) {
  const Example& e = example();
  const MatrixXd run = simulate_uncertain(e.model, e.fresh, Propagation::moment_matching)[0];
  const VectorXd y = e.fresh.experiments[0].y.col(0).tail(59), mean = run.col(0).tail(59);
  const VectorXd variance = run.col(1).tail(59).array() + 0.0025;
  EXPECT_LT(absolute_error(y, mean), 0.08);
  EXPECT_LT(squared_error(y, mean), 0.012);
  EXPECT_LT(log_density_error(y, mean, variance), -0.7);
}

TEST(GpSimulation, IsLessCertainWhenUncertaintyIsCarriedAlong) {
  const Example& e = example();
  const MatrixXd naive = simulate_uncertain(e.model, e.fresh, Propagation::naive)[0];
  const MatrixXd matched = simulate_uncertain(e.model, e.fresh, Propagation::moment_matching)[0];
  const MatrixXd first = simulate_uncertain(e.model, e.fresh, Propagation::first_order)[0];
  EXPECT_LT(naive.col(1).mean(), matched.col(1).mean());
  EXPECT_LT(naive.col(1).mean(), first.col(1).mean());
  EXPECT_EQ(naive.col(0), free_run(e.model, e.fresh)[0].col(0));
}

TEST(GpSimulation, ByMomentMatchingAgreesWithTrajectories) {
  const Example& e = example();
  const DataSet shorter = part(e.fresh, 0, 30);
  const MatrixXd matched = simulate_uncertain(e.model, shorter, Propagation::moment_matching)[0];
  const MatrixXd drawn = simulate_monte_carlo(e.model, shorter, 4000)[0];
  std::vector<double> ratios;
  for (Index k = 1; k < 30; ++k) {
    EXPECT_NEAR(matched(k, 0), drawn(k, 0), 0.03);
    ratios.push_back(std::sqrt(matched(k, 1) / drawn(k, 1)));
  }
  std::sort(ratios.begin(), ratios.end());
  EXPECT_GT(ratios.front(), 0.6);
  EXPECT_LT(ratios.back(), 1.2);
  EXPECT_NEAR(ratios[ratios.size() / 2], 1, 0.08);
}

// Of a linear process the distribution stays normal, and both closed forms are exact; with gaps between the lags.
TEST(GpSimulation, KeepsTheCovarianceOfLagsThatAreNoRegressors) {
  const DataSet data = first_order_data(80, 3, 303, 0, 0.02);
  GpOptions options;
  options.covariance = "linear";
  options.starts = 2;
  const NarxModel model = fit_narx_gp(data, parse_regressors("y(k-2), u(k-1)", data), options);
  const DataSet shorter = part(data, 0, 25);
  const MatrixXd first = simulate_uncertain(model, shorter, Propagation::first_order)[0];
  const MatrixXd drawn = simulate_monte_carlo(model, shorter, 6000)[0];
  for (Index k = 2; k < 25; ++k) EXPECT_NEAR(std::sqrt(first(k, 1) / drawn(k, 1)), 1, 0.05);
}

TEST(GpMap, HasTheDerivativesOfMeanAndVariance) {
  const Approximator& map = *example().model.map;
  const VectorXd at = (VectorXd(2) << 0.3, -0.6).finished();
  VectorXd slope(2), spread(2);
  map.derivative(at.data(), slope.data(), nullptr);
  map.variance_derivative(at.data(), spread.data(), nullptr);
  for (Index d = 0; d < 2; ++d) {
    const double h = 1e-3;
    const auto difference = [&](auto value) {
      const auto moved = [&](double step) {
        VectorXd x = at;
        x[d] += step;
        double result = 0;
        value(x.data(), &result);
        return result;
      };
      return (8 * (moved(h) - moved(-h)) - (moved(2 * h) - moved(-2 * h))) / (12 * h);
    };
    EXPECT_NEAR(slope[d], difference([&](const double* x, double* y) { map.evaluate(x, y, nullptr); }), 1e-8);
    EXPECT_NEAR(spread[d], difference([&](const double* x, double* y) { map.variance(x, y, nullptr); }), 1e-8);
  }
}

TEST(ModelFile, OfAGaussianProcessComesBackWithTheSameBits) {
  const Example& e = example();
  const std::string text = to_yaml(e.model);
  const NarxModel back = read_narx(read_model_file(text, "gp.yaml"));
  EXPECT_EQ(to_yaml(back), text);
  EXPECT_EQ(free_run(back, e.fresh)[0], free_run(e.model, e.fresh)[0]);
}

TEST(GpSimulationErrors, AreInTheUsersWords) {
  const DataSet data = first_order_data(40, 4, 304);
  GpOptions options;
  options.starts = 1;
  const NarxModel model = fit_narx_gp(data, parse_regressors("y(k-1)^2, u(k-1)", data), options);
  try {
    simulate_uncertain(model, data, Propagation::first_order);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "uncertainty is carried along for single lags only, not for 'y(k-1)^2'");
  }
}

}  // namespace
}  // namespace plantloop::identify
