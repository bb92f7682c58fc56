// S18 and limits: how runs end when they cannot go on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string error_of(const std::string& text, const RunControl& control = {}) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  if (!diagram) return to_text(report);
  try {
    if (!diagram->run({}, report, control)) return to_text(report);
  } catch (const std::exception& e) {
    return e.what();
  }
  return {};
}

TEST(S18NotANumber, NamesTheOperationTheBlockAndTheLine) {
  const std::string text = error_of(R"yaml(
blocks:
  level: {type: integrator, in: -1, initial: 1}
  inverse: 1/(level - 0.5)
  root: sqrt(level)
  outflow: {type: gain, in: root, k: 3}
simulation: {stop: 2}
record: [outflow]
)yaml");
  EXPECT_THAT(text,
              AllOf(HasSubstr("'outflow'"), HasSubstr("sqrt(-"), HasSubstr("block 'root'"), HasSubstr("test.yaml:6:")));
}

// The slope of y grows without end, but exists, until x is 0; behind it there is no root.
TEST(S18NotANumber, RightBehindTheLastStepIsNamed) {
  for (const char* solver : {"dopri5", "bdf"}) {
    const std::string text = error_of(std::string(R"yaml(
blocks:
  x: {type: integrator, in: -1, initial: 1}
  s: sqrt(x)
  l: log(s) + 1
  y: {type: integrator, in: l}
simulation: {stop: 3, solver: )yaml") +
                                      solver + "}\nrecord: [y]\n");
    EXPECT_THAT(text, AllOf(HasSubstr("right behind it the derivative of 'y' is not finite"), HasSubstr("sqrt(-"),
                            HasSubstr("in block 's' (test.yaml:5:")));
  }
}

TEST(S18NotANumber, ADivisionByZeroIsNamed) {
  const std::string text = error_of(R"yaml(
blocks:
  u: {type: step, time: 1, before: 2, after: 0}
  q: 1/u
simulation: {stop: 2}
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("at time 1 s"), HasSubstr("'q'"), HasSubstr("1 / 0"), HasSubstr("test.yaml:5:")));
}

TEST(S18NotANumber, ASideThatIsNotTakenIsNotLookedAt) {
  const Signals r = run(R"yaml(
blocks:
  level: {type: integrator, in: -1, initial: 1}
  root: where(level > 0, sqrt(level), 0)
  x: {type: integrator, in: "where(level > 0, sqrt(level), 0) + where(level < -5, log(level), 0)"}
simulation: {stop: 2, solver: bdf}
record: [root, x]
)yaml");
  EXPECT_NEAR(r.last("x"), 2.0 / 3, 1e-3);
  EXPECT_EQ(r.last("root"), 0);
}

TEST(S18NotANumber, IsNotBlamedOnASideThatIsNotTaken) {
  const std::string text = error_of(R"yaml(
blocks:
  a: {type: integrator, in: -1, initial: 1}
  aside: where(a > 5, sqrt(a - 5), 0)
  b: aside + log(a + 0.5)
simulation: {stop: 2}
record: [b]
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("block 'b'"), HasSubstr("log("), Not(HasSubstr("aside"))));
}

TEST(S18NotANumber, ThroughADelayIsBlamedOnWhatDividesByIt) {
  const std::string text = error_of(R"yaml(
blocks:
  u: {type: step, time: 0.3, before: 2, after: 0}
  late: {type: transport_delay, in: u, delay: 0.5, initial: 2}
  q: 8/late
simulation: {stop: 2}
record: [q]
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("8 / 0"), HasSubstr("block 'q'")));
}

TEST(S18NotANumber, InASampledStateIsFoundThoughNobodyRecordsIt) {
  const std::string text = error_of(R"yaml(
blocks:
  t: {type: clock}
  memory: {type: unit_delay, in: sqrt(0.25 - t), rate: 0.1}
  shown: {type: gain, in: t, k: 2}
simulation: {stop: 2}
record: [shown]
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("'memory'"), HasSubstr("sqrt(-0.05)"), HasSubstr("at time 0.3 s")));
}

TEST(S18NotANumber, InAnInitialValueIsFoundAtTheStart) {
  const std::string text = error_of(R"yaml(
blocks:
  u: {type: constant, value: -2}
  x: {type: integrator, in: 1, initial: sqrt(u)}
simulation: {stop: 2}
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("x"), HasSubstr("not a number"))) << text;
}

