// Models of the noise: NARMAX and NBJ, against the linear library and on a plant with coloured noise.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "identify/error.h"
#include "identify/linear/fit_linear.h"
#include "identify/mlp/fit_mlp.h"
#include "identify/mlp/noise_training.h"
#include "identify/model_file/model_file.h"
#include "identify/narx/noise_prediction.h"
#include "identify/validation/correlation.h"
#include "tests/identify/mlp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

DataSet two_outputs() {
  const DataSet a = first_order_data(60, 3, 61), b = first_order_data(60, 5, 62);
  MatrixXd u(60, 2), y(60, 2);
  u << a.experiments[0].u, b.experiments[0].u;
  y << a.experiments[0].y + 0.3 * b.experiments[0].y, b.experiments[0].y;
  return make_data_set(u, y, 0.5, {{"u1", ""}, {"u2", ""}}, {{"y1", ""}, {"y2", ""}});
}

// y(k) = y(k-1) - 0.5 tanh(y(k-1) + u(k-1)^3) + v(k) + 0.7 v(k-1),
DataSet coloured(int samples, std::uint64_t seed, double deviation = 0.03) {
  Random random(seed);
  MatrixXd u(samples, 1), y(samples, 1);
  double level = 0, before = 0;
  for (Index k = 0; k < samples; ++k) {
    if (k % 4 == 0) level = random.uniform(-1.2, 1.2);
    u(k, 0) = level;
    const double v = deviation * random.normal();
    y(k, 0) = (k == 0 ? 0 : y(k - 1, 0) - 0.5 * std::tanh(y(k - 1, 0) + std::pow(u(k - 1, 0), 3))) + v + 0.7 * before;
    before = v;
  }
  return make_data_set(u, y, 0.5, {{"u", ""}}, {{"y", ""}});
}

// A linear plant with the noise (C/D) v added to its output by `box_jenkins`, else C v to its equation.
DataSet linear_plant(bool box_jenkins, std::uint64_t seed = 8) {
  Random random(seed);
  const int n = 400;
  MatrixXd u(n, 1), y(n, 1);
  double level = 0, w = 0, noise = 0, before = 0;
  for (Index k = 0; k < n; ++k) {
    if (k % 3 == 0) level = random.uniform(-1, 1);
    u(k, 0) = k == 0 ? 0 : level;
    const double v = 0.1 * random.normal(), past = k == 0 ? 0 : u(k - 1, 0);
    if (box_jenkins) {
      w = 0.8 * w + 0.5 * past;
      noise = 0.7 * noise + v + 0.4 * before;
      y(k, 0) = w + noise;
    } else {
      y(k, 0) = 0.8 * (k == 0 ? 0 : y(k - 1, 0)) + 0.5 * past + v + 0.6 * before;
    }
    before = v;
  }
  return make_data_set(u, y, 1, {{"u", ""}}, {{"y", ""}});
}

// A sample of zeros first, so that the past of the first one is that of the linear library: rest.
DataSet from_rest(DataSet data) {
  for (Experiment& e : data.experiments) {
    MatrixXd u = MatrixXd::Zero(e.u.rows() + 1, e.u.cols()), y = MatrixXd::Zero(e.y.rows() + 1, e.y.cols());
    u.bottomRows(e.u.rows()) = e.u;
    y.bottomRows(e.y.rows()) = e.y;
    e.u = u;
    e.y = y;
  }
  return data;
}

