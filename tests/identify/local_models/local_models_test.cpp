// Networks of local models: derivatives, the book's grids, trees, and the two ways of blending.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "identify/error.h"
#include "identify/local_models/local_model_network.h"
#include "identify/model_file/model_file.h"
#include "tests/identify/mlp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Example {
  DataSet data = first_order_data(600, 4, 201, 0.01), fresh = first_order_data(300, 6, 202);
  RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  Regression rows = make_regression(data, regressors);
  LocalModelOptions options;
  Example() {
    options.lower = (VectorXd(2) << -1.73, -1.2).finished();
    options.upper = -options.lower;
  }
  double one_step_error(const LocalModelFit& fit) const {
    return rms(one_step(make_narx(fit.model, regressors, data), fresh)[0], fresh.experiments[0].y, 1);
  }
  double simulation_error(const LocalModelFit& fit) const {
    return rms(free_run(make_narx(fit.model, regressors, data), fresh)[0], fresh.experiments[0].y, 1);
  }
  // Median distance of the local slopes from the system's gradient at the centres.
  static double slope_error(const LocalModelFit& fit) {
    std::vector<double> errors;
    for (const LocalModel& model : fit.model->models()) {
      const double y = model.centre[0], u = model.centre[1];
      const double s = 1 - std::pow(std::tanh(y + u * u * u), 2);
      const double by_y = 1 - 0.5 * s, by_u = -0.5 * s * 3 * u * u;
      errors.push_back(std::hypot(model.parameters(0, 0) - by_y, model.parameters(0, 1) - by_u));
    }
    std::sort(errors.begin(), errors.end());
    return errors[errors.size() / 2];
  }
};

TEST(LocalModelNetwork, HasTheDerivativeOfItsInputs) {
  const Example e;
  const LocalModelFit fit = fit_local_grid(e.rows.X, e.rows.Y, 3, e.options);
  std::vector<double> scratch(static_cast<std::size_t>(fit.model->scratch_size()));
  const VectorXd at = (VectorXd(2) << 0.31, -0.47).finished();
  VectorXd slope(2);
  fit.model->derivative(at.data(), slope.data(), scratch.data());
  for (Index d = 0; d < 2; ++d) {
    const double h = 1e-3;
    const auto value = [&](double step) {
      VectorXd moved = at;
      moved[d] += step;
      double y = 0;
      fit.model->evaluate(moved.data(), &y, scratch.data());
      return y;
    };
    EXPECT_NEAR(slope[d], (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h), 1e-8);
  }
}

TEST(LocalModelNetwork, WeighsToOneAlsoFarFromAllCentres) {
  const Example e;
  const LocalModelFit fit = fit_local_grid(e.rows.X, e.rows.Y, 3, e.options);
  VectorXd mu(9);
  const VectorXd far = (VectorXd(2) << 1e6, -1e6).finished();
  fit.model->weights(far.data(), mu.data());
  EXPECT_NEAR(mu.sum(), 1, 1e-15);
  EXPECT_TRUE(mu.allFinite());
}

// One affine model is ordinary least squares.
TEST(LocalGrid, OfOneCellIsOneAffineModel) {
  const Example e;
  LocalModelOptions options = e.options;
  options.ridge = 0;
  for (const LocalEstimation estimation : {LocalEstimation::local, LocalEstimation::global}) {
    options.estimation = estimation;
    const LocalModelFit fit = fit_local_grid(e.rows.X, e.rows.Y, 1, options);
    MatrixXd one(e.rows.X.rows(), 3);
    one << e.rows.X, VectorXd::Ones(e.rows.X.rows());
    const VectorXd residual = e.rows.Y - one * fit.model->models()[0].parameters.transpose();
    EXPECT_LT((one.transpose() * residual).norm(), 1e-10);
  }
}

// The book's points on Figures 5.11 to 5.13.
TEST(LocalGrid, FitsBetterGloballyAndTellsSlopesBetterLocally) {
  Example e;
  const LocalModelFit local = fit_local_grid(e.rows.X, e.rows.Y, 5, e.options);
  e.options.estimation = LocalEstimation::global;
  const LocalModelFit global = fit_local_grid(e.rows.X, e.rows.Y, 5, e.options);
  EXPECT_LT(global.report.reached, local.report.reached);
  EXPECT_LT(e.one_step_error(global), 0.03);
  EXPECT_LT(e.one_step_error(local), 0.025);
  EXPECT_LT(e.simulation_error(local), 0.05);
  EXPECT_LT(Example::slope_error(local), Example::slope_error(global));
  EXPECT_LT(Example::slope_error(local), 0.14);
}

TEST(LocalGrid, IsWorseWithFewerSchedulingVariables) {
  Example e;
  const LocalModelFit both = fit_local_grid(e.rows.X, e.rows.Y, 5, e.options);
  e.options.scheduling = {1};
  e.options.lower = VectorXd::Constant(1, -1.2);
  e.options.upper = VectorXd::Constant(1, 1.2);
  const LocalModelFit input_only = fit_local_grid(e.rows.X, e.rows.Y, 5, e.options);
  EXPECT_GT(e.one_step_error(input_only), 1.3 * e.one_step_error(both));
}

