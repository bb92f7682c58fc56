// S11: algebraic loops, against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double rounding = 1e-14;  // what is left of an equation of size 1 that was solved to rounding

std::string error_of(const std::string& text) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  if (!diagram) return to_text(report);
  try {
    if (!diagram->run({}, report)) return to_text(report);
  } catch (const RunError& e) {
    return e.what();
  }
  return {};
}

TEST(S11Loops, OfOneLinearUnknownAreSolvedByAnExpression) {
  // e = 1 - x - k e, x' = e: x = 1 - exp(-t/(1 + k)).
  const Signals r = run(R"yaml(
parameters: {k: 2}
blocks:
  x: {type: integrator, in: e}
  e: 1 - x - k*e
  difference: x - (1 - exp(-time/(1 + k)))
  left_over: 1 - x - k*e - e
simulation: {stop: 5, rtol: 1e-11, atol: 1e-13}
)yaml");
  EXPECT_LT(r.greatest("difference"), 1e-10);
  EXPECT_LT(r.greatest("left_over"), rounding);
}

TEST(S11Loops, OfTwoLinearUnknownsSolveACoupledMassMatrix) {
  // [2 c; c 1] a = [sin t; cos t]; the first integrals in closed form.
  for (const char* solver : {"dopri5", "bdf", "adams"}) {
    const Signals r = run(std::string(R"yaml(
parameters: {m1: 2, m2: 1, c: 0.5}
blocks:
  a1: (sin(time) - c*a2)/m1
  a2: (cos(time) - c*a1)/m2
  v1: {type: integrator, in: a1}
  v2: {type: integrator, in: a2}
  det: m1*m2 - c^2
  d1: v1 - (m2*(1 - cos(time)) - c*sin(time))/det
  d2: v2 - (m1*sin(time) - c*(1 - cos(time)))/det
simulation: {stop: 4, rtol: 1e-10, atol: 1e-12, solver: )yaml") +
                          solver + "}\n");
    EXPECT_LT(r.greatest("d1"), 2e-8) << solver;
    EXPECT_LT(r.greatest("d2"), 2e-8) << solver;
  }
}

TEST(S11Loops, ThatAreNonlinearAreSolvedToRounding) {
  // y + y^3 = x, x' = -y - 3 y^3 from x = 2: y = exp(-t).
  for (const char* solver : {"dopri5", "bdf"}) {
    const Signals r = run(std::string(R"yaml(
blocks:
  x: {type: integrator, in: -y - 3*y^3, initial: 2}
  y: x - y^3
  difference: y - exp(-time)
  left_over: x - y^3 - y
simulation: {stop: 3, rtol: 1e-10, atol: 1e-12, solver: )yaml") +
                          solver + "}\n");
    EXPECT_LT(r.greatest("difference"), 1e-8) << solver;
    EXPECT_LT(r.greatest("left_over"), rounding) << solver;
  }
}

TEST(S11Loops, WithModesInsideStillLocateTheirEvents) {
  // y = t - sat(y): t/2 up to the limit at t = 2, then t - 1.
  const Signals r = run(R"yaml(
blocks:
  y: time - limited
  limited: {type: saturation, in: y, lower: -1, upper: 1}
  x: {type: integrator, in: y}
  difference: y - where(time < 2, time/2, time - 1)
simulation: {stop: 4, rtol: 1e-10, atol: 1e-12}
)yaml");
  EXPECT_LT(r.greatest("difference"), 1e-13);
  EXPECT_NEAR(r.last("x"), 1 + 6 - 2, 1e-12);
  EXPECT_EQ(r.whole().statistics.events, 1);
}

TEST(S11Loops, OfSampledBlocksAreSolvedAtTheirHits) {
  // e = r - u, u = sat(3 e): e = r/4 up to the limit, then r - 0.6.
  const Signals r = run(R"yaml(
blocks:
  e: {expr: time - u, rate: 0.1}
  u: {type: saturation, in: 3*e, lower: -0.6, upper: 0.6}
simulation: {stop: 2}
record: [e, u]
)yaml");
  EXPECT_NEAR(r.at("e", 0.4), 0.1, 1e-15);
  EXPECT_NEAR(r.at("u", 0.4), 0.3, 1e-15);
  EXPECT_NEAR(r.at("e", 1.5), 0.9, 1e-15);
  EXPECT_EQ(r.at("e", 1.55), r.at("e", 1.5));
}

TEST(S11Loops, ThroughASampledPartAreSolvedAtItsHitsAndOpenInBetween) {
  // y = t - 0.5 z with z sampled from y: at a hit y = t/1.5, between hits z stays.
  const Signals r = run(R"yaml(
blocks:
  y: time - 0.5*z
  z: {type: zero_order_hold, in: y, rate: 1}
  x: {type: integrator, in: y}
simulation: {stop: 2.5}
record: [y, z]
)yaml");
  EXPECT_NEAR(r.at("y", 1), 1 / 1.5, 1e-15);
  EXPECT_NEAR(r.at("z", 2), 2 / 1.5, 1e-15);
  EXPECT_NEAR(r.at("y", 2.5), 2.5 - 1 / 1.5, 1e-15);
}

TEST(S11Loops, MayGiveInitialValues) {
  const Signals r = run(R"yaml(
blocks:
  y: 2 - y^3 + 0*x
  x: {type: first_order, in: y, initial: y}
simulation: {stop: 1}
)yaml");
  EXPECT_NEAR(r.at("x", 0), 1, 1e-14);
  EXPECT_NEAR(r.last("x"), 1, 1e-14);
}

TEST(S11Loops, WithoutASolutionEndTheRunWithPathNearestTryAndRemedies) {
  EXPECT_EQ(error_of(R"yaml(
blocks:
  power: y^2
  y: power + 1 + 0*time
simulation: {stop: 1}
)yaml"),
            "at time 0 s no values are found that satisfy the algebraic loop power -> y -> power\n"
            "  the nearest try: 'power' = -0.5, where its equation is off by 0.75\n"
            "  a state breaks the loop: the lag or integrator that is there in the plant, or, in sampled parts, a "
            "unit_delay\n"
            "  or an algebraic_constraint states the equation, with bounds and an initial_guess near its solution\n"
            "  a delay of one step in a continuous loop is no remedy: the result would depend on the step");
}

TEST(S11Loops, WhoseSolutionEndsEndTheRunThere) {
  // y^2 - y + t = 0 has its last solution at t = 1/4.
  const std::string text = error_of(R"yaml(
blocks:
  y: y^2 + time
  x: {type: integrator, in: y}
simulation: {stop: 1}
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("at time 0.25 s no values are found that satisfy the algebraic loop y -> y"),
                          HasSubstr("'y' = 0.5")));
}

TEST(S11Loops, ThatParametersLeaveOpenAreReportedAtTheStart) {
  EXPECT_EQ(error_of("parameters: {k: 1}\nblocks: {y: k*y + time}\nsimulation: {stop: 1}\n"),
            "the equations of the algebraic loop y -> y hold for many values, or for none: with these parameters all "
            "that goes round in it cancels");
}

TEST(S11Loops, ThatHoldForEveryValueAreFoundByCheck) {
  EXPECT_THAT(findings("blocks: {a: b + time, b: a}\nsimulation: {stop: 1}\n"),
              HasSubstr("the equations of the algebraic loop a -> a hold for every 'a', or for none"));
}

TEST(S11Loops, AreANoteOrOnRequestAnError) {
  const std::string blocks = "blocks:\n  a: b + 1\n  b: {type: gain, k: 0.5, in: a}\n";
  const std::string note = findings(blocks + "simulation: {stop: 1}\n");
  EXPECT_THAT(note, AllOf(HasSubstr("note: algebraic loop: a -> b -> a; its values are found by iteration"),
                          Not(HasSubstr("error"))));
  const std::string error = findings(blocks + "simulation: {stop: 1, loops: error}\n");
  EXPECT_THAT(error, AllOf(HasSubstr("error: algebraic loop: a -> b -> a"), HasSubstr("put a state into the loop")));
  EXPECT_EQ(run(blocks + "simulation: {stop: 1}\n").last("a"), 2);
}

TEST(S11Loops, OfConditionsOnlyAreErrors) {
  EXPECT_THAT(findings("blocks: {a: not b, b: a and time > 1}\nsimulation: {stop: 1}\n"),
              AllOf(HasSubstr("error: algebraic loop: a -> b -> a"), HasSubstr("only true and false go round in it")));
}

TEST(S11Loops, OfTwoRatesAreErrors) {
  EXPECT_THAT(findings(R"yaml(
blocks:
  a: {expr: time - b, rate: 0.1}
  b: {expr: 0.5*a, rate: 0.2}
simulation: {stop: 1}
)yaml"),
              AllOf(HasSubstr("error: algebraic loop: a -> b -> a"), HasSubstr("parts of two rates")));
}

TEST(S11Loops, AreSolvedWhereTheUnknownPassesThroughZeroBesideLargeTerms) {
  // The node of an amplifier: y is 1e-12 of the other voltages, and so is what rounding leaves of its equation.
  const Signals r = run(R"yaml(
parameters: {bias: 3}
blocks:
  v: {type: integrator, in: 0, initial: bias}
  u: {type: integrator, in: 1e-12, initial: -1e-12}
  y: {type: algebraic_constraint, residual: (y - u)/1000 + 2*(y + v)/9000 - 2*bias/9000 + 1e-8*(exp(y) - 1)}
simulation: {stop: 2}
)yaml");
  // Rounding of the terms, 6/9000, moves the solution by as much times 1000.
  for (const double t : {0.5, 1.0, 1.5, 2.0}) EXPECT_NEAR(r.at("y", t), 1e-12 * (t - 1) / (11.0 / 9 + 1e-5), 1e-15);
}

TEST(S11Loops, OfSampledBlocksSettleWhereTwoBranchesMeet) {
  // At r = 0.8 the limit is reached exactly: rounding puts the input on either side of it.
  for (const double r : {0.8, 0.7999999999999999, 0.8000000000000002}) {
    const Signals s = run("blocks:\n  e: {expr: " + fmt::format("{:.17g}", r) +
                          " + 0*time - u, rate: 0.1}\n  u: {type: saturation, in: 3*e, lower: -0.6, upper: 0.6}\n"
                          "simulation: {stop: 0.2}\nrecord: [e, u]\n");
    EXPECT_NEAR(s.last("u"), 0.6, 1e-15);
  }
}

TEST(S11Loops, OfSampledBlocksWhoseBranchesDoNotSettleAreARunErrorThatNamesThem) {
  EXPECT_THAT(error_of(R"yaml(
blocks:
  y: {expr: "where(z > 0.5, 0, 1)", rate: 0.1}
  z: 0.9*y + 0.01
simulation: {stop: 1}
)yaml"),
              HasSubstr("at time 0 s the algebraic loop y -> z -> y does not settle: solved 20 times, and the branch "
                        "that is taken in 'y' changes each time\n  a state breaks the loop"));
}

TEST(S11Loops, ThroughAnEnabledPartAreSolvedWhileItIsActive) {
  // Inactive e = t; active e = t - 3 e.
  const Signals r = run(R"yaml(
blocks:
  e: time - part.y
  part: {type: p, in: {u: e}, enable: {when: time > 1, outputs: reset}}
types:
  p: {inputs: [u], blocks: {y: 3*u}, outputs: {y: {from: y, initial: 0}}}
simulation: {stop: 2}
record: [e, part.y]
)yaml");
  EXPECT_EQ(r.at("e", 0.5), 0.5);
  EXPECT_NEAR(r.at("e", 1.5), 0.375, 1e-14);
  EXPECT_NEAR(r.at("part.y", 2), 1.5, 1e-14);
}

TEST(S11Loops, ThroughAnEnabledPartThatIsNonlinearKeepItsHeldOutput) {
  // Active while t < 1: y + y^3 = t - y... e = t - y, y = e + e^3; then y holds its value at t = 1.
  const Signals r = run(R"yaml(
blocks:
  e: time - part.y
  part: {type: p, in: {u: e}, enable: time < 1}
  left_over: where(time < 1, e + e^3 - part.y, 0)
types:
  p: {inputs: [u], blocks: {y: u + u^3}, outputs: {y: {from: y, initial: 0}}}
simulation: {stop: 2}
record: [e, part.y, left_over]
)yaml");
  EXPECT_LT(r.greatest("left_over"), 1e-9);
  // 2 e + e^3 = 1 has the solution 0.4533976515164037.
  EXPECT_NEAR(r.last("part.y"), 1 - 0.4533976515164037, 1e-9);
  EXPECT_NEAR(r.last("e"), 2 - (1 - 0.4533976515164037), 1e-9);
}

TEST(S11Loops, ThroughATriggeredPartOrItsOwnConditionAreErrors) {
  const auto with = [](const std::string& key) {
    return findings("blocks:\n  e: time - part.y\n  part: {type: p, in: {u: e}, " + key +
                    "}\ntypes:\n  p: {inputs: [u], blocks: {y: 3*u}, outputs: {y: {from: y, initial: 0}}}\n"
                    "simulation: {stop: 2}\n");
  };
  for (const char* key : {"trigger: {when: time > 1}", "enable: e > 1"}) {
    EXPECT_THAT(with(key), AllOf(HasSubstr("error: algebraic loop: e -> part"),
                                 HasSubstr("a part of it is triggered, or decides by its own value whether it runs")));
  }
}

TEST(S11Loops, DoNotDependOnTheOrderOfTheBlocks) {
  const std::string rest = "simulation: {stop: 2, output_interval: 0.5}\nrecord: [x, y, z]\n";
  const Signals one =
      run("blocks:\n  x: {type: integrator, in: y - z}\n  y: cos(time) - 0.3*z^3 - x\n  z: 0.5*y - sin(z)\n" + rest);
  const Signals two =
      run("blocks:\n  z: 0.5*y - sin(z)\n  y: cos(time) - 0.3*z^3 - x\n  x: {type: integrator, in: y - z}\n" + rest);
  for (const char* name : {"x", "y", "z"}) EXPECT_EQ(one.column(name), two.column(name)) << name;
}

}  // namespace
}  // namespace plantloop::testing_diagrams
