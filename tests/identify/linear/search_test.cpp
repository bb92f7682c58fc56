// The prediction error method: gradients against complex steps, estimates against known systems, predictions.

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "identify/data/excitation.h"
#include "identify/error.h"
#include "identify/linear/filter.h"
#include "identify/linear/fit_linear.h"
#include "identify/model_file/model_file.h"
#include "identify/validation/metrics.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Complex = std::complex<double>;
using Series1 = std::vector<Complex>;

// A second implementation, sample by sample and in complex numbers: (P/Q) x.
Series1 ratio(const Series1& P, const Series1& Q, const Series1& x) {
  Series1 y(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    for (std::size_t i = 0; i < P.size() && i <= k; ++i) y[k] += P[i] * x[k - i];
    for (std::size_t i = 1; i < Q.size() && i <= k; ++i) y[k] -= Q[i] * y[k - i];
  }
  return y;
}

Series1 complex_errors(const Orders& o, const Series1& theta, const DataSet& data) {
  std::size_t at = 0;
  const auto take = [&](int count, Series1 head) {
    for (int i = 0; i < count; ++i) head.push_back(theta[at++]);
    return head;
  };
  const auto column = [](const auto& v) {
    Series1 s;
    for (const double x : v) s.emplace_back(x);
    return s;
  };
  const Series1 A = take(o.na, {1});
  std::vector<Series1> B;
  for (std::size_t i = 0; i < o.nb.size(); ++i) {
    B.push_back(take(o.nb[i], Series1(static_cast<std::size_t>(o.delay[i] + 1))));
  }
  const Series1 C = take(o.nc, {1});
  const Series1 D = take(o.nd, {1});
  Series1 s = ratio(A, {1}, column(data.all_y().col(0)));
  for (std::size_t i = 0; i < B.size(); ++i) {
    const Series1 F = take(o.nf[i], {1});
    const Series1 w = ratio(B[i], F, column(data.all_u().col(static_cast<Index>(i))));
    for (std::size_t k = 0; k < s.size(); ++k) s[k] -= w[k];
  }
  return ratio(D, C, s);
}

DataSet some_data(Index samples, Index inputs, std::uint64_t seed) {
  MatrixXd u(samples, inputs);
  for (Index i = 0; i < inputs; ++i) u.col(i) = white_noise(samples, 1, seed + static_cast<std::uint64_t>(i));
  return make_data_set(u, white_noise(samples, 1, seed + 100), 1);
}

class Gradient : public ::testing::TestWithParam<Orders> {};

