// Learned models in diagrams: the numbers of the library, bit for bit, and the rate of the model file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "identify/gp/gp_map.h"
#include "identify/linear/fit_linear.h"
#include "identify/mlp/network.h"
#include "identify/model_file/model_file.h"
#include "identify/narx/load.h"
#include "identify/narx/regression_narx.h"
#include "identify/neural_state_space/neural_state_space.h"
#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

const std::string system =
    "blocks:\n"
    "  u: {type: random_levels, generator: lcg, seed: 20240101, lower: -1.2, upper: 1.2, hold: 4, rate: 0.5}\n"
    "  y: {type: unit_delay, in: y - 0.5*tanh(y + u^3), rate: 0.5, initial: 0}\n";
const std::string network = "model: diagrams/book/models/first_order_mlp.yaml";

// A file of the test inside the project, as diagrams read no others.
std::string place(const std::string& name) {
  std::filesystem::create_directories("build/tests-of-learned");
  return "build/tests-of-learned/" + name;
}

// The recorded signals as identification sees them.
identify::DataSet data_of(const Signals& r) {
  const std::vector<double> u = r.samples("u"), y = r.samples("y");
  const auto n = static_cast<Eigen::Index>(u.size());
  return identify::make_data_set(Eigen::MatrixXd(Eigen::VectorXd::Map(u.data(), n)),
                                 Eigen::MatrixXd(Eigen::VectorXd::Map(y.data(), n)), 0.5, {{"u", ""}}, {{"y", ""}});
}

TEST(Narx, GivesTheNumbersOfTheLibraryBitForBit) {
  const Signals r = run(system + "  one: {type: narx, mode: one_step, in: {u: u, y: y}, " + network + "}\n" +
                        "  free: {type: narx, in: {u: u}, " + network + "}\n" +
                        "simulation: {stop: 50}\nrecord: [u, y, one.y, free.y]\n");
  const auto model = identify::load_model("diagrams/book/models/first_order_mlp.yaml");
  ASSERT_EQ(model->error, "");
  const identify::DataSet data = data_of(r);
  const Eigen::MatrixXd one = identify::one_step(model->narx, data)[0];
  const std::vector<double> found = r.samples("one.y"), run_free = r.samples("free.y");
  ASSERT_EQ(static_cast<Eigen::Index>(found.size()), one.rows());
  for (std::size_t k = 1; k < found.size(); ++k) EXPECT_EQ(found[k], one(static_cast<Eigen::Index>(k), 0));
  // The free run of the block starts from its first own output.
  identify::DataSet begun = data;
  begun.experiments[0].y(0, 0) = run_free[0];
  const Eigen::MatrixXd free = identify::free_run(model->narx, begun)[0];
  for (std::size_t k = 1; k < found.size(); ++k) EXPECT_EQ(run_free[k], free(static_cast<Eigen::Index>(k), 0));
}

