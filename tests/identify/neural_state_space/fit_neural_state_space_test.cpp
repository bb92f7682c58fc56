// Neural state-space models from data: a linear system exactly, a speed without its sign, a position, several outputs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "identify/model_file/model_file.h"
#include "identify/neural_state_space/fit_neural_state_space.h"
#include "identify/random.h"
#include "identify/validation/metrics.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

// Levels that are held for a while.
VectorXd levels(Index samples, double greatest, std::uint64_t seed) {
  Random random(seed);
  VectorXd u(samples);
  double level = 0;
  Index left = 0;
  for (double& value : u) {
    if (left-- == 0) {
      level = random.uniform(-greatest, greatest);
      left = static_cast<Index>(random.index(12)) + 3;
    }
    value = level;
  }
  return u;
}

// Root mean square of the free run's error from sample 20 on, the first state estimated from those before.
double error_of(const NeuralStateSpace& m, const DataSet& data) {
  const MatrixXd e = data.experiments[0].y - simulate(m, data, StateStart::estimated, 20)[0];
  return std::sqrt(e.bottomRows(e.rows() - 20).squaredNorm() / static_cast<double>(e.size() - 20 * e.cols()));
}

// A second-order system that begins in motion, with an offset that no mean of the record shows: all of it is found.
TEST(FitNeuralStateSpace, FindsALinearSystemWithItsOffsetAndItsFirstState) {
  const auto make = [](Index samples, std::uint64_t seed) {
    const VectorXd u = levels(samples, 1, seed);
    VectorXd y(samples);
    double x1 = 2, x2 = -1;
    for (Index k = 0; k < samples; ++k) {
      y[k] = 5 + x1;
      const double next = 1.6 * x1 + x2 + 0.3 * u[k];
      x2 = -0.8 * x1 + 0.1 * u[k];
      x1 = next;
    }
    return make_data_set(u, y, 0.1);
  };
  const NeuralStateSpace m = fit_neural_state_space(make(150, 1), {.order = 2, .hidden = {}, .decay = 0});
  EXPECT_LT(error_of(m, make(150, 2)), 1e-4);
  EXPECT_LT(m.deviations[0], 1e-4);
  EXPECT_THAT(to_text(m.fit), HasSubstr("tried: "));
}

// y = |speed|, of a driven mass on a spring: what no model of past outputs sees, the sign, is in the state.
TEST(FitNeuralStateSpace, SeesThroughAnOutputWithoutItsSign) {
  const auto make = [](Index samples, std::uint64_t seed) {
    const VectorXd u = levels(samples, 1, seed);
    Random random(seed + 10);
    VectorXd y(samples);
    double x1 = 0, x2 = 0;
    for (Index k = 0; k < samples; ++k) {
      y[k] = std::fabs(x1) + 0.01 * random.normal();
      const double next = 0.9 * x1 - 0.25 * x2 + 0.2 * u[k];
      x2 = 0.9 * x2 + 0.25 * x1 + 0.1 * u[k];
      x1 = next;
    }
    return make_data_set(u, y, 0.1);
  };
  const DataSet test = make(300, 4);
  const NeuralStateSpace m = fit_neural_state_space(make(400, 3), {.order = 2,
                                                                   .hidden = {},
                                                                   .output_hidden = {6},
                                                                   .projections = 1,
                                                                   .decay = 1e-3,
                                                                   .iterations = 200,
                                                                   .starts = 24,
                                                                   .refined = 6});
  const VectorXd y = test.experiments[0].y.col(0);
  const double deviation = std::sqrt((y.array() - y.mean()).square().mean());
  EXPECT_LT(error_of(m, test), 0.12 * deviation);
}