TEST_P(Gradient, IsThatOfAComplexStep) {
  const Orders orders = GetParam();
  const DataSet data = some_data(120, static_cast<Index>(orders.nb.size()), 5);
  PolynomialModel model = make_polynomial_model(orders, data, 0);
  const VectorXd theta = white_noise(orders.parameters(), 0.15, 9);
  model.set_parameters(theta);
  MatrixXd J;
  const VectorXd v = prediction_errors(model, data, &J);
  for (Index j = 0; j < theta.size(); ++j) {
    Series1 shifted(theta.begin(), theta.end());
    constexpr double h = 1e-30;
    shifted[static_cast<std::size_t>(j)] += Complex(0, h);
    const Series1 e = complex_errors(orders, shifted, data);
    for (Index k = 0; k < v.size(); ++k) {
      EXPECT_NEAR(e[static_cast<std::size_t>(k)].real(), v[k], 1e-13);
      EXPECT_NEAR(e[static_cast<std::size_t>(k)].imag() / h, J(k, j), 1e-14 * std::max(1.0, J.cwiseAbs().maxCoeff()));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Structures, Gradient,
    ::testing::Values(Orders{.na = 2, .nc = 2, .nb = {2}, .nf = {0}, .delay = {1}},
                      Orders{.nb = {2}, .nf = {3}, .delay = {0}},
                      Orders{.nc = 1, .nd = 2, .nb = {2}, .nf = {2}, .delay = {2}},
                      Orders{.na = 1, .nc = 1, .nd = 1, .nb = {2, 1}, .nf = {1, 2}, .delay = {-1, 1}}),
    [](const auto& about) { return fmt::format("Number{}", about.index); });

// y from the model's own parameters with noise v.
DataSet system_data(const Orders& orders, const VectorXd& theta, Index samples, double sigma, std::uint64_t seed) {
  DataSet data = some_data(samples, static_cast<Index>(orders.nb.size()), seed);
  PolynomialModel m = make_polynomial_model(orders, data, 0);
  m.set_parameters(theta);
  const PolynomialModel::Common c = m.common();
  VectorXd y = filter(m.C, multiply(m.A, m.D), white_noise(samples, sigma, seed + 7));
  for (std::size_t i = 0; i < m.B.size(); ++i) {
    y += filter(c.numerators[i], c.denominator, VectorXd(data.experiments[0].u.col(static_cast<Index>(i))));
  }
  data.experiments[0].y = y;
  return data;
}

void expect_within_three_deviations(const PolynomialModel& m, const VectorXd& truth) {
  const VectorXd theta = m.parameters();
  for (Index i = 0; i < truth.size(); ++i) {
    EXPECT_LT(std::abs(theta[i] - truth[i]), 3.5 * std::sqrt(m.covariance(i, i)))
        << m.parameter_names()[static_cast<std::size_t>(i)] << " = " << theta[i] << ", true " << truth[i];
  }
}

TEST(PredictionErrorMethod, FindsEachStructureAndItsOwnUncertainty) {
  const Orders armax{.na = 2, .nc = 1, .nb = {2}, .nf = {0}, .delay = {1}};
  const VectorXd t1 = (VectorXd(5) << -1.5, 0.7, 1, 0.5, 0.8).finished();
  const PolynomialModel m1 = fit_linear(system_data(armax, t1, 2000, 0.5, 1), armax);
  EXPECT_EQ(m1.structure, "ARMAX");
  expect_within_three_deviations(m1, t1);
  EXPECT_NEAR(m1.variance, 0.25, 0.03);

  const Orders oe{.nb = {2}, .nf = {2}, .delay = {0}};
  const VectorXd t2 = (VectorXd(4) << 1, 0.5, -1.5, 0.7).finished();
  const PolynomialModel m2 = fit_linear(system_data(oe, t2, 2000, 0.5, 2), oe);
  EXPECT_EQ(m2.structure, "OE");
  expect_within_three_deviations(m2, t2);

  const Orders bj{.nc = 1, .nd = 1, .nb = {2}, .nf = {2}, .delay = {0}};
  const VectorXd t3 = (VectorXd(6) << 1, 0.5, 0.6, -0.8, -1.5, 0.7).finished();
  const PolynomialModel m3 = fit_linear(system_data(bj, t3, 3000, 0.5, 3), bj);
  EXPECT_EQ(m3.structure, "BJ");
  expect_within_three_deviations(m3, t3);

  const Orders two{.nb = {2, 1}, .nf = {2, 1}, .delay = {0, 2}};
  const VectorXd t4 = (VectorXd(6) << 1, 0.5, 2, -1.5, 0.7, -0.9).finished();
  expect_within_three_deviations(fit_linear(system_data(two, t4, 3000, 0.3, 4), two), t4);
}

TEST(PredictionErrorMethod, ReachesTheOptimumExactlyWithoutNoise) {
  const Orders bj{.nb = {2}, .nf = {3}, .delay = {1}};
  const VectorXd truth = (VectorXd(5) << 0.3, -0.1, -2.1, 1.5, -0.36).finished();
  const PolynomialModel m = fit_linear(system_data(bj, truth, 400, 0, 11), bj);
  EXPECT_LT((m.parameters() - truth).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(PredictionErrorMethod, TheGradientVanishesAtTheEstimate) {
  const Orders bj{.nc = 1, .nd = 1, .nb = {2}, .nf = {2}, .delay = {0}};
  const VectorXd truth = (VectorXd(6) << 1, 0.5, 0.6, -0.8, -1.5, 0.7).finished();
  const DataSet data = system_data(bj, truth, 800, 0.5, 21);
  const PolynomialModel m = fit_linear(data, bj);
  MatrixXd J;
  const VectorXd v = prediction_errors(m, data, &J);
  for (Index j = 0; j < J.cols(); ++j) EXPECT_LT(std::abs(J.col(j).dot(v)), 1e-6 * J.col(j).norm() * v.norm());
  EXPECT_EQ(m.fit.tried.size(), 5U);
}

TEST(PredictionErrorMethod, InstrumentsAreUnbiasedWhereLeastSquaresIsNot) {
  const Orders oe{.nb = {2}, .nf = {2}, .delay = {0}};
  const VectorXd truth = (VectorXd(4) << 1, 0.5, -1.5, 0.7).finished();
  const DataSet data = system_data(oe, truth, 4000, 1, 31);
  const Orders arx{.na = 2, .nb = {2}, .nf = {}, .delay = {}};
  const PolynomialModel plain = fit_linear(data, arx);
  const PolynomialModel iv = fit_instrumental(data, arx);
  EXPECT_GT(std::abs(plain.A[1] + 1.5), 0.05);
  expect_within_three_deviations(iv, (VectorXd(4) << -1.5, 0.7, 1, 0.5).finished());
}

TEST(Predictions, OfOneStepPlusTheInnovationAreTheMeasurement) {
  const Orders bj{.nc = 1, .nd = 1, .nb = {2}, .nf = {2}, .delay = {0}};
  const VectorXd truth = (VectorXd(6) << 1, 0.5, 0.6, -0.8, -1.5, 0.7).finished();
  const DataSet data = system_data(bj, truth, 300, 0.5, 41);
  PolynomialModel m = make_polynomial_model(bj, data, 0);
  m.set_parameters(truth);
  EXPECT_LT((one_step(m, data)[0] + residuals(m, data)[0] - data.all_y().col(0)).norm(), 1e-12);
  // The innovations are the noise that made the data.
  EXPECT_LT((residuals(m, data)[0] - white_noise(300, 0.5, 48)).norm(), 1e-10);
  // Far ahead nothing of the noise is known: the prediction is the simulation from rest.
  EXPECT_LT((k_step(m, data, 300)[0] - simulate(m, data, Start::zero)[0]).norm(), 1e-10);
  // Errors grow with the horizon, to the variance of the noise itself.
  const VectorXd y = data.all_y().col(0);
  EXPECT_LT(squared_error(y, k_step(m, data, 1)[0]), squared_error(y, k_step(m, data, 3)[0]));
}

TEST(Predictions, OfAnArxModelOverTwoStepsAreTheRecursion) {
  const Orders arx{.na = 1, .nb = {1}, .nf = {0}, .delay = {0}};
  const DataSet data = some_data(50, 1, 51);
  PolynomialModel m = make_polynomial_model(arx, data, 0);
  m.set_parameters(Eigen::Vector2d(-0.8, 0.5));
  const VectorXd u = data.all_u().col(0);
  const VectorXd y = data.all_y().col(0);
  const VectorXd p = k_step(m, data, 2)[0];
  for (Index k = 2; k < 50; ++k) {
    const double ahead = 0.8 * y[k - 2] + 0.5 * u[k - 2];
    EXPECT_NEAR(p[k], 0.8 * ahead + 0.5 * u[k - 1], 1e-13);
  }
}

TEST(Predictions, SimulationFromMeasuredSamplesContinuesThem) {
  const Orders arx{.na = 2, .nb = {1}, .nf = {0}, .delay = {3}};
  DataSet data = some_data(30, 1, 61);
  PolynomialModel m = make_polynomial_model(arx, data, 0);
  m.set_parameters(Eigen::Vector3d(-1.2, 0.5, 0.4));
  m.u0[0] = 3;
  m.y0 = 10;
  const VectorXd s = simulate(m, data)[0];
  const VectorXd u = data.all_u().col(0);
  for (Index k = 0; k < 4; ++k) EXPECT_NEAR(s[k], data.all_y()(k, 0), 1e-14);  // through y - 10 and back
  for (Index k = 4; k < 30; ++k) {
    EXPECT_NEAR(s[k] - 10, 1.2 * (s[k - 1] - 10) - 0.5 * (s[k - 2] - 10) + 0.4 * (u[k - 4] - 3), 1e-12);
  }
}

TEST(LinearModels, ComeBackFromTheirFileWithTheSameBits) {
  const Orders two{.nc = 1, .nb = {2, 1}, .nf = {2, 1}, .delay = {0, 2}};
  const VectorXd truth = (VectorXd(7) << 1, 0.5, 2, 0.3, -1.5, 0.7, -0.9).finished();
  const DataSet data = system_data(two, truth, 500, 0.3, 71);
  const PolynomialModel m = fit_linear(data, two, {.output = "y", .remove_means = true});
  const std::string text = to_yaml("linear_model", to_item(m));
  const PolynomialModel back = polynomial_model_of(read_model_file(text, "m.yaml"));
  EXPECT_EQ(back.parameters(), m.parameters());
  EXPECT_EQ(back.covariance, m.covariance);
  EXPECT_EQ(simulate(back, data)[0], simulate(m, data)[0]);
  EXPECT_EQ(to_yaml("linear_model", to_item(back)), text);
}

std::string message(const std::function<void()>& action) {
  try {
    action();
  } catch (const IdentifyError& e) {
    return e.what();
  }
  return "no error";
}

TEST(LinearModels, SayWhatIsWrong) {
  DataSet data = some_data(40, 2, 81);
  EXPECT_EQ(message([&] {
              fit_linear(data, {.na = 1, .nb = {1, 1, 1}});
            }),
            "'nb' is one number, or one for each of 2 inputs; there are 3");
  EXPECT_EQ(message([&] { fit_linear(data, {.na = -1}); }), "'na' must lie between 0 and 10000, it is -1");
  EXPECT_EQ(message([&] { fit_linear(data, {.na = 30, .nb = {30}}); }),
            "90 parameters cannot be estimated from 40 samples");
  EXPECT_EQ(message([&] { fit_linear(data, {.na = 1}, {.output = "z"}); }),
            "the data have no output 'z'; there are: y");
  data.experiments[0].u.col(0).setZero();
  const PolynomialModel m = fit_linear(data, {.na = 1});
  ASSERT_EQ(m.fit.warnings.size(), 2U);
  EXPECT_EQ(m.fit.warnings[0], "'u1' does not vary");
  EXPECT_EQ(m.fit.warnings[1].substr(0, 43), "the data determine only 2 of 3 parameters: ");
}

TEST(LinearModels, RefuseNegativeIterationsAndRidges) {
  const VectorXd u = VectorXd::Random(50);
  const DataSet data = make_data_set(u, u, 1);
  EXPECT_THROW(fit_linear(data, {.nb = {1}, .nf = {1}}, {.iterations = -3}), IdentifyError);
  EXPECT_THROW(fit_linear(data, {.nb = {1}}, {.ridge = -1}), IdentifyError);
  EXPECT_THROW(fit_filtered(data, {.na = 1, .nb = {1}}, {}, -1), IdentifyError);
}

}  // namespace
}  // namespace plantloop::identify
