// Facts about every estimator: what data that cannot be used, or are hard to use, do to it.
//
// An estimator either raises IdentifyError, in words for people, or gives a model whose free run is a number wherever
// the inputs are. Of data that determine nothing it warns or raises; the size of numbers does not matter to it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "identify/error.h"
#include "identify/gp/gp_map.h"
#include "identify/linear/fit_linear.h"
#include "identify/linear/order.h"
#include "identify/linear/recursive.h"
#include "identify/linear/regression_model.h"
#include "identify/linear/state_space.h"
#include "identify/local_models/local_model_network.h"
#include "identify/mlp/fit_mlp.h"
#include "identify/mlp/prune.h"
#include "identify/model_file/model_file.h"
#include "identify/neural_state_space/fit_neural_state_space.h"
#include "identify/random.h"
#include "identify/rbf/rbf_network.h"
#include "identify/validation/folds.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Fitted {
  FitReport report;
  Outputs run;  // free, over the data of the fit
  std::string file;
};

struct Estimator {
  const char* name;
  std::function<Fitted(const DataSet&)> fit;
};

Fitted linear(const DataSet& data, const PolynomialModel& m) {
  Fitted result{m.fit, {}, to_yaml("linear_model", to_item(m))};
  for (const VectorXd& y : simulate(m, data)) result.run.emplace_back(y);
  return result;
}
Estimator polynomial(const char* name, const Orders& orders) {
  return {name, [orders](const DataSet& d) { return linear(d, fit_linear(d, orders)); }};
}

RegressorSet two_lags(const DataSet& data) {
  return parse_regressors(data.inputs.size() == 2 ? "y(k-1..2), u1(k-1), u2(k-1)" : "y(k-1..2), u(k-1..2)", data);
}
Fitted learned(const DataSet& data, const NarxModel& m) { return {m.fit, free_run(m, data), to_yaml(m)}; }
Fitted regression(const DataSet& data, const RegressionModel& m) {
  return {m.fit, free_run(m, data), to_yaml("regression_model", to_item(m))};
}
// An estimator of static maps, on the rows of two lags.
template <typename Fit>
Estimator of_rows(const char* name, Fit fit) {
  return {name, [fit](const DataSet& data) {
            const RegressorSet set = two_lags(data);
            const Regression rows = make_regression(data, set);
            auto found = fit(rows.X, rows.Y);
            if (rows.left_out > 0) found.report.warnings.emplace_back("rows were left out");
            return learned(data, make_narx(found.model, set, data, found.report));
          }};
}

