// Blocks without memory: mathematics, nonlinear ones, routing, weights.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string brief = "simulation: {stop: 1}\n";

// The outputs at time 0 of a block whose input is a signal, so that nothing is folded away while compiling.
std::vector<double> outputs(const std::string& block, int count, const std::string& record = "y") {
  const Signals r =
      run("blocks:\n  t: {type: clock}\n  y: " + block + "\nrecord: [" + record + "]\nsimulation: {stop: 1e-9}\n");
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(r.recording().at(0, static_cast<std::size_t>(i)));
  return values;
}
double output(const std::string& block) { return outputs(block, 1)[0]; }
std::string wrong(const std::string& block) { return findings("blocks: {y: " + block + "}\n" + brief); }

TEST(Gain, MultipliesElementByElement) {
  EXPECT_THAT(outputs("{type: gain, in: [t + 1, t + 2], k: [2, 5]}", 2), ElementsAre(2, 10));
  EXPECT_THAT(outputs("{type: gain, in: [t + 1, t + 2], k: 3}", 2), ElementsAre(3, 6));
}

TEST(Sum, AddsWithSigns) {
  EXPECT_EQ(output("{type: sum, in: [t + 5, t + 2, 1], signs: \"+-+\"}"), 4);
  EXPECT_EQ(output("{type: sum, in: t + 5}"), 5);
  EXPECT_THAT(wrong("{type: sum, in: [1, 2], signs: \"+-+\"}"), HasSubstr("there are 3 signs for 2 terms"));
  EXPECT_THAT(wrong("{type: sum, in: [1, 2], signs: \"+*\"}"), HasSubstr("signs are written with + and - only"));
}

TEST(Product, MultipliesAndDivides) {
  EXPECT_EQ(output("{type: product, in: [t + 6, t + 3, t + 4], operations: \"*/*\"}"), 8);
  EXPECT_THAT(wrong("{type: product, in: [1, 2], operations: \"*\"}"), HasSubstr("there are 1 operations for 2"));
}

TEST(MathFunction, KnowsEveryFunction) {
  struct Case {
    const char* name;
    double u, expected;
  };
  const Case cases[] = {{"exp", 0.5, std::exp(0.5)},
                        {"log", 0.5, std::log(0.5)},
                        {"log2", 0.5, -1},
                        {"log10", 100, 2},
                        {"exp10", 2, 100},
                        {"square", -3, 9},
                        {"sqrt", 9, 3},
                        {"cbrt", -8, -2},
                        {"reciprocal", 4, 0.25},
                        {"abs", -2, 2},
                        {"sign", -2, -1},
                        {"floor", -1.5, -2},
                        {"ceil", -1.5, -1},
                        {"round", -2.5, -3},
                        {"trunc", -1.5, -1},
                        {"sin", 0.5, std::sin(0.5)},
                        {"cos", 0.5, std::cos(0.5)},
                        {"tan", 0.5, std::tan(0.5)},
                        {"asin", 0.5, std::asin(0.5)},
                        {"acos", 0.5, std::acos(0.5)},
                        {"atan", 0.5, std::atan(0.5)},
                        {"sinh", 0.5, std::sinh(0.5)},
                        {"cosh", 0.5, std::cosh(0.5)},
                        {"tanh", 0.5, std::tanh(0.5)},
                        {"asinh", 0.5, std::asinh(0.5)},
                        {"acosh", 1.5, std::acosh(1.5)},
                        {"atanh", 0.5, std::atanh(0.5)},
                        {"erf", 0.5, std::erf(0.5)}};
  for (const Case& c : cases) {
    EXPECT_DOUBLE_EQ(output("{type: math_function, in: t + (" + std::to_string(c.u) + "), function: " + c.name + "}"),
                     c.expected)
        << c.name;
  }
}

