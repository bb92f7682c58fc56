// Predictions against simulations of the library, and their derivatives against differences.

#include "learned/predictor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "control/load_predictor.h"

namespace plantloop {
namespace {

std::shared_ptr<const Predictor> load(const std::string& file) {
  const LoadedPredictor loaded = load_predictor({.path = file, .inputs = {"u"}, .outputs = {"y"}, .Ts = 0.4});
  EXPECT_TRUE(loaded.predictor) << loaded.error;
  return loaded.predictor;
}

std::vector<double> predict(const Predictor& p, const std::vector<double>& state, const std::vector<double>& u) {
  const int horizon = static_cast<int>(u.size()) / p.inputs();
  std::vector<double> room(p.room(horizon, 0)), signals(static_cast<std::size_t>(horizon * p.signals()));
  p.predict(state.data(), u.data(), horizon, true, signals.data(), room.data());
  return signals;
}

std::vector<double> some(int count, double scale) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(scale * std::sin(1.3 * i + 0.4));
  return values;
}

void expect_exact_derivatives(const std::string& file) {
  SCOPED_TRACE(file);
  const auto p = load(file);
  if (!p) return;
  constexpr int horizon = 6;
  const std::vector<double> state = some(p->prediction_size(), 0.3);
  std::vector<double> u = some(horizon * p->inputs(), 0.5);
  const int variables = horizon * p->inputs();
  std::vector<double> room(p->room(horizon, variables)), signals(static_cast<std::size_t>(horizon * p->signals()));
  std::vector<double> by(static_cast<std::size_t>(variables * variables), 0.0), J(signals.size() * u.size());
  for (int i = 0; i < variables; ++i) by[static_cast<std::size_t>(i * variables + i)] = 1;
  p->predict(state.data(), u.data(), horizon, true, signals.data(), room.data());
  p->sensitivities(u.data(), horizon, true, by.data(), variables, J.data(), room.data());
  double greatest = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double h = 1e-5, at = u[i];
    u[i] = at + h;
    const std::vector<double> above = predict(*p, state, u);
    u[i] = at - h;
    const std::vector<double> below = predict(*p, state, u);
    u[i] = at;
    for (std::size_t s = 0; s < signals.size(); ++s) {
      const double difference = (above[s] - below[s]) / (2 * h);
      greatest = std::max(greatest, std::abs(difference));
      EXPECT_NEAR(J[s * u.size() + i], difference, 1e-7 * (1 + std::abs(difference))) << s << " by " << i;
    }
  }
  EXPECT_GT(greatest, 1e-3);
}

TEST(Predictor, DerivativesAreExact) {
  expect_exact_derivatives("diagrams/book/models/first_order_mlp.yaml");
  expect_exact_derivatives("diagrams/book/models/first_order_gp.yaml");
  expect_exact_derivatives("tests/control/models/two_by_two.yaml");
  expect_exact_derivatives("tests/control/models/products.yaml");
  expect_exact_derivatives("tests/control/models/tanks.yaml");
  expect_exact_derivatives("tests/control/models/reactor.yaml");
  expect_exact_derivatives("tests/control/models/sampled.yaml");
  expect_exact_derivatives("tests/control/models/balance.yaml");
}

// A prediction is the model advanced sample by sample.
TEST(Predictor, PredictsWhatAdvancingGives) {
  for (const std::string file :
       {"diagrams/book/models/first_order_gp.yaml", "tests/control/models/two_by_two.yaml",
        "tests/control/models/products.yaml", "tests/control/models/tanks.yaml", "tests/control/models/reactor.yaml",
        "tests/control/models/sampled.yaml", "tests/control/models/balance.yaml"}) {
    SCOPED_TRACE(file);
    const auto p = load(file);
    ASSERT_TRUE(p);
    constexpr int horizon = 7;
    std::vector<double> state = some(p->state_size(), 0.2), next = state;
    state.resize(static_cast<std::size_t>(p->prediction_size()), 0.0);  // no disturbance
    next = state;
    const std::vector<double> u = some(horizon * p->inputs(), 0.4), signals = predict(*p, state, u);
    std::vector<double> room(p->room(horizon, 1)), y(static_cast<std::size_t>(p->outputs()));
    for (int j = 0; j < horizon; ++j) {
      p->advance(state.data(), u.data() + j * p->inputs(), next.data(), room.data());
      state.swap(next);
      p->output(state.data(), y.data(), room.data());
      for (int o = 0; o < p->outputs(); ++o)
        EXPECT_NEAR(y[static_cast<std::size_t>(o)], signals[static_cast<std::size_t>(j * p->signals() + o)], 1e-12)
            << j;
    }
  }
}

TEST(Predictor, KnowsDeadTimeAndLinearity) {
  const auto tanks = load("tests/control/models/tanks.yaml"), products = load("tests/control/models/products.yaml");
  EXPECT_TRUE(tanks->is_linear());
  EXPECT_EQ(tanks->dead_samples(0), 1);  // the second tank
  EXPECT_EQ(tanks->dead_samples(1), 0);  // the state of the first one
  EXPECT_FALSE(products->is_linear());
  EXPECT_EQ(products->dead_samples(0), 1);  // u(k-2)
  EXPECT_TRUE(load("tests/control/models/two_by_two.yaml")->is_linear());
  EXPECT_FALSE(load("diagrams/book/models/first_order_mlp.yaml")->is_linear());
}

TEST(Predictor, KnowsWhichDiagramIsLinear) {
  const auto is_linear = [](const std::string& file, const std::string& output) {
    const LoadedPredictor loaded =
        load_predictor({.path = "tests/control/models/" + file, .inputs = {"u"}, .outputs = {output}, .Ts = 0.4});
    EXPECT_TRUE(loaded.predictor) << loaded.error;
    return loaded.predictor && loaded.predictor->is_linear();
  };
  EXPECT_TRUE(is_linear("affine.yaml", "y"));
  EXPECT_TRUE(is_linear("affine_continuous.yaml", "y"));
  EXPECT_FALSE(is_linear("stepped.yaml", "x"));
  EXPECT_FALSE(is_linear("sampled.yaml", "y"));
}

}  // namespace
}  // namespace plantloop