// One step with errors of past predictions, from a past of zeros; free runs know no errors.
TEST(Narx, RunsNoiseModelsAsTheLibraryDoes) {
  using namespace identify;
  DataSet channels;
  channels.Ts = 0.5;
  channels.inputs = {{"u", ""}};
  channels.outputs = {{"y", ""}};
  const auto model = [&](const char* regressors, bool simulated, NoiseFilters noise) {
    const RegressorSet set = parse_regressors(regressors, channels);
    Network net = make_network(static_cast<int>(set.size()), {2}, 1, Activation::tanh);
    Random random(3);
    randomise(net, 0.5, random);
    NarxModel m = make_narx(std::make_shared<Mlp>(net, no_scaling(set.size()), no_scaling(1)), set, channels);
    m.simulated = simulated;
    m.noise = std::move(noise);
    return m;
  };
  const Eigen::VectorXd c = Eigen::Vector3d(1, 0.5, -0.1), d = Eigen::Vector2d(1, -0.6), one = Eigen::VectorXd::Ones(1);
  int number = 0;
  for (const NarxModel& m : {model("y(k-1..2), u(k-1), e(k-1)*y(k-1), e(k-2)", false, {}),
                             model("y(k-1), u(k-1)", false, {{c}, {one}}), model("y(k-1), u(k-2)", true, {{c}, {d}})}) {
    const std::string name = place("noise" + std::to_string(++number) + ".yaml");
    std::ofstream(name) << to_yaml(m);
    const std::string file = "model: " + name;
    const Signals r = run(system + "  one: {type: narx, mode: one_step, in: {u: u, y: y}, " + file + "}\n" +
                          "  free: {type: narx, in: {u: u}, " + file + "}\n" +
                          "simulation: {stop: 50}\nrecord: [u, y, one.y, free.y]\n");
    // Rows of zeros before the record are the past that the block has.
    DataSet data = data_of(r);
    const Eigen::Index first = m.regressors.longest_lag(), n = data.samples();
    Experiment& e = data.experiments[0];
    for (Eigen::MatrixXd* signal : {&e.u, &e.y}) {
      Eigen::MatrixXd padded = Eigen::MatrixXd::Zero(n + first, 1);
      padded.bottomRows(n) = *signal;
      *signal = padded;
    }
    const Eigen::MatrixXd predicted = one_step(m, data)[0], free = free_run(m, data)[0];
    const std::vector<double> one_y = r.samples("one.y"), free_y = r.samples("free.y");
    ASSERT_EQ(static_cast<Eigen::Index>(one_y.size()), n);
    double noise = 0;
    for (Eigen::Index k = 0; k < n; ++k) {
      EXPECT_EQ(one_y[static_cast<std::size_t>(k)], predicted(first + k, 0)) << number << " " << k;
      EXPECT_EQ(free_y[static_cast<std::size_t>(k)], free(first + k, 0)) << number << " " << k;
      noise = std::max(noise, std::fabs(predicted(first + k, 0) - free(first + k, 0)));
    }
    EXPECT_GT(noise, 0.01);
  }
}

TEST(Narx, StartsFromGivenOutputsAndInputs) {
  const Signals r =
      run("blocks: {m: {type: narx, model: tests/blocks/models/narx.yaml, initial: 2, initial_u: 1, in: "
          "{u: 0}}}\nsimulation: {stop: 1}\nrecord: [m.y]\n");
  EXPECT_DOUBLE_EQ(r.samples("m.y")[0], 0.8 * 2 + 0.2);
  EXPECT_DOUBLE_EQ(r.samples("m.y")[1], 0.8 * (0.8 * 2 + 0.2));
}

TEST(Narx, TakesItsRateFromTheModelFile) {
  const std::string narx = "blocks:\n  m: {type: narx, model: tests/blocks/models/narx.yaml, in: {u: 1}";
  EXPECT_EQ(run(narx + "}\nsimulation: {stop: 1}\nrecord: [m.y]\n").samples("m.y").size(), 11U);
  EXPECT_EQ(findings(narx + ", rate: 0.1}\nsimulation: {stop: 1}\n"), "");
  EXPECT_THAT(findings(narx + ", rate: 0.2}\nsimulation: {stop: 1}\n"),
              HasSubstr("the model file of 'm' was made for a period of 0.1 s, not 0.2 s"));
}

TEST(Narx, SaysWhichPortsAModeHas) {
  EXPECT_THAT(
      findings(system + "  m: {type: narx, mode: one_step, in: {u: u}, " + network + "}\nsimulation: {stop: 1}\n"),
      HasSubstr("mode one_step predicts from measured outputs, so port y needs a wire"));
  EXPECT_THAT(findings(system + "  m: {type: narx, in: {u: u, y: y}, " + network + "}\nsimulation: {stop: 1}\n"),
              HasSubstr("mode free_run feeds the model's own outputs back, so port y stays free"));
  EXPECT_THAT(findings(system + "  m: {type: narx, in: {u: u}, propagation: first_order, " + network +
                       "}\nsimulation: {stop: 1}\n"),
              HasSubstr("only a Gaussian process knows how uncertain it is, this is 'mlp'"));
  EXPECT_THAT(
      findings("blocks: {m: {type: narx, model: tests/blocks/models/mlp.yaml, in: {u: 0}}}\nsimulation: {stop: 1}\n"),
      HasSubstr("the model 'tests/blocks/models/mlp.yaml' has no regressors; the block mlp runs it"));
}

