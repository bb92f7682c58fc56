// Predictive control against closed forms, and against searches that know nothing of derivatives.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

// A compass search from several points: slow, and sure for a handful of numbers.
struct Found {
  std::vector<double> x;
  double cost;
};
Found least(const std::function<double(const std::vector<double>&)>& cost, const std::vector<double>& lower,
            const std::vector<double>& upper, int grid = 5, double finest = 1e-9) {
  const std::size_t n = lower.size();
  Found best{lower, INFINITY};
  std::vector<int> at(n, 0);
  for (bool more = true; more;) {
    std::vector<double> x(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = lower[i] + (upper[i] - lower[i]) * (at[i] + 0.5) / grid;
    double now = cost(x), step = 0.5;
    while (step > finest) {
      bool better = false;
      for (std::size_t i = 0; i < n && !better; ++i) {
        for (const double sign : {1.0, -1.0}) {
          std::vector<double> tried = x;
          tried[i] = std::clamp(x[i] + sign * step * (upper[i] - lower[i]), lower[i], upper[i]);
          if (const double then = cost(tried); then < now) {
            x = tried;
            now = then;
            better = true;
            break;
          }
        }
      }
      if (!better) step /= 2;
    }
    if (now < best.cost) best = {x, now};
    more = false;
    for (std::size_t i = 0; i < n && !more; ++i) {
      at[i] = (at[i] + 1) % grid;
      more = at[i] != 0;
    }
  }
  return best;
}

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

// --- the linear case ------------------------------------------------------------------------------------------------

// x+ = A x + B (u - 0.5), y = 1 + x2: the model file tanks.yaml, with a plant that is a little different.
TEST(Nmpc, IsTheClosedFormOfALinearModelWithoutLimits) {
  constexpr int N1 = 2, N2 = 9, Nu = 3;
  const double alpha = 2.5, beta = 0.3, w = 1.8, lambda = 0.6;
  const Signals r =
      run("blocks:\n"
          "  c: {type: nmpc, model: tests/control/models/tanks.yaml, in: {w: 1.8, y: y}, minimum_horizon: 2, horizon: "
          "9, control_horizon: 3, "
          "output_weight: 2.5, move_weight: 0.3, lambda: 0.6, initial_u: 0.5}\n"
          "  a: {type: unit_delay, in: 0.82*a + 0.2*(c.u - 0.5), rate: 0.1}\n"
          "  b: {type: unit_delay, in: 0.9*b + 0.11*a, rate: 0.1}\n"
          "  y: 1 + b + 0.02\nsimulation: {stop: 4}\nrecord: [y, c.u, c.cost, c.status]\n");
  const std::vector<double> y = r.samples("y"), u = r.samples("c.u"), cost = r.samples("c.cost");
  MatrixXd A(2, 2), B(2, 1);
  A << 0.8, 0, 0.1, 0.9;
  B << 0.2, 0;
  VectorXd x = VectorXd::Zero(2);
  double before = 0.5;
  for (std::size_t k = 0; k < u.size(); ++k) {
    // y = free + G v for the moves v.
    constexpr int rows = N2 - N1 + 1;
    MatrixXd G(rows, Nu);
    VectorXd miss(rows);
    const double e = y[k] - (1 + x[1]);
    for (int column = -1; column < Nu; ++column) {
      VectorXd z = column < 0 ? x : VectorXd::Zero(2);
      for (int j = 1; j <= N2; ++j) {
        const bool acts = std::min(j - 1, Nu - 1) == column;
        z = A * z + B * (column < 0 ? -0.5 : acts ? 1.0 : 0.0);
        if (j < N1) continue;
        if (column < 0) {
          miss[j - N1] = w - std::pow(lambda, j) * (w - y[k]) - (1 + z[1] + e);
        } else {
          G(j - N1, column) = z[1];
        }
      }
    }
    MatrixXd D = MatrixXd::Identity(Nu, Nu);
    for (int i = 1; i < Nu; ++i) D(i, i - 1) = -1;
    VectorXd first = VectorXd::Zero(Nu);
    first[0] = before;
    const VectorXd v = (alpha * G.transpose() * G + beta * D.transpose() * D)
                           .ldlt()
                           .solve(alpha * G.transpose() * miss + beta * D.transpose() * first);
    EXPECT_NEAR(u[k], v[0], 1e-9) << k;
    EXPECT_NEAR(cost[k], alpha * (miss - G * v).squaredNorm() + beta * (D * v - first).squaredNorm(), 1e-9) << k;
    x = A * x + B * (u[k] - 0.5);
    before = u[k];
  }
  EXPECT_EQ(r.greatest("c.status"), 0);
  EXPECT_NEAR(y.back(), 1.8, 0.02);
}

TEST(Nmpc, HasTheOptimumOfALinearModelWithLimits) {
  const Signals r =
      run("blocks:\n"
          "  c: {type: nmpc, model: tests/blocks/models/linear_model.yaml, in: {w: 1, y: y}, horizon: 6, "
          "control_horizon: 2, "
          "move_weight: 0.05, lower: -0.3, upper: 1.4, max_rate: 6, y_upper: 0.7, correction: false}\n"
          "  y: {type: unit_delay, in: 0.8*y + 0.2*c.u, rate: 0.1}\n"
          "simulation: {stop: 1}\nrecord: [y, c.u, c.cost, c.status]\n");
  const std::vector<double> y = r.samples("y"), u = r.samples("c.u"), cost = r.samples("c.cost");
  double before = 0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    const Found wanted = least(
        [&](const std::vector<double>& v) {
          double now = y[k], sum = 0;
          const double steps[2] = {v[0] - before, v[1] - v[0]};
          for (const double step : steps) {
            sum += 0.05 * step * step;
            if (std::abs(step) > 0.6 + 1e-12) return 1e6 + std::abs(step);
          }
          for (int j = 0; j < 6; ++j) {
            now = 0.8 * now + 0.2 * v[j == 0 ? 0 : 1];
            sum += (now - 1) * (now - 1) + 1e6 * std::max(0.0, now - 0.7);
          }
          return sum;
        },
        {-0.3, -0.3}, {1.4, 1.4});
    EXPECT_LE(cost[k], wanted.cost * 1.001) << k;
    EXPECT_GE(cost[k], wanted.cost * 0.999 - 1e-9) << k;
    EXPECT_LE(std::abs(u[k] - before), 0.6 + 1e-12) << k;
    EXPECT_LE(u[k], 1.4) << k;
    EXPECT_LE(y[k], 0.7 + 1e-7) << k;
    before = u[k];
  }
  EXPECT_NEAR(y.back(), 0.7, 1e-3);
  EXPECT_EQ(r.greatest("c.status"), 0);
}

