// What training follows, J'J and J'e, against complex steps: static targets, free runs, models of the noise.
//
// The network, its regressors and the recursions are written anew on complex numbers (J. Lyness, C. Moler 1967), so
// that J is exact to rounding.

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "identify/mlp/noise_training.h"
#include "identify/mlp/problems.h"
#include "tests/identify/mlp/complex_network.h"
#include "tests/identify/mlp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

TEST(ComplexStep, ConfirmsStaticTraining) {
  Random random(11);
  MatrixXd x(25, 3), y(25, 2);
  for (double& each : x.reshaped()) each = random.uniform(-1, 1);
  for (double& each : y.reshaped()) each = random.uniform(-1, 1);
  for (const Activation activation : {Activation::sigmoid, Activation::tanh, Activation::linear, Activation::gaussian})
    for (const bool direct : {false, true})
      for (const std::vector<int>& hidden : {std::vector<int>{4}, {5, 3}, {3, 4, 2}}) {
        Network network = make_network(3, hidden, 2, activation, Activation::linear, direct);
        randomise(network, 0.9, random);
        const auto outputs = [&](const VectorXcd& theta) {
          VectorXcd all(50);
          for (Index k = 0; k < 25; ++k)
            all.segment(2 * k, 2) = complex_output(network, theta, VectorXd(x.row(k).transpose()).cast<Complex>());
          return all;
        };
        const VectorXd theta = network.theta();
        const VectorXd e = VectorXd(MatrixXd(y.transpose()).reshaped()) - outputs(theta.cast<Complex>()).real();
        expect_normal(StaticTraining(network, x, y), theta, complex_step(theta, outputs), e, name_of(activation));
      }
}

DataSet two_outputs(Index samples) {
  const DataSet a = first_order_data(60, 3, 61), b = first_order_data(60, 5, 62);
  MatrixXd u(60, 2), y(60, 2);
  u << a.experiments[0].u, b.experiments[0].u;
  y << a.experiments[0].y + 0.3 * b.experiments[0].y, b.experiments[0].y;
  return make_data_set(u.topRows(samples), y.topRows(samples), 0.5, {{"u1", ""}, {"u2", ""}}, {{"y1", ""}, {"y2", ""}});
}

// One experiment: what is predicted from the first sample with a whole past on, as a column of all outputs, each over
// its scale. Inputs from data_inputs() on are the errors.
struct ComplexRun {
  const Network& network;
  const RegressorSet& set;
  const Experiment& experiment;
  Scaling x, y;
  NoiseOrders orders;
  bool feed_back = false;

  VectorXcd operator()(const VectorXcd& theta) const {
    const Index samples = experiment.samples(), outputs = network.outputs(), first = set.longest_lag();
    const auto filters = static_cast<Index>(orders.nc + orders.nd);
    const Index weights = theta.size() - filters * outputs;
    MatrixXcd past_y = experiment.y.cast<Complex>(), s = MatrixXcd::Zero(samples, outputs), e = s;
    VectorXcd predicted((samples - first) * outputs);
    for (Index k = first; k < samples; ++k) {
      VectorXcd row(set.size());
      for (Index i = 0; i < row.size(); ++i) {
        Complex product = 1;
        for (const Factor& f : set.list[static_cast<std::size_t>(i)].factors) {
          const Index at = k - f.lag;
          const Complex value = f.of_output       ? past_y(at, f.channel)
                                : set.is_error(f) ? e(at, f.channel - set.data_inputs())
                                                  : Complex(experiment.u(at, f.channel));
          for (int p = 0; p < f.power; ++p) product *= value;
        }
        row[i] = (product - x.offset[i]) / x.scale[i];
      }
      const VectorXcd out = complex_output(network, theta.head(weights), row);
      for (Index o = 0; o < outputs; ++o) {
        const Complex map = y.offset[o] + y.scale[o] * out[o];
        s(k, o) = experiment.y(k, o) - map;
        e(k, o) = s(k, o);
        for (int i = 1; i <= orders.nc && i <= k; ++i) e(k, o) -= theta[weights + o * filters + i - 1] * e(k - i, o);
        for (int i = 1; i <= orders.nd && i <= k; ++i)
          e(k, o) += theta[weights + o * filters + orders.nc + i - 1] * s(k - i, o);
        if (feed_back) past_y(k, o) = map;
        predicted[(k - first) * outputs + o] = (experiment.y(k, o) - e(k, o)) / y.scale[o];
      }
    }
    return predicted;
  }
  VectorXd errors(const VectorXd& theta) const {
    const Index first = set.longest_lag();
    VectorXd e = -(*this)(theta.cast<Complex>()).real();
    for (Index i = 0; i < e.size(); ++i) {
      const Index o = i % network.outputs();
      e[i] += experiment.y(first + i / network.outputs(), o) / y.scale[o];
    }
    return e;
  }
};

