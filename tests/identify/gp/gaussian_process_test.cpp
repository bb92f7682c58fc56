// Likelihood, prediction and what follows from one factor, against explicit inverses and the static example of the
// book.

#include "identify/gp/gaussian_process.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "identify/dense/dense.h"
#include "identify/error.h"
#include "identify/gp/fit_gp.h"
#include "tests/identify/gp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

GaussianProcess eight_points(double w, double v1, double v0) {
  return {find_covariance("se_ard"), MeanFunction::zero, {se(w, v1), v0}, eight_x(), eight_y()};
}

TEST(Dense, FactorsAndInvertsSmallAndLargeMatrices) {
  for (const int n : {1, 5, 127, 128, 300}) {
    const MatrixXd b = random_points(n, n, 4);
    const MatrixXd a = b * b.transpose() + n * MatrixXd::Identity(n, n);
    MatrixXd factor = a;
    ASSERT_TRUE(factorise(factor));
    const MatrixXd l = factor.triangularView<Eigen::Lower>();
    EXPECT_LT((l * l.transpose() - a).norm(), 1e-13 * a.norm()) << n;
    MatrixXd solved = b;
    solve_lower(l, solved);
    solve_lower_transposed(l, solved);
    EXPECT_LT((a * solved - b).norm(), 1e-12 * b.norm()) << n;
    invert_factored(factor);
    mirror_lower(factor);
    EXPECT_LT((factor * a - MatrixXd::Identity(n, n)).norm(), 1e-11) << n;
  }
}

TEST(Dense, RefusesWhatIsNotPositiveDefinite) {
  for (const int n : {3, 200}) {
    MatrixXd a = MatrixXd::Identity(n, n);
    a(n - 1, n - 1) = -1;
    EXPECT_FALSE(factorise(a));
    MatrixXd b = MatrixXd::Identity(n, n);
    b(n / 2, n / 2) = std::nan("");
    EXPECT_FALSE(factorise(b));
  }
}

// The likelihood by inverse and determinant in extended precision.
TEST(Likelihood, AgreesWithExplicitInversesInExtendedPrecision) {
  const MatrixXd x = random_points(40, 3, 11);
  const VectorXd y = first_order_targets(x, 0.1, 12);
  for (const CovarianceType& type : covariances()) {
    const Covariance& form = type.form();
    const Hyperparameters at{random_positive(form.count(3), 13), 0.05};
    LongMatrix k = form.between(at.theta, x, x).cast<long double>();
    k.diagonal().array() += 0.05L;
    const LongMatrix inverse = k.inverse();
    const LongMatrix t = y.cast<long double>();
    const long double expected = -0.5L * (t.transpose() * inverse * t)(0, 0) - 0.5L * std::log(k.determinant()) -
                                 20 * std::log(2 * std::acos(-1.0L));
    const Likelihood found = log_likelihood(form, MeanFunction::zero, at, x, y);
    EXPECT_NEAR(found.value, static_cast<double>(expected), 1e-10 * std::fabs(static_cast<double>(expected)))
        << type.name;
  }
}

TEST(Likelihood, HasItsGradientForEveryCovarianceAndMean) {
  const MatrixXd x = random_points(25, 2, 21);
  const VectorXd y = first_order_targets(x, 0.1, 22);
  const double h = 1e-5;
  for (const CovarianceType& type : covariances()) {
    for (const MeanFunction mean : {MeanFunction::zero, MeanFunction::constant, MeanFunction::linear}) {
      const Covariance& form = type.form();
      Hyperparameters at{random_positive(form.count(2), 23), 0.05};
      const VectorXd gradient = log_likelihood(form, mean, at, x, y).gradient;
      for (Index p = 0; p <= at.theta.size(); ++p) {
        Hyperparameters up = at, down = at;
        (p < at.theta.size() ? up.theta[p] : up.v0) *= std::exp(h);
        (p < at.theta.size() ? down.theta[p] : down.v0) *= std::exp(-h);
        const double expected =
            (log_likelihood(form, mean, up, x, y).value - log_likelihood(form, mean, down, x, y).value) / (2 * h);
        EXPECT_NEAR(gradient[p], expected, 1e-6 * std::max(1.0, std::fabs(expected))) << type.name << " " << p;
      }
    }
  }
}