TEST(Nmpc, ControlsTwoOutputsByTwoInputs) {
  const Signals r =
      run("blocks:\n"
          "  c: {type: nmpc, model: tests/control/models/two_by_two.yaml, in: {w: [1, -0.5], y: [a, b]}, horizon: 12, "
          "control_horizon: 3, move_weight: [0.01, 0.02], lower: [-2, -3], upper: 3}\n"
          "  a: {type: unit_delay, in: 0.7*a + 0.1*b + 0.4*c.u.1 + 0.1*c.u.2 + 0.1, rate: 0.5}\n"
          "  b: {type: unit_delay, in: 0.05*a + 0.8*b - 0.1*c.u.1 + 0.42*c.u.2, rate: 0.5}\n"
          "simulation: {stop: 40}\nrecord: [a, b, c.u]\n");
  EXPECT_NEAR(r.samples("a").back(), 1, 1e-6);
  EXPECT_NEAR(r.samples("b").back(), -0.5, 1e-6);
}

// --- networks -------------------------------------------------------------------------------------------------------

TEST(Nmpc, HasTheOptimumOfTheFirstOrderSystemsNetwork) {
  const Signals r =
      run("blocks:\n"
          "  w: {type: staircase, times: [0, 5, 10, 15], values: [0.4, -0.9, 1.2, 2.6], rate: 0.5}\n"
          "  c: {type: nmpc, model: diagrams/book/models/first_order_mlp.yaml, in: {w: w, y: y}, horizon: 8, "
          "blocking: [2, 2, 4], move_weight: 0.02, lower: -1.5, upper: 1.5}\n"
          "  y: {type: unit_delay, in: y - 0.5*tanh(y + c.u^3), rate: 0.5}\n"
          "simulation: {stop: 19.5}\nrecord: [w, y, c.u, c.cost, c.status]\n");
  const std::vector<double> y = r.samples("y"), u = r.samples("c.u"), w = r.samples("w"), cost = r.samples("c.cost");
  double before = 0, model = 0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    const double e = y[k] - model;
    const Found wanted = least(
        [&](const std::vector<double>& v) {
          double now = model, sum = 0, last = before;
          for (const double move : v) {
            sum += 0.02 * (move - last) * (move - last);
            last = move;
          }
          for (std::size_t j = 0; j < 8; ++j) {
            now = network(now, v[j < 2 ? 0 : j < 4 ? 1 : 2]);
            sum += (now + e - w[k]) * (now + e - w[k]);
          }
          return sum;
        },
        {-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5});
    EXPECT_LE(cost[k], wanted.cost * 1.001 + 1e-9) << k << ": " << u[k] << ", wanted " << wanted.x[0];
    model = network(model, u[k]);
    before = u[k];
  }
  EXPECT_LE(r.greatest("c.status"), 0);
}

