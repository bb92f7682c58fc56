// Least squares against closed forms, and what it does with data that do not determine the parameters.

#include "identify/linear/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "identify/error.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  Random random(seed);
  MatrixXd m(rows, columns);
  for (double& v : m.reshaped()) v = random.normal();
  return m;
}

TEST(LeastSquares, AgreesWithTheNormalEquationsAndTheirCovariance) {
  const MatrixXd X = random_matrix(60, 4, 1);
  const VectorXd y = random_matrix(60, 1, 2);
  const LeastSquares fit = least_squares(X, y);
  const MatrixXd inverse = (X.transpose() * X).inverse();
  const VectorXd theta = inverse * X.transpose() * y;
  EXPECT_LT((fit.theta - theta).norm(), 1e-13);
  const double s2 = (y - X * theta).squaredNorm() / 56;
  EXPECT_NEAR(fit.s2, s2, 1e-13);
  EXPECT_LT((fit.covariance - s2 * inverse).norm(), 1e-13);
  EXPECT_TRUE(fit.warnings.empty());
}

TEST(LeastSquares, OfAStraightLineHasTheTextbookDeviations) {
  MatrixXd X(5, 2);
  VectorXd y(5);
  y << 1, 3, 2, 5, 4;
  for (int i = 0; i < 5; ++i) X.row(i) << 1, i - 2.0;
  const LeastSquares fit = least_squares(X, y);
  EXPECT_NEAR(fit.theta[0], 3, 1e-14);
  EXPECT_NEAR(fit.theta[1], 0.8, 1e-14);  // sum t y / sum t^2 = 8/10
  EXPECT_NEAR(fit.s2, 3.6 / 3, 1e-14);    // 10 - 0.8^2 10 over 3
  EXPECT_NEAR(fit.deviations()[1], std::sqrt(1.2 / 10), 1e-14);
  EXPECT_NEAR(fit.deviations()[0], std::sqrt(1.2 / 5), 1e-14);
}

TEST(LeastSquares, RidgeIsAddedToTheNormalEquations) {
  const MatrixXd X = 1e3 * random_matrix(30, 3, 3);
  const VectorXd y = random_matrix(30, 1, 4);
  const VectorXd theta = (X.transpose() * X + 5 * MatrixXd::Identity(3, 3)).inverse() * X.transpose() * y;
  EXPECT_LT((least_squares(X, y, {.ridge = 5}).theta - theta).norm(), 1e-12 * theta.norm());
}

TEST(LeastSquares, DoesNotDependOnTheUnitsOfColumns) {
  const MatrixXd X = random_matrix(50, 3, 5);
  const VectorXd y = random_matrix(50, 1, 6);
  MatrixXd scaled = X;
  scaled.col(0) *= 1e150;
  scaled.col(2) *= 1e-150;
  const LeastSquares fit = least_squares(scaled, y);
  const LeastSquares plain = least_squares(X, y);
  EXPECT_EQ(fit.rank, 3);
  EXPECT_NEAR(fit.theta[0] * 1e150, plain.theta[0], 1e-13);
  EXPECT_NEAR(fit.theta[2] * 1e-150, plain.theta[2], 1e-13);
}

TEST(LeastSquares, DependentAndConstantColumnsGiveAWarningAndZeros) {
  MatrixXd X = random_matrix(20, 4, 7);
  X.col(2) = X.col(0) - 2 * X.col(1);
  X.col(3).setZero();
  const VectorXd y = random_matrix(20, 1, 8);
  const LeastSquares fit = least_squares(X, y);
  EXPECT_EQ(fit.rank, 2);
  EXPECT_TRUE(fit.theta.allFinite());
  EXPECT_NEAR(fit.sse, least_squares(X.leftCols(2), y).sse, 1e-12);
  EXPECT_TRUE(std::isinf(fit.covariance(3, 3)));
  ASSERT_EQ(fit.warnings.size(), 1U);
  EXPECT_EQ(
      fit.warnings[0],
      "the data determine only 2 of 4 parameters: 2 are set to 0. The input does not excite the process enough, or "
      "a regressor is a combination of others");
}

// The pivots beyond the rank are rounding; dividing by them gave 4e13 and -4e13.
TEST(LeastSquares, EqualAndProportionalColumnsGiveOneOfThemTheWholeWeight) {
  for (int seed = 1; seed <= 20; ++seed) {
    const VectorXd a = random_matrix(100, 1, seed);
    for (const double factor : {1.0, 1e6, 1e-9, 1.0 / 3}) {
      MatrixXd X(100, 3);
      X << a, factor * a, 7.3 * a;
      const LeastSquares fit = least_squares(X, a.array() + 0.1);
      EXPECT_EQ(fit.rank, 1);
      EXPECT_EQ((fit.theta.array() != 0).count(), 1);
      const LeastSquares alone = least_squares(a, a.array() + 0.1);
      EXPECT_NEAR((X * fit.theta - a * alone.theta).norm(), 0, 1e-12);
      EXPECT_EQ(fit.condition, 1);
      // What is not determined has no finite variance, what is has the variance it has alone.
      EXPECT_EQ(fit.covariance.diagonal().array().isInf().count(), 2);
    }
  }
}

TEST(LeastSquares, ConstantColumnsShareNothing) {
  const VectorXd a = random_matrix(100, 1, 1), e = 0.1 * random_matrix(100, 1, 2);
  for (const double level : {2.0, 0.1, 7.3, 1e6, 1.0 / 3}) {
    MatrixXd X(100, 3);
    X.col(0) = a;
    X.rightCols(2).setConstant(level);
    const LeastSquares fit = least_squares(X, a + e + VectorXd::Constant(100, 3));
    EXPECT_EQ(fit.rank, 2);
    EXPECT_EQ((fit.theta.array() == 0).count(), 1);
    EXPECT_NEAR(fit.theta[0], 1, 0.1);
    EXPECT_NEAR((fit.theta[1] + fit.theta[2]) * level, 3, 0.1);
  }
}

TEST(LeastSquares, TheConditionIsThatOfTheSingularValues) {
  MatrixXd X = random_matrix(40, 5, 11);
  X.col(3) = X.col(0) + 1e-3 * X.col(3);
  const MatrixXd scaled = X * X.colwise().norm().cwiseInverse().asDiagonal();
  const VectorXd squares = Eigen::SelfAdjointEigenSolver<MatrixXd>(scaled.transpose() * scaled).eigenvalues();
  const LeastSquares fit = least_squares(X, random_matrix(40, 1, 12));
  EXPECT_NEAR(fit.condition, std::sqrt(squares[4] / squares[0]), 1e-6 * fit.condition);
}

TEST(LeastSquares, WithFewerRowsThanParametersFitsExactlyAndSaysSo) {
  const LeastSquares fit = least_squares(random_matrix(3, 5, 9), random_matrix(3, 1, 10));
  EXPECT_LT(fit.sse, 1e-24);
  EXPECT_TRUE(std::isnan(fit.s2));
  EXPECT_EQ(fit.warnings.size(), 1U);
}

TEST(LeastSquares, RefusesWhatIsNoNumber) {
  VectorXd y = VectorXd::Zero(3);
  y[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(least_squares(MatrixXd::Ones(3, 1), y), IdentifyError);
  EXPECT_THROW(least_squares(MatrixXd::Ones(3, 1), VectorXd::Zero(4)), IdentifyError);
}

}  // namespace
}  // namespace plantloop::identify