// A position that is driven by a speed with friction: the free run stays on it, and the last state is the position.
TEST(FitNeuralStateSpace, IntegratesAPosition) {
  const auto make = [](Index samples, std::uint64_t seed) {
    Random random(seed);
    VectorXd u(samples), y(samples);
    double position = 0, speed = 0, aim = 0;
    for (Index k = 0; k < samples; ++k) {
      if (k % 25 == 0) aim = random.uniform(-1, 1);
      u[k] = std::clamp(2 * (aim - position) - speed, -1.0, 1.0);
      y[k] = position + 0.002 * random.normal();
      position += 0.1 * speed;
      speed += 0.1 * (4 * u[k] - speed - 0.8 * std::tanh(20 * speed));
    }
    return make_data_set(u, y, 0.1);
  };
  const NeuralStateSpace m = fit_neural_state_space(
      make(600, 5), {.order = 2, .hidden = {4}, .integrating = true, .decay = 1e-3, .iterations = 150});
  EXPECT_LT(error_of(m, make(600, 6)), 0.06);
  // Nothing but the output's next value depends on the output.
  const Network& f = m.transition->network();
  EXPECT_EQ(f.layers[0].w.col(1), VectorXd::Zero(4));
  EXPECT_EQ(f.direct.col(1), VectorXd(Eigen::Vector2d(0, 1)));
  // Training on keeps that.
  const NeuralStateSpace on = refine(m, make(600, 6), {.iterations = 5});
  EXPECT_EQ(on.transition->network().direct.col(1), VectorXd(Eigen::Vector2d(0, 1)));
  EXPECT_EQ(on.transition->network().layers[0].w.col(1), VectorXd::Zero(4));
}

DataSet two_by_two(Index samples, std::uint64_t seed) {
  MatrixXd u(samples, 2), y(samples, 2);
  u << levels(samples, 1, seed), levels(samples, 1, seed + 1);
  double a = 0, b = 0;
  for (Index k = 0; k < samples; ++k) {
    y.row(k) << 10 * a, b * 1e-3;
    const double next = 0.8 * a + 0.2 * std::tanh(2 * u(k, 0)) - 0.1 * b;
    b = 0.7 * b + 0.3 * u(k, 1) * u(k, 0) + 0.1 * a;
    a = next;
  }
  return make_data_set(u, y, 1);
}

TEST(FitNeuralStateSpace, TakesSeveralInputsAndOutputsAndMissingOnes) {
  DataSet data = two_by_two(400, 7);
  for (Index k = 5; k < 400; k += 11) data.experiments[0].y(k, k % 2) = std::nan("");
  data.experiments[0].y.topLeftCorner(3, 1).setConstant(std::nan(""));
  data.experiments[0].y.bottomRows(2).setConstant(std::nan(""));
  const NeuralStateSpace m =
      fit_neural_state_space(data, {.order = 2, .hidden = {8}, .decay = 1e-5, .iterations = 150});
  const DataSet test = two_by_two(300, 17);
  const MatrixXd e = test.experiments[0].y - simulate(m, test, StateStart::estimated, 20)[0];
  for (Index o = 0; o < 2; ++o) {
    const VectorXd y = test.experiments[0].y.col(o);
    EXPECT_LT(std::sqrt(e.col(o).tail(280).squaredNorm() / 280),
              0.1 * std::sqrt((y.array() - y.mean()).square().mean()));
  }
}

TEST(FitNeuralStateSpace, DoesNotDependOnThreadsAndTrainsOn) {
  const DataSet data = two_by_two(150, 9);
  std::string first;
  for (const int threads : {1, 2, 3}) {
    const NeuralStateSpace m = fit_neural_state_space(
        data, {.order = 2, .hidden = {3}, .output_hidden = {2}, .iterations = 10, .threads = threads});
    const std::string text = to_yaml("neural_state_space", to_item(m));
    if (first.empty()) first = text;
    EXPECT_EQ(text, first) << threads;
  }
  const NeuralStateSpace m = neural_state_space_of(read_model_file(first, "m.yaml"));
  const NeuralStateSpace on = refine(m, data, {.iterations = 60});
  EXPECT_LT(on.fit.reached, m.fit.reached);
}

TEST(FitNeuralStateSpace, CanBeStopped) {
  std::atomic<bool> cancel{true};
  EXPECT_THROW(fit_neural_state_space(two_by_two(150, 9), {}, {.cancel = &cancel}), Cancelled);
}

}  // namespace
}  // namespace plantloop::identify
