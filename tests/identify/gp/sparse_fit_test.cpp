// Training of sparse processes, what their models do, and what is said of data and options that do not go.

#include "identify/gp/fit_sparse.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "identify/error.h"
#include "identify/gp/gp_map.h"
#include "identify/gp/inducing.h"
#include "identify/gp/propagate.h"
#include "identify/linear/fit_linear.h"
#include "identify/model_file/model_file.h"
#include "tests/identify/gp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Data {
  MatrixXd x = random_points(400, 2, 11);
  VectorXd y = first_order_targets(x, 0.05, 12);
};

GpOptions quick(int iterations = 60) {
  GpOptions options;
  options.starts = 2;
  options.max_iterations = iterations;
  return options;
}

double error_of(const GpPosterior& model) {
  const MatrixXd probe = random_points(300, 2, 13);
  return std::sqrt((model.predict_mean(probe) - first_order_targets(probe, 0, 0)).squaredNorm() / 300);
}

TEST(SparseFit, FindsTheFunctionAndItsNoise) {
  const Data data;
  for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
    SparseOptions sparse;
    sparse.method = method;
    sparse.inducing = 30;
    const SparseFit fit = fit_sparse(data.x, data.y, quick(), sparse);
    EXPECT_LT(error_of(fit.model), 0.03) << name_of(method);  // the noise is 0.05
    // What fitc calls noise is v0 and what the inducing inputs leave open, so v0 alone is too small there.
    const double deviation = std::sqrt(fit.model.hyperparameters().v0);
    EXPECT_LT(deviation, 0.06) << name_of(method);
    EXPECT_GT(deviation, method == SparseMethod::vfe ? 0.045 : 0.02) << name_of(method);
    EXPECT_EQ(fit.report.reached, fit.model.log_likelihood());
    EXPECT_EQ(fit.report.samples, 400);
    EXPECT_EQ(fit.report.parameters, 4 + 60);
    EXPECT_THAT(fit.report.tried, Contains(StartsWith("exact process of 400 rows, start 1: log likelihood ")));
    EXPECT_THAT(fit.report.tried,
                Contains(StartsWith(method == SparseMethod::fitc ? "FITC likelihood from optimum 1: "
                                                                 : "variational bound from optimum 1: ")));
    EXPECT_THAT(fit.report.stopped, ::testing::Not(::testing::IsEmpty()));
  }
}

TEST(SparseFit, TrainsTheInducingInputsOrHoldsThem) {
  const Data data;
  SparseOptions sparse;
  sparse.method = SparseMethod::vfe;
  sparse.inducing = 8;
  const SparseFit free = fit_sparse(data.x, data.y, quick(), sparse);
  sparse.hold = true;
  const SparseFit held = fit_sparse(data.x, data.y, quick(), sparse);
  EXPECT_EQ(held.model.inducing(), clustered_inputs(data.x, 8, 1));
  EXPECT_GT((free.model.inducing() - held.model.inducing()).norm(), 0.1);
  EXPECT_GT(free.report.reached, held.report.reached + 1);
  EXPECT_EQ(held.report.parameters, 4);
  EXPECT_THAT(held.report.options, Contains("inducing inputs 8, held"));
  // Given ones are where it begins.
  sparse.inputs = data.x.topRows(5);
  EXPECT_EQ(fit_sparse(data.x, data.y, quick(), sparse).model.inducing(), data.x.topRows(5));
}

TEST(SparseFit, GivesTheSameBitsForAnyNumberOfThreads) {
  const Data data;
  SparseOptions sparse;
  sparse.inducing = 10;
  GpOptions options = quick(20);
  options.threads = 1;
  const SparseFit one = fit_sparse(data.x, data.y, options, sparse);
  options.threads = 3;
  const SparseFit three = fit_sparse(data.x, data.y, options, sparse);
  EXPECT_EQ(one.model.inducing(), three.model.inducing());
  EXPECT_EQ(one.report.tried, three.report.tried);
}

// M. Titsias 2009: a further inducing input never makes the bound worse.
TEST(Sparse, MoreInducingInputsNeverMakeTheBoundWorse) {
  const Data data;
  const auto form = find_covariance("se_ard");
  const Hyperparameters at{random_positive(3, 14), 0.0025};
  const MatrixXd u = data.x(spread_subset(data.x, 40), Eigen::all);
  double before = -HUGE_VAL;
  for (Index m = 4; m <= 40; m += 4) {
    const double bound =
        sparse_likelihood(SparseMethod::vfe, *form, MeanFunction::zero, at, data.x, data.y, u.topRows(m), false).value;
    EXPECT_GT(bound, before) << m;
    before = bound;
  }
}

