// Networks: values and exact derivatives, and the network that the book prints.

#include "identify/mlp/network.h"

#include <gtest/gtest.h>

#include <complex>

#include "identify/error.h"
#include "identify/mlp/fit_mlp.h"
#include "identify/model_file/model_file.h"
#include "identify/narx/narx.h"
#include "tests/identify/mlp/complex_network.h"
#include "tests/identify/mlp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class EveryActivation : public ::testing::TestWithParam<Activation> {};

TEST_P(EveryActivation, GivesExactDerivativesOfWeightsAndInputs) {
  struct Outputs {
    Activation activation;
    bool direct;
  };
  for (const Outputs& outputs : {Outputs{Activation::linear, false},
                                 {Activation::linear, true},
                                 {Activation::tanh, false},
                                 {Activation::sigmoid, false},
                                 {Activation::gaussian, false}})
    for (const std::vector<int>& hidden : {std::vector<int>{}, {4}, {5, 3}, {3, 4, 2}}) {
      Network network = make_network(3, hidden, 2, GetParam(), outputs.activation, outputs.direct);
      Random random(5);
      randomise(network, 0.8, random);
      const VectorXd theta = network.theta();
      VectorXd x(3), y(2), scratch(network.scratch_size()), by_theta(2 * theta.size()), by_x(6);
      x << 0.3, -0.7, 1.1;
      network.differentiate(x.data(), y.data(), by_theta.data(), by_x.data(), scratch.data());
      VectorXd plain(2);
      network.evaluate(x.data(), plain.data(), scratch.data());
      EXPECT_EQ(plain, y);
      const double h = 1e-30;
      for (Index j = 0; j < theta.size(); ++j) {
        Eigen::VectorXcd moved = theta.cast<Complex>();
        moved[j] += Complex(0, h);
        const VectorXd exact = complex_output(network, moved, x.cast<Complex>()).imag() / h;
        for (Index o = 0; o < 2; ++o) EXPECT_NEAR(by_theta[o * theta.size() + j], exact[o], 1e-12);
      }
      for (Index k = 0; k < 3; ++k) {
        Eigen::VectorXcd moved = x.cast<Complex>();
        moved[k] += Complex(0, h);
        const VectorXd exact = complex_output(network, theta.cast<Complex>(), moved).imag() / h;
        for (Index o = 0; o < 2; ++o) EXPECT_NEAR(by_x[o * 3 + k], exact[o], 1e-12);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Smooth, EveryActivation,
                         ::testing::Values(Activation::sigmoid, Activation::tanh, Activation::linear,
                                           Activation::gaussian),
                         [](const auto& text) { return name_of(text.param); });

TEST(Network, OrdersItsWeightsFromTheOutputsToTheInputs) {
  Network network = printed_network();
  const VectorXd theta = network.theta();
  ASSERT_EQ(theta.size(), 21);
  EXPECT_EQ(theta[0], 1.2054);
  EXPECT_EQ(theta[5], -0.0580);
  EXPECT_EQ(theta[6], -0.5588);
  EXPECT_EQ(theta[8], -1.9530);
  Network copy = make_network(2, {5}, 1, Activation::tanh);
  copy.set_theta(theta);
  EXPECT_EQ(copy.theta(), theta);
}

// sigmoid(s) = (1 + tanh(s/2))/2.
TEST(Network, OfSigmoidsIsOneOfTanh) {
  Network sigmoid = make_network(2, {4}, 1, Activation::sigmoid);
  Random random(3);
  randomise(sigmoid, 2, random);
  Network tanh = sigmoid;
  tanh.layers[0].activation = Activation::tanh;
  tanh.layers[0].w /= 2;
  tanh.layers[1].w.leftCols(4) /= 2;
  tanh.layers[1].w(0, 4) += sigmoid.layers[1].w.leftCols(4).sum() / 2;
  VectorXd x(2), a(1), b(1), scratch(sigmoid.scratch_size());
  x << 0.4, -1.3;
  sigmoid.evaluate(x.data(), a.data(), scratch.data());
  tanh.evaluate(x.data(), b.data(), scratch.data());
  EXPECT_NEAR(a[0], b[0], 1e-14);
}

NarxModel printed_model(const DataSet& data) {
  return make_narx(std::make_shared<Mlp>(printed_network(), no_scaling(2), no_scaling(1)),
                   parse_regressors("y(k-1), u(k-1)", data), data);
}

// The static values y = f(y, u) of the printed weights.
TEST(PrintedNetwork, RestsWhereTheBooksWeightsSay) {
  const VectorXd u = (VectorXd(7) << -1.2, -0.9, -0.6, 0, 0.6, 0.9, 1.2).finished();
  const VectorXd expected =
      (VectorXd(7) << 1.74958, 0.73361, 0.20742, 0.00850, -0.22265, -0.74661, -1.69433).finished();
  for (Index i = 0; i < 7; ++i) {
    const DataSet data =
        make_data_set(MatrixXd::Constant(400, 1, u[i]), MatrixXd::Zero(400, 1), 0.5, {{"u", ""}}, {{"y", ""}});
    EXPECT_NEAR(free_run(printed_model(data), data)[0](399, 0), expected[i], 2e-5);
  }
}

TEST(PrintedNetwork, FollowsTheSystemOnDataOfItsRange) {
  const DataSet data = first_order_data(1000, 5, 41);
  const NarxModel model = printed_model(data);
  EXPECT_NEAR(rms(one_step(model, data)[0], data.experiments[0].y, 1), 0.022, 0.005);
  EXPECT_NEAR(rms(free_run(model, data)[0], data.experiments[0].y, 1), 0.04, 0.012);
}

TEST(ModelFile, OfANetworkComesBackWithTheSameBits) {
  const DataSet data = first_order_data(100, 4, 42);
  MlpOptions options;
  options.hidden = {4, 2};
  options.starts = 2;
  options.training.iterations = 20;
  const NarxModel model = fit_narx_mlp(data, parse_regressors("y(k-1), u(k-1)", data), {}, options).model;
  const std::string text = to_yaml(model);
  const NarxModel back = read_narx(read_model_file(text, "net.yaml"));
  EXPECT_EQ(to_yaml(back), text);
  EXPECT_EQ(free_run(back, data)[0], free_run(model, data)[0]);
  EXPECT_EQ(back.channels.Ts, 0.5);
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

TEST(ModelFileErrors, AreInTheUsersWords) {
  const std::string head =
      "plantloop_model: 1\ntype: mlp\ndata:\n  Ts: 0.5\n  inputs:\n    - name: u\n  outputs:\n    - name: \"y\"\n";
  const auto read = [&](const std::string& rest) {
    return complaint([&] { read_narx(read_model_file(head + rest, "net.yaml")); });
  };
  EXPECT_EQ(read("regressors: \"y(k-1)\"\nlayers:\n  - activation: relu\n    weights:\n      - [1, 2]\n"),
            "net.yaml:11:17: there is no activation 'relu'; there are sigmoid, tanh, linear, gaussian, signum");
  EXPECT_EQ(read("regressors: \"y(k-1)\"\nlayers:\n  - activation: tanh\n    weights:\n      - [1, 2, 3]\n"),
            "net.yaml:9:13: there are 1 regressors, but the map has 2 inputs");
  EXPECT_EQ(complaint([] { read_narx(read_model_file("plantloop_model: 1\ntype: tree\n", "net.yaml")); }).substr(0, 60),
            "net.yaml:2:7: a model of type 'tree' is no learned map; ther");
  EXPECT_EQ(read("regressors: \"y(k-1)\"\nx_scaling:\n  offset: [0]\n  scale: [0]\nlayers:\n  - activation: tanh\n    "
                 "weights:\n      - [1, 2]\n"),
            "net.yaml:11:3: offsets must be finite and scales greater than 0");
}

TEST(ModelFile, KeepsDirectConnections) {
  const DataSet data = first_order_data(60, 3, 71);
  Network network = make_network(2, {3}, 1, Activation::tanh, Activation::linear, true);
  Random random(72);
  randomise(network, 0.7, random);
  const NarxModel model = make_narx(std::make_shared<Mlp>(network, no_scaling(2), no_scaling(1)),
                                    parse_regressors("y(k-1), u(k-1)", data), data);
  const std::string text = to_yaml(model);
  const NarxModel back = read_narx(read_model_file(text, "net.yaml"));
  EXPECT_EQ(to_yaml(back), text);
  EXPECT_EQ(free_run(back, data)[0], free_run(model, data)[0]);
}

TEST(NetworkErrors, AreInTheUsersWords) {
  EXPECT_EQ(complaint([] { make_network(2, {3}, 1, Activation::tanh, Activation::tanh, true); }),
            "direct connections need linear outputs, those of this network are tanh");
  EXPECT_EQ(complaint([] { find_activation("relu"); }),
            "there is no activation 'relu'; there are sigmoid, tanh, linear, gaussian, signum");
  EXPECT_EQ(complaint([] { make_network(2, {0}, 1, Activation::tanh); }),
            "a hidden layer of 0 neurons; there must be at least one");
  MlpOptions options;
  options.activation = Activation::signum;
  EXPECT_EQ(complaint([&] { fit_mlp(MatrixXd::Ones(3, 1), MatrixXd::Ones(3, 1), options); }),
            "a network of signum neurons has no gradient to follow; train it by the perceptron rule, or choose sigmoid "
            "or tanh");
}

}  // namespace
}  // namespace plantloop::identify
