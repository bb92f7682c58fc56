// Uncertain inputs against quadrature and sampling.

#include "identify/gp/propagate.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "identify/error.h"
#include "identify/gp/gaussian_process.h"
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

// `slope` is cov(f, x) here: the mean slope times S.
UncertainPrediction by_quadrature(const std::vector<GaussianProcess>& models, const UncertainPoint& point, int nodes) {
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
  const auto m = static_cast<Index>(models.size());
  MatrixXd apart(x.rows(), m);
  UncertainPrediction result{VectorXd(m), MatrixXd::Zero(m, m), MatrixXd(m, 2)};
  for (Index o = 0; o < m; ++o) {
    for (Index i = 0; i < x.rows(); i += nodes) {
      const Prediction at = models[static_cast<std::size_t>(o)].predict(x.middleRows(i, nodes));
      apart.col(o).segment(i, nodes) = at.mean;
      result.covariance(o, o) += w.segment(i, nodes).dot(at.variance);
    }
    result.mean[o] = w.dot(apart.col(o));
    apart.col(o).array() -= result.mean[o];
  }
  result.covariance += apart.transpose() * w.asDiagonal() * apart;
  result.slope = apart.transpose() * w.asDiagonal() * MatrixXd(x.rowwise() - point.mean.transpose());
  return result;
}

std::vector<GaussianProcess> models_of(const std::string& covariance, MeanFunction mean) {
  const MatrixXd x = random_points(40, 2, 61);
  const VectorXd y = first_order_targets(x, 0.05, 62);
  const auto form = find_covariance(covariance);
  return {{form, mean, {random_positive(form->count(2), 63), 0.01}, x, y}};
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
      const std::vector<GaussianProcess> models = models_of(covariance, mean);
      const Propagator propagator(models, Propagation::moment_matching);
      for (const UncertainPoint& point :
           {point_with(0.2, 0.05, 0.1), point_with(0.3, 0, 0), point_with(1e-6, 0, 1e-4)}) {
        const UncertainPrediction found = propagator.predict(point), expected = by_quadrature(models, point, 60);
        EXPECT_NEAR(found.mean[0], expected.mean[0], 1e-10);
        EXPECT_NEAR(found.covariance(0, 0), expected.covariance(0, 0), 1e-10);
        EXPECT_LT((found.slope * point.covariance - expected.slope).norm(), 1e-10);
      }
    }
  }
}

// Of other points each, and with other covariances and means.
std::vector<GaussianProcess> three_models(double v0 = 0.01) {
  const auto model = [&](const char* covariance, MeanFunction mean, int points, std::uint64_t seed) {
    const MatrixXd x = random_points(points, 2, seed);
    const auto form = find_covariance(covariance);
    return GaussianProcess(form, mean, {random_positive(form->count(2), seed + 1), v0}, x,
                           first_order_targets(x, 0.05, seed + 2));
  };
  return {model("se_ard", MeanFunction::zero, 25, 81), model("se_ard*linear + linear", MeanFunction::linear, 31, 84),
          model("se_ard + se_ard", MeanFunction::constant, 18, 87)};
}

TEST(MomentMatching, GivesTheCovariancesOfSeveralOutputs) {
  const std::vector<GaussianProcess> models = three_models();
  const Propagator propagator(models, Propagation::moment_matching);
  for (const UncertainPoint& point :
       {point_with(0.2, 0.05, 0.1), point_with(0.3, 0, 0), point_with(0.04, 0.04, 0.04), point_with(1e-6, 0, 1e-4)}) {
    const UncertainPrediction found = propagator.predict(point), expected = by_quadrature(models, point, 60);
    const MatrixXd slopes = found.slope * point.covariance;
    for (Index a = 0; a < 3; ++a) {
      EXPECT_NEAR(found.mean[a], expected.mean[a], 1e-9 * std::fabs(expected.mean[a]));
      for (Index b = 0; b < 3; ++b) {
        // Relative to what the covariance can be.
        const double size = std::sqrt(expected.covariance(a, a) * expected.covariance(b, b));
        EXPECT_NEAR(found.covariance(a, b), expected.covariance(a, b), 1e-9 * size) << a << b;
        EXPECT_EQ(found.covariance(a, b), found.covariance(b, a));
      }
      for (Index d = 0; d < 2; ++d)
        EXPECT_NEAR(slopes(a, d), expected.slope(a, d),
                    1e-9 * std::sqrt(expected.covariance(a, a) * point.covariance(d, d)));
    }
  }
}

