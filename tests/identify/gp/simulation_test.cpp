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

// Two outputs that drive each other: y1 the book's system with a part of y2, y2 a lag of y1 and an input of its own.
DataSet coupled_data(int samples, std::uint64_t seed, double noise = 0.03) {
  Random random(seed);
  MatrixXd u(samples, 2), y = MatrixXd::Zero(samples, 2);
  VectorXd level = VectorXd::Zero(2);
  for (Index k = 0; k < samples; ++k) {
    if (k % 4 == 0) level << random.uniform(-1.2, 1.2), random.uniform(-1, 1);
    u.row(k) = level.transpose();
    if (k > 0) {
      y(k, 0) = y(k - 1, 0) - 0.5 * std::tanh(y(k - 1, 0) + std::pow(u(k - 1, 0), 3)) + 0.2 * y(k - 1, 1);
      y(k, 1) = 0.6 * y(k - 1, 1) + 0.3 * std::sin(y(k - 1, 0)) + 0.2 * u(k - 1, 1);
    }
  }
  for (Index k = 0; k < samples; ++k) {
    for (Index o = 0; o < 2; ++o) y(k, o) += noise * random.normal();
  }
  return make_data_set(u, y, 0.5, {{"u1", ""}, {"u2", ""}}, {{"y1", ""}, {"y2", ""}});
}

TEST(GpSimulation, OfTwoOutputsAgreesWithTrajectories) {
  const DataSet data = coupled_data(120, 311), fresh = coupled_data(25, 312, 0);
  GpOptions options;
  options.starts = 1;
  const NarxModel model = fit_narx_gp(data, parse_regressors("y1(k-1), y2(k-1), u1(k-1), u2(k-1)", data), options);
  const MatrixXd matched = simulate_uncertain(model, fresh, Propagation::moment_matching)[0];
  constexpr int trajectories = 6000;
  const MatrixXd drawn = simulate_monte_carlo(model, fresh, trajectories)[0];
  ASSERT_EQ(matched.cols(), 6);
  // The first step starts from what is known; the second is exact but for the sampling, since its inputs are normal.
  EXPECT_NEAR(matched(1, 3), 0, 1e-14);
  const double standard_error = std::sqrt(2.0 / trajectories);
  for (Index o = 0; o < 2; ++o) {
    EXPECT_NEAR(matched(2, o), drawn(2, o), 4 * std::sqrt(matched(2, 2 + 3 * o) / trajectories));
    EXPECT_NEAR(matched(2, 2 + 3 * o) / drawn(2, 2 + 3 * o), 1, 4 * standard_error);
  }
  EXPECT_NEAR(matched(2, 3), drawn(2, 3),
              4 * std::sqrt((matched(2, 2) * matched(2, 5) + matched(2, 3) * matched(2, 3)) / trajectories));
  // Later ones are not normal any more.
  double correlated = 0;
  for (Index k = 3; k < 25; ++k) {
    for (Index o = 0; o < 2; ++o) {
      EXPECT_NEAR(matched(k, o), drawn(k, o), 0.2 * std::sqrt(drawn(k, 2 + 3 * o)));
      EXPECT_NEAR(std::sqrt(matched(k, 2 + 3 * o) / drawn(k, 2 + 3 * o)), 1, 0.25);
    }
    const double by_matching = matched(k, 3) / std::sqrt(matched(k, 2) * matched(k, 5));
    const double by_drawing = drawn(k, 3) / std::sqrt(drawn(k, 2) * drawn(k, 5));
    EXPECT_NEAR(by_matching, by_drawing, 0.15);
    EXPECT_EQ(matched(k, 3), matched(k, 4));
    correlated = std::max(correlated, std::fabs(by_drawing));
  }
  EXPECT_GT(correlated, 0.2);
}

