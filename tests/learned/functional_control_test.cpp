// Predictive functional control against implementations of its own: a scan with bisection on the printed network, and
// closed forms on a linear model.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

double plant(double y, double u) { return y - 0.5 * std::tanh(y + u * u * u); }

// The network whose weights the book prints; the columns are of y, u and 1.
double network(double y, double u) {
  constexpr std::array<std::array<double, 3>, 5> W1{{{-0.5588, -2.0621, -1.953},
                                                     {0.5155, 0.0499, -0.867},
                                                     {-1.5149, 0.319, 0.4768},
                                                     {0.3366, -1.2029, 1.8379},
                                                     {0.8411, 1.3841, 1.7123}}};
  constexpr std::array<double, 6> W2{1.2054, 1.7784, 0.081, 1.1704, 1.4048, -0.058};
  double sum = W2[5];
  for (std::size_t i = 0; i < W1.size(); ++i) sum += W2[i] * std::tanh(W1[i][0] * y + W1[i][1] * u + W1[i][2]);
  return sum;
}

// The zero of f that is least in magnitude, by a scan of 401 points and bisection; else the point of the least |f|.
double least_zero(const std::function<double(double)>& f, double lower, double upper) {
  constexpr int points = 400;
  double best = lower, least = std::abs(f(lower)), found = INFINITY;
  for (int i = 0; i < points; ++i) {
    double a = lower + (upper - lower) * i / points, b = lower + (upper - lower) * (i + 1) / points;
    const double fa = f(a), fb = f(b);
    if (std::abs(fb) < least) {
      least = std::abs(fb);
      best = b;
    }
    if ((fa < 0) == (fb < 0)) continue;
    while (b - a > 1e-13) {
      const double middle = 0.5 * (a + b);
      ((f(middle) < 0) == (fa < 0) ? a : b) = middle;
    }
    if (std::abs(a) < std::abs(found)) found = a;
  }
  return std::isinf(found) ? best : found;
}

struct Loop {
  bool correction = true, from_reference = false;
  int horizon = 8;
  double lambda = std::exp(-0.1);
};

std::vector<double> outputs_of_loop(const Loop& how, const std::vector<double>& levels, int hold) {
  double y = 0, model = 0, r = 0;
  std::vector<double> outputs;
  for (const double w : levels) {
    for (int k = 0; k < hold; ++k) {
      const double e = how.correction ? y - model : 0, base = how.from_reference ? r : y;
      const double target = w - std::pow(how.lambda, how.horizon) * (w - base);
      const auto miss = [&](double u) {
        double x = how.correction ? model : y;
        for (int j = 0; j < how.horizon; ++j) x = network(x, u);
        return x + e - target;
      };
      const double u = least_zero(miss, -1.5, 1.5);
      outputs.push_back(y);
      model = network(model, u);
      y = plant(y, u);
      r = w - how.lambda * (w - r);
    }
  }
  return outputs;
}

const std::string model = "model: diagrams/book/models/first_order_mlp.yaml, lower: -1.5, upper: 1.5";

std::vector<double> outputs_of_block(const std::string& how) {
  return run("blocks:\n"
             "  w: {type: staircase, times: [0, 10, 20, 30, 40], values: [0.3, -0.8, 1.1, 1.9, -0.2], rate: 0.5}\n"
             "  c: {type: pfc, " +
             model + ", in: {w: w, y: y}" + how +
             "}\n"
             "  y: {type: unit_delay, in: y - 0.5*tanh(y + c.u^3), rate: 0.5}\n"
             "simulation: {stop: 49.5}\nrecord: [y]\n")
      .samples("y");
}

void expect_same(const std::string& block, const Loop& loop) {
  SCOPED_TRACE(block);
  const std::vector<double> found = outputs_of_block(block),
                            wanted = outputs_of_loop(loop, {0.3, -0.8, 1.1, 1.9, -0.2}, 20);
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], wanted[k], 1e-7) << k;
}

TEST(Pfc, ControlsAsAnImplementationOfItsOwnDoes) {
  expect_same("", {});
  expect_same(", correction: false", {.correction = false});
  expect_same(", start: reference", {.from_reference = true});
  expect_same(", horizon: 3, lambda: 0.7", {.horizon = 3, .lambda = 0.7});
}

// y(k) = 0.8 y(k-1) + 0.2 u(k-1), of the test's model file.
const std::string linear = "  c: {type: pfc, model: tests/blocks/models/narx.yaml, in: {w: w, y: y}, correction: false";

Signals linear_loop(const std::string& how, const std::string& set_point = "1") {
  return run("blocks:\n  w: " + set_point + "\n" + linear + how +
             "}\n  y: {type: unit_delay, in: 0.8*y + 0.2*c.u, rate: 0.1}\nsimulation: {stop: 1}\n"
             "record: [y, c.u, c.status]\n");
}