// With its modes frozen no step would get across the point where the level is gone.
TEST(S18NotANumber, AStepGetsAcrossTheEndOfWhatItSelected) {
  for (const char* solver : {"solver: dopri5", "solver: bogacki_shampine", "solver: bdf", "solver: adams",
                             "solver: rk4, step: 0.03", "solver: heun, step: 0.01"}) {
    // h' = -sqrt(h) from 1: h = (1 - t/2)^2, empty at 2 s, and then it stays empty; filled again from 3 s on.
    const Signals r = run(std::string(R"yaml(
blocks:
  inflow: {type: step, time: 3}
  outflow: where(h > 0, sqrt(h), 0)
  h: {type: integrator, in: inflow - outflow - 0.01, initial: 1}
  total: {type: integrator, in: outflow}
simulation: {stop: 4, )yaml") +
                          solver + "}\nrecord: [h, outflow, total]\n");
    EXPECT_NEAR(r.at("h", 1), 0.25, 0.02) << solver;
    EXPECT_NEAR(r.last("h") + r.last("total"), 1 + 1 - 0.04, 1e-3) << solver << ": nothing is lost";
  }
}

TEST(S9Failures, AStepSizeThatCollapsesNamesTheState) {
  for (const char* solver : {"dopri5", "bogacki_shampine", "adams", "bdf"}) {
    const std::string text = error_of(std::string(R"yaml(
blocks:
  slow: {type: integrator, in: 1}
  runaway: {type: integrator, in: runaway^2, initial: 1}
simulation: {stop: 2, solver: )yaml") +
                                      solver + "}\n");
    EXPECT_THAT(text, AllOf(HasSubstr("at t = "), HasSubstr("state 'runaway' changes too fast there"))) << solver;
    EXPECT_THAT(text, Not(HasSubstr("\n"))) << solver;
  }
}

TEST(S9Failures, AFixedStepThatIsTooLongNamesTheState) {
  const std::string text = error_of(R"yaml(
blocks:
  slow: {type: integrator, in: 1}
  runaway: {type: integrator, in: runaway^2, initial: 1}
simulation: {stop: 20, solver: rk4, step: 0.1}
)yaml");
  EXPECT_THAT(text, HasSubstr("runaway"));
}

TEST(Limits, TooManyRowsAreRefusedBeforehandWithTheAmount) {
  const std::string text = error_of(R"yaml(
blocks:
  x: {type: integrator, in: 1}
simulation: {stop: 1000, solver: rk4, step: 0.001, max_rows: 1e5}
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("1000000 rows"), HasSubstr("100000"), HasSubstr("max_rows")));
}

TEST(Limits, RowsOfEventsAreCountedToo) {
  const std::string text = error_of(R"yaml(
blocks:
  n: {type: discrete_integrator, in: 1, rate: 0.001}
simulation: {stop: 1000, max_rows: 1e4}
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("10000"), HasSubstr("max_rows")));
}

TEST(S9Limits, HitsOfARateAreForeseen) {
  const std::string text = R"yaml(
blocks:
  n: {type: discrete_integrator, in: 1, rate: 1e-9}
simulation: {stop: 1)yaml";
  EXPECT_THAT(error_of(text + "}"),
              AllOf(HasSubstr("the rate of 1e-09 s, that of 'n', has its hit 1e+09 times until 1 s"),
                    HasSubstr("the limit is 100000000 (simulation: max_steps)"), HasSubstr("a longer period")));
  EXPECT_THAT(error_of(text + ", max_steps: 1e10}"),
              AllOf(HasSubstr("each of which is a row"), HasSubstr("max_rows"), HasSubstr("an output_interval")));
  EXPECT_THAT(error_of(R"yaml(
blocks:
  u: {type: pulse, period: 1e-9, width: 1e-10}
  x: {type: integrator, in: u}
simulation: {stop: 1}
)yaml"),
              HasSubstr("the source 'u' has an edge"));
}