// Inputs that act late, an output that reads them, networks of both: the free run of the library, bit for bit.
TEST(NeuralStateSpace, GivesTheFreeRunOfTheLibrary) {
  using namespace identify;
  Random random(4);
  plantloop::identify::NeuralStateSpace m;
  m.inputs = {{"u1", ""}, {"u2", ""}};
  m.outputs = {{"y1", ""}, {"y2", ""}};
  m.Ts = 0.5;
  m.delay = {2, 0};
  Network f = make_network(5, {4}, 3, Activation::tanh, Activation::linear, true);
  Network g = make_network(5, {2}, 2, Activation::sigmoid, Activation::linear, true);
  randomise(f, 0.3, random);
  randomise(g, 0.5, random);
  m.transition = std::make_shared<Mlp>(f, no_scaling(5), no_scaling(3));
  m.output = std::make_shared<Mlp>(g, no_scaling(5), no_scaling(2));
  m.deviations = Eigen::VectorXd::Ones(2);
  const std::string path = place("neural.yaml");
  std::ofstream(path) << to_yaml("neural_state_space", to_item(m));
  const Signals r =
      run("blocks:\n  a: {type: random_levels, generator: lcg, seed: 7, lower: -1, upper: 1, hold: 2, rate: "
          "0.5}\n  m: {type: neural_state_space, model: " +
          path + ", in: {u: '[a, a^2]'}}\nsimulation: {stop: 20}\nrecord: [a, m.y]\n");
  const std::vector<double> a = r.samples("a"), y1 = r.samples("m.y.1"), y2 = r.samples("m.y.2");
  const auto n = static_cast<Eigen::Index>(a.size());
  ASSERT_EQ(n, 41);
  Eigen::MatrixXd u(n, 2);
  u.col(0) = Eigen::VectorXd::Map(a.data(), n);
  u.col(1) = u.col(0).cwiseAbs2();
  const Eigen::MatrixXd y =
      simulate(m, make_data_set(u, Eigen::MatrixXd::Zero(n, 2), 0.5, m.inputs, m.outputs), StateStart::zero)[0];
  for (Eigen::Index k = 0; k < n; ++k) {
    EXPECT_EQ(y1[static_cast<std::size_t>(k)], y(k, 0)) << k;
    EXPECT_EQ(y2[static_cast<std::size_t>(k)], y(k, 1)) << k;
  }
}

TEST(NeuralStateSpace, NamesTheBlockThatRunsAnotherModel) {
  const auto said = [](const std::string& type, const std::string& file) {
    return findings("blocks: {m: {type: " + type + ", model: tests/blocks/models/" + file +
                    ".yaml, in: {u: 0}}}\nsimulation: {stop: 1}\n");
  };
  EXPECT_THAT(said("neural_state_space", "narx"), HasSubstr("; the block narx runs it"));
  EXPECT_THAT(said("neural_state_space", "linear_model"),
              HasSubstr("holds a linear model; the block linear_model runs it"));
  EXPECT_THAT(said("narx", "neural_state_space"),
              HasSubstr("holds a neural state-space model; the block neural_state_space runs it"));
  EXPECT_THAT(said("linear_model", "neural_state_space"),
              HasSubstr("holds a neural state-space model; the block neural_state_space runs it"));
}

TEST(LinearModel, StartsAtItsOperatingPointOrAtRest) {
  const std::string block = "blocks: {m: {type: linear_model, model: tests/blocks/models/linear_model.yaml, in: {u: 3}";
  const std::vector<double> begun = run(block + "}}\nsimulation: {stop: 1}\nrecord: [m]\n").samples("m");
  ASSERT_EQ(begun.size(), 11U);  // the file's period is 0.1 s
  for (std::size_t k = 0; k < begun.size(); ++k)
    EXPECT_NEAR(begun[k], 3 * (1 - std::pow(0.8, static_cast<double>(k))), 1e-12);
  for (const double y : run(block + ", start: rest}}\nsimulation: {stop: 1}\nrecord: [m]\n").samples("m")) {
    EXPECT_NEAR(y, 3, 1e-12);
  }
}