// Two inducing inputs at one place, and one at a distance of rounding: a jitter, the same function.
TEST(Sparse, InducingInputsAtOnePlaceAreOne) {
  const Data data;
  const auto form = find_covariance("se_ard");
  const Hyperparameters at{random_positive(3, 14), 0.0025};
  const MatrixXd u = data.x(spread_subset(data.x, 12), Eigen::all);
  MatrixXd more(14, 2);
  more << u, u.row(3), u.row(5).array() + 1e-9;
  for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
    const SparseGaussianProcess once(method, form, MeanFunction::zero, at, data.x, data.y, u);
    const SparseGaussianProcess twice(method, form, MeanFunction::zero, at, data.x, data.y, more);
    EXPECT_EQ(once.jitter(), 0);
    EXPECT_GT(twice.jitter(), 0);
    EXPECT_LT(twice.jitter(), 1e-9);
    EXPECT_NEAR(once.log_likelihood(), twice.log_likelihood(), 1e-5 * std::fabs(once.log_likelihood()));
    const MatrixXd probe = random_points(20, 2, 15);
    // The jitter of 1e-12 over the smallest eigenvalue of K_uu.
    EXPECT_LT((once.predict(probe).mean - twice.predict(probe).mean).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_LT((once.predict(probe).variance - twice.predict(probe).variance).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_TRUE(twice.likelihood().gradient.allFinite());
  }
}

TEST(Sparse, TakesInMoreMeasurementsAsFromAllOfThem) {
  const Data data;
  const auto form = find_covariance("matern_5_2 + linear");
  const Hyperparameters at{random_positive(form->count(2), 16), 0.01};
  const MatrixXd u = data.x(spread_subset(data.x, 15), Eigen::all), probe = random_points(20, 2, 17);
  for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
    const SparseGaussianProcess all(method, form, MeanFunction::zero, at, data.x, data.y, u);
    const SparseGaussianProcess first(method, form, MeanFunction::zero, at, data.x.topRows(370), data.y.head(370), u);
    const SparseGaussianProcess more = first.with(data.x.bottomRows(30), data.y.tail(30));
    EXPECT_EQ(more.log_likelihood(), all.log_likelihood());
    // What a model file holds is enough.
    Item item;
    first.write(item);
    const auto map = std::make_shared<const GpMap>(GpMap::Processes{std::make_shared<SparseGaussianProcess>(first)},
                                                   no_scaling(2), no_scaling(1));
    Item content;
    map->write(content);
    const Item file = read_model_file(to_yaml("gaussian_process", content), "sparse.yaml");
    const auto read = std::dynamic_pointer_cast<const GpMap>(read_approximator(file));
    const auto late = with_measurements(*read, data.x.bottomRows(30), data.y.tail(30));
    EXPECT_NEAR(late->log_likelihood(0), all.log_likelihood(), 1e-8 * std::fabs(all.log_likelihood()));
    EXPECT_EQ(late->process(0).samples(), 400);
    const Prediction a = late->process(0).predict(probe), b = all.predict(probe);
    EXPECT_LT((a.mean - b.mean).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((a.variance - b.variance).cwiseAbs().maxCoeff(), 1e-9);
  }
}

// Mean and variance of the mixture over one uncertain input, by the trapezoidal rule, which is exact to rounding there.
TEST(Sparse, MomentMatchingIsThatOfTheMixture) {
  const MatrixXd x = random_points(80, 1, 21), u = random_points(9, 1, 22);
  VectorXd y = (2 * x.col(0).array()).sin() + 0.3 * x.col(0).array();
  for (const char* text : {"se_ard", "se_ard + linear", "se_ard*linear"}) {
    const auto form = find_covariance(text);
    for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
      const Hyperparameters at{random_positive(form->count(1), 23), 0.01};
      const SparseGaussianProcess gp(method, form, MeanFunction::linear, at, x, y, u);
      const std::vector<std::shared_ptr<const GpPosterior>> models{std::make_shared<SparseGaussianProcess>(gp)};
      const Propagator propagator(models, Propagation::moment_matching);
      for (const double deviation : {0.5, 0.1, 1e-3}) {
        const double mu = 0.3;
        const UncertainPrediction found =
            propagator.predict({VectorXd::Constant(1, mu), MatrixXd::Constant(1, 1, deviation * deviation)});
        double mean = 0, square = 0, variance = 0, weights = 0;
        for (int i = -160; i <= 160; ++i) {
          const double z = i / 16.0, weight = std::exp(-0.5 * z * z);
          const Prediction p = gp.predict(MatrixXd::Constant(1, 1, mu + deviation * z));
          const double m = p.mean[0] - gp.predict_mean(MatrixXd::Constant(1, 1, mu))[0];
          weights += weight;
          mean += weight * m;
          square += weight * m * m;
          variance += weight * p.variance[0];
        }
        mean /= weights;
        const double expected = variance / weights + square / weights - mean * mean;
        EXPECT_NEAR(found.mean[0], gp.predict_mean(MatrixXd::Constant(1, 1, mu))[0] + mean, 1e-9) << text;
        EXPECT_NEAR(found.covariance(0, 0), expected, 1e-8 * std::max(1e-3, expected)) << text << " " << deviation;
        const auto slope = [&](double h) { return gp.predict_mean(MatrixXd::Constant(1, 1, mu + h))[0]; };
        if (deviation < 0.01) {
          EXPECT_NEAR(found.slope(0, 0), (slope(1e-4) - slope(-1e-4)) / 2e-4, 1e-4) << text;
        }
      }
    }
  }
}

