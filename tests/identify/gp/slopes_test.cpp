// Observations of slopes: covariances against differences, predictions against a dense reference, linear models as
// prior knowledge.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "identify/error.h"
#include "identify/gp/fit_gp.h"
#include "identify/gp/gp_map.h"
#include "identify/gp/slopes.h"
#include "identify/linear/fit_linear.h"
#include "identify/model_file/model_file.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

VectorXd some(Index count, double lower, double upper, std::uint64_t seed) {
  Random random(seed);
  VectorXd v(count);
  for (double& x : v) x = random.uniform(lower, upper);
  return v;
}

template <typename F>
double difference(F f, double h) {  // order 8
  return (672 * (f(h) - f(-h)) - 168 * (f(2 * h) - f(-2 * h)) + 32 * (f(3 * h) - f(-3 * h)) -
          3 * (f(4 * h) - f(-4 * h))) /
         (840 * h);
}

const std::vector<const char*> smooth{
    "se_ard", "matern_3_2",      "matern_5_2",    "rational_quadratic",
    "linear", "se_ard + linear", "se_ard*linear", "rational_quadratic*(linear + matern_5_2)"};

TEST(Slopes, OfAllCovariancesAreTheirDerivatives) {
  for (const char* text : smooth) {
    const auto covariance = find_covariance(text);
    const VectorXd theta = some(covariance->count(3), 0.3, 1.2, 4), x = some(3, -1, 1, 5), z = some(3, -1, 1, 6);
    const auto k = [&](const VectorXd& a, const VectorXd& b) {
      return covariance->between(theta, a.transpose(), b.transpose())(0, 0);
    };
    MatrixXd block, other;
    std::vector<MatrixXd> by_theta;
    ASSERT_TRUE(covariance->slopes(theta, x, z, block, &by_theta)) << text;
    EXPECT_NEAR(block(0, 0), k(x, z), 1e-14) << text;
    for (int d = 0; d < 3; ++d) {
      const VectorXd unit = VectorXd::Unit(3, d);
      EXPECT_NEAR(block(d + 1, 0), difference([&](double h) { return k(x + h * unit, z); }, 1e-2), 1e-10) << text;
      // The row of slopes by z, of which a difference by x is the last part.
      EXPECT_NEAR(block(0, d + 1), difference([&](double h) { return k(x, z + h * unit); }, 1e-2), 1e-10) << text;
      for (int e = 0; e < 3; ++e) {
        const auto slope = [&](double h) {
          covariance->slopes(theta, x + h * unit, z, other, nullptr);
          return other(0, e + 1);
        };
        EXPECT_NEAR(block(d + 1, e + 1), difference(slope, 1e-2), 1e-10) << text;
      }
    }
    ASSERT_EQ(static_cast<Index>(by_theta.size()), theta.size());
    for (Index p = 0; p < theta.size(); ++p) {
      for (Index i = 0; i < 4; ++i) {
        for (Index j = 0; j < 4; ++j) {
          const auto at = [&](double h) {
            VectorXd moved = theta;
            moved[p] *= std::exp(h);
            covariance->slopes(moved, x, z, other, nullptr);
            return other(i, j);
          };
          EXPECT_NEAR(by_theta[static_cast<std::size_t>(p)](i, j), difference(at, 1e-2), 1e-10) << text << " " << p;
        }
      }
    }
    // At one point nothing is infinite, and the variance of a slope is not negative.
    ASSERT_TRUE(covariance->slopes(theta, x, x, block, &by_theta));
    EXPECT_TRUE(block.allFinite()) << text;
    EXPECT_GE(block.diagonal().minCoeff(), 0) << text;
    const MatrixXd own = covariance->slope_covariance(theta, x);
    if (own.size() > 0) {
      EXPECT_LT((block.bottomRightCorner(3, 3) - own).cwiseAbs().maxCoeff(), 1e-12) << text;
    }
  }
}