const std::vector<Estimator>& estimators() {
  MlpOptions mlp;
  mlp.hidden = {3};
  mlp.starts = 2;
  mlp.training.iterations = 15;
  MlpOptions through_time = mlp;
  through_time.simulation = through_time.direct = true;
  MlpOptions narmax = mlp, nbj = through_time;
  narmax.nc = nbj.nc = nbj.nd = 1;
  GpOptions gp;
  gp.starts = 1;
  gp.max_iterations = 15;
  GpOptions restarts = gp;
  restarts.starts = 3;
  restarts.max_iterations = 5;
  const auto sparse = [restarts](const DataSet& d, SparseMethod method) {
    GpModelOptions options{.process = restarts};
    options.process.max_iterations = 15;
    options.sparse = SparseOptions{.method = method, .inducing = 12};
    return learned(d, fit_narx_gp(d, two_lags(d), options));
  };
  const auto rbf = [](RbfCentres centres) {
    return [centres](const MatrixXd& X, const MatrixXd& Y) {
      RbfOptions options;
      options.functions = 8;
      options.width = 0.7;
      options.centres = centres;
      return fit_rbf(X, Y, options);
    };
  };
  static const std::vector<Estimator> all{
      polynomial("fir", {.nb = {4}}),
      polynomial("arx", {.na = 2, .nb = {2}}),
      polynomial("armax", {.na = 2, .nc = 1, .nb = {2}}),
      polynomial("oe", {.nb = {2}, .nf = {2}}),
      polynomial("bj", {.nc = 1, .nd = 1, .nb = {2}, .nf = {2}}),
      {"filtered", [](const DataSet& d) { return linear(d, fit_filtered(d, {.na = 2, .nb = {2}})); }},
      {"instrumental", [](const DataSet& d) { return linear(d, fit_instrumental(d, {.na = 2, .nb = {2}})); }},
      {"state_space",
       [](const DataSet& d) {
         const StateSpaceModel m = fit_subspace(d, {.order = 2});
         return Fitted{m.fit, simulate(m, d), to_yaml("state_space_model", to_item(m))};
       }},
      {"regression",
       [](const DataSet& d) { return regression(d, fit_regression(d, two_lags(d), {.normalise = true})); }},
      {"polynomial",
       [](const DataSet& d) {
         return regression(d, fit_selected(d, polynomial(two_lags(d), 2), {.most_terms = 6, .iterations = 10}));
       }},
      {"mlp", [mlp](const DataSet& d) { return learned(d, fit_narx_mlp(d, two_lags(d), {}, mlp).model); }},
      {"mlp_through_time",
       [through_time](const DataSet& d) { return learned(d, fit_narx_mlp(d, two_lags(d), {}, through_time).model); }},
      {"mlp_pruned",
       [mlp](const DataSet& d) {
         const NarxMlpFit whole = fit_narx_mlp(d, two_lags(d), {}, mlp);
         const Regression rows = make_regression(d, two_lags(d));
         const Pruned pruned = prune(*whole.map.model, rows.X, rows.Y, {}, {}, {.iterations = 5, .least = 6});
         FitReport report = pruned.report;
         if (rows.left_out > 0) report.warnings.emplace_back("rows were left out");
         return learned(d, make_narx(pruned.model, two_lags(d), d, report));
       }},
      {"narmax", [narmax](const DataSet& d) { return learned(d, fit_narx_mlp(d, two_lags(d), {}, narmax).model); }},
      {"nbj", [nbj](const DataSet& d) { return learned(d, fit_narx_mlp(d, two_lags(d), {}, nbj).model); }},
      {"neural_state_space",
       [](const DataSet& d) {
         const NeuralStateSpace m = fit_neural_state_space(
             d, {.order = 2, .hidden = {3}, .output_hidden = {2}, .iterations = 15, .starts = 3, .refined = 1});
         return Fitted{m.fit, simulate(m, d), to_yaml("neural_state_space", to_item(m))};
       }},
      of_rows("rbf_ols", rbf(RbfCentres::ols)),
      of_rows("rbf_box", rbf(RbfCentres::box)),
      of_rows("rbf_spread", rbf(RbfCentres::spread)),
      of_rows("local_grid", [](const MatrixXd& X, const MatrixXd& Y) { return fit_local_grid(X, Y, 2); }),
      of_rows("lolimot", [](const MatrixXd& X, const MatrixXd& Y) { return fit_lolimot(X, Y, 4); }),
      {"gaussian_process", [gp](const DataSet& d) { return learned(d, fit_narx_gp(d, two_lags(d), gp)); }},
      {"gaussian_process_of_three_starts",
       [restarts](const DataSet& d) { return learned(d, fit_narx_gp(d, two_lags(d), restarts)); }},
      {"gaussian_process_of_a_subset",
       [gp](const DataSet& d) { return learned(d, fit_narx_gp(d, two_lags(d), {.process = gp, .most = 40})); }},
      {"gaussian_process_at_given_hyperparameters",
       [gp](const DataSet& d) {
         GpModelOptions at{.process = gp};
         at.process.covariance = "linear";
         at.process.max_iterations = 0;
         at.given = {{VectorXd::Ones(two_lags(d).size() + 1), 0.01}};
         return learned(d, fit_narx_gp(d, two_lags(d), at));
       }},
      {"gaussian_process_fitc", [sparse](const DataSet& d) { return sparse(d, SparseMethod::fitc); }},
      {"gaussian_process_vfe", [sparse](const DataSet& d) { return sparse(d, SparseMethod::vfe); }},
  };
  return all;
}

// A lag with a bend and little noise.
DataSet good_data(Index samples = 160, double noise = 0.01) {
  Random random(3);
  MatrixXd u(samples, 1), y = MatrixXd::Zero(samples, 1);
  for (Index k = 0; k < samples; ++k) {
    u(k, 0) = k % 4 == 0 ? random.uniform(-1, 1) : u(k - 1, 0);
    if (k > 0) y(k, 0) = 0.7 * y(k - 1, 0) + 0.3 * std::tanh(2 * u(k - 1, 0));
  }
  for (double& each : y.reshaped()) each += noise * random.normal();
  return make_data_set(u, y, 0.1, {{"u", ""}}, {{"y", ""}});
}