TEST(MathFunction, TakesASecondArgumentWhereItNeedsOne) {
  EXPECT_DOUBLE_EQ(output("{type: math_function, in: t + 2, v: 10, function: pow}"), 1024);
  EXPECT_DOUBLE_EQ(output("{type: math_function, in: {u: t + 3, v: t + 4}, function: hypot}"), 5);
  EXPECT_DOUBLE_EQ(output("{type: math_function, in: {u: t - 1, v: -1}, function: atan2}"), std::atan2(-1, -1));
  EXPECT_DOUBLE_EQ(output("{type: math_function, in: {u: t - 7, v: 3}, function: mod}"), 2);
  EXPECT_DOUBLE_EQ(output("{type: math_function, in: {u: t - 7, v: 3}, function: rem}"), -1);
  EXPECT_THAT(wrong("{type: math_function, in: 1, function: pow}"), HasSubstr("pow needs a second argument"));
  EXPECT_THAT(wrong("{type: math_function, in: {u: 1, v: 2}, function: sin}"), HasSubstr("sin has one argument, u"));
}

TEST(MinAndMax, CompareEntriesOrElements) {
  EXPECT_EQ(output("{type: min, in: [t + 3, t + 1, 2]}"), 1);
  EXPECT_EQ(output("{type: max, in: [t + 3, t + 1, 2]}"), 3);
  const Signals r = run(R"(
blocks:
  v: [time, 1 - time, 0.25]
  least: {type: min, in: v}
  most: {type: max, in: [v, 0.5]}
  low: least - where(time < 0.25, time, where(time < 0.75, 0.25, 1 - time))
)" + brief);
  EXPECT_LT(r.greatest("low"), 1e-12);
  EXPECT_EQ(r.last("most.1"), 1);
  EXPECT_EQ(r.last("most.2"), 0.5);
  EXPECT_EQ(r.last("most.3"), 0.5);
}