TEST(Nmpc, KeepsALimitOfTheOutputOnANetwork) {
  const Signals r =
      run("blocks:\n"
          "  c: {type: nmpc, model: diagrams/book/models/first_order_mlp.yaml, in: {w: 1.5, y: y}, horizon: 10, "
          "control_horizon: 3, "
          "lower: -1.5, upper: 1.5, y_upper: 0.8, correction: false}\n"
          "  y: {type: narx, model: diagrams/book/models/first_order_mlp.yaml, in: c.u}\n"
          "simulation: {stop: 20}\nrecord: [y, c.u, c.status, c.excess]\n");
  EXPECT_LE(r.greatest("y"), 0.8 + 1e-6);
  EXPECT_NEAR(r.samples("y").back(), 0.8, 1e-3);
  EXPECT_EQ(r.greatest("c.status"), 0);
}

TEST(Nmpc, ExceedsALimitAsLittleAsPossibleWhenNoInputKeepsIt) {
  const std::string loop =
      "blocks:\n"
      "  c: {type: nmpc, model: tests/blocks/models/linear_model.yaml, in: {w: 0, y: y}, horizon: 6, control_horizon: "
      "2, "
      "move_weight: 10, lower: -1, upper: 1, y_upper: 0.5";
  const std::string rest =
      ", correction: false, initial: 2}\n"
      "  y: {type: unit_delay, in: 0.8*y + 0.2*c.u, initial: 2, rate: 0.1}\n"
      "simulation: {stop: 1}\nrecord: [y, c.u, c.status, c.excess]\n";
  const Signals hard = run(loop + rest);
  EXPECT_EQ(hard.samples("c.u")[0], -1);  // the cost alone would hardly move it
  EXPECT_EQ(hard.samples("c.status")[0], 3);
  EXPECT_NEAR(hard.samples("c.excess")[0], 0.8 * 2 - 0.2 - 0.5, 1e-9);
  EXPECT_EQ(hard.samples("c.status").back(), 0);
  const Signals soft = run(loop + ", limits: soft" + rest);
  EXPECT_NEAR(soft.samples("c.u")[0], -1, 1e-6);
  EXPECT_EQ(soft.samples("c.status")[0], 1);
  const Signals cheap = run(loop + ", limits: soft, slack_weight: 1e-3" + rest);
  EXPECT_GT(cheap.samples("c.u")[0], -0.5);
}