TEST(Slopes, OfOtherCovariancesAreRefused) {
  for (const char* text : {"neural_network", "periodic", "se_ard + periodic", "se_ard*neural_network"}) {
    try {
      with_slopes(find_covariance(text), 2);
      FAIL() << text;
    } catch (const IdentifyError& error) {
      EXPECT_EQ(error.what(),
                "slopes can be observed with se_ard, matern_3_2, matern_5_2, rational_quadratic, linear, their sums "
                "and products, not with '" +
                    find_covariance(text)->name() + "'");
    }
  }
}

// Values with the noise v0, values and slopes with noise of their own.
struct Mixed {
  MatrixXd rows{9, 4};
  VectorXd y{9};
  VectorXd theta = Eigen::Vector3d(0.8, 1.7, 1.3);
  double v0 = 0.02;
  Mixed() {
    rows << 0.1, 0.2, 0, -1,  //
        -0.4, 0.9, 1, 0.01,   //
        -0.4, 0.9, 2, 0.03,   //
        0.7, -0.3, 0, -1,     //
        -0.4, 0.9, 0, 0.005,  //
        0.5, 0.5, 0, -1,      //
        0.1, 0.2, 2, 0,       //
        -0.9, -0.6, 0, -1,    //
        0.3, -0.8, 1, 0.02;
    y << 0.3, 1.1, -0.7, 0.4, 0.9, -0.2, 0.5, -0.6, 0.2;
  }
};

// k and its derivatives written out for the squared exponential.
double reference(const Mixed& m, const VectorXd& x, int a, const VectorXd& z, int b) {
  const double w[] = {m.theta[0], m.theta[1]}, r[] = {x[0] - z[0], x[1] - z[1]};
  const double k = m.theta[2] * std::exp(-0.5 * (w[0] * r[0] * r[0] + w[1] * r[1] * r[1]));
  if (a == 0 && b == 0) return k;
  if (b == 0) return -w[a - 1] * r[a - 1] * k;
  if (a == 0) return w[b - 1] * r[b - 1] * k;
  return ((a == b ? w[a - 1] : 0) - w[a - 1] * r[a - 1] * w[b - 1] * r[b - 1]) * k;
}

TEST(Slopes, PredictionsAreThoseOfADenseReference) {
  const Mixed m;
  MatrixXd K(9, 9);
  for (Index i = 0; i < 9; ++i) {
    for (Index j = 0; j < 9; ++j)
      K(i, j) = reference(m, m.rows.row(i).head(2).transpose(), static_cast<int>(m.rows(i, 2)),
                          m.rows.row(j).head(2).transpose(), static_cast<int>(m.rows(j, 2)));
    K(i, i) += m.rows(i, 3) < 0 ? m.v0 : m.rows(i, 3);
  }
  const MatrixXd inverse = K.fullPivLu().inverse();
  const GaussianProcess gp(with_slopes(find_covariance("se_ard"), 2), MeanFunction::zero, {m.theta, m.v0}, m.rows, m.y);
  EXPECT_EQ(gp.jitter(), 0);
  EXPECT_NEAR(gp.log_likelihood(),
              -0.5 * m.y.dot(inverse * m.y) - 0.5 * std::log(K.fullPivLu().determinant()) - 4.5 * std::log(2 * M_PI),
              1e-9);
  MatrixXd points(3, 2);
  points << 0.2, 0.3, -0.4, 0.9, 1.5, -1.1;
  for (Index point = 0; point < 3; ++point) {
    const VectorXd x = points.row(point).transpose();
    VectorXd k(9);
    for (Index i = 0; i < 9; ++i)
      k[i] = reference(m, x, 0, m.rows.row(i).head(2).transpose(), static_cast<int>(m.rows(i, 2)));
    const Prediction p = gp.predict(x.transpose());
    EXPECT_NEAR(p.mean[0], k.dot(inverse * m.y), 1e-9);
    EXPECT_NEAR(p.variance[0], m.theta[2] - k.dot(inverse * k), 1e-9);
    for (int d = 0; d < 2; ++d) {
      const auto at = [&](double h) { return gp.predict((x + h * VectorXd::Unit(2, d)).transpose()); };
      EXPECT_NEAR(gp.mean_gradient(x)[d], difference([&](double h) { return at(h).mean[0]; }, 1e-2), 1e-9);
      EXPECT_NEAR(gp.variance_gradient(x)[d], difference([&](double h) { return at(h).variance[0]; }, 1e-2), 1e-9);
    }
  }
}