// The book's printed hyperparameters on eight points.
TEST(Likelihood, OfThePrintedHyperparameters) {
  const Likelihood found =
      log_likelihood(*find_covariance("se_ard"), MeanFunction::zero, {se(4.2, 13.8), 0.0065}, eight_x(), eight_y());
  EXPECT_NEAR(found.value, -3.941736, 5e-7);
  EXPECT_NEAR(found.gradient[0], -1.82102, 5e-6);
  EXPECT_NEAR(found.gradient[1], -1.55091, 5e-6);
  EXPECT_NEAR(found.gradient[2], -0.10781, 5e-6);
  const Prediction at = eight_points(4.2, 13.8, 0.0065).predict(MatrixXd::Constant(1, 1, 1.2));
  EXPECT_NEAR(at.mean[0], 1.9192, 5e-5);
  EXPECT_NEAR(std::sqrt(at.variance[0]), 0.6787, 5e-5);
}

TEST(Gp, PredictsTheStaticExampleOfTheBook) {
  const GaussianProcess model = eight_points(4.3239, 1.58117, 0.0100724);
  VectorXd x(6), mean(6), deviation(6);
  x << 0.25, 0.5, 0.75, 1.0, 1.1, 1.2;
  mean << 0.1377, -0.3612, -0.0714, 0.8253, 1.1708, 1.4258;
  deviation << 0.0851, 0.0557, 0.0636, 0.1259, 0.2262, 0.3683;
  const Prediction found = model.predict(x);
  EXPECT_LT((found.mean - mean).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((found.variance.cwiseSqrt() - deviation).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_NEAR(model.log_likelihood(), -1.868180, 1e-6);
  const LeaveOneOut loo = model.leave_one_out();
  EXPECT_NEAR(std::sqrt((loo.mean - eight_y()).squaredNorm() / 8), 0.24054, 1e-5);
  EXPECT_NEAR(loo.log_probability, 2.44077, 1e-4);
}

TEST(Gp, LeavesOneOutAsIfItHadNeverSeenIt) {
  const GaussianProcess model = eight_points(4.3239, 1.58117, 0.0100724);
  const LeaveOneOut loo = model.leave_one_out(), folds = cross_validate(model, 8);
  EXPECT_LT((loo.mean - folds.mean).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT((loo.variance - folds.variance).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_NEAR(loo.log_probability, folds.log_probability, 1e-10);
}

TEST(Gp, TakesInOneMeasurementLikeAllAtOnce) {
  const MatrixXd x = random_points(150, 2, 31);
  const VectorXd y = first_order_targets(x, 0.05, 32);
  const Hyperparameters at{random_positive(3, 33), 0.01};
  const auto form = find_covariance("se_ard");
  GaussianProcess grown(form, MeanFunction::zero, at, x.topRows(120), y.head(120));
  for (Index i = 120; i < 150; ++i) grown.add(x.row(i), y[i]);
  const GaussianProcess whole(form, MeanFunction::zero, at, x, y);
  const MatrixXd probe = random_points(20, 2, 34);
  EXPECT_LT((grown.predict(probe).mean - whole.predict(probe).mean).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((grown.predict(probe).variance - whole.predict(probe).variance).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_NEAR(grown.log_likelihood(), whole.log_likelihood(), 1e-9);
}

TEST(Gp, HasTheSlopesOfItsMeanAndVariance) {
  const MatrixXd x = random_points(60, 2, 41);
  const VectorXd y = first_order_targets(x, 0.05, 42);
  for (const char* text : {"se_ard", "matern_5_2 + linear", "neural_network", "se_ard*periodic"}) {
    const auto form = find_covariance(text);
    const GaussianProcess model(form, MeanFunction::linear, {random_positive(form->count(2), 43), 0.01}, x, y);
    const VectorXd at = VectorXd::Constant(2, 0.2);
    for (Index d = 0; d < 2; ++d) {
      MatrixXd probe(2, 2);
      probe << at.transpose(), at.transpose();
      probe(0, d) += 1e-5, probe(1, d) -= 1e-5;
      const Prediction p = model.predict(probe);
      EXPECT_NEAR(model.mean_gradient(at)[d], (p.mean[0] - p.mean[1]) / 2e-5, 1e-6) << text;
      EXPECT_NEAR(model.variance_gradient(at)[d], (p.variance[0] - p.variance[1]) / 2e-5, 1e-6) << text;
    }
  }
}

TEST(Gp, FollowsItsMeanFunctionFarFromTheData) {
  const MatrixXd x = random_points(60, 1, 51);
  const VectorXd y = (3 + 2 * x.col(0).array() + 0.1 * (5 * x.col(0).array()).sin()).matrix();
  VectorXd theta(2);
  theta << 20, 0.02;
  const GaussianProcess model(find_covariance("se_ard"), MeanFunction::linear, {theta, 1e-4}, x, y);
  const Prediction far = model.predict(MatrixXd::Constant(1, 1, 100.0));
  EXPECT_NEAR(far.mean[0], 203, 3);
  EXPECT_NEAR(far.variance[0], 0.02, 1e-12);
}

TEST(Gp, AddsJitterWherePointsRepeatWithoutNoise) {
  MatrixXd x(4, 1);
  x << 0, 1, 1, 2;
  VectorXd y(4);
  y << 0, 1, 1, 0;
  const GaussianProcess model(find_covariance("se_ard"), MeanFunction::zero, {se(1, 1), 0}, x, y);
  EXPECT_GT(model.jitter(), 0);
  EXPECT_LE(model.jitter(), 1e-10);
  EXPECT_NEAR(model.predict(x).mean[1], 1, 1e-4);
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

TEST(GpErrors, AreInTheUsersWords) {
  const auto form = find_covariance("se_ard");
  const auto make = [&](const VectorXd& theta, double v0, const MatrixXd& x, const VectorXd& y) {
    return complaint([&] { GaussianProcess(form, MeanFunction::zero, {theta, v0}, x, y); });
  };
  EXPECT_EQ(make(se(1, 1), 0.1, MatrixXd(0, 1), VectorXd(0)), "the data has no rows");
  EXPECT_EQ(make(se(1, 1), 0.1, eight_x(), VectorXd::Zero(5)),
            "the inputs have 8 rows and the targets 5; they must agree");
  VectorXd gap = eight_y();
  gap[2] = std::nan("");
  EXPECT_EQ(make(se(1, 1), 0.1, eight_x(), gap), "the target in row 3 is nan, not a finite number");
  MatrixXd endless = eight_x();
  endless(4, 0) = INFINITY;
  EXPECT_EQ(make(se(1, 1), 0.1, endless, eight_y()), "input 1 in row 5 is inf, not a finite number");
  EXPECT_EQ(make(VectorXd::Ones(3), 0.1, eight_x(), eight_y()),
            "covariance 'se_ard' with 1 inputs has 2 hyperparameters (w1, v1), but 3 are given");
  EXPECT_EQ(make(se(1, -2), 0.1, eight_x(), eight_y()), "hyperparameter v1 is -2; it must be greater than 0");
  EXPECT_EQ(make(se(1, 1), -0.1, eight_x(), eight_y()), "the noise variance v0 is -0.1; it must be 0 or greater");
  EXPECT_EQ(complaint([] { find_mean_function("square"); }),
            "there is no mean function 'square'; there are zero, constant, linear");
}

// Two equal inputs: one of them has the slope of the mean, they do not share 1e13 and -1e13.
TEST(GaussianProcess, ALinearMeanOfEqualInputsStaysFinite) {
  MatrixXd x(60, 2);
  x.col(0) = VectorXd::LinSpaced(60, -1, 1);
  x.col(1) = x.col(0);
  const VectorXd y = 3 * x.col(0);
  VectorXd theta(3);
  theta << 1, 1, 1;
  const GaussianProcess model(find_covariance("se_ard"), MeanFunction::linear, {theta, 1e-4}, x, y);
  MatrixXd far(1, 2);
  far << 40, 40;
  EXPECT_NEAR(model.predict_mean(far)[0], 120, 1e-6);
  far << 40, 40.001;
  EXPECT_NEAR(model.predict_mean(far)[0], 120, 0.01);
}

}  // namespace
}  // namespace plantloop::identify
