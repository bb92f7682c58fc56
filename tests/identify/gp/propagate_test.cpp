// Uncertain inputs against quadrature and sampling.

#include "identify/gp/propagate.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "identify/error.h"
#include "tests/identify/gp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Nodes and weights for the standard normal density (G. Golub, J. Welsch 1969).
struct Quadrature {
  explicit Quadrature(int n) {
    MatrixXd jacobi = MatrixXd::Zero(n, n);
    for (Index i = 1; i < n; ++i) jacobi(i, i - 1) = jacobi(i - 1, i) = std::sqrt(static_cast<double>(i));
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(jacobi);
    node = solver.eigenvalues();
    weight = solver.eigenvectors().row(0).array().square();
  }
  VectorXd node, weight;
};

// `slope` is cov(x, f) here: S times the mean slope.
UncertainPrediction by_quadrature(const GaussianProcess& model, const UncertainPoint& point, int nodes) {
  const Quadrature rule(nodes);
  const MatrixXd root = point.covariance.ldlt().matrixL();
  const VectorXd d = point.covariance.ldlt().vectorD().cwiseMax(0.0).cwiseSqrt();
  const auto p = point.covariance.ldlt().transpositionsP();
  MatrixXd x(nodes * nodes, 2);
  VectorXd w(nodes * nodes);
  for (Index i = 0; i < nodes; ++i) {
    for (Index j = 0; j < nodes; ++j) {
      VectorXd z(2);
      z << rule.node[i], rule.node[j];
      const VectorXd turned = p.transpose() * VectorXd(root * d.cwiseProduct(z));
      x.row(i * nodes + j) = (point.mean + turned).transpose();
      w[i * nodes + j] = rule.weight[i] * rule.weight[j];
    }
  }
  const Prediction at = model.predict(x);
  UncertainPrediction result;
  result.mean = w.dot(at.mean);
  result.variance = w.dot(at.variance) + (w.array() * (at.mean.array() - result.mean).square()).sum();
  result.slope =
      (x.rowwise() - point.mean.transpose()).transpose() * w.cwiseProduct(VectorXd(at.mean.array() - result.mean));
  return result;
}

GaussianProcess model_of(const std::string& covariance, MeanFunction mean) {
  const MatrixXd x = random_points(40, 2, 61);
  const VectorXd y = first_order_targets(x, 0.05, 62);
  const auto form = find_covariance(covariance);
  return {form, mean, {random_positive(form->count(2), 63), 0.01}, x, y};
}

UncertainPoint point_with(double s11, double s12, double s22) {
  UncertainPoint point{VectorXd(2), MatrixXd(2, 2)};
  point.mean << 0.4, -0.7;
  point.covariance << s11, s12, s12, s22;
  return point;
}

TEST(MomentMatching, AgreesWithQuadrature) {
  for (const char* covariance : {"se_ard", "linear", "se_ard + linear", "linear + se_ard + linear", "se_ard + se_ard",
                                 "se_ard*se_ard", "se_ard*linear", "se_ard*linear + se_ard*se_ard + linear",
                                 "linear*linear*se_ard", "linear*(se_ard + linear)"}) {
    for (const MeanFunction mean : {MeanFunction::zero, MeanFunction::constant, MeanFunction::linear}) {
      const GaussianProcess model = model_of(covariance, mean);
      const Propagator propagator(model, Propagation::moment_matching);
      for (const UncertainPoint& point :
           {point_with(0.2, 0.05, 0.1), point_with(0.3, 0, 0), point_with(1e-6, 0, 1e-4)}) {
        const UncertainPrediction found = propagator.predict(point), expected = by_quadrature(model, point, 60);
        EXPECT_NEAR(found.mean, expected.mean, 1e-10);
        EXPECT_NEAR(found.variance, expected.variance, 1e-10);
        EXPECT_LT((point.covariance * found.slope - expected.slope).norm(), 1e-10);
      }
    }
  }
}