// What the training follows, J'e, is -1/2 of the derivative of the sum of squares, by a difference of order 8.
TEST(NoiseTraining, HasExactGradientsThroughTime) {
  const DataSet data = join(two_outputs(), part(two_outputs(), 10, 40));
  struct Case {
    const char* text;
    NoiseOrders orders;
  };
  for (const Case& c : {Case{"y1(k-1), y2(k-1), u1(k-1), u2(k-2), e1(k-1), e2(k-2)", {0, 0, false}},
                        Case{"y1(k-1..2), u1(k-1), y2(k-1)*e1(k-1), e2(k-1)^2, u2(k-1)", {1, 0, false}},
                        Case{"y1(k-1), y2(k-1), u1(k-1), u2(k-1)", {2, 0, false}},
                        Case{"y1(k-1), y2(k-2), u1(k-1), u2(k-1)", {2, 1, true}}}) {
    const RegressorSet regressors = parse_regressors(c.text, data);
    Network network = make_network(static_cast<int>(regressors.size()), {4}, 2, Activation::tanh);
    Random random(63);
    randomise(network, 0.4, random);
    DataSet holes = data;
    holes.experiments[1].y(20, 0) = std::nan("");
    const NoiseTraining training(network, no_scaling(regressors.size()), standard_scaling(data.experiments[0].y),
                                 regressors, holes, c.orders);
    VectorXd theta(training.parameters());
    theta.setConstant(0.3);
    theta.head(network.parameters()) = network.theta();
    MatrixXd r;
    VectorXd g;
    EXPECT_NEAR(training.normal(theta, r, g), training.sse(theta), 1e-12 * training.sse(theta));
    for (Index j = 0; j < theta.size(); ++j) {
      const auto at = [&](double step) {
        VectorXd moved = theta;
        moved[j] += step;
        return training.sse(moved) - training.sse([&] {
          VectorXd back = theta;
          back[j] -= step;
          return back;
        }());
      };
      const double h = 4e-3;
      const double slope = (672 * at(h) - 168 * at(2 * h) + 32 * at(3 * h) - 3 * at(4 * h)) / (840 * h);
      // 1e-15 of the sum of squares over h is what rounding leaves.
      EXPECT_NEAR(g[j], -slope / 2, 1e-10 * std::max({1.0, g.cwiseAbs().maxCoeff(), training.sse(theta)}))
          << c.text << " " << j;
    }
  }
}

MlpOptions linear_network() {
  MlpOptions options;
  options.hidden = {};
  options.starts = 1;
  options.normalise = false;
  options.training.decrease = 1e-16;
  return options;
}

TEST(NoiseModels, NarmaxOfALinearNetworkIsArmax) {
  const DataSet data = linear_plant(false), padded = from_rest(data);
  const Orders orders{.na = 1, .nc = 1, .nb = {1}, .nf = {}, .delay = {0}};
  const PolynomialModel armax = fit_linear(data, orders);
  // The bias of a network is not part of the linear model: what is compared is the fit at equal parameters and the
  // optimum of all but the bias, which the network may only lower.
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1), e(k-1)", padded);
  const Network shape = make_network(3, {}, 1, Activation::tanh);
  const NoiseTraining training(shape, no_scaling(3), no_scaling(1), regressors, padded, {});
  VectorXd theta(4);
  theta << -armax.A[1], armax.B[0][0], armax.C[1], 0;
  EXPECT_NEAR(training.sse(theta), prediction_errors(armax, data, nullptr).squaredNorm(), 1e-10);
  TrainingOptions how;
  how.fixed = {false, false, false, true};
  how.decrease = 0;
  Watch watch({}, 1);
  const TrainingResult free = train(training, VectorXd::Zero(4), how, watch);
  EXPECT_NEAR((free.theta - theta).cwiseAbs().maxCoeff(), 0, 1e-7);
  // So is the filter C beside the map.
  const RegressorSet rest = parse_regressors("y(k-1), u(k-1)", padded);
  const NoiseTraining filtered(make_network(2, {}, 1, Activation::tanh), no_scaling(2), no_scaling(1), rest, padded,
                               {1, 0, false});
  VectorXd with_c(4);
  with_c << theta.head(2), 0, theta[2];
  how.fixed = {false, false, true, false};
  const TrainingResult filter = train(filtered, VectorXd::Zero(4), how, watch);
  EXPECT_NEAR((filter.theta - with_c).cwiseAbs().maxCoeff(), 0, 1e-7);
  // And the whole fit, from its own starts, is no worse.
  const NarxMlpFit fit = fit_narx_mlp(padded, regressors, {}, linear_network());
  EXPECT_LE(fit.map.training.sse, free.sse + 1e-9);
  EXPECT_GT(fit.map.training.sse, 0.98 * free.sse);
  EXPECT_NEAR(
      (residuals(armax, data)[0] - (data.experiments[0].y - one_step(make_narx(std::make_shared<Mlp>(
                                                                                   [&] {
                                                                                     Network n = shape;
                                                                                     n.set_theta(theta);
                                                                                     return n;
                                                                                   }(),
                                                                                   no_scaling(3), no_scaling(1)),
                                                                               regressors, padded),
                                                                     padded)[0]
                                                                .bottomRows(data.samples()))
                                       .col(0))
          .tail(data.samples() - 60)
          .cwiseAbs()
          .maxCoeff(),
      0, 1e-9);
}