NarxModel fitted(SparseMethod method, const std::string& mean = "zero", int outputs = 1) {
  const MatrixXd u = random_points(250, 1, 31);
  Random random(32);
  MatrixXd y = MatrixXd::Zero(250, outputs);
  for (Index k = 1; k < 250; ++k) {
    for (Index o = 0; o < outputs; ++o)
      y(k, o) = y(k - 1, o) - 0.5 * std::tanh(y(k - 1, o) + std::pow(u(k - 1, 0), 3)) + 0.02 * random.normal();
  }
  std::vector<Channel> names;
  for (int o = 0; o < outputs; ++o) names.push_back({outputs == 1 ? "y" : "y" + std::to_string(o + 1), ""});
  const DataSet data = make_data_set(u, y, 0.5, {{"u", ""}}, names);
  GpModelOptions options{.process = quick(25)};
  options.process.starts = 1;
  options.process.mean = mean;
  options.sparse = SparseOptions{.method = method, .inducing = 20, .refined = 1};
  return fit_narx_gp(data, parse_regressors(outputs == 1 ? "y(k-1), u(k-1)" : "y1(k-1), y2(k-1), u(k-1)", data),
                     options);
}

TEST(SparseModel, ComesBackFromItsFileWithTheSameBits) {
  for (const auto& [method, mean, outputs] :
       {std::tuple{SparseMethod::fitc, "zero", 1}, {SparseMethod::vfe, "linear", 2}}) {
    const NarxModel model = fitted(method, mean, outputs);
    const std::string text = to_yaml(model);
    const NarxModel back = read_narx(read_model_file(text, "sparse.yaml"));
    EXPECT_EQ(to_yaml(back), text);
    EXPECT_THAT(text, HasSubstr("approximation: " + name_of(method)));
    const auto& map = dynamic_cast<const GpMap&>(*model.map);
    const auto& read = dynamic_cast<const GpMap&>(*back.map);
    const MatrixXd probe = random_points(30, map.inputs(), 33);
    EXPECT_EQ(evaluate_rows(read, probe), evaluate_rows(map, probe));
    for (Index o = 0; o < outputs; ++o) {
      EXPECT_EQ(read.process(o).predict(probe).variance, map.process(o).predict(probe).variance);
      EXPECT_EQ(read.log_likelihood(o), map.log_likelihood(o));
    }
    try {
      read.likelihood(0);
      FAIL();
    } catch (const IdentifyError& error) {
      EXPECT_STREQ(
          error.what(),
          "the gradient of a sparse process needs its data, which a model file does not hold; ask the model as "
          "it was fitted");
    }
    EXPECT_THROW(read.leave_one_out(0), IdentifyError);
  }
}