TEST(S9Limits, ARunThatDivergesSaysSoWhereItEnds) {
  EXPECT_THAT(error_of(R"yaml(
blocks:
  x: {type: integrator, in: 10*x, initial: 1}
  w: {type: integrator, in: 100*cos(300*time)}
simulation: {stop: 100, max_steps: 2000}
)yaml"),
              AllOf(HasSubstr("2000 steps"), HasSubstr("state 'x' has grown to"), HasSubstr("may diverge")));
}

TEST(S9Limits, AFastInputIsNotCalledStiff) {
  const std::string text = error_of(R"yaml(
blocks:
  x: {type: integrator, in: cos(1000*time)}
simulation: {stop: 10000, max_steps: 3000}
)yaml");
  EXPECT_THAT(text, AllOf(HasSubstr("3000 steps"), HasSubstr("the fastest state is 'x'"),
                          HasSubstr("what drives it is that fast"), Not(HasSubstr("stiff"))));
}

TEST(Limits, TooManyStepsEndTheRun) {
  EXPECT_THAT(error_of(R"yaml(
blocks:
  x: {type: integrator, in: cos(1000*time)}
simulation: {stop: 1000, max_steps: 500}
)yaml"),
              AllOf(HasSubstr("500 steps"), HasSubstr("max_steps")));
  EXPECT_THAT(error_of(R"yaml(
blocks:
  x: sin(time)
simulation: {stop: 1000, max_step: 1e-290}
)yaml"),
              AllOf(HasSubstr("steps"), HasSubstr("max_steps")));
}

TEST(Limits, ARunCanBeStoppedFromOutside) {
  std::atomic<bool> cancel = true;
  RunControl control;
  control.cancel = &cancel;
  for (const char* text : {"blocks:\n  x: {type: integrator, in: 1}\nsimulation: {stop: 10}\n",
                           "blocks:\n  x: {type: integrator, in: 1}\nsimulation: {stop: 10, solver: rk4, step: 0.1}\n",
                           "blocks:\n  x: {type: discrete_integrator, in: 1, rate: 1}\nsimulation: {stop: 10}\n",
                           "blocks:\n  x: sin(time)\nsimulation: {stop: 10}\n"}) {
    EXPECT_THAT(error_of(text, control), HasSubstr("stopped at time 0 s")) << text;
  }
}

TEST(Limits, OfTimeEndALongRun) {
  RunControl control;
  control.time_limit = 0.05;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(error_of("blocks:\n  x: {type: integrator, in: cos(1e5*time)}\nsimulation: {stop: 1e6}\n", control),
              HasSubstr("time limit"));
  EXPECT_THAT(
      error_of("blocks:\n  x: {type: discrete_integrator, in: 1, rate: 1e-3}\nsimulation: {stop: 50000}\n", control),
      HasSubstr("time limit"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST(Limits, WhatWasRecordedUntilAFailureIsHandedOut) {
  Report report;
  const auto diagram = Diagram::from_text(R"yaml(plantloop: 1
blocks:
  a: {type: integrator, in: -1, initial: 1}
  b: sqrt(a)
simulation: {stop: 2}
)yaml",
                                          "test.yaml", report);
  DiagramRun partial;
  EXPECT_THROW(diagram->run({}, report, {}, &partial), RunError);
  ASSERT_GT(partial.recording.rows(), 100u);
  EXPECT_NEAR(partial.recording.time().back(), 1, 0.01);
}

TEST(InitialValues, MayReadSignals) {
  const Signals r = run(R"yaml(
blocks:
  u: {type: step, time: 1, before: 3, after: 5}
  y: 2*u + x
  x: {type: integrator, in: 0, initial: u + 1}
  z: {type: integrator, in: 0, initial: y}
  d: {type: unit_delay, in: z, rate: 0.5, initial: y + z}
simulation: {stop: 1}
record: [x, z, d]
)yaml");
  EXPECT_EQ(r.column("x").front(), 4);
  EXPECT_EQ(r.column("z").front(), 10);
  EXPECT_EQ(r.column("d").front(), 20);
}

TEST(InitialValues, ThatDependOnEachOtherAreReported) {
  EXPECT_THAT(findings(R"yaml(
blocks:
  x: {type: integrator, in: 1, initial: y + 1}
  y: {type: integrator, in: 1, initial: x}
simulation: {stop: 2}
)yaml"),
              AllOf(HasSubstr("initial values depend on each other"), HasSubstr("x -> y")));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