TEST(MomentMatching, OfOneModelTwiceIsThatOfTheModel) {
  const std::vector<GaussianProcess> one = models_of("se_ard", MeanFunction::linear), two{one[0], one[0]};
  const UncertainPoint point = point_with(0.2, 0.05, 0.1);
  const UncertainPrediction once = Propagator(one, Propagation::moment_matching).predict(point);
  const UncertainPrediction twice = Propagator(two, Propagation::moment_matching).predict(point);
  double certain = 0;  // the mean over x of the function's own variance, by sampling the mean alone
  {
    const UncertainPrediction all = by_quadrature(two, point, 60);
    certain = all.covariance(0, 0) - all.covariance(0, 1);
  }
  for (Index a = 0; a < 2; ++a) {
    EXPECT_NEAR(twice.mean[a], once.mean[0], 1e-12);
    EXPECT_NEAR(twice.covariance(a, a), once.covariance(0, 0), 1e-12);
    EXPECT_LT((twice.slope.row(a) - once.slope.row(0)).norm(), 1e-12);
  }
  EXPECT_NEAR(twice.covariance(0, 1), once.covariance(0, 0) - certain, 1e-10);
}

// Each function depends on one input only: they know of each other what the inputs do.
TEST(MomentMatching, OfIndependentInputsIsIndependent) {
  const MatrixXd x = random_points(30, 2, 91);
  const VectorXd y = first_order_targets(x, 0.05, 92);
  const auto se_ard = find_covariance("se_ard");
  const auto of_input = [&](Index d) {
    VectorXd theta = VectorXd::Constant(3, 1e-300);
    theta[d] = 1.3;
    theta[2] = 0.8;
    return GaussianProcess(se_ard, MeanFunction::zero, {theta, 0.02}, x, y);
  };
  const std::vector<GaussianProcess> models{of_input(0), of_input(1)};
  const Propagator propagator(models, Propagation::moment_matching);
  const UncertainPrediction apart = propagator.predict(point_with(0.2, 0, 0.1));
  const UncertainPrediction together = propagator.predict(point_with(0.2, 0.1, 0.1));
  EXPECT_NEAR(apart.covariance(0, 1), 0, 1e-13);
  EXPECT_GT(std::fabs(together.covariance(0, 1)), 1e-3);
  EXPECT_NEAR(together.covariance(0, 0), apart.covariance(0, 0), 1e-12);
  EXPECT_NEAR(together.covariance(1, 1), apart.covariance(1, 1), 1e-12);
}

// More points than are taken apart exactly.
TEST(MomentMatching, OfManyPointsLeavesNothingOut) {
  std::vector<GaussianProcess> models;
  for (const std::uint64_t seed : {101, 104}) {
    const MatrixXd x = random_points(170, 2, seed);
    const auto form = find_covariance("se_ard + linear");
    VectorXd theta = random_positive(form->count(2), seed + 1);
    theta.head(2) *= 6;  // short lengths: C is far from low rank
    models.emplace_back(form, MeanFunction::zero, Hyperparameters{theta, 0.01}, x,
                        first_order_targets(x, 0.05, seed + 2));
  }
  const UncertainPoint point = point_with(0.3, 0.05, 0.2);
  const UncertainPrediction found = Propagator(models, Propagation::moment_matching).predict(point);
  const UncertainPrediction expected = by_quadrature(models, point, 120);
  EXPECT_LT((found.covariance - expected.covariance).cwiseAbs().maxCoeff(), 1e-9);
}

// With little noise the weights of the points are large and cancel; with many points C is taken apart in part only.
TEST(MomentMatching, KeepsEightDigitsWithLittleNoise) {
  for (const Index points : {12, 90, 260}) {
    for (const char* covariance : {"se_ard", "linear", "se_ard + linear"}) {
      const MatrixXd x = random_points(points, 2, 71);
      const VectorXd y = first_order_targets(x, 0.01, 72);
      const auto form = find_covariance(covariance);
      const std::vector<GaussianProcess> models{
          {form, MeanFunction::linear, {random_positive(form->count(2), 73), points < 100 ? 1e-4 : 1e-3}, x, y}};
      const Propagator propagator(models, Propagation::moment_matching);
      for (const UncertainPoint& point :
           {point_with(0.2, 0.05, 0.1), point_with(0.05, 0, 0), point_with(1e-5, 0, 1e-4)}) {
        const UncertainPrediction found = propagator.predict(point), expected = by_quadrature(models, point, 60);
        EXPECT_NEAR(found.mean[0], expected.mean[0], 1e-9) << covariance << points;
        // A known function's variance is a difference of numbers of the size of the prior's.
        EXPECT_NEAR(found.covariance(0, 0), expected.covariance(0, 0), 1e-8 * expected.covariance(0, 0) + 1e-12)
            << covariance << points;
      }
    }
  }
}

