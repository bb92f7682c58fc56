// Training for simulation: exact gradients through time, and what they are good for.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "identify/error.h"
#include "identify/linear/regression_model.h"
#include "identify/mlp/fit_mlp.h"
#include "identify/mlp/problems.h"
#include "tests/identify/mlp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

DataSet two_outputs() {
  const DataSet a = first_order_data(60, 3, 61), b = first_order_data(60, 5, 62);
  MatrixXd u(60, 2), y(60, 2);
  u << a.experiments[0].u, b.experiments[0].u;
  y << a.experiments[0].y + 0.3 * b.experiments[0].y, b.experiments[0].y;
  return make_data_set(u, y, 0.5, {{"u1", ""}, {"u2", ""}}, {{"y1", ""}, {"y2", ""}});
}

// g = J'e is -1/2 of the derivative of the sum of squares: by differences of order 4.
TEST(SimulationTraining, HasExactGradientsThroughTime) {
  const DataSet data = join(two_outputs(), part(two_outputs(), 10, 40));
  for (const char* text : {"y1(k-1), y2(k-1), u1(k-1), u2(k-2)",
                           "y1(k-1..2), y2(k-3), y1(k-1)*u1(k-1), y2(k-1)^2, u2(k-1)", "u1(k-1..2), u2(k-1)"}) {
    const RegressorSet regressors = parse_regressors(text, data);
    Network network = make_network(static_cast<int>(regressors.size()), {4}, 2, Activation::tanh);
    Random random(63);
    randomise(network, 0.4, random);
    const Regression rows = make_regression(data, regressors);
    const SimulationTraining training(network, standard_scaling(rows.X), standard_scaling(rows.Y), regressors, data);
    const VectorXd theta = network.theta();
    MatrixXd r;
    VectorXd g;
    EXPECT_NEAR(training.normal(theta, r, g), training.sse(theta), 1e-10 * training.sse(theta));
    for (Index j = 0; j < theta.size(); ++j) {
      const auto at = [&](double step) {
        VectorXd moved = theta;
        moved[j] += step;
        return training.sse(moved);
      };
      const double h = 1e-3;
      const double slope = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
      EXPECT_NEAR(g[j], -slope / 2, 1e-7 * std::max(1.0, g.cwiseAbs().maxCoeff())) << text;
    }
  }
}

TEST(SimulationTraining, CountsMissingOutputsNotAsErrors) {
  DataSet data = first_order_data(80, 4, 64);
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  const Network network = printed_network();
  const SimulationTraining whole(network, no_scaling(2), no_scaling(1), regressors, data);
  const double missed = std::pow(
      data.experiments[0].y(30, 0) -
          [&] {
            return free_run(make_narx(std::make_shared<Mlp>(network, no_scaling(2), no_scaling(1)), regressors, data),
                            data)[0](30, 0);
          }(),
      2);
  data.experiments[0].y(30, 0) = std::nan("");
  const SimulationTraining gap(network, no_scaling(2), no_scaling(1), regressors, data);
  EXPECT_NEAR(gap.sse(network.theta()), whole.sse(network.theta()) - missed, 1e-12);
  EXPECT_EQ(gap.targets(), 78);
  data.experiments[0].u(30, 0) = std::nan("");
  try {
    const SimulationTraining none(network, no_scaling(2), no_scaling(1), regressors, data);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(
        error.what(),
        "training for simulation needs every input, and every output of the first 1 samples; values are missing");
  }
}

// The book's example: five neurons follow the noise-free system one step ahead and in free run.
TEST(FitNarxMlp, FollowsTheBooksFirstOrderSystem) {
  const DataSet data = first_order_data(500, 4, 65), fresh = first_order_data(300, 6, 66);
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  MlpOptions options;
  options.hidden = {5};
  options.starts = 8;
  const NarxMlpFit fit = fit_narx_mlp(data, regressors, {}, options);
  EXPECT_LT(rms(one_step(fit.model, fresh)[0], fresh.experiments[0].y, 1), 0.015);
  EXPECT_LT(rms(free_run(fit.model, fresh)[0], fresh.experiments[0].y, 1), 0.03);
}

// With measurement noise the one-step criterion is biased; simulation error on average is not.
TEST(FitNarxMlp, TrainedForSimulationIsBetterWithMeasurementNoise) {
  double narx = 0, noe = 0;  // sums of free-run errors against the true output
  for (std::uint64_t draw = 0; draw < 6; ++draw) {
    const DataSet data = first_order_data(500, 4, 170 + draw, 0, 0.05), fresh = first_order_data(300, 6, 180 + draw);
    const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
    MlpOptions options;
    options.hidden = {5};
    options.starts = 6;
    narx += rms(free_run(fit_narx_mlp(data, regressors, {}, options).model, fresh)[0], fresh.experiments[0].y, 1);
    options.simulation = true;
    noe += rms(free_run(fit_narx_mlp(data, regressors, {}, options).model, fresh)[0], fresh.experiments[0].y, 1);
  }
  EXPECT_LT(noe, 0.85 * narx);
}