// A model of one output twice: each is that of the one. y2 is fed back by nobody.
TEST(GpSimulation, OfAnOutputTwiceIsThatOfTheOutput) {
  const Example& e = example();
  const auto map = std::dynamic_pointer_cast<const GpMap>(e.model.map);
  Scaling both;
  both.offset = VectorXd::Constant(2, map->y_scaling().offset[0]);
  both.scale = VectorXd::Constant(2, map->y_scaling().scale[0]);
  const auto twice =
      std::make_shared<const GpMap>(GpMap::Processes{map->processes()[0], map->processes()[0]}, map->x_scaling(), both);
  DataSet fresh = e.fresh;
  fresh.outputs = {{"y1", ""}, {"y2", ""}};
  MatrixXd& y = fresh.experiments[0].y;
  y = y.col(0).replicate(1, 2).eval();
  const NarxModel model = make_narx(twice, parse_regressors("y1(k-1), u(k-1)", fresh), fresh);
  for (const Propagation how : {Propagation::naive, Propagation::first_order, Propagation::moment_matching}) {
    const MatrixXd two = simulate_uncertain(model, fresh, how)[0], one = simulate_uncertain(e.model, e.fresh, how)[0];
    for (Index o = 0; o < 2; ++o) {
      EXPECT_LT((two.col(o) - one.col(0)).norm(), 1e-10);
      EXPECT_LT((two.col(2 + 3 * o) - one.col(1)).norm(), 1e-10);
    }
    // What they share is less than the variance of each.
    for (Index k = 2; k < one.rows(); ++k) EXPECT_LT(two(k, 3), one(k, 1));
  }
}

// y(k) = A y(k-1) + B u(k-1) known exactly but for noise v0: the covariance obeys P = A P A' + V.
TEST(GpSimulation, OfALinearSystemObeysTheLyapunovRecursion) {
  Random random(321);
  const MatrixXd A = (MatrixXd(2, 2) << 0.6, -0.3, 0.4, 0.5).finished();
  const MatrixXd B = (MatrixXd(2, 1) << 1.0, -0.5).finished();
  const int samples = 40;
  MatrixXd u(samples, 1), y = MatrixXd::Zero(samples, 2);
  for (Index k = 0; k < samples; ++k) {
    u(k, 0) = random.uniform(-1, 1);
    if (k > 0) y.row(k) = y.row(k - 1) * A.transpose() + u.row(k - 1) * B.transpose();
  }
  const DataSet data = make_data_set(u, y, 1, {{"u", ""}}, {{"y1", ""}, {"y2", ""}});
  const RegressorSet set = parse_regressors("y1(k-1), y2(k-1), u(k-1)", data);
  const Regression rows = make_regression(data, set);
  const double noise = 1e-4;
  std::vector<GaussianProcess> processes;
  for (Index o = 0; o < 2; ++o)
    processes.emplace_back(find_covariance("linear"), MeanFunction::zero,
                           Hyperparameters{VectorXd::Constant(4, 1e4), noise}, rows.X, rows.Y.col(o));
  const auto map = std::make_shared<const GpMap>(processes, no_scaling(3), no_scaling(2));
  const NarxModel model = make_narx(map, set, data);
  for (const Propagation how : {Propagation::first_order, Propagation::moment_matching}) {
    const MatrixXd run = simulate_uncertain(model, data, how)[0];
    MatrixXd P = MatrixXd::Zero(2, 2), with_noise = P;
    VectorXd mean = y.row(0).transpose();
    for (Index k = 1; k < samples; ++k) {
      P = A * with_noise * A.transpose();
      mean = A * mean + B * u.row(k - 1).transpose();
      EXPECT_LT((run.row(k).head(2).transpose() - mean).norm(), 1e-5);
      // The model's own uncertainty comes on top: of the order of the noise over the number of rows.
      for (Index i = 0; i < 4; ++i) EXPECT_NEAR(run(k, 2 + i), P(i / 2, i % 2), 0.5 * noise);
      with_noise = P + noise * MatrixXd::Identity(2, 2);
    }
    EXPECT_GT(P(0, 0), 0.3 * noise);
  }
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