TEST(Pfc, MeetsTheReferenceOfALinearModelInClosedForm) {
  // 0.8^h y + (1 - 0.8^h) u = w - lambda^h (w - y).
  const Signals r = linear_loop(", horizon: 5, lambda: 0.5");
  const std::vector<double> y = r.samples("y"), u = r.samples("c.u");
  const double a = std::pow(0.8, 5), l = std::pow(0.5, 5);
  for (std::size_t k = 0; k < y.size(); ++k) EXPECT_NEAR(u[k], (1 - l * (1 - y[k]) - a * y[k]) / (1 - a), 1e-10) << k;
}

TEST(Pfc, RampsTheInputToMeetTwoPoints) {
  // y(k+h) = 0.8^h y + sum_j 0.2 0.8^(h-1-j) (c1 + c2 j): two equations for c1 and c2.
  const Signals r = linear_loop(", horizon: 6, coincidence: [2, 6], basis: 2, lambda: 0.6");
  const std::vector<double> y = r.samples("y"), u = r.samples("c.u");
  const auto weights = [](int h) {
    std::array<double, 2> sum{};
    for (int j = 0; j < h; ++j) {
      sum[0] += 0.2 * std::pow(0.8, h - 1 - j);
      sum[1] += 0.2 * std::pow(0.8, h - 1 - j) * j;
    }
    return sum;
  };
  const auto a = weights(2), b = weights(6);
  for (std::size_t k = 0; k < y.size(); ++k) {
    const double p = 1 - std::pow(0.6, 2) * (1 - y[k]) - std::pow(0.8, 2) * y[k];
    const double q = 1 - std::pow(0.6, 6) * (1 - y[k]) - std::pow(0.8, 6) * y[k];
    EXPECT_NEAR(u[k], (p * b[1] - q * a[1]) / (a[0] * b[1] - a[1] * b[0]), 1e-7) << k;
  }
}

TEST(Pfc, LooksAheadWhereTheSetPointIsKnown) {
  // With lambda 0 and one sample of horizon the output is where the set point will be.
  const Signals r =
      run("blocks:\n  now: sin(10*time)\n  soon: sin(10*(time + 0.1))\n" +
          std::string("  c: {type: pfc, model: tests/blocks/models/narx.yaml, in: {w: [now, soon], y: y}, horizon: 1, "
                      "lambda: 0}\n") +
          "  y: {type: unit_delay, in: 0.8*y + 0.2*c.u, rate: 0.1}\nsimulation: {stop: 1}\nrecord: [y]\n");
  const std::vector<double> y = r.samples("y");
  for (std::size_t k = 1; k < y.size(); ++k) EXPECT_NEAR(y[k], std::sin(static_cast<double>(k)), 1e-9) << k;
}

TEST(Pfc, KeepsTheLimitsOfTheInputAndOfItsRateAndSaysSo) {
  const Signals limited = linear_loop(", horizon: 1, lambda: 0, upper: 1.6, max_rate: 5");
  const std::vector<double> u = limited.samples("c.u"), status = limited.samples("c.status");
  for (std::size_t k = 0; k < 3; ++k) EXPECT_DOUBLE_EQ(u[k], 0.5 * static_cast<double>(k + 1));
  EXPECT_DOUBLE_EQ(u[3], 1.6);
  EXPECT_DOUBLE_EQ(u[4], 1.6);
  EXPECT_EQ(status[0], 1);
  EXPECT_EQ(status.back(), 0);
}

TEST(Pfc, RemovesAnOffsetByItsCorrection) {
  const std::string loop = "blocks:\n  c: {type: pfc, model: tests/blocks/models/narx.yaml, in: {w: 1, y: y}";
  const std::string rest =
      "}\n  y: {type: unit_delay, in: 0.7*y + 0.2*c.u + 0.15, rate: 0.1}\nsimulation: {stop: 60}\nrecord: [y]\n";
  EXPECT_NEAR(run(loop + rest).samples("y").back(), 1, 1e-9);
  EXPECT_GT(std::abs(run(loop + ", correction: false" + rest).samples("y").back() - 1), 0.01);
}

TEST(Pfc, SaysWhatDoesNotFit) {
  const std::string begin = "blocks:\n  c: {type: pfc, model: tests/blocks/models/narx.yaml, in: {w: 1, y: 0}";
  const std::string end = "}\nsimulation: {stop: 1}\n";
  EXPECT_THAT(findings(begin + ", max_variance: 1" + end),
              HasSubstr("only a Gaussian process knows how uncertain it is, this is 'mlp'"));
  EXPECT_THAT(findings(begin + ", basis: 2" + end),
              HasSubstr("2 coefficients need as many coincidence points, but there is 1"));
  EXPECT_THAT(findings(begin + ", coincidence: [2, 9]" + end), HasSubstr("the point 9 lies beyond the horizon, 8"));
  EXPECT_THAT(findings(begin + ", coincidence: 2.5" + end), HasSubstr("the points are whole numbers of samples"));
  EXPECT_THAT(
      findings("blocks:\n  c: {type: pfc, model: tests/blocks/models/narx.yaml, in: {w: [1, 2, 3], y: 0}" + end),
      HasSubstr("the set point is one number, or 9: now and at the 8 samples of the horizon"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
