// Recursive least squares against the batch estimate.

#include "identify/linear/recursive.h"

#include <gtest/gtest.h>

#include "identify/data/excitation.h"
#include "identify/error.h"
#include "identify/linear/least_squares.h"

namespace plantloop::identify {
namespace {

TEST(RecursiveLeastSquares, WithoutForgettingIsRidgeLeastSquares) {
  Eigen::MatrixXd X(80, 3);
  for (Eigen::Index i = 0; i < 3; ++i) X.col(i) = white_noise(80, 1, 10 + static_cast<std::uint64_t>(i));
  const Eigen::VectorXd y = white_noise(80, 1, 20);
  const RecursiveResult r = recursive_least_squares(X, y);
  const LeastSquares batch = least_squares(X, y, {.ridge = 1e-4});
  EXPECT_LT((r.theta.row(79).transpose() - batch.theta).norm(), 1e-9);
  const Eigen::MatrixXd information = X.transpose() * X + 1e-4 * Eigen::MatrixXd::Identity(3, 3);
  EXPECT_LT((r.P * information - Eigen::MatrixXd::Identity(3, 3)).norm(), 1e-8);
}

TEST(RecursiveLeastSquares, WithForgettingIsWeightedLeastSquaresAndFollowsAChange) {
  const Eigen::Index rows = 400;
  const Eigen::MatrixXd X = white_noise(rows, 1, 1);
  Eigen::VectorXd y = 2 * X;
  y.tail(200) = -X.bottomRows(200);
  const double lambda = 0.95;
  const RecursiveResult r = recursive_least_squares(X, y, {.forgetting = lambda});
  EXPECT_NEAR(r.theta(199, 0), 2, 1e-6);
  EXPECT_NEAR(r.theta(399, 0), -1, 1e-3);
  // The weighted estimate of the last row, lambda^(rows - 1 - k); the start is forgotten.
  double top = 0;
  double bottom = 0;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double weight = std::pow(lambda, static_cast<double>(rows - 1 - k));
    top += weight * X(k, 0) * y[k];
    bottom += weight * X(k, 0) * X(k, 0);
  }
  EXPECT_NEAR(r.theta(399, 0), top / bottom, 1e-9);
}

TEST(RecursiveLeastSquares, SkipsWhatIsMissingAndRefusesFactorsOutOfRange) {
  RecursiveLeastSquares rls(1);
  rls.update(Eigen::VectorXd::Ones(1), 3);
  const double before = rls.theta()[0];
  EXPECT_TRUE(std::isnan(rls.update(Eigen::VectorXd::Ones(1), std::nan(""))));
  EXPECT_EQ(rls.theta()[0], before);
  EXPECT_THROW(RecursiveLeastSquares(1, {.forgetting = 1.1}), IdentifyError);
}

}  // namespace
}  // namespace plantloop::identify