// A model of two inputs with an operating point, from polynomials and from matrices: the free run of the library.
TEST(LinearModel, GivesTheFreeRunOfTheLibrary) {
  identify::StateSpaceModel m;
  m.inputs = {{"u1", ""}, {"u2", ""}};
  m.outputs = {{"y1", ""}, {"y2", ""}};
  m.Ts = 0.5;
  m.A = (Eigen::MatrixXd(2, 2) << 0.7, 0.2, -0.1, 0.5).finished();
  m.B = (Eigen::MatrixXd(2, 2) << 1, 0.3, 0, -0.4).finished();
  m.C = (Eigen::MatrixXd(2, 2) << 1, 0, 0.5, 2).finished();
  m.D = (Eigen::MatrixXd(2, 2) << 0, 0, 0, 0.25).finished();
  m.u0 = (Eigen::VectorXd(2) << 1, -2).finished();
  m.y0 = (Eigen::VectorXd(2) << 10, 20).finished();
  const std::string path = place("linear.yaml");
  std::ofstream(path) << identify::to_yaml("state_space_model", identify::to_item(m));
  const Signals r =
      run("blocks:\n  u: {type: random_levels, generator: lcg, seed: 5, lower: -1, upper: 2, hold: 3, rate: "
          "0.5}\n  m: {type: linear_model, model: " +
          path + ", in: {u: [u, u^2]}}\nsimulation: {stop: 20}\nrecord: [u, m]\n");
  const std::vector<double> u = r.samples("u"), y = r.samples("m.2");
  Eigen::MatrixXd inputs(static_cast<Eigen::Index>(u.size()), 2);
  for (std::size_t k = 0; k < u.size(); ++k) inputs.row(static_cast<Eigen::Index>(k)) << u[k], u[k] * u[k];
  const identify::DataSet data =
      identify::make_data_set(inputs, Eigen::MatrixXd::Zero(inputs.rows(), 2), 0.5, m.inputs, m.outputs);
  const Eigen::MatrixXd expected = identify::simulate(m, data, identify::StateStart::zero)[0];
  ASSERT_EQ(static_cast<Eigen::Index>(y.size()), expected.rows());
  for (std::size_t k = 0; k < y.size(); ++k) EXPECT_NEAR(y[k], expected(static_cast<Eigen::Index>(k), 1), 1e-12);
}

// y(k) - 7 = 0.8 (y(k-1) - 7) + 0.2 u(k-1): the offset 1.4 makes the level 7.
TEST(LinearModel, RunsAnEstimatedConstant) {
  Eigen::VectorXd u(40), y(40);
  double state = -1;
  for (Eigen::Index k = 0; k < 40; ++k) {
    u[k] = k % 7 < 3 ? 1 : -0.5;
    y[k] = 7 + state;
    state = 0.8 * state + 0.2 * u[k];
  }
  const identify::PolynomialModel m =
      identify::fit_linear(identify::make_data_set(u, y, 0.5), {.na = 1, .nb = {1}}, {.offset = true});
  EXPECT_NEAR(m.offset, 1.4, 1e-12);
  const std::string path = place("constant.yaml");
  std::ofstream(path) << identify::to_yaml("linear_model", identify::to_item(m));
  const std::vector<double> run_y =
      run("blocks: {m: {type: linear_model, model: " + path + ", in: {u: 3}}}\nsimulation: {stop: 5}\nrecord: [m]\n")
          .samples("m");
  ASSERT_EQ(run_y.size(), 11U);
  for (std::size_t k = 0; k < run_y.size(); ++k)
    EXPECT_NEAR(run_y[k], 7 + 3 * (1 - std::pow(0.8, static_cast<double>(k))), 1e-10);
}

TEST(LinearModel, SaysWhichBlockRunsAModel) {
  EXPECT_THAT(
      findings("blocks: {m: {type: linear_model, model: tests/blocks/models/narx.yaml, in: {u: 0}}}\n"
               "simulation: {stop: 1}\n"),
      HasSubstr("'tests/blocks/models/narx.yaml' holds a model of type 'mlp', which is not linear; the block narx "
                "runs it"));
  EXPECT_THAT(
      findings("blocks: {m: {type: narx, model: tests/blocks/models/linear_model.yaml, in: {u: 0}}}\n"
               "simulation: {stop: 1}\n"),
      HasSubstr("'tests/blocks/models/linear_model.yaml' holds a linear model; the block linear_model runs it"));
}