// y(k) = 1.6 y(k-1) - 0.65 y(k-2) + 0.05 tanh(2 u(k-1)): slow, and linear but for its input.
DataSet slow_data(int samples, std::uint64_t seed, double noise) {
  Random random(seed);
  MatrixXd u(samples, 1), y = MatrixXd::Zero(samples, 1);
  for (Index k = 0; k < samples; ++k) {
    u(k, 0) = k % 10 == 0 ? random.uniform(-2, 2) : u(k - 1, 0);
    if (k > 1) y(k, 0) = 1.6 * y(k - 1, 0) - 0.65 * y(k - 2, 0) + 0.05 * std::tanh(2 * u(k - 1, 0));
  }
  for (double& each : y.reshaped()) each += noise * random.normal();
  return make_data_set(u, y, 1, {{"u", ""}}, {{"y", ""}});
}

// From the linear model, over short pieces and then the whole record, few iterations find what random weights do not.
TEST(FitNarxMlp, BesideALinearModelFollowsASlowProcess) {
  const DataSet data = slow_data(500, 91, 0.02), fresh = slow_data(400, 92, 0);
  const RegressorSet regressors = parse_regressors("y(k-1..2), u(k-1..2)", data);
  MlpOptions options;
  options.hidden = {3};
  options.starts = 4;
  options.refined = 2;
  options.simulation = true;
  options.direct = true;
  options.one_step_iterations = 20;
  options.training.iterations = 40;
  options.training.decay = 1e-3;
  options.horizons = {30, 0};
  const NarxMlpFit fit = fit_narx_mlp(data, regressors, {}, options);
  const RegressionModel linear = fit_regression(data, parse_regressors("1, y(k-1..2), u(k-1..2)", data));
  const double error = rms(free_run(fit.model, fresh)[0], fresh.experiments[0].y, 2);
  EXPECT_LT(error, 0.01);
  EXPECT_LT(error, 0.2 * rms(free_run(linear, fresh)[0], fresh.experiments[0].y, 2));
}

// No neuron reaches the output at first: one iteration from there cannot be worse than least squares.
TEST(FitMlp, WithDirectConnectionsIsNeverWorseThanTheLinearModel) {
  const DataSet data = slow_data(300, 93, 0.05);
  const Regression rows = make_regression(data, parse_regressors("y(k-1..2), u(k-1..2)", data));
  MatrixXd x(rows.X.rows(), 5);
  x << rows.X, VectorXd::Ones(rows.X.rows());
  const VectorXd theta = (x.transpose() * x).ldlt().solve(x.transpose() * rows.Y);
  MlpOptions options;
  options.hidden = {4};
  options.starts = 1;
  options.direct = true;
  options.training.iterations = 1;
  EXPECT_LE(rms(evaluate_rows(*fit_mlp(rows.X, rows.Y, options).model, rows.X), rows.Y),
            rms(x * theta, rows.Y) * (1 + 1e-9));
}

TEST(FitNarxMlpErrors, AreInTheUsersWords) {
  const DataSet data = first_order_data(100, 4, 94);
  MlpOptions options;
  options.simulation = true;
  options.horizons = {-3};
  try {
    fit_narx_mlp(data, parse_regressors("y(k-1), u(k-1)", data), {}, options);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "the horizons of the free run are numbers of samples; 0 stands for the whole record");
  }
}

TEST(RefineNarxMlp, StartsFromTheGivenNetworkAndImprovesIt) {
  const DataSet data = first_order_data(500, 5, 90);
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  const Mlp printed(printed_network(), no_scaling(2), no_scaling(1));
  const NarxMlpFit fit = refine_narx_mlp(data, regressors, printed, {});
  EXPECT_LT(rms(one_step(fit.model, data)[0], data.experiments[0].y, 1), 0.0125);
  MlpOptions options;
  options.simulation = true;
  const NarxMlpFit simulated = refine_narx_mlp(data, regressors, printed, options);
  EXPECT_LT(rms(free_run(simulated.model, data)[0], data.experiments[0].y, 1),
            0.5 * rms(free_run(make_narx(std::make_shared<Mlp>(printed), regressors, data), data)[0],
                      data.experiments[0].y, 1));
}

}  // namespace
}  // namespace plantloop::identify
