// Training: the static functions of the book, the algorithms against each other, and what the report says.

#include "identify/mlp/fit_mlp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "identify/error.h"
#include "identify/fit/training.h"
#include "identify/mlp/problems.h"
#include "tests/identify/mlp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::Contains;
using ::testing::HasSubstr;

// f(x) = 30[100(x-0.6)^2(x-0.1)(x-0.8) - 5 exp(-5x) + 0.9 sin(20x + pi/4)] on 101 points of [0, 1].
struct Function1 {
  MatrixXd x = VectorXd::LinSpaced(101, 0, 1), y = MatrixXd(101, 1);
  Function1() {
    for (Index i = 0; i < 101; ++i) {
      const double v = x(i, 0);
      y(i, 0) = 30 * (100 * std::pow(v - 0.6, 2) * (v - 0.1) * (v - 0.8) - 5 * std::exp(-5 * v) +
                      0.9 * std::sin(20 * v + std::acos(-1.0) / 4));
    }
  }
};

MlpOptions options_of(int neurons, int starts) {
  MlpOptions options;
  options.hidden = {neurons};
  options.activation = Activation::sigmoid;
  options.starts = starts;
  options.spread = 3;
  return options;
}

double error_of(const MlpFit& fit, const MatrixXd& x, const MatrixXd& y) {
  return rms(evaluate_rows(*fit.model, x), y);
}

TEST(FitMlp, ReachesTheBooksErrorsOnItsFirstFunction) {
  const Function1 f;
  EXPECT_NEAR(f.y(0, 0), -44.508, 1e-3);
  EXPECT_NEAR(f.y(100, 0), 110.610, 1e-3);
  EXPECT_NEAR(error_of(fit_mlp(f.x, f.y, options_of(1, 15)), f.x, f.y), 26.889, 0.05);
  EXPECT_NEAR(error_of(fit_mlp(f.x, f.y, options_of(2, 15)), f.x, f.y), 18.398, 0.05);
  EXPECT_NEAR(error_of(fit_mlp(f.x, f.y, options_of(3, 15)), f.x, f.y), 13.676, 0.05);
  EXPECT_LT(error_of(fit_mlp(f.x, f.y, options_of(4, 20)), f.x, f.y), 1.6);
  EXPECT_LT(error_of(fit_mlp(f.x, f.y, options_of(5, 20)), f.x, f.y), 0.3);
}

// z = x cos 2x + y sin 2y - 0.75 on 21 x 21 points of [-1, 1]^2.
TEST(FitMlp, ReachesTheBooksErrorsOnItsSecondFunction) {
  MatrixXd x(441, 2), z(441, 1);
  for (Index i = 0; i < 441; ++i) {
    x.row(i) << -1 + 0.1 * static_cast<double>(i % 21), -1 + 0.1 * static_cast<double>(i / 21);
    z(i, 0) = x(i, 0) * std::cos(2 * x(i, 0)) + x(i, 1) * std::sin(2 * x(i, 1)) - 0.75;
  }
  EXPECT_NEAR(error_of(fit_mlp(x, z, options_of(1, 10)), x, z), 0.3511, 0.002);
  EXPECT_NEAR(error_of(fit_mlp(x, z, options_of(2, 10)), x, z), 0.2252, 0.002);
  EXPECT_NEAR(error_of(fit_mlp(x, z, options_of(3, 10)), x, z), 0.0329, 0.002);
}

TEST(FitMlp, OrdersTheAlgorithmsAsTheBookDoes) {
  const Function1 f;
  const auto error = [&](TrainingMethod method, double momentum, bool variable, int iterations) {
    MlpOptions options = options_of(5, 1);
    options.training.method = method;
    options.training.momentum = momentum;
    options.training.variable_rate = variable;
    options.training.iterations = iterations;
    return error_of(fit_mlp(f.x, f.y, options), f.x, f.y);
  };
  const double steepest = error(TrainingMethod::back_propagation, 0, false, 5000);
  const double variable = error(TrainingMethod::back_propagation, 0, true, 5000);
  const double momentum = error(TrainingMethod::back_propagation, 0.9, true, 5000);
  const double marquardt = error(TrainingMethod::levenberg_marquardt, 0, false, 200);
  EXPECT_LT(marquardt, 0.5 * momentum);
  EXPECT_LT(momentum, variable);
  EXPECT_LT(variable, steepest);
}