// A polynomial model runs as a network does: the same numbers as the library, and exact derivatives.
TEST(Narx, RunsPolynomialModels) {
  const Signals data_run = run(system + "simulation: {stop: 60}\nrecord: [u, y]\n");
  const identify::DataSet data = data_of(data_run);
  const identify::RegressionModel model = identify::fit_selected(
      data, identify::polynomial(identify::parse_regressors("y(k-1..2), u(k-1..2)", data), 3), {.most_terms = 8});
  const identify::NarxModel narx = identify::to_narx(model);
  EXPECT_LT((identify::free_run(narx, data)[0] - identify::free_run(model, data)[0]).cwiseAbs().maxCoeff(), 1e-10);
  const auto n = static_cast<std::size_t>(narx.map->inputs());
  std::vector<double> x(n), slopes(n), scratch(static_cast<std::size_t>(narx.map->scratch_size()));
  for (std::size_t i = 0; i < n; ++i) x[i] = 0.3 - 0.2 * static_cast<double>(i);
  narx.map->derivative(x.data(), slopes.data(), scratch.data());
  for (std::size_t i = 0; i < n; ++i) {
    const auto at = [&](double step) {
      std::vector<double> moved = x;
      moved[i] += step;
      double y = 0;
      narx.map->evaluate(moved.data(), &y, scratch.data());
      return y;
    };
    EXPECT_NEAR(slopes[i], (8 * (at(1e-3) - at(-1e-3)) - (at(2e-3) - at(-2e-3))) / 12e-3, 1e-9);
  }
  const std::string path = place("polynomial.yaml");
  std::ofstream(path) << identify::to_yaml("regression_model", identify::to_item(model));
  const Signals r = run(system + "  one: {type: narx, mode: one_step, in: {u: u, y: y}, model: " + path +
                        "}\nsimulation: {stop: 60}\nrecord: [u, y, one.y]\n");
  const Eigen::MatrixXd one = identify::one_step(model, data)[0];
  const std::vector<double> found = r.samples("one.y");
  for (std::size_t k = 2; k < found.size(); ++k) EXPECT_NEAR(found[k], one(static_cast<Eigen::Index>(k), 0), 1e-12);
}

TEST(Map, SaysWhichBlockRunsAModel) {
  EXPECT_THAT(
      findings("blocks: {m: {type: mlp, model: tests/blocks/models/rbf_network.yaml, in: {x: 0}}}\nsimulation: "
               "{stop: 1}\n"),
      HasSubstr("'tests/blocks/models/rbf_network.yaml' holds a model of type 'rbf_network'; a block of that type "
                "runs it"));
  EXPECT_THAT(
      findings("blocks: {m: {type: mlp, model: tests/blocks/signals.csv, in: {x: 0}}}\nsimulation: {stop: 1}\n"),
      HasSubstr("tests/blocks/signals.csv"));
}

// A Gaussian process in free run: mean and variance are those of the library for each way of carrying uncertainty.
TEST(Narx, CarriesTheUncertaintyOfAGaussianProcessAlong) {
  const std::string file = "tests/blocks/models/gp_narx.yaml";
  for (const char* how : {"naive", "first_order", "moment_matching"}) {
    const Signals r = run(system + "  m: {type: narx, in: {u: u}, propagation: " + how + ", model: " + file +
                          "}\nsimulation: {stop: 15}\nrecord: [u, y, m.y, m.variance]\n");
    const auto model = identify::load_model(file);
    ASSERT_EQ(model->error, "");
    // One sample of rest before the start, as the block has it.
    const identify::DataSet data = data_of(r);
    Eigen::MatrixXd u = Eigen::MatrixXd::Zero(data.samples() + 1, 1), y = u;
    u.bottomRows(data.samples()) = data.experiments[0].u;
    const identify::DataSet begun = identify::make_data_set(u, y, 0.5, {{"u", ""}}, {{"y", ""}});
    const Eigen::MatrixXd expected =
        identify::simulate_uncertain(model->narx, begun, identify::find_propagation(how))[0];
    const std::vector<double> mean = r.samples("m.y"), variance = r.samples("m.variance");
    for (std::size_t k = 0; k < mean.size(); ++k) {
      EXPECT_EQ(mean[k], expected(static_cast<Eigen::Index>(k) + 1, 0)) << how;
      EXPECT_NEAR(variance[k], expected(static_cast<Eigen::Index>(k) + 1, 1), 1e-15) << how;
    }
  }
}

