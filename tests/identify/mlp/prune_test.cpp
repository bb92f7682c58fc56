// Pruning by the optimal brain surgeon.

#include "identify/mlp/prune.h"

#include <gtest/gtest.h>

#include "identify/error.h"
#include "identify/mlp/fit_mlp.h"
#include "identify/mlp/problems.h"
#include "tests/identify/mlp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(Prune, FindsASmallerNetworkThatGeneralisesBetter) {
  const DataSet data = first_order_data(500, 4, 101, 0.02), test = first_order_data(300, 6, 102, 0.02);
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  const Regression rows = make_regression(data, regressors), held = make_regression(test, regressors);
  MlpOptions options;
  options.hidden = {8};
  options.starts = 4;
  options.training.decay = 1e-4;
  options.training.iterations = 200;
  const MlpFit fit = fit_mlp(rows.X, rows.Y, options);
  PruneOptions how;
  how.decay = 1e-4;
  const Pruned pruned = prune(*fit.model, rows.X, rows.Y, held.X, held.Y, how);
  EXPECT_EQ(pruned.steps.front().weights, 33);
  const PruneStep& best = pruned.steps[pruned.best];
  EXPECT_LT(best.weights, 33);
  EXPECT_LE(best.test_sse, pruned.steps.front().test_sse);
  for (std::size_t i = 1; i < pruned.steps.size(); ++i) EXPECT_LT(pruned.steps[i].weights, pruned.steps[i - 1].weights);
  EXPECT_EQ((pruned.model->network().theta().array() != 0).count(), best.weights);
  EXPECT_NEAR(rms(evaluate_rows(*pruned.model, held.X), held.Y),
              fit.model->y_scaling().scale[0] * std::sqrt(best.test_sse / 299), 1e-9);
}

// The update is the minimiser of the quadratic model with theta_j = 0: for a linear network that is the refit itself.
TEST(Prune, OfALinearNetworkRemovesTheWeightThatMattersLeast) {
  Random random(103);
  MatrixXd x(100, 3), y(100, 1);
  for (double& v : x.reshaped()) v = random.normal();
  for (Index k = 0; k < 100; ++k) y(k, 0) = 2 * x(k, 0) - x(k, 1) + 0.001 * x(k, 2) + 0.1 * random.normal();
  MlpOptions options;
  options.hidden = {};
  options.starts = 1;
  const MlpFit fit = fit_mlp(x, y, options);
  const Pruned pruned = prune(*fit.model, x, y, MatrixXd(0, 3), MatrixXd(0, 1));
  ASSERT_GE(pruned.steps.size(), 3U);
  // The mean is removed by normalisation, so bias and third weight go first.
  EXPECT_EQ(pruned.steps[2].theta[2], 0);
  EXPECT_EQ(pruned.steps[2].theta[3], 0);
  EXPECT_NE(pruned.steps[2].theta[0], 0);
  EXPECT_NE(pruned.steps[2].theta[1], 0);
}

TEST(Prune, LeavesNoNeuronWithoutInputOrOutput) {
  const DataSet data = first_order_data(200, 4, 104);
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  const Regression rows = make_regression(data, regressors);
  MlpOptions options;
  options.hidden = {4};
  options.starts = 2;
  options.training.iterations = 100;
  const MlpFit fit = fit_mlp(rows.X, rows.Y, options);
  const Pruned pruned = prune(*fit.model, rows.X, rows.Y, MatrixXd(0, 2), MatrixXd(0, 1));
  for (const PruneStep& step : pruned.steps) {
    Network network = fit.model->network();
    network.set_theta(step.theta);
    for (Index i = 0; i < 4; ++i) {
      const bool in = !network.layers[0].w.row(i).head(2).isZero(0), out = network.layers[1].w(0, i) != 0;
      EXPECT_EQ(in, out);
    }
  }
}

TEST(PruneErrors, AreInTheUsersWords) {
  const Mlp map(printed_network(), no_scaling(2), no_scaling(1));
  try {
    prune(map, MatrixXd::Zero(5, 3), MatrixXd::Zero(5, 1), {}, {});
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "the data is 5 x 3 and 5 x 1; the network has 2 inputs and 1 outputs");
  }
}

}  // namespace
}  // namespace plantloop::identify