TEST(SparseModel, HasTheDerivativesOfMeanAndVariance) {
  for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
    const NarxModel model = fitted(method, "linear", 2);
    const Approximator& map = *model.map;
    const VectorXd at = Eigen::Vector3d(0.3, -0.2, -0.6);
    VectorXd slope(6), spread(6);
    map.derivative(at.data(), slope.data(), nullptr);
    map.variance_derivative(at.data(), spread.data(), nullptr);
    for (Index d = 0; d < 3; ++d) {
      const auto moved = [&](double step, bool variance) {
        VectorXd x = at, result(2);
        x[d] += step;
        variance ? map.variance(x.data(), result.data(), nullptr) : map.evaluate(x.data(), result.data(), nullptr);
        return result;
      };
      const double h = 1e-3;
      for (const bool variance : {false, true}) {
        const VectorXd expected =
            (8 * (moved(h, variance) - moved(-h, variance)) - (moved(2 * h, variance) - moved(-2 * h, variance))) /
            (12 * h);
        for (Index o = 0; o < 2; ++o)
          EXPECT_NEAR((variance ? spread : slope)[o * 3 + d], expected[o], 1e-8) << name_of(method);
      }
    }
  }
}

TEST(SparseModel, RunsFreeWithItsUncertainty) {
  const NarxModel model = fitted(SparseMethod::vfe);
  DataSet fresh = make_data_set(random_points(40, 1, 41), MatrixXd::Zero(40, 1), 0.5, {{"u", ""}}, {{"y", ""}});
  const MatrixXd matched = simulate_uncertain(model, fresh, Propagation::moment_matching)[0];
  const MatrixXd drawn = simulate_monte_carlo(model, fresh, 3000)[0];
  for (Index k = 1; k < 40; ++k) {
    EXPECT_NEAR(matched(k, 0), drawn(k, 0), 0.02);
    EXPECT_NEAR(std::sqrt(matched(k, 1) / drawn(k, 1)), 1, 0.2);
  }
}

std::string complaint_of(const MatrixXd& x, const VectorXd& y, const GpModelOptions& options) {
  try {
    fit_gp_map(x, y, options);
  } catch (const IdentifyError& error) {
    return error.what();
  }
  return "none";
}

TEST(SparseErrors, AreInTheUsersWords) {
  const Data data;
  GpModelOptions options{.process = quick(5)};
  options.sparse = SparseOptions{.inducing = 0};
  EXPECT_EQ(complaint_of(data.x, data.y, options), "the number of inducing inputs is 0; it must be 1 or more");
  options.sparse = SparseOptions{.refined = 0};
  EXPECT_EQ(complaint_of(data.x, data.y, options), "the number of refined optima is 0; it must be 1 or more");
  options.sparse = SparseOptions{.inputs = MatrixXd::Zero(3, 5)};
  EXPECT_EQ(complaint_of(data.x, data.y, options), "the inducing inputs have 5 columns, the data 2 inputs");
  options.sparse = SparseOptions{.inputs = MatrixXd::Constant(3, 2, std::nan(""))};
  EXPECT_EQ(complaint_of(data.x, data.y, options), "an inducing input is not a finite number");
  options.sparse = SparseOptions{.inducing = 1000};
  EXPECT_EQ(complaint_of(MatrixXd::Random(60000, 1), VectorXd::Random(60000), options),
            "60000 rows through 1000 inducing inputs need about 4 GB; choose fewer inducing inputs or rows");
  options.sparse = SparseOptions{};
  options.process.max_iterations = 0;
  options.given = {{Eigen::Vector3d(1, 1, 1), 0}};
  EXPECT_EQ(complaint_of(data.x, data.y, options),
            "the noise variance v0 is 0; a sparse process needs one greater than 0");
  options.process.covariance = "linear";
  options.given = {{Eigen::Vector3d(1e200, 1, 1e308), 1}};
  const std::string too_large = "a covariance is not a finite number: hyperparameters or inputs are too large";
  options.normalise = false;
  EXPECT_EQ(complaint_of(data.x * 1e100, data.y, options), too_large);
  options.sparse.reset();
  EXPECT_EQ(complaint_of(data.x * 1e100, data.y, options), too_large);
  options = {.process = quick(5)};
  options.sparse = SparseOptions{};
  VectorXd y = data.y;
  y[7] = std::nan("");
  EXPECT_EQ(complaint_of(data.x, y, options), "the target in row 8 is nan, not a finite number");
  const std::vector<std::vector<Observation>> known(1, {{Eigen::Vector2d(0, 0), 1, 0.5, 0.1}});
  try {
    fit_gp_map(data.x, data.y, options, {}, known);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(),
                 "local models are observations that need every point of their own; a sparse process cannot take them");
  }
  try {
    find_sparse_method("dtc");
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(), "there is no sparse approximation 'dtc'; there are fitc, vfe");
  }
}