// Through inducing inputs: the blocks narx and gaussian_process give the numbers of the library, with exact
// derivatives.
TEST(Narx, RunsSparseGaussianProcessesAsTheLibraryDoes) {
  using namespace identify;
  const Signals recorded = run(system + "simulation: {stop: 150}\nrecord: [u, y]\n");
  const DataSet data = data_of(recorded);
  for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
    GpModelOptions options;
    options.process.starts = 1;
    options.process.max_iterations = 20;
    options.sparse = SparseOptions{.method = method, .inducing = 15, .refined = 1};
    const NarxModel model = fit_narx_gp(data, parse_regressors("y(k-1), u(k-1)", data), options);
    const std::string file = place(name_of(method) + ".yaml");
    std::ofstream(file) << to_yaml(model);
    const Signals r = run(system + "  one: {type: narx, mode: one_step, in: {u: u, y: y}, model: " + file + "}\n" +
                          "  free: {type: narx, in: {u: u}, propagation: moment_matching, model: " + file +
                          "}\nsimulation: {stop: 30}\nrecord: [u, y, one.y, free.y, free.variance]\n");
    const DataSet short_run = data_of(r);
    const Eigen::MatrixXd one = one_step(model, short_run)[0];
    const std::vector<double> found = r.samples("one.y"), mean = r.samples("free.y"),
                              variance = r.samples("free.variance");
    for (std::size_t k = 1; k < found.size(); ++k) EXPECT_EQ(found[k], one(static_cast<Eigen::Index>(k), 0));
    Eigen::MatrixXd u = Eigen::MatrixXd::Zero(short_run.samples() + 1, 1), y = u;
    u.bottomRows(short_run.samples()) = short_run.experiments[0].u;
    const DataSet begun = make_data_set(u, y, 0.5, {{"u", ""}}, {{"y", ""}});
    const Eigen::MatrixXd expected = simulate_uncertain(model, begun, Propagation::moment_matching)[0];
    for (std::size_t k = 0; k < mean.size(); ++k) {
      EXPECT_EQ(mean[k], expected(static_cast<Eigen::Index>(k) + 1, 0)) << k;
      EXPECT_NEAR(variance[k], expected(static_cast<Eigen::Index>(k) + 1, 1), 1e-14) << k;
    }
  }
}

TEST(GaussianProcess, RunsASparseOneAsTheLibraryDoes) {
  using namespace identify;
  Random random(5);
  Eigen::MatrixXd x(200, 1), y(200, 1);
  for (Eigen::Index i = 0; i < 200; ++i) {
    x(i, 0) = random.uniform(-2, 2);
    y(i, 0) = std::sin(2 * x(i, 0)) + 0.1 * random.normal();
  }
  const DataSet data = make_data_set(x, y, 1, {{"x", ""}}, {{"y", ""}});
  GpModelOptions options;
  options.process.starts = 1;
  options.process.max_iterations = 20;
  options.sparse = SparseOptions{.method = SparseMethod::vfe, .inducing = 12, .refined = 1};
  const NarxModel model = fit_narx_gp(data, parse_regressors("x(k)", data), options);
  const std::string file = place("sparse_map.yaml");
  std::ofstream(file) << to_yaml(model);
  const Signals r = run("blocks: {gp: {type: gaussian_process, model: " + file +
                        ", in: {x: 0.4}}}\nsimulation: {stop: 1}\nrecord: [gp.y, gp.variance]\n");
  const double at_x = 0.4;
  double mean = 0, variance = 0;
  model.map->evaluate(&at_x, &mean, nullptr);
  model.map->variance(&at_x, &variance, nullptr);
  EXPECT_EQ(r.samples("gp.y").front(), mean);
  EXPECT_EQ(r.samples("gp.variance").front(), variance);
  EXPECT_NEAR(mean, std::sin(0.8), 0.1);
}