TEST(FitMlp, OfALinearNetworkIsLeastSquares) {
  Random random(8);
  MatrixXd x(200, 3), y(200, 2), one(200, 4);
  for (double& v : x.reshaped()) v = random.uniform(-1, 1);
  for (double& v : y.reshaped()) v = random.normal();
  one << x, VectorXd::Ones(200);
  const MatrixXd expected = one * (one.transpose() * one).inverse() * (one.transpose() * y);
  for (const TrainingMethod method : {TrainingMethod::levenberg_marquardt, TrainingMethod::gauss_newton}) {
    MlpOptions options;
    options.hidden = {};
    options.starts = 1;
    options.training.method = method;
    EXPECT_LT((evaluate_rows(*fit_mlp(x, y, options).model, x) - expected).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(FitMlp, IsTheSameForAnyNumberOfThreads) {
  const Function1 f;
  MlpOptions options = options_of(3, 5);
  options.training.iterations = 40;
  options.threads = 1;
  const MlpFit one = fit_mlp(f.x, f.y, options);
  options.threads = 3;
  const MlpFit three = fit_mlp(f.x, f.y, options);
  EXPECT_EQ(one.model->network().theta(), three.model->network().theta());
  EXPECT_EQ(one.report.tried, three.report.tried);
}

// A network of as many weights as data learns the noise; decay and early stopping keep it from that.
TEST(FitMlp, IsKeptFromLearningTheNoiseByDecayAndByEarlyStopping) {
  const DataSet data = first_order_data(100, 4, 51, 0.02), fresh = first_order_data(300, 6, 52);
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  const Regression rows = make_regression(data, regressors), held = make_regression(fresh, regressors);
  MlpOptions options;
  options.hidden = {10};
  options.starts = 4;
  options.training.iterations = 300;
  const double plain = error_of(fit_mlp(rows.X, rows.Y, options), held.X, held.Y);
  const double stopped = error_of(fit_mlp(rows.X, rows.Y, held.X, held.Y, options), held.X, held.Y);
  options.training.decay = 1e-3;
  const double decayed = error_of(fit_mlp(rows.X, rows.Y, options), held.X, held.Y);
  EXPECT_LT(decayed, 0.8 * plain);
  EXPECT_LT(stopped, 0.8 * plain);
}

TEST(FitMlp, LeavesFixedWeightsAlone) {
  const Function1 f;
  Network network = make_network(1, {4}, 1, Activation::tanh);
  Random random(9);
  randomise(network, 1, random);
  const StaticTraining training(network, f.x, f.y / 48);
  TrainingOptions options;
  options.fixed = std::vector<bool>(13);
  options.fixed[2] = options.fixed[7] = true;
  const VectorXd start = network.theta();
  for (const TrainingMethod method :
       {TrainingMethod::levenberg_marquardt, TrainingMethod::gauss_newton, TrainingMethod::back_propagation}) {
    options.method = method;
    options.iterations = 50;
    Watch watch({}, 50);
    const TrainingResult result = train(training, start, options, watch);
    EXPECT_EQ(result.theta[2], start[2]);
    EXPECT_EQ(result.theta[7], start[7]);
    EXPECT_LT(result.sse, training.sse(start));
  }
}

TEST(FitMlp, SaysWhatItTriedAndWarns) {
  MatrixXd x(20, 2);
  x << VectorXd::LinSpaced(20, -1, 1), VectorXd::Ones(20);
  const MatrixXd y = x.col(0).array().square().matrix();
  MlpOptions options;
  options.starts = 3;
  const FitReport report = fit_mlp(x, y, options).report;
  EXPECT_EQ(report.tried.size(), 3U);
  EXPECT_THAT(report.tried[0], HasSubstr("start 1: error "));
  EXPECT_FALSE(report.stopped.empty());
  EXPECT_THAT(report.warnings,
              Contains("There are 41 weights for 20 targets; weight decay or fewer neurons are needed."));
  EXPECT_THAT(report.warnings, Contains("Input 2 is constant, so its weights are not determined."));
}

TEST(FitMlp, WarnsOfSaturatedNeurons) {
  Network network = make_network(1, {2}, 1, Activation::tanh);
  network.layers[0].w << 1, 0, 0, 50;
  network.layers[1].w << 1, 0.1, 0;
  const DataSet data = make_data_set(MatrixXd(40, 0), VectorXd::LinSpaced(40, -1, 1), 1, {}, {{"y", ""}});
  MlpOptions options;
  options.training.iterations = 1;
  const Mlp map(network, no_scaling(1), no_scaling(1));
  const auto fit = refine_narx_mlp(data, parse_regressors("y(k-1)", data), map, options);
  EXPECT_THAT(fit.map.report.warnings, Contains("1 of 2 neurons of the first layer are saturated for all data."));
}

TEST(FinalPredictionError, WithoutDecayIsAkaikes) {
  MatrixXd r = MatrixXd::Identity(5, 5) * 7;
  r(0, 1) = r(1, 0) = 2;
  EXPECT_NEAR(final_prediction_error(r, VectorXd::Zero(5), 3, 100), (100.0 + 5) / (100 - 5) * 3 / 200, 1e-12);
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

TEST(FitMlpErrors, AreInTheUsersWords) {
  const MatrixXd x = MatrixXd::Ones(4, 1);
  MlpOptions options;
  options.starts = 0;
  EXPECT_EQ(complaint([&] { fit_mlp(x, x, options); }), "the number of starts is 0; it must be 1 or more");
  EXPECT_EQ(complaint([&] { fit_mlp(x, MatrixXd::Ones(3, 1)); }),
            "the inputs have 4 rows and the targets 3; they must agree");
  EXPECT_EQ(complaint([&] { fit_mlp(x, MatrixXd::Constant(4, 1, std::nan(""))); }),
            "the data has numbers that are not finite; leave such rows out");
  EXPECT_EQ(complaint([&] { find_training_method("adam"); }),
            "there is no training method 'adam'; there are levenberg_marquardt, gauss_newton, back_propagation");
}

// 8001 weights for 199 targets: equations of 8001 unknowns ran for minutes before anything was said.
TEST(FitMlp, RefusesFarMoreWeightsThanThereAreTargets) {
  const DataSet data = first_order_data(200, 4, 1);
  const RegressorSet set = parse_regressors("y(k-1), u(k-1)", data);
  for (const int neurons : {600, 2000, 2'000'000'000}) {
    MlpOptions options;
    options.hidden = {neurons};
    try {
      fit_narx_mlp(data, set, {}, options);
      ADD_FAILURE() << neurons;
    } catch (const IdentifyError& error) {
      EXPECT_EQ(
          error.what(),
          fmt::format("the network would have {:.0f} weights and there are 199 targets. Training takes at most 3000 "
                      "weights, and data determine no more than there are targets: one layer of 49 neurons has 197",
                      4.0 * neurons + 1));
    }
  }
}

// The limit is an instant that all threads look at, in the midst of an iteration too. A fit to the end takes minutes.
TEST(FitMlp, EndsSoonAfterItsDeadlineInEveryThread) {
  const DataSet data = first_order_data(20'000, 4, 1, 0.01);
  const RegressorSet set = parse_regressors("y(k-1..3), u(k-1..3)", data);
  MlpOptions options;
  options.hidden = {150};
  const auto start = std::chrono::steady_clock::now();
  for (const bool simulation : {false, true}) {
    options.simulation = simulation;
    FitControl control;
    control.deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
    EXPECT_THROW(fit_narx_mlp(data, set, {}, options, control), Cancelled);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

// One piece ends by an exception of its owner's progress; the others learn of it and do not go on to their own ends.
TEST(FitMlp, EndsInAllThreadsWhenProgressThrows) {
  const DataSet data = first_order_data(5000, 4, 1, 0.01);
  const RegressorSet set = parse_regressors("y(k-1..3), u(k-1..3)", data);
  MlpOptions options;
  options.hidden = {60};
  options.threads = 4;
  FitControl control;
  control.progress = [](double) { throw std::runtime_error("enough"); };
  const auto start = std::chrono::steady_clock::now();
  EXPECT_ANY_THROW(fit_narx_mlp(data, set, {}, options, control));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST(FitMlp, SaysWhatItReachedAndThatItsLimitEndedIt) {
  const DataSet data = first_order_data(300, 4, 1, 0.01);
  const RegressorSet set = parse_regressors("y(k-1), u(k-1)", data);
  MlpOptions options;
  options.hidden = {4};
  options.starts = 1;
  options.training.iterations = 3;
  options.training.decay = 1e-3;
  const FitReport report = fit_narx_mlp(data, set, {}, options).model.fit;
  EXPECT_EQ(
      report.measure,
      "mean square of the error of the normalised outputs, without the weight decay that the criterion has beside "
      "it");
  EXPECT_THAT(report.tried[0],
              HasSubstr(fmt::format("start 1: error {:.6g} (root mean square)", std::sqrt(report.reached))));
  EXPECT_THAT(report.warnings,
              ::testing::Contains("Training stopped at its limit of 3 iterations; more may improve the network."));
  EXPECT_THAT(to_text(report), HasSubstr(fmt::format("reached: {:.6g}, mean square of the error", report.reached)));
}

TEST(FitMlp, RefusesAPatienceOfNothing) {
  const DataSet data = first_order_data(100, 4, 1);
  MlpOptions options;
  options.training.patience = 0;
  EXPECT_THROW(fit_narx_mlp(data, parse_regressors("y(k-1)", data), {}, options), IdentifyError);
}

}  // namespace
}  // namespace plantloop::identify