class EveryEstimator : public ::testing::TestWithParam<Estimator> {
 protected:
  // What was raised; empty when there is a model, which then is in `fitted`.
  std::string complaint(const DataSet& data) {
    try {
      fitted = GetParam().fit(data);
      return "";
    } catch (const IdentifyError& error) {
      const std::string text = error.what();
      // In words: no sentence without letters, no names of C++, no exclamation.
      EXPECT_GT(text.size(), 20U) << text;
      EXPECT_EQ(text.find("::"), std::string::npos) << text;
      EXPECT_EQ(text.find('!'), std::string::npos) << text;
      EXPECT_EQ(text.find("nan"), std::string::npos) << text;
      return text;
    }
  }
  // Every output is a number, or infinite where a free run diverges.
  void expect_numbers(const DataSet& data, const char* what) const {
    for (std::size_t i = 0; i < fitted.run.size(); ++i) {
      ASSERT_EQ(fitted.run[i].rows(), data.experiments[i].samples()) << what;
      EXPECT_FALSE(fitted.run[i].hasNaN()) << what;
    }
  }
  double relative_error(const DataSet& data) const {
    const VectorXd y = data.experiments[0].y.col(0), run = fitted.run[0].col(0);
    const double scale = y.cwiseAbs().maxCoeff();
    return std::sqrt(((y - run) / scale).squaredNorm() / static_cast<double>(y.size()));
  }
  Fitted fitted;
};

TEST_P(EveryEstimator, FollowsGoodData) {
  const DataSet data = good_data();
  ASSERT_EQ(complaint(data), "");
  EXPECT_LT(relative_error(data), 0.3);
  EXPECT_FALSE(fitted.report.method.empty());
  EXPECT_FALSE(fitted.report.stopped.empty());
  EXPECT_GT(fitted.report.samples, 0);
  EXPECT_FALSE(fitted.report.tried.empty());
  EXPECT_GT(fitted.report.parameters, 0);
  EXPECT_TRUE(std::isfinite(fitted.report.reached));
  EXPECT_EQ(fitted.report.data, hash(data));
}

TEST_P(EveryEstimator, GivesTheSameBitsTwice) {
  const DataSet data = good_data();
  ASSERT_EQ(complaint(data), "");
  const Outputs once = fitted.run;
  ASSERT_EQ(complaint(data), "");
  EXPECT_EQ(fitted.run, once);
}

// The model file is the same on one thread and on more, of the whole record and of a training part of blocked folds.
TEST_P(EveryEstimator, GivesTheSameFileOnAnyNumberOfThreads) {
  const char* const before = std::getenv("LP_NUM_THREADS");
  const std::string kept = before != nullptr ? before : "";
  for (const DataSet& data : {good_data(), data_folds(good_data(), 3)[1].first}) {
    std::string first;
    for (const char* const threads : {"1", "2", "3"}) {
      setenv("LP_NUM_THREADS", threads, 1);
      ASSERT_EQ(complaint(data), "");
      if (first.empty()) first = fitted.file;
      EXPECT_EQ(fitted.file, first) << threads;
    }
    EXPECT_GT(first.size(), 100U);
  }
  if (before != nullptr) {
    setenv("LP_NUM_THREADS", kept.c_str(), 1);
  } else {
    unsetenv("LP_NUM_THREADS");
  }
}

TEST_P(EveryEstimator, WarnsOfAnInputThatDoesNotVary) {
  DataSet data = good_data();
  data.experiments[0].u.setConstant(2);
  if (!complaint(data).empty()) return;
  expect_numbers(data, "constant input");
  EXPECT_FALSE(fitted.report.warnings.empty());
}

TEST_P(EveryEstimator, SaysSoOrStaysWhereTheOutputDoesNotVary) {
  DataSet data = good_data();
  data.experiments[0].y.setConstant(5);
  if (!complaint(data).empty()) return;
  expect_numbers(data, "constant output");
  if (fitted.report.warnings.empty()) {
    EXPECT_NEAR(fitted.run[0](data.samples() - 1, 0), 5, 0.5);
  }
}

TEST_P(EveryEstimator, SurvivesZeros) {
  DataSet data = good_data();
  data.experiments[0].u.setZero();
  data.experiments[0].y.setZero();
  if (!complaint(data).empty()) return;
  expect_numbers(data, "zeros");
  EXPECT_FALSE(fitted.report.warnings.empty());
}