TEST(Nmpc, GivesTheBestMovesSoFarWhenIterationsAreUsedUp) {
  const std::string loop =
      "blocks:\n"
      "  c: {type: nmpc, model: diagrams/book/models/first_order_mlp.yaml, in: {w: 1, y: y}, horizon: 8, "
      "control_horizon: 4, "
      "lower: -1.5, upper: 1.5, max_rate: 1, candidates: 0, initial_u: -0.2, max_iterations: ";
  const std::string rest =
      "}\n  y: {type: unit_delay, in: y - 0.5*tanh(y + c.u^3), rate: 0.5}\n"
      "simulation: {stop: 10}\nrecord: [y, c.u, c.status, c.cost, c.iterations]\n";
  const Signals one = run(loop + "1" + rest), many = run(loop + "50" + rest);
  EXPECT_EQ(one.samples("c.status")[0], 2);
  EXPECT_EQ(one.greatest("c.iterations"), 1);
  EXPECT_EQ(many.samples("c.status")[0], 0);
  EXPECT_GT(one.samples("c.cost")[0], many.samples("c.cost")[0]);
  std::vector<double> u = one.samples("c.u");
  u.insert(u.begin(), -0.2);
  for (std::size_t k = 1; k < u.size(); ++k) EXPECT_LE(std::abs(u[k] - u[k - 1]), 0.5 + 1e-12) << k;
  EXPECT_NEAR(one.samples("y").back(), 1, 0.02);  // it catches up from sample to sample
}

TEST(Nmpc, TheRunTellsHowTheSearchesEnded) {
  const Signals r =
      run("blocks:\n"
          "  c: {type: nmpc, model: tests/blocks/models/linear_model.yaml, in: {w: 0, y: y}, horizon: 6, "
          "lower: -1, upper: 1, y_upper: 0.5, correction: false, initial: 2}\n"
          "  y: {type: unit_delay, in: 0.8*y + 0.2*c.u, initial: 2, rate: 0.1}\n"
          "simulation: {stop: 0.9}\nrecord: [y, c.u, c.status]\n");
  ASSERT_EQ(r.whole().statistics.findings.size(), 1U);
  const RunFinding& finding = r.whole().statistics.findings[0];
  EXPECT_EQ(finding.check, "control-status");
  EXPECT_EQ(finding.text, "'c' at 10 samples: optimum found at 70 % (7); limits that no input keeps at 30 % (3)");
}

// --- Gaussian processes ---------------------------------------------------------------------------------------------

TEST(Nmpc, KeepsThePredictedDeviationOfAGaussianProcessBelowItsLimit) {
  const std::string loop =
      "blocks:\n"
      "  w: {type: staircase, times: [0, 10, 20], values: [-1, 1.8, -1.9], rate: 0.5}\n"
      "  c: {type: nmpc, model: diagrams/book/models/first_order_gp.yaml, in: {w: w, y: y}, horizon: 8, lambda: 0.9, "
      "lower: -1.5, upper: 1.5";
  const std::string rest =
      "}\n  y: {type: unit_delay, in: y - 0.5*tanh(y + c.u^3), rate: 0.5}\n"
      "simulation: {stop: 30}\nrecord: [y, c.u, c.std, c.status]\n";
  const Signals free = run(loop + rest), careful = run(loop + ", max_variance: 0.13^2" + rest);
  EXPECT_GT(free.greatest("c.std"), 0.17);
  EXPECT_LE(careful.greatest("c.std"), 0.13);
  EXPECT_GT(careful.greatest("c.std"), 0.1299);  // it goes to the border, not further
  EXPECT_EQ(careful.greatest("c.status"), 0);
}

// --- diagrams as models ---------------------------------------------------------------------------------------------

using State = std::vector<double>;
using RightSide = std::function<State(const State&, double)>;