TEST(Logic, FollowsItsTruthTables) {
  const auto table = [](const std::string& op) {
    std::vector<double> values;
    for (const char* in : {"[t, t]", "[t, t + 1]", "[t + 1, t]", "[t + 1, t + 2]"}) {
      values.push_back(output(std::string("{type: logic, in: ") + in + ", operator: " + op + "}"));
    }
    return values;
  };
  EXPECT_THAT(table("and"), ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(table("or"), ElementsAre(0, 1, 1, 1));
  EXPECT_THAT(table("xor"), ElementsAre(0, 1, 1, 0));
  EXPECT_THAT(table("nand"), ElementsAre(1, 1, 1, 0));
  EXPECT_THAT(table("nor"), ElementsAre(1, 0, 0, 0));
  EXPECT_EQ(output("{type: logic, in: t - 1, operator: not}"), 1);
  EXPECT_EQ(output("{type: logic, in: [t + 1, t + 1, t + 1], operator: xor}"), 1);
  EXPECT_THAT(wrong("{type: logic, in: [1, 0], operator: not}"), HasSubstr("not takes one condition"));
}

TEST(Logic, TurnsAVectorElementByElement) {
  const Signals r = run("blocks: {f: \"[time - 1, time + 1]\", y: {type: logic, in: [f], operator: not}}\n" + brief);
  EXPECT_EQ(r.at("y.1", 0), 1);
  EXPECT_EQ(r.at("y.2", 0), 0);
}

TEST(Compare, KnowsSixRelations) {
  const auto table = [](const std::string& op) {
    std::vector<double> values;
    for (const char* u : {"t - 1", "t", "t + 1"}) {
      values.push_back(output(std::string("{type: compare, in: ") + u + ", operator: " + op + "}"));
    }
    return values;
  };
  EXPECT_THAT(table("greater"), ElementsAre(0, 0, 1));
  EXPECT_THAT(table("greater_equal"), ElementsAre(0, 1, 1));
  EXPECT_THAT(table("less"), ElementsAre(1, 0, 0));
  EXPECT_THAT(table("less_equal"), ElementsAre(1, 1, 0));
  EXPECT_THAT(table("equal"), ElementsAre(0, 1, 0));
  EXPECT_THAT(table("not_equal"), ElementsAre(1, 0, 1));
}

TEST(Concat, JoinsScalarsAndVectors) {
  EXPECT_THAT(outputs("{type: concat, in: [t, [t + 1, t + 2], 3]}", 4), ElementsAre(0, 1, 2, 3));
}

TEST(Select, TakesElements) {
  EXPECT_THAT(outputs("{type: select, in: [t + 10, t + 20, t + 30], elements: [3, 1, 3]}", 3), ElementsAre(30, 10, 30));
  EXPECT_EQ(output("{type: select, in: [t + 10, t + 20], elements: 2}"), 20);
  EXPECT_THAT(wrong("{type: select, in: [1, 2], elements: [1, 3]}"), HasSubstr("there is no element 3"));
  EXPECT_THAT(wrong("{type: select, in: [1, 2], elements: 1.5}"), HasSubstr("whole numbers from 1"));
  EXPECT_THAT(wrong("{type: select, in: [1, 2], elements: 0}"), HasSubstr("at least 1"));
}

TEST(Switch, ChoosesByItsCondition) {
  const Signals r = run(R"(
blocks:
  y: {type: switch, in: {condition: [time - 0.5, 0.25 - time], then: 1, else: [2, 3]}}
  root: {type: switch, in: {condition: time - 0.5, then: sqrt(time - 0.5), else: 0}}
  x: {type: integrator, in: y}
)" + brief);
  EXPECT_EQ(r.at("y.1", 0.2), 2);
  EXPECT_EQ(r.at("y.1", 0.7), 1);
  EXPECT_EQ(r.at("y.2", 0.2), 1);
  EXPECT_NEAR(r.last("x.1"), 1.5, 1e-12);
  EXPECT_NEAR(r.last("x.2"), 0.25 + 3 * 0.75, 1e-11);
  EXPECT_NEAR(r.last("root"), std::sqrt(0.5), 1e-12);  // the root of a negative number is never looked at
}

TEST(Saturation, Limits) {
  EXPECT_THAT(outputs("{type: saturation, in: [t - 3, t, t + 3], lower: -1, upper: 2}", 3), ElementsAre(-1, 0, 2));
  EXPECT_EQ(output("{type: saturation, in: t - 100}"), -100);
  EXPECT_THAT(wrong("{type: saturation, in: 1, lower: [0, 3], upper: 2}"), HasSubstr("'upper' must not be less than"));
}

TEST(DeadZone, GivesTheExcess) {
  EXPECT_THAT(outputs("{type: dead_zone, in: [t - 3, t + 0.3, t + 3], lower: -1, upper: 2}", 3), ElementsAre(-2, 0, 1));
}

TEST(Quantiser, RoundsHalvesAwayFromZero) {
  EXPECT_THAT(outputs("{type: quantiser, in: [t + 0.74, t + 0.75, t - 0.75, t + 0.2], interval: 0.5}", 4),
              ElementsAre(0.5, 1, -1, 0));
  // A ramp changes step at the odd multiples of half an interval, located exactly: its integral tells.
  const Signals r =
      run("blocks: {y: {type: quantiser, in: time, interval: 0.1}, x: {type: integrator, in: y}}\n" + brief);
  EXPECT_NEAR(r.last("x"), 0.1 * (0.1 + 0.2 + 0.3 + 0.4 + 0.5 + 0.6 + 0.7 + 0.8 + 0.9) + 0.05 * 1, 1e-11);
}

TEST(Relay, HasHysteresis) {
  // u = sin t with on 0.5, off -0.5: on from pi/6 to 7 pi/6.
  const Signals r = run(R"(
blocks:
  u: {type: sine}
  y: {type: relay, in: u, on: 0.5, off: -0.5, on_value: 2, off_value: -1}
  x: {type: integrator, in: y}
simulation: {stop: 2*pi}
)");
  const double pi = std::acos(-1);
  EXPECT_EQ(r.at("y", 0.3), -1);
  EXPECT_EQ(r.at("y", 1), 2);
  EXPECT_EQ(r.at("y", 3.3), 2);
  EXPECT_EQ(r.at("y", 4), -1);
  EXPECT_NEAR(r.last("x"), 2 * pi - pi, 1e-8);
}

TEST(Relay, KeepsATemperatureInALoop) {
  // T' = 1 while heated, -1 otherwise, between 0 and 1: a triangle with period 2.
  const Signals r = run(R"(
blocks:
  T: {type: integrator, in: heater}
  heater: {type: relay, in: -T, on: 0, off: -1, on_value: 1, off_value: -1, initial: 1}
simulation: {stop: 7.5}
)");
  EXPECT_NEAR(r.last("T"), 0.5, 1e-9);
  for (const double v : r.column("T")) EXPECT_LE(std::fabs(v - 0.5), 0.5 + 1e-9);
}

TEST(Relay, RunsSampled) {
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 2, 3, 4], values: [0, 2, 0.5, -1, 0.5], }
  y: {type: relay, in: u, on: 1, off: 0, rate: 1}