TEST_P(EveryEstimator, WarnsOfTwoInputsThatAreTheSame) {
  DataSet data = good_data();
  data.inputs = {{"u1", ""}, {"u2", ""}};
  data.experiments[0].u = data.experiments[0].u.replicate(1, 2).eval();
  if (!complaint(data).empty()) return;
  expect_numbers(data, "equal inputs");
  EXPECT_THAT(fitted.report.warnings,
              ::testing::Contains("'u1' and 'u2' carry the same signal: their effects cannot be "
                                  "told apart"));
}

TEST_P(EveryEstimator, TakesRowsThatRepeat) {
  DataSet data = good_data(8, 0);
  data.experiments[0].u = data.experiments[0].u.replicate(20, 1).eval();
  data.experiments[0].y = data.experiments[0].y.replicate(20, 1).eval();
  if (!complaint(data).empty()) return;
  expect_numbers(data, "repeated rows");
}

TEST_P(EveryEstimator, DoesNotMindTheSizeOfNumbers) {
  const DataSet data = good_data();
  ASSERT_EQ(complaint(data), "");
  const double plain = relative_error(data);
  for (const double scale : {1e-12, 1e-6, 1e6, 1e12}) {
    DataSet scaled = data;
    scaled.experiments[0].u *= scale;
    scaled.experiments[0].y *= scale;
    ASSERT_EQ(complaint(scaled), "") << scale;
    EXPECT_LT(relative_error(scaled), 1.5 * plain + 1e-3) << scale;
  }
  for (const double scale : {1e-160, 1e160}) {
    DataSet scaled = data;
    scaled.experiments[0].u *= scale;
    scaled.experiments[0].y *= scale;
    EXPECT_THAT(complaint(scaled), ::testing::HasSubstr("whose squares cannot be computed; take another unit"));
  }
}

TEST_P(EveryEstimator, RefusesInfiniteNumbers) {
  DataSet data = good_data();
  data.experiments[0].y(80, 0) = HUGE_VAL;
  EXPECT_NE(complaint(data), "");
}

TEST_P(EveryEstimator, LeavesMissingValuesOutOrRefusesThem) {
  DataSet data = good_data();
  data.experiments[0].y(80, 0) = std::nan("");
  const std::string text = complaint(data);
  if (!text.empty()) {
    EXPECT_THAT(text, ::testing::AnyOf(::testing::HasSubstr("missing"), ::testing::HasSubstr("not finite")));
    return;
  }
  expect_numbers(data, "a missing output");
  EXPECT_FALSE(fitted.report.warnings.empty());
}

TEST_P(EveryEstimator, RefusesInfiniteInputs) {
  DataSet data = good_data();
  data.experiments[0].u(80, 0) = -HUGE_VAL;
  EXPECT_NE(complaint(data), "");
}

TEST_P(EveryEstimator, LeavesMissingInputsOutOrRefusesThem) {
  DataSet data = good_data();
  data.experiments[0].u(80, 0) = std::nan("");
  const std::string text = complaint(data);
  if (!text.empty()) {
    EXPECT_THAT(text, ::testing::AnyOf(::testing::HasSubstr("missing"), ::testing::HasSubstr("not finite")));
    return;
  }
  EXPECT_FALSE(fitted.report.warnings.empty());
}

TEST_P(EveryEstimator, RefusesRecordsWithoutAnyValue) {
  DataSet data = good_data();
  data.experiments[0].y.setConstant(std::nan(""));
  EXPECT_NE(complaint(data), "");
}

// From one sample to fewer rows than most models have parameters.
TEST_P(EveryEstimator, RefusesAFewSamplesOrGivesNumbers) {
  for (Index samples = 1; samples <= 9; ++samples) {
    const DataSet data = part(good_data(), 0, samples);
    if (!complaint(data).empty()) continue;
    expect_numbers(data, "few samples");
    EXPECT_TRUE(std::isfinite(fitted.report.reached)) << samples;
  }
}

TEST_P(EveryEstimator, RefusesRecordsThatAreTooShort) {
  EXPECT_NE(complaint(part(good_data(), 0, 2)), "");
  if (complaint(part(good_data(), 0, 6)).empty()) expect_numbers(part(good_data(), 0, 6), "six samples");
}

INSTANTIATE_TEST_SUITE_P(All, EveryEstimator, ::testing::ValuesIn(estimators()),
                         [](const auto& text) { return std::string(text.param.name); });

}  // namespace
}  // namespace plantloop::identify