State runge_kutta(const RightSide& f, State x, double u, double Ts, int steps) {
  const double h = Ts / steps;
  const auto ahead = [&](const State& k, double by) {
    State moved = x;
    for (std::size_t i = 0; i < x.size(); ++i) moved[i] += by * k[i];
    return moved;
  };
  for (int n = 0; n < steps; ++n) {
    const State a = f(x, u), b = f(ahead(a, h / 2), u), c = f(ahead(b, h / 2), u), d = f(ahead(c, h), u);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  return x;
}

// Seborg's reactor: concentration (mol/l) and temperature (K).
State reactor(const State& x, double coolant) {
  const double rate = 7.2e10 / 60 * std::exp(-8750 / x[1]) * x[0];
  return {(1 - x[0]) / 60 - rate, (350 - x[1]) / 60 + 5e4 / 239 * rate + 5e4 / 60 / (100 * 239) * (coolant - x[1])};
}

// The neutralisation without dead time: q3, h1, xa, xb, s.
double pH_of(double xa, double xb) {
  double low = -1, high = 15;
  const double pK1 = -std::log10(4.47e-7), pK2 = -std::log10(5.62e-11);
  while (high - low > 1e-13) {
    const double pH = 0.5 * (low + high);
    const double charge = xa + std::pow(10, pH - 14) - std::pow(10, -pH) +
                          xb * (1 + 2 * std::pow(10, pH - pK2)) / (1 + std::pow(10, pK1 - pH) + std::pow(10, pH - pK2));
    (charge > 0 ? high : low) = pH;
  }
  return 0.5 * (low + high);
}
State neutralisation(const State& x, double base) {
  const double in = 16.6 + 0.55 + x[0], volume = 207 * x[1];
  return {(base - x[0]) / 6, (in - 4.5860778 * std::pow(x[1] + 11.5, 0.607)) / 207,
          (16.6 * 3e-3 - 0.55 * 0.03 - x[0] * 3.05e-3 - in * x[2]) / volume,
          (0.55 * 0.03 + x[0] * 5e-5 - in * x[3]) / volume, (pH_of(x[2], x[3]) - x[4]) / 15};
}

struct Case {
  RightSide f;
  State start;
  std::size_t output;
  double Ts, set_point, beta, lower, upper, u_start;
  int horizon;
  std::vector<int> blocking;
};

// The least cost of the first sample, by a search that knows no derivative.
double least_cost(const Case& c, int substeps) {
  const std::vector<double> lower(c.blocking.size(), c.lower), upper(c.blocking.size(), c.upper);
  return least(
             [&](const std::vector<double>& v) {
               double cost = 0, last = c.u_start;
               for (const double move : v) {
                 cost += c.beta * (move - last) * (move - last);
                 last = move;
               }
               State x = c.start;
               for (std::size_t j = 0, move = 0, left = static_cast<std::size_t>(c.blocking[0]);
                    j < static_cast<std::size_t>(c.horizon); ++j) {
                 if (left == 0 && move + 1 < v.size()) left = static_cast<std::size_t>(c.blocking[++move]);
                 if (left > 0) --left;
                 x = runge_kutta(c.f, x, v[move], c.Ts, substeps);
                 cost += (x[c.output] - c.set_point) * (x[c.output] - c.set_point);
               }
               return cost;
             },
             lower, upper, 3, 1e-4)
      .cost;
}

TEST(Nmpc, HasTheOptimumOfTheReactor) {
  for (const double set_point : {350.0, 335.0, 322.0}) {
    SCOPED_TRACE(set_point);
    const Case c{reactor, {0.8772, 324.5}, 1, 6, set_point, 0.05, 280, 320, 300, 12, {2, 4}};
    const Signals r =
        run("blocks:\n  c: {type: nmpc, rate: 6, model: diagrams/examples/models/cstr.yaml, input: coolant, output: T, "
            "in: {w: " +
            std::to_string(set_point) +
            ", y: 324.5}, horizon: 12, blocking: [2, 4], move_weight: 0.05, lower: 280, upper: 320, initial_u: 300, "
            "substeps: 5}\n"
            "simulation: {stop: 1}\nrecord: [c.cost, c.status]\n");
    const double wanted = least_cost(c, 5);
    EXPECT_NEAR(r.samples("c.cost")[0], wanted, 1e-3 * wanted);
    EXPECT_EQ(r.samples("c.status")[0], 0);
  }
}

TEST(Nmpc, HasTheOptimumOfTheNeutralisation) {
  for (const double set_point : {6.5, 7.4, 9.0}) {
    SCOPED_TRACE(set_point);
    const Case c{
        neutralisation, {15.6, 14, -4.3603053e-4, 5.2763359e-4, 7.0254861}, 4, 25, set_point, 0.02, 12, 19, 15.6, 8,
        {2, 6}};
    const Signals r =
        run("blocks:\n  c: {type: nmpc, rate: 25, model: tests/control/models/ph.yaml, input: u, output: y, in: {w: " +
            std::to_string(set_point) +
            ", y: 7.0254861}, horizon: 8, blocking: [2, 6], move_weight: 0.02, lower: 12, upper: 19, initial_u: 15.6, "
            "substeps: 10}\n"
            "simulation: {stop: 1}\nrecord: [c.cost, c.status]\n");
    const double wanted = least_cost(c, 10);
    EXPECT_NEAR(r.samples("c.cost")[0], wanted, 1e-3 * wanted);
    EXPECT_EQ(r.samples("c.status")[0], 0);
  }
}

TEST(Nmpc, ASampledDiagramIsAModelToo) {
  // The same system as a sampled diagram and as what the plant computes: the model is right, so nothing is left.
  const Signals r = run(
      "blocks:\n"
      "  c: {type: nmpc, rate: 0.4, model: tests/control/models/sampled.yaml, input: u, output: y, in: {w: 0.8, y: y}, "
      "horizon: 6, control_horizon: 2, lower: -1.5, upper: 1.5}\n"
      "  y: {type: unit_delay, in: y - 0.5*tanh(y + c.u^3) + 0.1*f, initial: 0.2, rate: 0.4}\n"
      "  f: {type: unit_delay, in: 0.5*f + c.u*y, initial: 0.1, rate: 0.4}\n"
      "simulation: {stop: 20}\nrecord: [y, c.status, c.cost]\n");
  EXPECT_NEAR(r.samples("y").back(), 0.8, 1e-6);
  EXPECT_EQ(r.greatest("c.status"), 0);
  // The model begins where its diagram does: with u = 0 the next output is 0.2 - tanh(0.2)/2 + 0.1^2.
  const Signals first = run(
      "blocks:\n"
      "  c: {type: nmpc, rate: 0.4, model: tests/control/models/sampled.yaml, input: u, output: y, in: {w: 0, y: 0.2}, "
      "horizon: 1, lower: 0, upper: 0, correction: false}\nsimulation: {stop: 0.1}\nrecord: [c.cost]\n");
  EXPECT_NEAR(first.samples("c.cost")[0], std::pow(0.2 - 0.5 * std::tanh(0.2) + 0.01, 2), 1e-12);
}

// x1+ = 0.9 x1 + 0.05 u + 0.05, x2+ = sin(0.9) x2 + x1 - u, y = 2 x1 - 0.3 x2, from rest.
TEST(Nmpc, ALinearDiagramMakesOneQuadraticProgram) {
  constexpr double w = 0.7, beta = 0.05;
  const auto outputs = [](double first, double second) {
    double x1 = 0, x2 = 0;
    std::array<double, 6> y{};
    for (std::size_t j = 0; j < y.size(); ++j) {
      const double u = j == 0 ? first : second;
      x2 = std::sin(0.9) * x2 + x1 - u;
      x1 = 0.9 * x1 + 0.05 * u + 0.05;
      y[j] = 2 * x1 - 0.3 * x2;
    }
    return y;
  };
  // The normal equations H u = g of sum (w - y)^2 + beta (u1^2 + (u2 - u1)^2).
  const auto free = outputs(0, 0), by_first = outputs(1, 0), by_second = outputs(0, 1);
  double H11 = 2 * beta, H12 = -beta, H22 = beta, g1 = 0, g2 = 0;
  for (std::size_t j = 0; j < free.size(); ++j) {
    const double first = by_first[j] - free[j], second = by_second[j] - free[j];
    H11 += first * first, H12 += first * second, H22 += second * second;
    g1 += first * (w - free[j]), g2 += second * (w - free[j]);
  }
  const double u1 = (H22 * g1 - H12 * g2) / (H11 * H22 - H12 * H12);
  const double u2 = (H11 * g2 - H12 * g1) / (H11 * H22 - H12 * H12);
  double cost = beta * (u1 * u1 + (u2 - u1) * (u2 - u1));
  for (const double y : outputs(u1, u2)) cost += (w - y) * (w - y);
  const auto control = [](const std::string& model) {
    return run("blocks:\n  c: {type: nmpc, rate: 0.4, model: tests/control/models/" + model +
               ", input: u, output: y, in: {w: 0.7, y: 0}, horizon: 6, control_horizon: 2, move_weight: 0.05}\n"
               "simulation: {stop: 0.3}\nrecord: [c.u, c.cost, c.iterations, c.status]\n");
  };
  const Signals r = control("affine.yaml");
  EXPECT_NEAR(r.samples("c.u")[0], u1, 1e-9);
  EXPECT_NEAR(r.samples("c.cost")[0], cost, 1e-9);
  EXPECT_EQ(r.samples("c.iterations")[0], 1);
  EXPECT_EQ(r.samples("c.status")[0], 0);
  EXPECT_EQ(control("affine_continuous.yaml").samples("c.iterations")[0], 1);
}

TEST(Nmpc, GivesTheBestMovesSoFarWhenTimeIsUsedUp) {
  const Signals r =
      run("blocks:\n"
          "  c: {type: nmpc, model: diagrams/book/models/first_order_mlp.yaml, in: {w: 1, y: y}, horizon: 8, "
          "control_horizon: 4, lower: -1.5, upper: 1.5, max_rate: 1, initial_u: -0.2, max_time: 1e-12}\n"
          "  y: {type: unit_delay, in: y - 0.5*tanh(y + c.u^3), rate: 0.5}\n"
          "simulation: {stop: 2}\nrecord: [c.u, c.status, c.cost]\n");
  EXPECT_EQ(r.samples("c.status")[0], 2);
  EXPECT_TRUE(std::isfinite(r.samples("c.cost")[0]));
  double before = -0.2;
  for (const double u : r.samples("c.u")) {
    EXPECT_LE(std::abs(u - before), 0.5 + 1e-12);
    before = u;
  }
  ASSERT_EQ(r.whole().statistics.findings.size(), 1U);
  EXPECT_THAT(r.whole().statistics.findings[0].text, HasSubstr("iterations or time used up"));
}

TEST(Nmpc, AMeasuredStateLeavesNoOffsetAlthoughTheModelIsWrong) {
  const Signals r =
      run("blocks:\n"
          "  c: {type: nmpc, model: tests/control/models/tanks.yaml, in: {w: 1.8, y: y, x: [a, b]}, horizon: 12, "
          "control_horizon: 3, move_weight: 0.3, initial_u: 0.5}\n"
          "  a: {type: unit_delay, in: 0.75*a + 0.2*(c.u - 0.5) - 0.02, rate: 0.1}\n"
          "  b: {type: unit_delay, in: 0.9*b + 0.12*a + 0.01, rate: 0.1}\n"
          "  y: 1 + b\nsimulation: {stop: 15}\nrecord: [y, c.status]\n");
  EXPECT_NEAR(r.samples("y").back(), 1.8, 1e-6);
}

TEST(Nmpc, KeepsALimitOfAState) {
  const Signals r =
      run("blocks:\n"
          "  c: {type: nmpc, model: tests/control/models/tanks.yaml, in: {w: 1.8, y: y, x: [a, b]}, horizon: 15, "
          "control_horizon: 4, move_weight: 0.01, initial_u: 0.5, x_upper: [0.9, 10]}\n"
          "  a: {type: unit_delay, in: 0.8*a + 0.2*(c.u - 0.5), rate: 0.1}\n"
          "  b: {type: unit_delay, in: 0.9*b + 0.1*a, rate: 0.1}\n"
          "  y: 1 + b\nsimulation: {stop: 5}\nrecord: [y, a, c.status]\n");
  EXPECT_LE(r.greatest("a"), 0.9 + 1e-7);
  EXPECT_GT(r.greatest("a"), 0.89);
  EXPECT_NEAR(r.samples("y").back(), 1.8, 1e-3);
  EXPECT_EQ(r.greatest("c.status"), 0);
}

// --- what does not fit ----------------------------------------------------------------------------------------------

TEST(Nmpc, SaysWhatDoesNotFit) {
  const std::string begin = "blocks:\n  c: {type: nmpc, model: tests/blocks/models/nmpc.yaml, in: {w: 1, y: 0}";
  const std::string end = "}\nsimulation: {stop: 1}\n";
  EXPECT_THAT(findings(begin + ", max_variance: 1" + end),
              HasSubstr("only a Gaussian process knows how uncertain it is"));
  EXPECT_THAT(findings(begin + ", minimum_horizon: 9" + end),
              HasSubstr("the cost begins at sample 9, behind the horizon of 8 samples"));
  EXPECT_THAT(findings(begin + ", control_horizon: 9" + end),
              HasSubstr("9 moves do not fit into the horizon of 8 samples"));
  EXPECT_THAT(findings(begin + ", blocking: [4, 4, 2]" + end),
              HasSubstr("a move begins at sample 8, behind the horizon of 8 samples"));
  EXPECT_THAT(findings(begin + ", blocking: 1.5" + end), HasSubstr("a move is held for a whole number of samples"));
  EXPECT_THAT(findings(begin + ", lower: 2, upper: 1" + end), HasSubstr("upper is 1, less than lower, 2"));
  EXPECT_THAT(findings(begin + ", output_weight: [1, 2, 3]" + end),
              HasSubstr("expected one number or 8, one for each sample from N1 to N2, got 3 numbers"));
  EXPECT_THAT(findings(begin + ", x_upper: 1" + end),
              HasSubstr("the model is made of past outputs and has no state to limit; y_lower and y_upper limit the "
                        "outputs"));
  EXPECT_THAT(
      findings("blocks:\n  c: {type: nmpc, model: tests/blocks/models/nmpc.yaml, in: {w: [1, 2, 3], y: 0}" + end),
      HasSubstr("the set point has 1 number, or 9: now and at the 8 samples of the horizon"));
  EXPECT_THAT(
      findings("blocks:\n  c: {type: nmpc, model: tests/blocks/models/nmpc.yaml, in: {w: 1, y: 0, x: [1, 2]}" + end),
      HasSubstr("the model is made of past outputs and inputs, which the block keeps: leave x out"));
  EXPECT_THAT(findings("blocks:\n  c: {type: nmpc, model: tests/blocks/models/mlp.yaml, in: {w: 1, y: 0}" + end),
              HasSubstr("the model has no regressors, so it is no dynamic model but a map 'mlp'"));
  const auto of_diagram = [](const std::string& model, const std::string& how) {
    return findings("blocks:\n  c: {type: nmpc, rate: 0.4, model: tests/control/models/" + model +
                    ".yaml, in: {w: 1, y: 0}" + how + "}\nsimulation: {stop: 1}\n");
  };
  EXPECT_THAT(of_diagram("reactor", ""), HasSubstr("is a diagram: say which of its signals are input and output"));
  EXPECT_THAT(of_diagram("reactor", ", input: u, output: z"),
              HasSubstr("is wrong: the output 'z' is no signal of the diagram"));
  EXPECT_THAT(of_diagram("reactor", ", input: y, output: a"), HasSubstr("the input 'y' depends on its states"));
  EXPECT_THAT(of_diagram("reactor", ", input: u, output: u"),
              HasSubstr("the output 'u' depends at once on the input, so it is no prediction"));
  EXPECT_THAT(of_diagram("delayed", ", input: u, output: y"),
              HasSubstr("block 'late' remembers more than states, as delays do"));
  EXPECT_THAT(of_diagram("timed", ", input: u, output: y"),
              HasSubstr("it depends on the time, which stands still in a prediction"));
  EXPECT_THAT(of_diagram("slow", ", input: u, output: y"),
              HasSubstr("the model file of 'c' was made for a period of 0.5 s, not 0.4 s"));
  EXPECT_THAT(of_diagram("itself", ", input: c.u, output: y"), HasSubstr("is its own model"));
  EXPECT_THAT(findings(begin + ", input: u" + end),
              HasSubstr("only a diagram has signals to choose from; a model file has its own inputs and outputs"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