TEST(SparseErrors, OfModelFilesSayWhere) {
  const std::string text = to_yaml(fitted(SparseMethod::fitc));
  const auto complaint = [&](const std::string& from, const std::string& to) -> std::string {
    std::string wrong = text;
    wrong.replace(wrong.find(from), from.size(), to);
    try {
      read_narx(read_model_file(wrong, "sparse.yaml"));
    } catch (const IdentifyError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(complaint("approximation: fitc", "approximation: dtc"),
              HasSubstr("there is no sparse approximation 'dtc'; there are fitc, vfe"));
  EXPECT_THAT(complaint("    jitter: ", "    jitter: 7"), HasSubstr("it is a part of the covariances, from 0 to 1"));
  EXPECT_THAT(complaint("    weights: [", "    weights: [.nan, "), HasSubstr("sparse.yaml:"));
  EXPECT_THAT(complaint("    precision:\n      - [", "    precision:\n      - [-"),
              HasSubstr("the precision is not positive definite"));
  EXPECT_THAT(complaint("    samples: ", "    samples: -"), HasSubstr("it must be 0 or more"));
}

struct Unusual {
  const char* what;
  double x_scale, x_offset, y_scale, y_offset;
};

// Normalisation takes units out; what is left is the same fit.
TEST(SparseData, TinyAndHugeNumbersGiveTheSameFit) {
  const Data data;
  GpModelOptions options{.process = quick(15)};
  options.sparse = SparseOptions{.inducing = 12, .refined = 1};
  const double reached = fit_gp_map(data.x, data.y, options).report.reached;
  for (const Unusual& u :
       {Unusual{"tiny", 1e-100, 0, 1e-120, 0}, {"huge", 1e100, 0, 1e120, 0}, {"far", 1, 1e4, 1, 1e5}}) {
    const MatrixXd x = (data.x * u.x_scale).array() + u.x_offset;
    const VectorXd y = (data.y * u.y_scale).array() + u.y_offset;
    const GpMapFit fit = fit_gp_map(x, y, options);
    EXPECT_NEAR(fit.report.reached, reached, 0.05 * std::fabs(reached)) << u.what;
    VectorXd mean(1);
    const VectorXd at = x.row(5).transpose();
    fit.model->evaluate(at.data(), mean.data(), nullptr);
    EXPECT_NEAR((mean[0] - y[5]) / u.y_scale, 0, 0.3) << u.what;
  }
}

TEST(SparseData, DuplicatesAndConstantsAreToldOf) {
  const Data data;
  GpModelOptions options{.process = quick(15)};
  options.sparse = SparseOptions{.inducing = 30, .refined = 1};
  // Seven different rows: as many inducing inputs, and the noise is what the repetitions tell.
  MatrixXd x(210, 2);
  for (Index i = 0; i < 210; ++i) x.row(i) = data.x.row(i % 7);
  const VectorXd y = first_order_targets(x, 0.05, 55);
  const GpMapFit few = fit_gp_map(x, y, options);
  EXPECT_EQ(few.model->process(0).x().rows(), 7);
  EXPECT_THAT(few.report.warnings, Contains("Only 7 rows differ, so there are 7 inducing inputs instead of 30."));
  EXPECT_THAT(few.report.warnings, Contains(StartsWith("203 of 210 points repeat an earlier one;")));
  EXPECT_NEAR(std::sqrt(few.model->noise_variance(0)), 0.05, 0.01);
  // A constant input.
  MatrixXd constant = data.x;
  constant.col(1).setConstant(3);
  EXPECT_THAT(fit_gp_map(constant, data.y, options).report.warnings,
              Contains("Input 2 is constant, so its weight is not determined."));
  // Constant targets.
  const GpMapFit flat = fit_gp_map(data.x, VectorXd::Constant(400, 2.5), options);
  EXPECT_THAT(flat.report.warnings, Contains("All targets are equal, so nothing can be learned from them."));
  VectorXd mean(1);
  const VectorXd at = Eigen::Vector2d(0.1, 0.2);
  flat.model->evaluate(at.data(), mean.data(), nullptr);
  EXPECT_NEAR(mean[0], 2.5, 1e-6);
  // Inducing inputs that are given twice.
  options.sparse->inputs = MatrixXd(4, 2);
  options.sparse->inputs << 0, 0, 1, 1, 0, 0, -1, 1;
  options.sparse->hold = true;
  EXPECT_THAT(fit_gp_map(data.x, data.y, options).report.warnings,
              Contains("1 of 4 inducing inputs lie on another one; fewer of them would do the same."));
}

}  // namespace
}  // namespace plantloop::identify