TEST(ComplexStep, ConfirmsTrainingThroughTime) {
  const DataSet data = two_outputs(60);
  for (const char* text : {"y1(k-1), y2(k-1), u1(k-1), u2(k-2)",
                           "y1(k-1..2), y2(k-3), y1(k-1)*u1(k-1), y2(k-1)^2, u2(k-1)", "u1(k-1..2), u2(k-1)"})
    for (const Activation activation : {Activation::sigmoid, Activation::tanh, Activation::gaussian})
      for (const bool direct : {false, true}) {
        const RegressorSet set = parse_regressors(text, data);
        Network network = make_network(static_cast<int>(set.size()), {4, 3}, 2, activation, Activation::linear, direct);
        Random random(63);
        randomise(network, 0.4, random);
        const Regression rows = make_regression(data, set);
        const ComplexRun run{network, set, data.experiments[0], standard_scaling(rows.X), standard_scaling(rows.Y),
                             {},      true};
        const VectorXd theta = network.theta();
        expect_normal(SimulationTraining(network, run.x, run.y, set, data), theta, complex_step(theta, run),
                      run.errors(theta), text);
      }
}

struct NoiseCase {
  const char* text;
  NoiseOrders orders;
};

TEST(ComplexStep, ConfirmsTrainingWithAModelOfTheNoise) {
  const DataSet data = two_outputs(60);
  for (const NoiseCase& c : {NoiseCase{"y1(k-1), y2(k-1), u1(k-1), u2(k-2), e1(k-1), e2(k-2)", {0, 0, false}},
                             {"y1(k-1..2), u1(k-1), y2(k-1)*e1(k-1), e2(k-1)^2, u2(k-1)", {1, 0, false}},
                             {"y1(k-1), y2(k-1), u1(k-1), u2(k-1)", {2, 0, false}},
                             {"y1(k-1), y2(k-2), u1(k-1), u2(k-1)", {2, 1, true}}}) {
    const RegressorSet set = parse_regressors(c.text, data);
    Network network = make_network(static_cast<int>(set.size()), {4}, 2, Activation::tanh);
    Random random(63);
    randomise(network, 0.4, random);
    const ComplexRun run{network,
                         set,
                         data.experiments[0],
                         no_scaling(set.size()),
                         standard_scaling(data.experiments[0].y),
                         c.orders,
                         c.orders.simulated};
    const NoiseTraining training(network, run.x, run.y, set, data, c.orders);
    VectorXd theta(training.parameters());
    theta.setConstant(0.3);
    theta.head(network.parameters()) = network.theta();
    const MatrixXd J = complex_step(theta, run);
    const VectorXd e = run.errors(theta);
    expect_normal(training, theta, J, e, c.text);
    const Index filters = theta.size() - network.parameters();
    const MatrixXd covariance = training.covariance(theta, VectorXd::Constant(theta.size(), 0.1));
    ASSERT_EQ(covariance.rows(), filters);
    if (filters == 0) continue;
    // The sandwich, with the effective parameters of the decay 0.1.
    const MatrixXd R = J.transpose() * J;
    const MatrixXd H = (R + 0.1 * MatrixXd::Identity(theta.size(), theta.size())).inverse();
    const MatrixXd E = e.reshaped(2, e.size() / 2).transpose();
    const MatrixXd S = E.transpose() * E / (static_cast<double>(E.rows()) - (H * R).trace() / 2);
    MatrixXd middle = MatrixXd::Zero(theta.size(), theta.size());
    for (Index k = 0; k < E.rows(); ++k) {
      const MatrixXd own = J.middleRows(2 * k, 2);
      middle += own.transpose() * S * own;
    }
    const MatrixXd expected = (H * middle * H).bottomRightCorner(filters, filters);
    EXPECT_LT((covariance - expected).norm(), 1e-8 * expected.norm()) << c.text;
  }
}

}  // namespace
}  // namespace plantloop::identify