// With little noise the weights of the points are large and cancel; with many points C is taken apart in part only.
TEST(MomentMatching, KeepsEightDigitsWithLittleNoise) {
  for (const Index points : {12, 90, 260}) {
    for (const char* covariance : {"se_ard", "linear", "se_ard + linear"}) {
      const MatrixXd x = random_points(points, 2, 71);
      const VectorXd y = first_order_targets(x, 0.01, 72);
      const auto form = find_covariance(covariance);
      const GaussianProcess model{
          form, MeanFunction::linear, {random_positive(form->count(2), 73), points < 100 ? 1e-4 : 1e-3}, x, y};
      const Propagator propagator(model, Propagation::moment_matching);
      for (const UncertainPoint& point :
           {point_with(0.2, 0.05, 0.1), point_with(0.05, 0, 0), point_with(1e-5, 0, 1e-4)}) {
        const UncertainPrediction found = propagator.predict(point), expected = by_quadrature(model, point, 60);
        EXPECT_NEAR(found.mean, expected.mean, 1e-9) << covariance << points;
        // A known function's variance is a difference of numbers of the size of the prior's.
        EXPECT_NEAR(found.variance, expected.variance, 1e-8 * expected.variance + 1e-12) << covariance << points;
      }
    }
  }
}

// Far away both the expectations and what they are multiplied by leave the range of numbers.
TEST(MomentMatching, FarFromAllPointsIsThePrior) {
  const GaussianProcess model = model_of("se_ard", MeanFunction::zero);
  UncertainPoint point = point_with(0.2, 0.05, 0.1);
  point.mean << 300, -400;
  const UncertainPrediction found = Propagator(model, Propagation::moment_matching).predict(point);
  EXPECT_NEAR(found.mean, 0, 1e-300);
  EXPECT_NEAR(found.variance, model.hyperparameters().theta[2], 1e-15);
}

TEST(MomentMatching, OfACertainInputIsThePrediction) {
  const GaussianProcess model = model_of("se_ard", MeanFunction::constant);
  const UncertainPoint point = point_with(0, 0, 0);
  const Prediction expected = model.predict(point.mean.transpose());
  const UncertainPrediction found = Propagator(model, Propagation::moment_matching).predict(point);
  EXPECT_NEAR(found.mean, expected.mean[0], 1e-12);
  EXPECT_NEAR(found.variance, expected.variance[0], 1e-11);
  EXPECT_LT((found.slope - model.mean_gradient(point.mean)).norm(), 1e-12);
}

TEST(FirstOrder, AgreesWithQuadratureForSmallUncertainty) {
  for (const char* covariance : {"se_ard", "matern_5_2", "neural_network"}) {
    const GaussianProcess model = model_of(covariance, MeanFunction::zero);
    const UncertainPoint point = point_with(1e-6, 3e-7, 2e-6);
    const UncertainPrediction found = Propagator(model, Propagation::first_order).predict(point);
    const UncertainPrediction expected = by_quadrature(model, point, 12);
    // What is left out is of the order of the covariance.
    EXPECT_NEAR(found.mean, expected.mean, 1e-5) << covariance;
    EXPECT_NEAR(found.variance, expected.variance, 1e-5) << covariance;
    EXPECT_LT((point.covariance * found.slope - expected.slope).norm(), 1e-10) << covariance;
  }
}

TEST(FirstOrder, IsExactForALinearFunction) {
  const GaussianProcess model = model_of("linear", MeanFunction::zero);
  const UncertainPoint point = point_with(0.2, 0.05, 0.1);
  const UncertainPrediction found = Propagator(model, Propagation::first_order).predict(point);
  const UncertainPrediction exact = Propagator(model, Propagation::moment_matching).predict(point);
  EXPECT_NEAR(found.mean, exact.mean, 1e-12);
  EXPECT_LT((found.slope - exact.slope).norm(), 1e-12);
}

TEST(Propagation, SaysWhichCovariancesHaveAClosedForm) {
  const GaussianProcess model = model_of("matern_3_2", MeanFunction::zero);
  try {
    const Propagator propagator(model, Propagation::moment_matching);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(
        error.what(),
        "moment matching has a closed form for sums and products of se_ard and linear, at most two linear in a "
        "product, not for 'matern_3_2'; first_order works with every covariance");
  }
  EXPECT_THROW(Propagator(model_of("linear*linear*linear", MeanFunction::zero), Propagation::moment_matching),
               IdentifyError);
  EXPECT_THROW(Propagator(model_of("se_ard*periodic", MeanFunction::zero), Propagation::moment_matching),
               IdentifyError);
  try {
    find_propagation("exact");
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "there is no propagation 'exact'; there are naive, first_order, moment_matching");
  }
}

}  // namespace
}  // namespace plantloop::identify