// At an uncertain point: the numbers of the library in the user's units.
TEST(Map, OfAGaussianProcessCarriesTheUncertaintyOfItsInputs) {
  const std::string file = "tests/blocks/models/gaussian_process.yaml", block = "blocks: {m: {type: gaussian_process, ";
  const auto map = std::dynamic_pointer_cast<const identify::GpMap>(identify::load_model(file)->map);
  ASSERT_EQ(map->inputs(), 1);
  for (const char* how : {"first_order", "moment_matching"}) {
    const Signals r = run(block + "propagation: " + how + ", model: " + file +
                          ", in: {x: 0.5, x_covariance: 0.01}}}\nsimulation: {stop: 1}\n" +
                          "record: [m.y, m.variance, m.covariance]\n");
    const identify::UncertainPrediction expected =
        identify::UncertainMap(map, identify::find_propagation(how))
            .predict({Eigen::VectorXd::Constant(1, 0.5), Eigen::MatrixXd::Constant(1, 1, 0.01)});
    EXPECT_EQ(r.last("m.y"), expected.mean[0]);
    EXPECT_EQ(r.last("m.variance"), expected.covariance(0, 0));
    EXPECT_EQ(r.last("m.covariance"), expected.covariance(0, 0));
  }
  EXPECT_THAT(findings(block + "model: " + file + ", in: {x: 0.5, x_covariance: 0.01}}}\nsimulation: {stop: 1}\n"),
              HasSubstr("naive leaves the covariance of x out; first_order and moment_matching use it"));
  EXPECT_THAT(
      findings(block + "propagation: first_order, model: " + file + ", in: {x: 0.5}}}\nsimulation: {stop: 1}\n"),
      HasSubstr("first_order and moment_matching need the covariance of x, so port x_covariance needs a wire"));
}

// Of two outputs, both fed back: means, variances and the covariance of the two.
TEST(Narx, CarriesTheCovarianceOfTwoOutputsAlong) {
  using namespace identify;
  Random random(17);
  Eigen::MatrixXd u(60, 1), y = Eigen::MatrixXd::Zero(60, 2);
  for (Eigen::Index k = 0; k < 60; ++k) {
    u(k, 0) = random.uniform(-1, 1);
    if (k > 0) {
      y(k, 0) = 0.5 * y(k - 1, 0) + 0.3 * std::sin(2 * y(k - 1, 1)) + 0.4 * u(k - 1, 0) + 0.05 * random.normal();
      y(k, 1) = 0.7 * y(k - 1, 1) - 0.2 * y(k - 1, 0) + 0.05 * random.normal();
    }
  }
  const DataSet data = make_data_set(u, y, 0.5, {{"u", ""}}, {{"y1", ""}, {"y2", ""}});
  GpOptions options;
  options.starts = 1;
  const NarxModel model = fit_narx_gp(data, parse_regressors("y1(k-1), y2(k-1..2), u(k-1)", data), options);
  const std::string file = place("two_outputs.yaml");
  std::ofstream(file) << to_yaml(model);
  for (const char* how : {"naive", "first_order", "moment_matching"}) {
    const Signals r =
        run(system + "  m: {type: narx, in: {u: u}, initial: 0.3, propagation: " + how + ", model: " + file +
            "}\nsimulation: {stop: 10}\n" + "record: [u, m.y, m.variance, m.covariance]\n");
    // Two samples before the start, as the block has them: inputs of 0 and the initial outputs.
    const std::vector<double> input = r.samples("u");
    const auto n = static_cast<Eigen::Index>(input.size());
    Eigen::MatrixXd past_u = Eigen::MatrixXd::Zero(n + 2, 1), past_y = Eigen::MatrixXd::Constant(n + 2, 2, 0.3);
    past_u.bottomRows(n) = Eigen::VectorXd::Map(input.data(), n);
    const DataSet begun = make_data_set(past_u, past_y, 0.5, {{"u", ""}}, {{"y1", ""}, {"y2", ""}});
    const Eigen::MatrixXd expected = simulate_uncertain(model, begun, find_propagation(how))[0];
    const char* const names[] = {"m.y.1",           "m.y.2", "m.covariance.1.1", "m.covariance.1.2", "m.covariance.2.1",
                                 "m.covariance.2.2"};
    for (Eigen::Index c = 0; c < 6; ++c) {
      const std::vector<double> found = r.samples(names[c]);
      for (Eigen::Index k = 0; k < n; ++k)
        EXPECT_NEAR(found[static_cast<std::size_t>(k)], expected(k + 2, c), 1e-14) << how << names[c] << k;
    }
    EXPECT_EQ(r.samples("m.variance.2"), r.samples("m.covariance.2.2"));
  }
}

}  // namespace
}  // namespace plantloop::testing_diagrams
