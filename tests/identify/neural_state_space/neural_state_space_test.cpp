// Neural state-space models: derivatives through time against complex steps, first states, files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "identify/error.h"
#include "identify/model_file/model_file.h"
#include "identify/neural_state_space/fit_neural_state_space.h"
#include "identify/neural_state_space/state_space_training.h"
#include "tests/identify/mlp/complex_network.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

TEST(StateSpaceTraining, AgreesWithComplexStepsThroughTime) {
  Random random(5);
  std::vector<Experiment> experiments(2);
  for (Experiment& e : experiments) {
    e.u.resize(12, 2);
    e.y.resize(12, 2);
    for (double& each : e.u.reshaped()) each = random.uniform(-1, 1);
    for (double& each : e.y.reshaped()) each = random.uniform(-1, 1);
  }
  for (const std::vector<int>& hidden : {std::vector<int>{}, {3}, {3, 2}})
    for (const std::vector<int>& output_hidden : {std::vector<int>{}, {4}})
      for (const bool feedthrough : {false, true}) {
        Network f = make_network(5, hidden, 3, Activation::tanh, Activation::linear, !hidden.empty());
        Network g = make_network(feedthrough ? 5 : 3, output_hidden, 2, Activation::sigmoid, Activation::linear,
                                 !output_hidden.empty());
        randomise(f, 0.4, random);
        randomise(g, 0.8, random);
        VectorXd theta(f.parameters() + g.parameters() + 6);
        theta << f.theta(), g.theta(), VectorXd::Constant(6, 0.3);
        const auto outputs = [&](const VectorXcd& t) {
          VectorXcd all(48);
          Index at = 0;
          for (Index i = 0; i < 2; ++i) {
            VectorXcd x = t.segment(f.parameters() + g.parameters() + 3 * i, 3), z(5);
            for (Index k = 0; k < 12; ++k, at += 2) {
              z << x, experiments[static_cast<std::size_t>(i)].u.row(k).transpose().cast<Complex>();
              all.segment(at, 2) = complex_output(g, t.segment(f.parameters(), g.parameters()), z.head(g.inputs()));
              x = complex_output(f, t.head(f.parameters()), z);
            }
          }
          return all;
        };
        VectorXd e(48);
        for (Index i = 0; i < 2; ++i)
          e.segment(24 * i, 24) = MatrixXd(experiments[static_cast<std::size_t>(i)].y.transpose()).reshaped();
        e -= outputs(theta.cast<Complex>()).real();
        const StateSpaceTraining training(f, g, experiments);
        expect_normal(training, theta, complex_step(theta, outputs), e, "neural state space");
        EXPECT_NEAR(training.sse(theta), e.squaredNorm(), 1e-12 * e.squaredNorm());
      }
}

// x(k+1) = 0.9 x1 + 0.2 tanh(x2 + u), x2(k+1) = 0.7 x2 - 0.3 x1 + u; y = 2 x1 + 1.
NeuralStateSpace by_hand() {
  NeuralStateSpace m;
  m.inputs = {{"u", "V"}};
  m.outputs = {{"y", "mm"}};
  m.Ts = 0.5;
  m.delay = {1};
  Network f = make_network(3, {1}, 2, Activation::tanh, Activation::linear, true);
  f.layers[0].w << 0, 1, 1, 0;
  f.layers[1].w << 0.2, 0, 0, 0;
  f.direct << 0.9, 0, 0, -0.3, 0.7, 1;
  Network g = make_network(2, {}, 1, Activation::tanh);
  g.layers[0].w << 2, 0, 1;
  m.transition = std::make_shared<Mlp>(f, no_scaling(3), no_scaling(2));
  m.output = std::make_shared<Mlp>(g, no_scaling(2), no_scaling(1));
  m.deviations = VectorXd::Constant(1, 1e-3);
  return m;
}

DataSet data_of(const NeuralStateSpace& m, VectorXd x, Index samples) {
  Random random(8);
  MatrixXd u(samples, 1), y(samples, 1);
  double late = 0;
  for (Index k = 0; k < samples; ++k) {
    u(k, 0) = random.uniform(-1, 1);
    if (k == 0) late = u(0, 0);
    y(k, 0) = 2 * x[0] + 1;
    x = Eigen::Vector2d(0.9 * x[0] + 0.2 * std::tanh(x[1] + late), 0.7 * x[1] - 0.3 * x[0] + late);
    late = u(k, 0);
  }
  return make_data_set(u, y, m.Ts, m.inputs, m.outputs);
}