TEST(NoiseModels, NbjOfALinearNetworkIsBoxJenkins) {
  const DataSet data = linear_plant(true), padded = from_rest(data);
  const Orders orders{.na = 0, .nc = 1, .nd = 1, .nb = {1}, .nf = {1}, .delay = {0}};
  const PolynomialModel bj = fit_linear(data, orders);
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", padded);
  const NoiseTraining training(make_network(2, {}, 1, Activation::tanh), no_scaling(2), no_scaling(1), regressors,
                               padded, {1, 1, true});
  VectorXd theta(5);
  theta << -bj.F[0][1], bj.B[0][0], 0, bj.C[1], bj.D[1];
  EXPECT_NEAR(training.sse(theta), prediction_errors(bj, data, nullptr).squaredNorm(), 1e-10);
  TrainingOptions how;
  how.fixed = {false, false, true, false, false};
  how.decrease = 0;
  Watch watch({}, 1);
  VectorXd start = VectorXd::Zero(5);
  start[4] = -0.5;
  const TrainingResult free = train(training, start, how, watch);
  EXPECT_NEAR((free.theta - theta).cwiseAbs().maxCoeff(), 0, 1e-7);
  MlpOptions options = linear_network();
  options.simulation = true;
  options.nc = options.nd = 1;
  const NarxMlpFit fit = fit_narx_mlp(padded, regressors, {}, options);
  EXPECT_LE(fit.map.training.sse, free.sse + 1e-9);
  EXPECT_EQ(structure_name(fit.model), "NBJ");
  EXPECT_NEAR(fit.model.noise.D[0][1], -0.7, 0.12);
  EXPECT_NEAR(fit.model.noise.C[0][1], 0.4, 0.15);
}

// The filters' coefficients scatter by what their covariance says: the mean of (theta - truth)'P^-1(theta - truth) over
// 150 records is their number, with the deviation sqrt(2 p/150). And it comes back from the file.
TEST(NoiseModels, KnowTheUncertaintyOfTheirFilters) {
  for (const bool box_jenkins : {true, false}) {
    MlpOptions options = linear_network();
    options.simulation = box_jenkins;
    options.nc = 1;
    options.nd = box_jenkins ? 1 : 0;
    const Index p = options.nc + options.nd;
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= 150; ++seed) {
      const DataSet data = from_rest(linear_plant(box_jenkins, seed));
      const NarxModel model = fit_narx_mlp(data, parse_regressors("y(k-1), u(k-1)", data), {}, options).model;
      ASSERT_EQ(model.noise.covariance.rows(), p);
      VectorXd error(p);
      error[0] = model.noise.C[0][1] - (box_jenkins ? 0.4 : 0.6);
      if (box_jenkins) error[1] = model.noise.D[0][1] + 0.7;
      sum += error.dot(model.noise.covariance.ldlt().solve(error));
      if (seed > 1) continue;
      const std::string text = to_yaml(model);
      const NarxModel back = read_narx(read_model_file(text, "noise.yaml"));
      EXPECT_EQ(back.noise.covariance, model.noise.covariance);
      EXPECT_EQ(to_yaml(back), text);
    }
    EXPECT_NEAR(sum / 150, static_cast<double>(p), 5 * std::sqrt(2 * static_cast<double>(p) / 150)) << box_jenkins;
  }
}

