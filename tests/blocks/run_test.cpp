// What ends a run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/error.h"
#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::StrEq;

TEST(Stop, EndsTheRunAtALocatedInstant) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: 2*time}
  end: {type: stop, in: x - 4}
simulation: {stop: 10}
)");
  EXPECT_NEAR(r.recording().time().back(), 2, 1e-9);
  EXPECT_NEAR(r.last("x"), 4, 1e-8);
  EXPECT_EQ(r.last("end"), 1);
  EXPECT_EQ(r.whole().statistics.ended_by, "end");
}

TEST(Stop, EndsTheRunAtASampleAStepOrTheStart) {
  const auto end = [](const std::string& condition) {
    return run("blocks:\n  end: {type: stop, in: " + condition +
               "}\n  k: {type: unit_delay, in: k + 1, rate: 0.1}\n"
               "  u: {type: step, time: 0.25}\nsimulation: {stop: 1}\n");
  };
  EXPECT_EQ(end("k > 3.5").recording().time().back(), 0.4);
  EXPECT_EQ(end("u").recording().time().back(), 0.25);
  EXPECT_EQ(end("1").recording().time().back(), 0);
  EXPECT_EQ(end("[u, k > 1.5]").recording().time().back(), 0.2);
  const Signals whole = end("0");
  EXPECT_EQ(whole.recording().time().back(), 1);
  EXPECT_EQ(whole.whole().statistics.ended_by, "");
}

TEST(Stop, LeavesWhatWasExpectedLaterOpen) {
  const Signals r =
      run("blocks:\n  x: {type: integrator, in: 1}\n  end: {type: stop, in: x - 2}\n"
          "simulation: {stop: 10}\nexpect: [{signal: x, at: 1, value: 1, abs: 1e-9}, {signal: x, at: 5, value: 5}]\n");
  EXPECT_TRUE(r.whole().verdicts[0].met);
  EXPECT_FALSE(r.whole().verdicts[1].met);
  EXPECT_THAT(r.whole().verdicts[1].measured, StrEq("not measured: 'end' ended the run before"));
}

TEST(Stop, EndsWithEverySolverAndStep) {
  for (const RunRequest& request : {RunRequest{.step = 0.3, .solver = "rk4"}, RunRequest{.solver = "bdf"}}) {
    const Signals r =
        run("blocks:\n  x: {type: integrator, in: 1}\n  end: {type: stop, in: x - pi}\n"
            "simulation: {stop: 10}\n",
            request);
    EXPECT_NEAR(r.recording().time().back(), std::acos(-1), 1e-9);
  }
}

std::string message_of(const std::string& text) {
  try {
    run(text);
  } catch (const RunError& error) {
    return error.what();
  }
  return "the run went on";
}

TEST(Assertion, EndsTheRunWithItsMessage) {
  EXPECT_THAT(
      message_of("blocks:\n  x: {type: integrator, in: 1}\n  dry: {type: assertion, in: 2 - x, message: \"{x} is 2\"}\n"
                 "simulation: {stop: 10}\n"),
      StrEq("at time 2 s the assertion 'dry' does not hold: {x} is 2"));
  EXPECT_THAT(
      message_of(
          "blocks:\n  k: {type: unit_delay, in: k + 1, rate: 0.5}\n  few: {type: assertion, in: \"[1, k < 3]\"}\n"
          "simulation: {stop: 10}\n"),
      StrEq("at time 1.5 s the assertion 'few' does not hold"));
  EXPECT_THAT(message_of("blocks: {never: {type: assertion, in: 0}}\nsimulation: {stop: 10}\n"),
              StrEq("at time 0 s the assertion 'never' does not hold"));
}

TEST(Assertion, DoesNotMindWhatHolds) {
  EXPECT_EQ(run("blocks: {always: {type: assertion, in: 1 + time}}\nsimulation: {stop: 1}\n").last("always"), 1);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