TEST(Slopes, TheLikelihoodHasItsGradient) {
  const Mixed m;
  for (const char* text : {"se_ard", "matern_5_2", "matern_3_2 + linear", "se_ard*linear"}) {
    const auto covariance = with_slopes(find_covariance(text), 2);
    const VectorXd theta = some(covariance->count(2), 0.4, 1.5, 7);
    const Likelihood found = log_likelihood(*covariance, MeanFunction::zero, {theta, m.v0}, m.rows, m.y);
    for (Index p = 0; p <= theta.size(); ++p) {
      const auto at = [&](double h) {
        Hyperparameters moved{theta, m.v0};
        (p < theta.size() ? moved.theta[p] : moved.v0) *= std::exp(h);
        return log_likelihood(*covariance, MeanFunction::zero, moved, m.rows, m.y, false).value;
      };
      EXPECT_NEAR(found.gradient[p], difference(at, 1e-2), 1e-8 * std::max(1.0, std::fabs(found.gradient[p])))
          << text << " " << p;
    }
  }
}

// A held-back measurement has the noise v0, a held-back observation its own, also when it is added to a model.
TEST(Slopes, HeldBackOnesAreAsNoisyAsTheySay) {
  const Mixed m;
  const auto covariance = with_slopes(find_covariance("se_ard"), 2);
  const GaussianProcess all(covariance, MeanFunction::zero, {m.theta, m.v0}, m.rows, m.y);
  const LeaveOneOut folds = cross_validate(all, 9), closed = all.leave_one_out();
  EXPECT_LT((folds.mean - closed.mean).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((folds.variance - closed.variance).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(folds.log_probability, closed.log_probability, 1e-7);
  // The second row is a slope with the variance 0.01 of its noise, v0 is 0.02.
  std::vector<Index> rest{0, 2, 3, 4, 5, 6, 7, 8};
  GaussianProcess others(covariance, MeanFunction::zero, {m.theta, m.v0}, m.rows(rest, Eigen::all), m.y(rest));
  EXPECT_NEAR(folds.variance[1], others.predict(m.rows.row(1)).variance[0] + 0.01, 1e-12);
  others.add(m.rows.row(1).transpose(), m.y[1]);
  EXPECT_NEAR(others.log_likelihood(), all.log_likelihood(), 1e-9);
}

// What is observed without noise is kept: the value and the slope.
TEST(Slopes, ThatAreExactAreThoseOfTheMean) {
  MatrixXd rows(3, 4);
  rows << 0.2, -0.1, 0, 0, 0.2, -0.1, 1, 0, 0.2, -0.1, 2, 0;
  const GaussianProcess gp(with_slopes(find_covariance("matern_5_2"), 2), MeanFunction::zero,
                           {Eigen::Vector3d(1, 2, 1.5), 0.1}, rows, Eigen::Vector3d(0.7, -1.3, 0.4));
  const VectorXd x = rows.row(0).head(2).transpose();
  EXPECT_NEAR(gp.predict(x.transpose()).mean[0], 0.7, 1e-12);
  EXPECT_NEAR(gp.predict(x.transpose()).variance[0], 0, 1e-12);
  EXPECT_NEAR(gp.mean_gradient(x)[0], -1.3, 1e-12);
  EXPECT_NEAR(gp.mean_gradient(x)[1], 0.4, 1e-12);
}

// y(k) = 0.8 y(k-1) + g(u(k-1)), g(u) = u - 0.3 u^3; slopes 0.8 and 1 - 0.9 u^2.
DataSet plant(double centre, double width, int samples, std::uint64_t seed, double noise) {
  Random random(seed);
  MatrixXd u(samples, 1), y(samples, 1);
  const auto g = [](double v) { return v - 0.3 * v * v * v; };
  double level = centre;
  for (Index k = 0; k < samples; ++k) {
    if (k % 3 == 0) level = centre + width * random.uniform(-1, 1);
    u(k, 0) = level;
    y(k, 0) = k == 0 ? 5 * g(centre) : 0.8 * y(k - 1, 0) + g(u(k - 1, 0)) + noise * random.normal();
  }
  return make_data_set(u, y, 1, {{"u", ""}}, {{"y", ""}});
}

PolynomialModel local(double centre) {
  LinearOptions options;
  options.remove_means = true;
  return fit_linear(plant(centre, 0.1, 200, 12, 0.002), {.na = 1, .nb = {1}, .nf = {}, .delay = {0}}, options);
}

TEST(LocalModels, SayTheValueAtRestAndTheSlopes) {
  const PolynomialModel arx = local(0.5);
  const RegressorSet set = parse_regressors("u(k-1), y(k-1), 1", plant(0, 1, 10, 1, 0));
  const std::vector<Observation> list = observations_of(arx, set);
  ASSERT_EQ(list.size(), 3U);
  for (const Observation& o : list) {
    EXPECT_EQ(o.x, Eigen::Vector3d(arx.u0[0], arx.y0, 1));
    EXPECT_GT(o.noise, 0);
  }
  EXPECT_EQ(list[0].slope_of, 0);
  EXPECT_EQ(list[0].value, arx.y0);
  EXPECT_EQ(list[1].slope_of, 2);
  EXPECT_NEAR(list[1].value, 0.8, 0.03);
  EXPECT_NEAR(list[1].noise, arx.covariance(0, 0), 1e-12 * arx.covariance(0, 0) + 1e-15);
  EXPECT_EQ(list[2].slope_of, 1);
  EXPECT_NEAR(list[2].value, 1 - 0.9 * 0.25, 0.03);
  const auto message = [&](const char* text) -> std::string {
    try {
      observations_of(arx, parse_regressors(text, plant(0, 1, 10, 1, 0)));
    } catch (const IdentifyError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("y(k-1), u(k-2)"), "the linear model looks back to u(k-1), which is not among the regressors");
  EXPECT_EQ(message("y(k-1), u(k-1)^2"), "a linear model tells slopes by single lags, not by 'u(k-1)^2'");
}

// A few values alone, and with two linear models besides: the free run between the operating points gets better.
TEST(LocalModels, HelpWhereThereAreFewValues) {
  const DataSet few = plant(0, 0.9, 14, 13, 0.01), fresh = plant(0, 0.9, 200, 14, 0);
  const RegressorSet set = parse_regressors("y(k-1), u(k-1)", few);
  GpOptions options;
  options.starts = 4;
  const NarxModel alone = fit_narx_gp(few, set, {.process = options});
  const NarxModel helped = fit_narx_gp(few, set, {.process = options}, {}, {local(-0.6), local(0), local(0.6)});
  const auto error = [&](const NarxModel& model) {
    return (free_run(model, fresh)[0] - fresh.experiments[0].y).norm();
  };
  EXPECT_LT(error(helped), 0.6 * error(alone)) << error(helped) << " " << error(alone);
  // The file holds everything.
  const std::string text = to_yaml(helped);
  EXPECT_THAT(text, HasSubstr("slope_of: ["));
  const NarxModel back = read_narx(read_model_file(text, "m.yaml"));
  EXPECT_EQ(to_yaml(back), text);
  EXPECT_EQ(free_run(back, fresh)[0], free_run(helped, fresh)[0]);
  const Outputs first = simulate_uncertain(helped, fresh, Propagation::first_order);
  EXPECT_TRUE(first[0].allFinite());
  try {
    simulate_uncertain(helped, fresh, Propagation::moment_matching);
    FAIL();
  } catch (const IdentifyError& e) {
    EXPECT_STREQ(e.what(),
                 "moment matching is for observed values, this model has observed slopes too; first_order works with "
                 "both");
  }
  options.mean = "linear";
  try {
    fit_narx_gp(few, set, {.process = options}, {}, {local(0)});
    FAIL();
  } catch (const IdentifyError& e) {
    EXPECT_STREQ(e.what(),
                 "observations of slopes need the mean zero; '+ linear' in the covariance stands for a linear one");
  }
}

}  // namespace
}  // namespace plantloop::identify