// The book's plant with coloured equation noise: NARX leaves the colour in its residuals, NARMAX does not.
// What the plant makes of its past without noise, and the white noise itself.
struct Truth {
  VectorXd plant, v;
};
Truth truth_of(const DataSet& data) {
  const MatrixXd &u = data.experiments[0].u, &y = data.experiments[0].y;
  Truth t{VectorXd::Zero(y.rows()), VectorXd::Zero(y.rows())};
  for (Index k = 1; k < y.rows(); ++k) {
    t.plant[k] = y(k - 1, 0) - 0.5 * std::tanh(y(k - 1, 0) + std::pow(u(k - 1, 0), 3));
    t.v[k] = y(k, 0) - t.plant[k] - 0.7 * t.v[k - 1];
  }
  return t;
}
double rms_of(const VectorXd& e) { return std::sqrt(e.squaredNorm() / static_cast<double>(e.size())); }

TEST(NoiseModels, NarmaxTakesTheColourOutOfTheResiduals) {
  const DataSet data = coloured(500, 7);
  MlpOptions options;
  options.hidden = {5};
  options.starts = 6;
  options.training.iterations = 300;
  const auto residual = [&](const NarxModel& model) {
    return VectorXd((data.experiments[0].y - one_step(model, data)[0]).col(0).tail(499));
  };
  const auto colour = [&](const NarxModel& model) {
    const Correlation c = autocorrelation({residual(model)}, 3);
    double largest = 0;
    for (Index i = 0; i < c.lag.size(); ++i) {
      if (c.lag[i] != 0) largest = std::max(largest, std::fabs(c.r[i]));
    }
    return largest;
  };
  const NarxMlpFit narx = fit_narx_mlp(data, parse_regressors("y(k-1), u(k-1)", data), {}, options);
  options.nc = 1;
  const NarxMlpFit filter = fit_narx_mlp(data, parse_regressors("y(k-1), u(k-1)", data), {}, options);
  options.nc = 0;
  const NarxMlpFit inside = fit_narx_mlp(data, parse_regressors("y(k-1), u(k-1), e(k-1)", data), {}, options);
  EXPECT_GT(colour(narx.model), 0.3);  // the book's 0.48; the band is 0.088
  const double white = rms_of(truth_of(data).v.tail(499));
  for (const NarxMlpFit* fit : {&filter, &inside}) {
    EXPECT_EQ(structure_name(fit->model), "NARMAX");
    EXPECT_LT(colour(fit->model), 0.088);
    EXPECT_NEAR(rms_of(residual(fit->model)), white, 0.05 * white);
    EXPECT_GT(rms_of(residual(narx.model)), 1.1 * rms_of(residual(fit->model)));
  }
  EXPECT_NEAR(filter.model.noise.C[0][1], 0.7, 0.1);
}

// Least squares takes the noise's past for the plant's: the map is wrong, however long the record.
TEST(NoiseModels, NarmaxTakesTheBiasOutOfTheMap) {
  const DataSet data = coloured(3000, 11, 0.2);
  MlpOptions options;
  options.hidden = {6};
  options.starts = 4;
  options.training.iterations = 200;
  const VectorXd plant = truth_of(data).plant;
  const auto bias = [&](const NarxModel& model) {
    return rms_of((one_step(noise_free(model), data)[0].col(0) - plant).tail(2999));
  };
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1)", data);
  const double narx = bias(fit_narx_mlp(data, regressors, {}, options).model);
  options.nc = 1;
  const double narmax = bias(fit_narx_mlp(data, regressors, {}, options).model);
  EXPECT_LT(narmax, 0.5 * narx) << narmax << " " << narx;
  EXPECT_GT(narx, 0.03);
}