TEST(NeuralStateSpace, RunsAsTheFormulaSaysAndFindsItsFirstState) {
  const NeuralStateSpace m = by_hand();
  const DataSet rest = data_of(m, Eigen::Vector2d(0, 0), 60);
  EXPECT_LT((simulate(m, rest, StateStart::zero)[0] - rest.experiments[0].y).cwiseAbs().maxCoeff(), 1e-13);
  // From the first ten samples alone; the prior of the state pulls a little, by the square of the deviation.
  const DataSet moving = data_of(m, Eigen::Vector2d(1.5, -2), 60);
  const VectorXd x0 = first_states(m, moving, 10)[0];
  EXPECT_NEAR(x0[0], 1.5, 1e-4);
  EXPECT_NEAR(x0[1], -2, 1e-3);
  EXPECT_LT((simulate(m, moving, StateStart::estimated, 10)[0] - moving.experiments[0].y).cwiseAbs().maxCoeff(), 1e-3);
  // Missing outputs do not count.
  DataSet gaps = moving;
  for (Index k = 3; k < 60; k += 2) gaps.experiments[0].y(k, 0) = std::nan("");
  EXPECT_NEAR(first_states(m, gaps, 20)[0][0], 1.5, 1e-4);
}

TEST(NeuralStateSpace, KeepsEveryBitInItsFile) {
  NeuralStateSpace m = by_hand();
  m.x0 = {Eigen::Vector2d(1.0 / 3, -0.1)};
  const std::string text = to_yaml("neural_state_space", to_item(m));
  const NeuralStateSpace again = neural_state_space_of(read_model_file(text, "m.yaml"));
  EXPECT_EQ(to_yaml("neural_state_space", to_item(again)), text);
  const DataSet data = data_of(m, Eigen::Vector2d(0.4, 0), 30);
  EXPECT_EQ(simulate(m, data)[0], simulate(again, data)[0]);
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const IdentifyError& error) {
    return error.what();
  }
  return "";
}

TEST(NeuralStateSpace, SaysWhatDoesNotFit) {
  const NeuralStateSpace m = by_hand();
  DataSet data = data_of(m, Eigen::Vector2d(0, 0), 30);
  data.experiments[0].u(4, 0) = std::nan("");
  EXPECT_THAT(refusal([&] { simulate(m, data); }),
              HasSubstr("a free run needs every input, and 'u' is missing at sample 5 (time 2 s)"));
  std::string text = to_yaml("neural_state_space", to_item(m));
  text.replace(text.find("order: 2"), 8, "order: 3");
  EXPECT_THAT(refusal([&] { neural_state_space_of(read_model_file(text, "m.yaml")); }),
              HasSubstr("the transition has 2 states, not 3"));
  text = to_yaml("neural_state_space", to_item(m));
  text.replace(text.find("delay: [1]"), 10, "delay: [-1]");
  EXPECT_THAT(refusal([&] { neural_state_space_of(read_model_file(text, "m.yaml")); }),
              HasSubstr("a delay is a number of samples, 0 or more"));
  const auto fit = [&](NeuralStateSpaceOptions o) {
    return refusal([&] { fit_neural_state_space(data_of(m, Eigen::Vector2d(0, 0), 50), o); });
  };
  EXPECT_EQ(fit({.order = 0}), "'order' lies between 1 and 100, it is 0");
  EXPECT_EQ(fit({.projections = 1}), "projections are what the output's neurons see; give them 'output_hidden'");
  EXPECT_EQ(fit({.order = 1, .integrating = true}),
            "an integrating model has an order of 2 or more, and its output, the last state, has no neurons");
  EXPECT_EQ(fit({.delay = {1, 2}}), "there are 2 delays for 1 inputs; give one for each, or one for all");
  EXPECT_EQ(fit({.decay = -1}), "the weight decay is -1; it must be 0 or greater");
  EXPECT_EQ(refusal([&] { fit_neural_state_space(make_data_set({}, VectorXd::Ones(50), 1)); }),
            "a neural state-space model needs an input");
}

}  // namespace
}  // namespace plantloop::identify
