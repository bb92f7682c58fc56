// NARX models that are linear in their parameters: selection of terms, fit of the free run, predictions.

#include "identify/linear/regression_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/data/excitation.h"
#include "identify/error.h"
#include "identify/linear/least_squares.h"
#include "identify/model_file/model_file.h"
#include "identify/validation/metrics.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// y(k) = 0.6 y(k-1) - 0.2 y(k-1) u(k-1) + 0.5 u(k-2)^2 + equation noise, measured with noise.
DataSet bilinear(Index samples, double equation, double measurement, std::uint64_t seed) {
  const VectorXd u = staircase(samples, 2, 6, -1, 1, seed);
  VectorXd y = VectorXd::Zero(samples);
  const VectorXd e = white_noise(samples, 1, seed + 1);
  for (Index k = 2; k < samples; ++k) {
    y[k] = 0.6 * y[k - 1] - 0.2 * y[k - 1] * u[k - 1] + 0.5 * u[k - 2] * u[k - 2] + equation * e[k];
  }
  return make_data_set(u, y + measurement * white_noise(samples, 1, seed + 2), 1);
}

RegressorSet candidates() { return polynomial(parse_regressors("y(k-1..2), u(k-1..3)", {"u"}, {"y"}), 2); }

TEST(ForwardSelection, TakesWhatBruteForceTakes) {
  MatrixXd X(60, 8);
  for (Index i = 0; i < 8; ++i) X.col(i) = white_noise(60, 1, 30 + static_cast<std::uint64_t>(i));
  X.col(5) = X.col(0) + X.col(1);  // dependent once both are taken
  const VectorXd y = white_noise(60, 1, 50) + X.col(2) - 0.5 * X.col(6);
  const ForwardSelection s = forward_selection(X, y, 8);
  ASSERT_EQ(s.order.size(), 7U);
  std::vector<Index> taken;
  double before = y.squaredNorm();
  for (std::size_t step = 0; step < s.order.size(); ++step) {
    Index best = -1;
    double best_sse = HUGE_VAL;
    for (Index j = 0; j < 8; ++j) {
      if (std::find(taken.begin(), taken.end(), j) != taken.end()) continue;
      MatrixXd chosen(60, static_cast<Index>(taken.size()) + 1);
      for (std::size_t i = 0; i < taken.size(); ++i) chosen.col(static_cast<Index>(i)) = X.col(taken[i]);
      chosen.rightCols(1) = X.col(j);
      const LeastSquares fit = least_squares(chosen, y);
      if (fit.rank == chosen.cols() && fit.sse < best_sse) {
        best_sse = fit.sse;
        best = j;
      }
    }
    // Once 0 or 1 is taken, 5 and the other one explain the same: what counts is how much.
    EXPECT_NEAR(s.err[step], (before - best_sse) / y.squaredNorm(), 1e-12) << "step " << step << ", best " << best;
    before = best_sse;
    taken.push_back(s.order[step]);
  }
}

TEST(Selection, FindsTheTermsOfTheProcess) {
  const RegressionModel m =
      fit_selected(bilinear(600, 0.01, 0, 1), candidates(), {.most_terms = 8, .normalise = false});
  std::vector<std::string> terms;
  for (const Regressor& r : m.regressors.list) terms.push_back(to_text(r, m.regressors));
  for (const char* term : {"y(k-1)", "y(k-1)*u(k-1)", "u(k-2)^2"}) {
    EXPECT_NE(std::find(terms.begin(), terms.end(), term), terms.end()) << term;
  }
  const DataSet other = bilinear(400, 0, 0, 9);
  EXPECT_LT(root_mean_square_error(other.all_y().col(0), free_run(m, other)[0].col(0)), 0.01);
}

TEST(Selection, TheModelOfAllDataRunsFreelyWhereThatOfAPartDid) {
  // Rich candidates and noisy measurements: one-step fits of some sizes diverge.
  const RegressorSet rich = polynomial(parse_regressors("y(k-1..4), u(k..3)", {"u"}, {"y"}), 3);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const DataSet data = bilinear(300, 0, 0.15, 7 * seed);
    const RegressionModel m = fit_selected(data, rich, {.most_terms = 30, .iterations = 20});
    EXPECT_LT(root_mean_square_error(data.all_y().col(0), free_run(m, data)[0].col(0)), 0.3);
  }
}