TEST(NoiseModels, ComeBackFromTheirFilesWithTheSameBits) {
  const DataSet data = coloured(80, 9);
  MlpOptions options;
  options.hidden = {2};
  options.starts = 1;
  options.training.iterations = 8;
  options.nc = 1;
  std::vector<NarxModel> models{
      fit_narx_mlp(data, parse_regressors("y(k-1), u(k-1), e(k-1..2)", data), {}, options).model};
  options.simulation = true;
  options.nd = 2;
  models.push_back(fit_narx_mlp(data, parse_regressors("y(k-1), u(k-1)", data), {}, options).model);
  for (const NarxModel& model : models) {
    const std::string text = to_yaml(model);
    const NarxModel back = read_narx(read_model_file(text, "m.yaml"));
    EXPECT_EQ(structure_name(back), structure_name(model));
    EXPECT_EQ(to_yaml(back), text);
    for (const int steps : {1, 3}) {
      const MatrixXd a = k_step(model, data, steps)[0], b = k_step(back, data, steps)[0];
      const Index first = model.regressors.longest_lag() + steps - 1;
      EXPECT_EQ(a.bottomRows(80 - first), b.bottomRows(80 - first));
      EXPECT_TRUE(a.topRows(first).hasNaN());
    }
    EXPECT_EQ(free_run(model, data)[0], free_run(back, data)[0]);
  }
}

// Of NARMAX: errors of steps that are not measured yet are 0, so the prediction tends to the free run.
TEST(NoiseModels, PredictSeveralStepsWithoutFurtherErrors) {
  const DataSet data = coloured(40, 10);
  const RegressorSet regressors = parse_regressors("y(k-1), u(k-1), e(k-1)", data);
  Network network = make_network(3, {}, 1, Activation::tanh);
  network.layers[0].w << 0.5, 1, 0.4, 0.1;
  const NarxModel model = make_narx(std::make_shared<Mlp>(network, no_scaling(3), no_scaling(1)), regressors, data);
  const MatrixXd& y = data.experiments[0].y;
  const MatrixXd& u = data.experiments[0].u;
  const MatrixXd one = one_step(model, data)[0], three = k_step(model, data, 3)[0];
  for (Index k = 10; k < 40; ++k) {
    const double e = y(k - 3, 0) - one(k - 3, 0);
    const double first = 0.5 * y(k - 3, 0) + u(k - 3, 0) + 0.4 * e + 0.1;
    const double second = 0.5 * first + u(k - 2, 0) + 0.1;
    EXPECT_NEAR(three(k, 0), 0.5 * second + u(k - 1, 0) + 0.1, 1e-14);
  }
  // Runs without noise: the errors are 0 throughout.
  const NarxModel quiet = noise_free(model);
  EXPECT_EQ(quiet.regressors.list.size(), 2U);
  const MatrixXd run = free_run(model, data)[0];
  for (Index k = 1; k < 40; ++k) EXPECT_NEAR(run(k, 0), 0.5 * run(k - 1, 0) + u(k - 1, 0) + 0.1, 1e-14);
}

TEST(NoiseModels, AreRefusedWhereTheyMakeNoSense) {
  const DataSet data = coloured(40, 10);
  const auto message = [&](const char* text, bool simulation, int nc, int nd) -> std::string {
    MlpOptions options;
    options.simulation = simulation;
    options.nc = nc;
    options.nd = nd;
    try {
      fit_narx_mlp(data, parse_regressors(text, data), {}, options);
    } catch (const IdentifyError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("y(k-1), e(k-1)", true, 1, 0),
            "NBJ has its noise model beside the map, so no prediction errors are among its regressors");
  EXPECT_EQ(message("u(k-1)", true, 1, 0), "NBJ simulates its past outputs, but there are none among the regressors");
  EXPECT_EQ(message("y(k-1)", false, 1, 1),
            "a filter D ('nd') stands beside a simulated map only: structure NBJ; of NARMAX there is C ('nc')");
  EXPECT_EQ(message("e(k-1)", false, 0, 0), "there must be a regressor that is no prediction error");
  EXPECT_EQ(message("y(k-1)", false, -1, 0), "the orders of a noise model, 'nc' and 'nd', must be 0 or more");
  EXPECT_THAT(message("y(k-1), e(k)", false, 0, 0),
              HasSubstr("a prediction error is a regressor from k-1 on; at k it is not known"));
  try {
    make_regression(data, parse_regressors("y(k-1), e(k-1)", data));
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(),
                 "'e' stands for prediction errors; only an mlp is trained with them, as structure NARMAX");
  }
}

}  // namespace
}  // namespace plantloop::identify