// Of data without noise a fit takes long lengths and a great variance, and the weights of the points cancel to the last
// digit: C must be known far below its own rounding.
TEST(MomentMatching, KeepsItsDigitsWithoutNoise) {
  const MatrixXd x = random_points(40, 2, 111);
  const VectorXd y = x.col(0).array().sin() + 0.3 * x.col(1).array();
  const VectorXd of_se_ard = (VectorXd(3) << 0.11, 8e-5, 874).finished();
  const VectorXd of_product = (VectorXd(9) << 2e-6, 2e-5, 3.3, 1660, 1e-5, 1.6e-3, 0.35, 5e-4, 0.004).finished();
  std::vector<GaussianProcess> models;
  models.emplace_back(find_covariance("se_ard"), MeanFunction::zero, Hyperparameters{of_se_ard, 6e-8}, x, y);
  models.emplace_back(find_covariance("se_ard*linear + se_ard"), MeanFunction::constant,
                      Hyperparameters{of_product, 6e-8}, x, y);
  const Propagator propagator(models, Propagation::moment_matching);
  for (const UncertainPoint& point : {point_with(0.2, 0.05, 0.1), point_with(0.01, 0.002, 0.005)}) {
    // The means of the second one agree to seven digits only.
    const UncertainPrediction found = propagator.predict(point), expected = by_quadrature(models, point, 40);
    for (Index a = 0; a < 2; ++a) {
      EXPECT_NEAR(found.mean[a], expected.mean[a], 1e-7);
      for (Index b = 0; b < 2; ++b)
        EXPECT_NEAR(found.covariance(a, b), expected.covariance(a, b),
                    (a + b == 0 ? 1e-8 : 3e-7) * std::fabs(expected.covariance(a, b)));
    }
  }
}

// Far away both the expectations and what they are multiplied by leave the range of numbers.
TEST(MomentMatching, FarFromAllPointsIsThePrior) {
  const std::vector<GaussianProcess> models = models_of("se_ard", MeanFunction::zero);
  UncertainPoint point = point_with(0.2, 0.05, 0.1);
  point.mean << 300, -400;
  const UncertainPrediction found = Propagator(models, Propagation::moment_matching).predict(point);
  EXPECT_NEAR(found.mean[0], 0, 1e-300);
  EXPECT_NEAR(found.covariance(0, 0), models[0].hyperparameters().theta[2], 1e-15);
}

TEST(MomentMatching, OfACertainInputIsThePrediction) {
  const std::vector<GaussianProcess> models = models_of("se_ard", MeanFunction::constant);
  const UncertainPoint point = point_with(0, 0, 0);
  const Prediction expected = models[0].predict(point.mean.transpose());
  const UncertainPrediction found = Propagator(models, Propagation::moment_matching).predict(point);
  EXPECT_NEAR(found.mean[0], expected.mean[0], 1e-12);
  EXPECT_NEAR(found.covariance(0, 0), expected.variance[0], 1e-11);
  EXPECT_LT((found.slope.row(0).transpose() - models[0].mean_gradient(point.mean)).norm(), 1e-12);
}

TEST(FirstOrder, AgreesWithQuadratureForSmallUncertainty) {
  for (const char* covariance : {"se_ard", "matern_5_2", "neural_network"}) {
    const std::vector<GaussianProcess> models = models_of(covariance, MeanFunction::zero);
    const UncertainPoint point = point_with(1e-6, 3e-7, 2e-6);
    const UncertainPrediction found = Propagator(models, Propagation::first_order).predict(point);
    const UncertainPrediction expected = by_quadrature(models, point, 12);
    // What is left out is of the order of the covariance.
    EXPECT_NEAR(found.mean[0], expected.mean[0], 1e-5) << covariance;
    EXPECT_NEAR(found.covariance(0, 0), expected.covariance(0, 0), 1e-5) << covariance;
    EXPECT_LT((found.slope * point.covariance - expected.slope).norm(), 1e-10) << covariance;
  }
}

// Of every form, also where a point of the data is, at which some have a kink.
TEST(FirstOrder, HasTheSlopesOfEveryCovariance) {
  std::vector<std::string> texts{"matern_3_2*linear + periodic", "neural_network*se_ard"};
  for (const CovarianceType& type : covariances()) texts.emplace_back(type.name);
  for (const std::string& text : texts) {
    const std::vector<GaussianProcess> models = models_of(text, MeanFunction::linear);
    const Propagator propagator(models, Propagation::first_order);
    for (const bool on_data : {false, true}) {
      UncertainPoint point = point_with(0.2, 0.05, 0.1);
      if (on_data) point.mean = models[0].x().row(3).transpose();
      const UncertainPrediction found = propagator.predict(point);
      const Prediction at = models[0].predict(point.mean.transpose());
      VectorXd slope(2);
      for (Index d = 0; d < 2; ++d) {
        const auto mean = [&](double step) {
          VectorXd x = point.mean;
          x[d] += step;
          return models[0].predict_mean(x.transpose())[0];
        };
        // Of a function with one derivative the error is of the order of the step.
        const double h = on_data ? 1e-6 : 1e-4;
        slope[d] = on_data ? (mean(h) - mean(-h)) / (2 * h)
                           : (8 * (mean(h) - mean(-h)) - (mean(2 * h) - mean(-2 * h))) / (12 * h);
        EXPECT_NEAR(found.slope(0, d), slope[d], on_data ? 1e-4 : 1e-8) << text;
      }
      EXPECT_EQ(found.mean[0], at.mean[0]);
      EXPECT_NEAR(found.covariance(0, 0), at.variance[0] + slope.dot(point.covariance * slope), on_data ? 1e-4 : 1e-8)
          << text;
    }
  }
}