TEST(FreeRunFit, IsBetterInFreeRunThanOneStepWhereTheMeasurementIsNoisy) {
  const RegressorSet terms = parse_regressors("y(k-1), y(k-1)*u(k-1), u(k-2)^2", {"u"}, {"y"});
  double one = 0;
  double free = 0;
  const DataSet truth = bilinear(400, 0, 0, 99);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const DataSet data = bilinear(500, 0, 0.1, 10 * seed);
    RegressionModel m = fit_regression(data, terms);
    one += root_mean_square_error(truth.all_y().col(0), free_run(m, truth)[0].col(0));
    fit_free_run(m, data, 100);
    free += root_mean_square_error(truth.all_y().col(0), free_run(m, truth)[0].col(0));
  }
  EXPECT_LT(free, 0.5 * one);
}

TEST(FreeRunFit, StandsAtAMinimumOfTheFreeRunError) {
  const RegressorSet terms = parse_regressors("y(k-1), y(k-1)*u(k-1), u(k-2)^2, y(k-2)^3", {"u"}, {"y"});
  const DataSet data = bilinear(200, 0, 0.05, 3);
  RegressionModel m = fit_regression(data, terms);
  fit_free_run(m, data, 200);
  const auto error = [&](const RegressionModel& of) { return (free_run(of, data)[0] - data.all_y()).squaredNorm(); };
  // Central differences of the whole criterion vanish in every direction.
  for (Index j = 0; j < 4; ++j) {
    RegressionModel up = m;
    RegressionModel down = m;
    up.theta(j, 0) += 1e-5;
    down.theta(j, 0) -= 1e-5;
    const double slope = (error(up) - error(down)) / 2e-5;
    const double curve = (error(up) + error(down) - 2 * error(m)) / 1e-10;
    EXPECT_GT(curve, 0);
    EXPECT_LT(std::abs(slope / curve), 1e-5) << j;
  }
}

TEST(RegressionModel, WithSeveralOutputsIsOneFitForEachAndComesBackFromItsFile) {
  MatrixXd y(100, 2);
  y << white_noise(100, 1, 1), white_noise(100, 1, 2);
  const DataSet data = make_data_set(white_noise(100, 1, 3), y, 0.5, {{"u", "V"}}, {{"a", "m"}, {"b", ""}});
  const RegressionModel m =
      fit_regression(data, parse_regressors("a(k-1), b(k-1..2), u(k)^2, 1", data), {.normalise = true});
  EXPECT_EQ(m.theta.rows(), 5);
  EXPECT_EQ(m.theta.cols(), 2);
  const RegressionModel back = regression_model_of(read_model_file(to_yaml("narx", to_item(m)), "m.yaml"));
  EXPECT_EQ(one_step(back, data)[0].bottomRows(90), one_step(m, data)[0].bottomRows(90));
  // Two steps ahead the first is the model's own.
  const MatrixXd one = one_step(m, data)[0];
  DataSet replaced = data;
  replaced.experiments[0].y.row(50) = one.row(50);
  EXPECT_LT((k_step(m, data, 2)[0].row(51) - one_step(m, replaced)[0].row(51)).norm(), 1e-13);
}

TEST(FreeRun, OfAnUnstableModelIsInfiniteFromWhereItLeaves) {
  const DataSet data = make_data_set(white_noise(2000, 1, 1), white_noise(2000, 1, 2), 1);
  RegressionModel m = fit_regression(data, parse_regressors("y(k-1), u(k-1)", data));
  m.theta << 1.1, 1;
  const MatrixXd y = free_run(m, data)[0];
  EXPECT_TRUE(std::isfinite(y(10, 0)));
  EXPECT_TRUE(std::isinf(y(1999, 0)));
  EXPECT_TRUE(std::isinf(root_mean_square_error(data.all_y().col(0), y.col(0))));
}

// The mean of equal values is not always that value, and what rounding leaves is no regressor: its parameter was 1e13.
TEST(RegressionModel, AConstantInputHasNoParameterWhenNormalised) {
  for (const double level : {0.1, 2.0, 7.3, 1.0 / 3}) {
    const VectorXd y = white_noise(100, 1, 1);
    const DataSet data = make_data_set(VectorXd::Constant(100, level), y, 1);
    const RegressionModel m = fit_regression(data, parse_regressors("y(k-1), u(k-1..2)", data), {.normalise = true});
    EXPECT_EQ(m.theta(1, 0), 0);
    EXPECT_EQ(m.theta(2, 0), 0);
    EXPECT_LT(free_run(m, data)[0].cwiseAbs().maxCoeff(), 10);
  }
}

}  // namespace
}  // namespace plantloop::identify