TEST(Lolimot, NeverGetsWorseWhileItGrows) {
  Example e;
  const LocalModelFit fit = fit_lolimot(e.rows.X, e.rows.Y, 10, e.options);
  ASSERT_EQ(fit.errors.size(), 10U);
  for (std::size_t i = 1; i < fit.errors.size(); ++i) EXPECT_LE(fit.errors[i], fit.errors[i - 1]);
  EXPECT_NEAR(fit.errors[0], 0.0905, 0.3 * 0.0905);
  EXPECT_NEAR(fit.errors[4], 0.031, 0.3 * 0.031);
  EXPECT_NEAR(fit.errors[9], 0.023, 0.3 * 0.023);
  // At the end all models are estimated once more.
  EXPECT_NEAR(std::sqrt(fit.report.reached), fit.errors[9], 0.05 * fit.errors[9]);
}

// Models (a, b) = (0.5, 0.5) and (0.9, 0.1) with mu = ((1-u)/2, (1+u)/2): as Gaussian weights that is close to it.
TEST(Blending, OfOutputsAndOfParametersDiffersForDynamicModels) {
  Random random(7);
  MatrixXd u(200, 1);
  for (Index k = 0; k < 200; ++k) u(k, 0) = k % 10 == 0 ? random.uniform(-1, 1) : u(k - 1, 0);
  const DataSet data = make_data_set(u, MatrixXd::Zero(200, 1), 1, {{"u", ""}}, {{"y", ""}});
  const auto model = [&](double a, double b, double centre) {
    return LocalModel{VectorXd::Constant(1, centre), VectorXd::Constant(1, 1.0),
                      (MatrixXd(1, 3) << a, b, 0).finished()};
  };
  const auto network = [&](double a2, double b2) {
    return make_narx(std::make_shared<LocalModelNetwork>(
                         std::vector<int>{1}, std::vector<LocalModel>{model(0.5, 0.5, -1), model(a2, b2, 1)}),
                     parse_regressors("y(k-1), u(k-1)", data), data);
  };
  const NarxModel dynamic = network(0.9, 0.1), equal = network(0.5, 0.5);
  const double difference = rms(free_run(dynamic, data)[0], simulate_blended_outputs(dynamic, data)[0]);
  EXPECT_GT(difference, 0.03);
  EXPECT_LT(difference, 0.2);
  EXPECT_LT(rms(free_run(equal, data)[0], simulate_blended_outputs(equal, data)[0]), 1e-14);
}

TEST(ModelFile, OfLocalModelsComesBackWithTheSameBits) {
  const Example e;
  const LocalModelFit fit = fit_lolimot(e.rows.X, e.rows.Y, 4, e.options);
  const NarxModel model = make_narx(fit.model, e.regressors, e.data, fit.report);
  const std::string text = to_yaml(model);
  const NarxModel back = read_narx(read_model_file(text, "local.yaml"));
  EXPECT_EQ(to_yaml(back), text);
  EXPECT_EQ(free_run(back, e.fresh)[0], free_run(model, e.fresh)[0]);
}

template <typename Action>
std::string complaint(const Action& action) {
  try {
    action();
  } catch (const IdentifyError& error) {
    return error.what();
  }
  return "none";
}

TEST(LocalModelErrors, AreInTheUsersWords) {
  const Example e;
  LocalModelOptions options;
  options.scheduling = {2};
  EXPECT_EQ(complaint([&] { fit_local_grid(e.rows.X, e.rows.Y, 3, options); }),
            "scheduling variable 3 is none of the 2 regressors");
  EXPECT_EQ(complaint([&] { fit_local_grid(e.rows.X, e.rows.Y, 200); }),
            "200 cells along each of 2 scheduling variables are 40000 local models, more than 10000; schedule by fewer "
            "variables or use a tree");
  MatrixXd flat = e.rows.X;
  flat.col(0).setConstant(2);
  EXPECT_EQ(complaint([&] { fit_lolimot(flat, e.rows.Y, 3); }), "scheduling variable 1 does not vary: from 2 to 2");
}

// 1000 models of 3 parameters from 199 rows never ended.
TEST(FitLolimot, StopsWhereModelsWouldSeeFewerRowsThanTheyHaveParameters) {
  const DataSet data = first_order_data(200, 4, 1, 0.01);
  const RegressorSet set = parse_regressors("y(k-1), u(k-1)", data);
  const Regression rows = make_regression(data, set);
  const LocalModelFit fit = fit_lolimot(rows.X, rows.Y, 1000);
  EXPECT_LE(fit.model->models().size(), 66U);
  ASSERT_FALSE(fit.report.warnings.empty());
  EXPECT_EQ(fit.report.warnings[0],
            "More local models were asked for than 199 rows can have: 66 of 3 parameters each.");
  FitControl control;
  control.deadline = std::chrono::steady_clock::now();
  EXPECT_THROW(fit_lolimot(rows.X, rows.Y, 60, {}, control), Cancelled);
}

TEST(FitLocalGrid, RefusesMoreParametersAtOnceThanCanBeSolvedFor) {
  const Example e;
  LocalModelOptions options = e.options;
  options.estimation = LocalEstimation::global;
  try {
    fit_local_grid(e.rows.X, e.rows.Y, 40, options);
    ADD_FAILURE();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(),
                 "1600 local models have 4800 parameters, which global estimation solves for at once; it takes at most "
                 "3000: fewer models, or estimation = \"local\"");
  }
}

}  // namespace
}  // namespace plantloop::identify