TEST(FirstOrder, OfSeveralOutputsIsExactForSmallUncertainty) {
  const std::vector<GaussianProcess> models = three_models();
  const UncertainPoint point = point_with(1e-8, 3e-9, 2e-8);
  const UncertainPrediction found = Propagator(models, Propagation::first_order).predict(point);
  const UncertainPrediction exact = Propagator(models, Propagation::moment_matching).predict(point);
  EXPECT_LT((found.slope - exact.slope).norm(), 1e-6);
  for (Index a = 0; a < 3; ++a) {
    EXPECT_NEAR(found.mean[a], exact.mean[a], 1e-6);
    for (Index b = 0; b < a; ++b)
      EXPECT_NEAR(found.covariance(a, b), exact.covariance(a, b), 1e-5 * std::fabs(exact.covariance(a, b)));
  }
}

TEST(Naive, KnowsNothingOfOtherOutputs) {
  const std::vector<GaussianProcess> models = three_models();
  const UncertainPoint point = point_with(0.2, 0.05, 0.1);
  const UncertainPrediction found = Propagator(models, Propagation::naive).predict(point);
  for (Index a = 0; a < 3; ++a) {
    EXPECT_EQ(found.covariance(a, a), models[static_cast<std::size_t>(a)].predict(point.mean.transpose()).variance[0]);
    EXPECT_EQ(found.covariance(a, (a + 1) % 3), 0);
  }
}

TEST(FirstOrder, IsExactForALinearFunction) {
  const std::vector<GaussianProcess> models = models_of("linear", MeanFunction::zero);
  const UncertainPoint point = point_with(0.2, 0.05, 0.1);
  const UncertainPrediction found = Propagator(models, Propagation::first_order).predict(point);
  const UncertainPrediction exact = Propagator(models, Propagation::moment_matching).predict(point);
  EXPECT_NEAR(found.mean[0], exact.mean[0], 1e-12);
  EXPECT_LT((found.slope - exact.slope).norm(), 1e-12);
}

TEST(UncertainPoint, SaysWhatIsWrongWithIt) {
  const auto complaint = [](const VectorXd& mean, const MatrixXd& covariance) -> std::string {
    try {
      check_point({mean, covariance}, 2);
      return "";
    } catch (const IdentifyError& error) {
      return error.what();
    }
  };
  const VectorXd mean = VectorXd::Zero(2);
  const MatrixXd unit = MatrixXd::Identity(2, 2);
  EXPECT_EQ(complaint(mean, unit), "");
  EXPECT_EQ(complaint(mean, MatrixXd::Zero(2, 2)), "");
  EXPECT_EQ(complaint(VectorXd::Zero(3), unit), "the point has 3 inputs, the model 2");
  EXPECT_EQ(complaint(mean, MatrixXd::Identity(3, 3)),
            "the covariance of the point is 3 x 3; the model has 2 inputs, so it is 2 x 2");
  EXPECT_EQ(complaint(mean, unit / 0.0), "the point has numbers that are not finite");
  EXPECT_EQ(complaint(mean, (MatrixXd(2, 2) << 1, 0.5, 0.25, 1).finished()),
            "the covariance of the point is not symmetric: its element 2, 1 is 0.25, 1, 2 is 0.5");
  EXPECT_EQ(complaint(mean, (MatrixXd(2, 2) << 1, 1.5, 1.5, 1).finished()),
            "the covariance of the point has the eigenvalue -0.5; no variance is below 0");
}

TEST(Propagation, SaysWhichCovariancesHaveAClosedForm) {
  const std::vector<GaussianProcess> models = models_of("matern_3_2", MeanFunction::zero);
  try {
    const Propagator propagator(models, Propagation::moment_matching);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(
        error.what(),
        "moment matching has a closed form for sums and products of se_ard and linear, at most two linear in a "
        "product, not for 'matern_3_2'; first_order works with every covariance");
  }
  EXPECT_THROW(Propagator(models_of("linear*linear*linear", MeanFunction::zero), Propagation::moment_matching),
               IdentifyError);
  EXPECT_THROW(Propagator(models_of("se_ard*periodic", MeanFunction::zero), Propagation::moment_matching),
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
