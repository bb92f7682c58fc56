// The first learning rules: what they can and what they cannot learn.

#include "identify/mlp/rules.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "identify/error.h"
#include "identify/mlp/fit_mlp.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(DeltaRule, ComesCloseToLeastSquares) {
  Random random(1);
  MatrixXd x(200, 2), d(200, 1), one(200, 3);
  for (double& v : x.reshaped()) v = random.uniform(-1, 1);
  for (Index k = 0; k < 200; ++k) d(k, 0) = 0.7 * x(k, 0) - 0.2 * x(k, 1) + 0.4 + 0.01 * random.normal();
  one << x, VectorXd::Ones(200);
  const VectorXd exact = (one.transpose() * one).inverse() * (one.transpose() * d);
  const MatrixXd w = delta_rule(MatrixXd::Zero(1, 3), x, d, 0.02, 200);
  EXPECT_LT((w.transpose() - exact).cwiseAbs().maxCoeff(), 1e-3);
}

MatrixXd corners() {
  MatrixXd x(4, 2);
  x << 0, 0, 0, 1, 1, 0, 1, 1;
  return x;
}

TEST(PerceptronRule, LearnsAndAndOrButNotXor) {
  const VectorXd both = (VectorXd(4) << -1, -1, -1, 1).finished(), either = (VectorXd(4) << -1, 1, 1, 1).finished();
  const VectorXd one = (VectorXd(4) << -1, 1, 1, -1).finished();
  const MatrixXd w = MatrixXd::Constant(1, 3, 0.1);
  EXPECT_TRUE(perceptron_rule(w, corners(), both, 0.1, 100).separated);
  EXPECT_TRUE(perceptron_rule(w, corners(), either, 0.1, 100).separated);
  EXPECT_FALSE(perceptron_rule(w, corners(), one, 0.1, 1000).separated);
  MlpOptions options;
  options.hidden = {2};
  options.starts = 10;
  const MlpFit fit = fit_mlp(corners(), one, options);
  EXPECT_LT((evaluate_rows(*fit.model, corners()) - one).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(HebbRule, FindsTheFirstPrincipalDirection) {
  Random random(2);
  MatrixXd x(1000, 2);
  for (Index k = 0; k < 1000; ++k) {
    const double a = random.normal(), b = 0.3 * random.normal();
    x.row(k) << a + b, 0.5 * a - b;
  }
  x.rowwise() -= x.colwise().mean().eval();
  const VectorXd first = Eigen::SelfAdjointEigenSolver<MatrixXd>(x.transpose() * x).eigenvectors().col(1);
  const VectorXd w = hebb_rule(VectorXd::Constant(2, 0.1), x, 0.005, 10);
  EXPECT_GT(std::fabs(w.dot(first)) / w.norm(), 0.999);
  EXPECT_NEAR(w.norm(), 1, 0.01);
}

TEST(RuleErrors, AreInTheUsersWords) {
  try {
    delta_rule(MatrixXd::Zero(1, 2), corners(), VectorXd::Zero(4), 0.1, 1);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "samples of 4 x 2 with targets of 4 x 1 need 1 x 3 weights, there are 1 x 2");
  }
  try {
    hebb_rule(VectorXd::Ones(2), corners(), 0, 1);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "the step gamma is 0; it must be greater than 0");
  }
}

}  // namespace
}  // namespace plantloop::identify