simulation: {stop: 4}
)");
  EXPECT_THAT(r.samples("y"), ElementsAre(0, 1, 1, 0, 0));
}

TEST(Lookup1d, DrawsStraightLines) {
  const auto look = [](const std::string& u, const std::string& outside) {
    return output("{type: lookup_1d, in: t + (" + u + "), x: [0, 1, 3], y: [1, 3, -1], outside: " + outside + "}");
  };
  EXPECT_DOUBLE_EQ(look("0.5", "clip"), 2);
  EXPECT_DOUBLE_EQ(look("2", "clip"), 1);
  EXPECT_DOUBLE_EQ(look("1", "clip"), 3);
  EXPECT_DOUBLE_EQ(look("-1", "clip"), 1);
  EXPECT_DOUBLE_EQ(look("7", "clip"), -1);
  EXPECT_DOUBLE_EQ(look("-1", "linear"), -1);
  EXPECT_DOUBLE_EQ(look("5", "linear"), -5);
  EXPECT_DOUBLE_EQ(look("2.5", "error"), 0);
  EXPECT_THAT(wrong("{type: lookup_1d, in: 1, x: [0, 1], y: [1, 2, 3]}"),
              HasSubstr("2 points x need as many values y"));
  EXPECT_THAT(wrong("{type: lookup_1d, in: 1, x: [0, 0], y: [1, 2]}"), HasSubstr("must ascend"));
}

TEST(Lookup1d, IntegratesAcrossItsKinksExactly) {
  // The integral of the table over 0..4 with u = time, by trapezia: 2 + 2 - 1.
  const Signals r = run(R"(
blocks:
  y: {type: lookup_1d, in: time, x: [0, 1, 3], y: [1, 3, -1]}
  x: {type: integrator, in: y}
simulation: {stop: 4}
)");
  EXPECT_NEAR(r.last("x"), 3, 1e-11);
}

TEST(Lookup1d, HoldsAndTakesTheNearestPoint) {
  const Signals r = run(R"(
blocks:
  held: {type: lookup_1d, in: time, x: [0, 1, 3], y: [1, 3, -1], interpolation: hold}
  nearest: {type: lookup_1d, in: time - 1, x: [0, 1, 3], y: [1, 3, -1], interpolation: nearest, outside: linear}
  x: {type: integrator, in: [held, nearest]}
simulation: {stop: 4}
)");
  EXPECT_EQ(r.at("held", 1, true), 1);
  EXPECT_EQ(r.at("held", 1), 3);
  EXPECT_EQ(r.last("held"), -1);
  EXPECT_EQ(r.at("nearest", 0), 1);
  EXPECT_EQ(r.at("nearest", 2), 3);
  EXPECT_NEAR(r.last("x.1"), 1 + 2 * 3 - 1, 1e-11);
  EXPECT_NEAR(r.last("x.2"), 1.5 * 1 + 1.5 * 3 - 1, 1e-11);
}

TEST(Lookup1d, EndsTheRunOutsideWhenTold) {
  const std::string text = "blocks: {torque: {type: lookup_1d, in: 2*time, x: [0, 1], y: [0, 1], outside: error}}\n";
  try {
    run(text + "simulation: {stop: 2}\n");
    FAIL() << "the run went on";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the input of block 'torque' is"));
    EXPECT_THAT(error.what(), HasSubstr("outside its table from 0 to 1"));
    EXPECT_LT(error.time(), 0.51);
  }
}

TEST(GaussianWeights, AreThoseOfTheBook) {
  // dynamics.md section 5: centres 0, pi/2, pi, s = 0.7 at 0, pi/8, pi/4.
  const auto at = [](const std::string& theta) {
    return outputs("{type: gaussian_weights, in: t + " + theta + ", centres: [0, pi/2, pi], widths: 0.7}", 3);
  };
  const double tol = 5e-7;  // printed to six digits
  const auto near = [&](double x) { return ::testing::DoubleNear(x, tol); };
  EXPECT_THAT(at("0"), ElementsAre(near(.925341), near(.074620), near(.000039)));
  EXPECT_THAT(at("pi/8"), ElementsAre(near(.778515), near(.221077), near(.000408)));
  EXPECT_THAT(at("pi/4"), ElementsAre(near(.49838), near(.49838), near(.003241)));
}

TEST(GaussianWeights, SumToOneFarFromAllCentres) {
  EXPECT_THAT(outputs("{type: gaussian_weights, in: t + 1e6, centres: [0, 1, 2], widths: [0.1, 0.1, 0.1]}", 3),
              ElementsAre(0, 0, 1));
  EXPECT_THAT(outputs("{type: gaussian_weights, in: t - 1e6, centres: [0, 1], widths: [0.1, 0.2]}", 2),
              ElementsAre(0, 1));
  EXPECT_THAT(wrong("{type: gaussian_weights, in: 1, centres: [0, 1, 2], widths: [1, 2]}"),
              HasSubstr("3 centres need as many widths"));
  EXPECT_THAT(wrong("{type: gaussian_weights, in: 1, centres: [0, 1], widths: 0}"), HasSubstr("greater than 0"));
}

TEST(TriangularWeights, InterpolateAndHoldTheirEnds) {
  const auto at = [](const std::string& h) {
    return outputs("{type: triangular_weights, in: t + " + h + ", centres: [1, 1.4, 1.8]}", 3);
  };
  EXPECT_THAT(at("0"), ElementsAre(1, 0, 0));
  EXPECT_THAT(at("1.4"), ElementsAre(0, 1, 0));
  EXPECT_THAT(at("9"), ElementsAre(0, 0, 1));
  const std::vector<double> between = at("1.7");
  EXPECT_NEAR(between[1], 0.25, 1e-12);
  EXPECT_NEAR(between[2], 0.75, 1e-12);
  EXPECT_EQ(between[0], 0);
}

TEST(Blend, WeighsScalarsVectorsAndRows) {
  EXPECT_EQ(output("{type: blend, in: {weights: [t + 0.25, 0.75], values: [8, 4]}}"), 5);
  const Signals r = run(R"(
parameters: {M: [[1, 2, 3], [5, 6, 7]]}
blocks:
  mu: [time, 1 - time]
  a: [1, 10]
  b: [3, 30]
  vectors: {type: blend, in: {weights: mu, values: [a, b]}}
  rows: {type: blend, in: {weights: mu, values: M}}
)" + brief);
  EXPECT_EQ(r.at("vectors.2", 0), 30);
  EXPECT_EQ(r.last("vectors.1"), 1);
  EXPECT_EQ(r.at("rows.3", 0), 7);
  EXPECT_EQ(r.last("rows.3"), 3);
  EXPECT_THAT(wrong("{type: blend, in: {weights: [1, 2], values: [1, 2, 3]}}"),
              HasSubstr("2 weights cannot be spread"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
