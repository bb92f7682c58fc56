// The state machine block: transitions at events and at hits, their order, what is set, elapsed; against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(StateMachine, TakesATransitionWhereAContinuousConditionBeginsToHold) {
  // x' = 1 until x = 2 at t = 2, then x' = -3 until x = 1/2 at t = 2.5, then up again.
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: m.v, initial: 0}
  m:
    type: state_machine
    in: {x: x}
    initial: up
    states: {up: {set: {v: 1}}, down: {set: {v: -3}}}
    transitions:
      - {from: up, to: down, when: x >= 2}
      - {from: down, to: up, when: x <= 0.5}
simulation: {stop: 3, rtol: 1e-10, atol: 1e-12}
record: [x, m.state, m.v]
expect: [{signal: x, at: 2.25, value: 0}, {event: m.down, count: 1}]
)");
  EXPECT_NEAR(r.sampled("x", 2.25), 2 - 0.75, 1e-9);
  EXPECT_NEAR(r.last("x"), 1, 1e-9);
  ASSERT_EQ(r.recording().events.at("m.down").size(), 1U);
  EXPECT_NEAR(r.recording().events.at("m.down")[0], 2, 1e-9);
  EXPECT_NEAR(r.recording().events.at("m.up")[0], 2.5, 1e-9);
  EXPECT_EQ(r.at("m.state", 2, true), 1);
  EXPECT_EQ(r.at("m.state", 2.25), 2);
  EXPECT_TRUE(r.whole().verdicts[1].met);
}

TEST(StateMachine, CountsTheTimeSinceAStateWasEntered) {
  // Three states of 1, 2 and 0.5 s: state 1 at 0..1, 2 at 1..3, 3 at 3..3.5.
  const Signals r = run(R"(
parameters: {T: 0.5}
blocks:
  m:
    type: state_machine
    initial: a
    states: {a: {set: {y: 10*elapsed}}, b: {set: {y: -elapsed}}, c: {set: {y: 7}}}
    transitions:
      - {from: a, to: b, when: elapsed >= 2*T}
      - {from: b, to: c, when: elapsed >= 2}
      - {from: c, to: a, when: elapsed >= T}
simulation: {stop: 4}
record: [m.state, m.y, m.elapsed]
expect: [{signal: m.y, at: 0.5, value: 5}, {signal: m.y, at: 2.5, value: -1.5}, {signal: m.y, at: 3.75, value: 2.5}]
)");
  for (const Verdict& verdict : r.whole().verdicts)
    EXPECT_TRUE(verdict.met) << verdict.text << ": " << verdict.measured;
  EXPECT_NEAR(r.recording().events.at("m.b")[0], 1, 1e-10);
  EXPECT_NEAR(r.recording().events.at("m.c")[0], 3, 1e-10);
  EXPECT_NEAR(r.recording().events.at("m.a")[0], 3.5, 1e-10);
}

TEST(StateMachine, OfConditionsThatHoldTogetherTheFirstInTheListIsTaken) {
  const std::string head =
      "blocks:\n  m:\n    type: state_machine\n    in: {t: time}\n    initial: a\n    states: {a, b, c}\n"
      "    transitions:\n";
  const std::string to_b = "      - {from: a, to: b, when: t >= 1}\n",
                    to_c = "      - {from: a, to: c, when: t >= 1}\n";
  const std::string tail = "simulation: {stop: 2}\nrecord: [m.state]\n";
  const auto with = [&](const std::string& list) {
    Report report;
    const auto diagram = Diagram::from_text("plantloop: 1\n" + head + list + tail, "test.yaml", report);
    const auto done = diagram->run({}, report);
    EXPECT_TRUE(done) << to_text(report);
    return done->recording.at(done->recording.rows() - 1, 0);
  };
  EXPECT_EQ(with(to_b + to_c), 2);
  EXPECT_EQ(with(to_c + to_b), 3);
}

TEST(StateMachine, GoesThroughSeveralStatesInOneInstant) {
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 1}
  m:
    type: state_machine
    in: {u: u}
    initial: a
    states: {a: {set: {y: 1}}, b: {set: {y: 2}}, c: {set: {y: 3}}}
    transitions:
      - {from: a, to: b, when: u > 0.5}
      - {from: b, to: c, when: u > 0.5}
simulation: {stop: 2}
record: [m.y]
)");
  EXPECT_EQ(r.at("m.y", 1, true), 1);
  EXPECT_EQ(r.at("m.y", 1), 3);
  EXPECT_EQ(r.recording().events.at("m.b").size(), 1U);
}

TEST(StateMachine, TakesWhatHoldsAtTheStartAtTheStart) {
  const Signals r = run(R"(
blocks:
  m:
    type: state_machine
    in: {u: 3 - time}
    initial: a
    states: {a: {set: {y: 1}}, b: {set: {y: 2}}}
    transitions: [{from: a, to: b, when: u > 2}]
simulation: {stop: 1}
record: [m.y]
)");
  EXPECT_EQ(r.at("m.y", 0), 2);
}

TEST(StateMachine, WithoutEndInOneInstantIsARunError) {
  Report report;
  const auto diagram = Diagram::from_text(R"(plantloop: 1
blocks:
  m:
    type: state_machine
    in: {u: time}
    initial: a
    states: {a: {set: {y: 1}}, b: {set: {y: 2}}}
    transitions: [{from: a, to: b, when: u > 1}, {from: b, to: a, when: u > 1}]
simulation: {stop: 2}
)",
                                          "test.yaml", report);
  try {
    diagram->run({}, report);
    FAIL() << "it settled";
  } catch (const RunError& e) {
    EXPECT_THAT(e.what(), HasSubstr("events do not settle: m."));
  }
}

TEST(StateMachine, OfSampledInputsChangesAtTheirHits) {
  // The counter passes 3.5 between hits; the machine sees it at 0.4 and shows it in the same instant.
  const Signals r = run(R"(
blocks:
  n: {type: zero_order_hold, in: 10*time + 0.5, rate: 0.1}
  m:
    type: state_machine
    in: {n: n}
    initial: low
    states: {low: {set: {y: 0}}, high: {set: {y: 1}}}
    transitions:
      - {from: low, to: high, when: n > 3.7 and n < 6}
      - {from: high, to: low, when: n > 6.7 and elapsed > 0.15}
simulation: {stop: 1}
record: [m.state, m.y]
)");
  EXPECT_NEAR(r.recording().events.at("m.high")[0], 0.4, 1e-15);
  EXPECT_NEAR(r.recording().events.at("m.low")[0], 0.7, 1e-15);
  EXPECT_EQ(r.at("m.y", 0.4), 1);
  EXPECT_EQ(r.whole().statistics.events, 0);  // nothing is searched for between hits
}

TEST(StateMachine, WithARateLooksAtContinuousSignalsAtItsHitsOnly) {
  const Signals r = run(R"(
blocks:
  m:
    type: state_machine
    rate: 0.25
    in: {u: time}
    initial: a
    states: {a: {set: {y: 1}}, b: {set: {y: 2}}}
    transitions: [{from: a, to: b, when: u > 0.6}]
simulation: {stop: 1}
record: [m.y]
)");
  EXPECT_EQ(r.recording().events.at("m.b"), std::vector<double>{0.75});
}

TEST(StateMachine, IsAResetAway) {
  const Signals r = run(R"(
blocks:
  m:
    type: state_machine
    in: {u: time}
    initial: a
    reset: {when: time > 2}
    states: {a: {set: {y: elapsed}}, b: {set: {y: -elapsed}}}
    transitions: [{from: a, to: b, when: u > 1 and u < 1.5}]
simulation: {stop: 3}
record: [m.state, m.y]
expect: [{signal: m.y, at: 2.5, value: 0.5, abs: 1e-9}, {signal: m.y, at: 1.75, value: -0.75, abs: 1e-9}]
)");
  for (const Verdict& verdict : r.whole().verdicts)
    EXPECT_TRUE(verdict.met) << verdict.text << ": " << verdict.measured;
  EXPECT_EQ(r.last("m.state"), 1);
}

TEST(StateMachine, InACopyKeepsAStateOfItsOwn) {
  const Signals r = run(R"(
blocks:
  m:
    type: state_machine
    repeat: 3
    in: {u: time - index/2}
    initial: a
    states: {a: {set: {y: 0}}, b: {set: {y: 1}}}
    transitions: [{from: a, to: b, when: u > 0}]
simulation: {stop: 1.2}
record: [m.1.y, m.2.y, m.3.y]
)");
  EXPECT_EQ(r.last("m.1.y"), 1);
  EXPECT_EQ(r.last("m.2.y"), 1);
  EXPECT_EQ(r.last("m.3.y"), 0);
}

TEST(StateMachine, InsideASubsystemSeesItsParametersAndNothingElse) {
  const Signals r = run(R"(
parameters: {limit: 100}
blocks: {a: {type: t, in: time, limit: 2}}
types:
  t:
    parameters: {limit: 1}
    inputs: [u]
    blocks:
      m:
        type: state_machine
        in: {u: u}
        initial: low
        states: {low: {set: {y: -limit}}, high: {set: {y: limit}}}
        transitions: [{from: low, to: high, when: u > limit}]
    outputs: {y: m.y}
simulation: {stop: 3}
record: [a.y]
)");
  EXPECT_EQ(r.at("a.y", 0), -2);
  EXPECT_EQ(r.last("a.y"), 2);
}

TEST(StateMachine, ThatIsEnabledStandsStillWhileItIsNot) {
  const Signals r = run(R"(
blocks:
  on: where(time < 1, 0, 1)
  m:
    type: state_machine
    in: {t: time}
    enable: on
    initial: a
    states: {a: {set: {y: 5}}, b: {set: {y: 6}}}
    transitions: [{from: a, to: b, when: t > 0.5}]
simulation: {stop: 2}
record: [m.state, m.y]
)");
  EXPECT_EQ(r.at("m.y", 0.75), 5);
  EXPECT_EQ(r.last("m.y"), 6);  // the condition holds when it begins to be looked at
  EXPECT_NEAR(r.recording().events.at("m.b")[0], 1, 1e-12);
}

TEST(StateMachine, HasTheNamesOfItsStatesBesideTheirNumbers) {
  const Signals r = run(R"(
blocks:
  m: {type: state_machine, initial: off, states: {off: {set: {y: 1}}, on: {set: {y: 2}}}, transitions: [{from: off, to: on, when: elapsed > 0.5}]}
simulation: {stop: 1}
record: [m.state, m.y]
)");
  EXPECT_THAT(r.recording().columns[0].names, ElementsAre("off", "on"));
  EXPECT_TRUE(r.recording().columns[1].names.empty());
  EXPECT_THAT(to_json(r.recording()),
              HasSubstr("\"name\": \"m.state\", \"unit\": \"\", \"rate\": 0, \"names\": [\"off\", \"on\"]"));
  const RecordingResult again = from_npz(to_npz(r.recording()));
  ASSERT_TRUE(again.ok()) << again.error;
  EXPECT_THAT(again.recording.columns[0].names, ElementsAre("off", "on"));
}

TEST(StateMachine, DoesNotDependOnTheOrderOfTheBlocks) {
  const std::string x = "  x: {type: integrator, in: m.v}\n";
  const std::string m =
      "  m: {type: state_machine, in: {x: x}, initial: up, states: {up: {set: {v: 1}}, down: {set: {v: -2}}}, "
      "transitions: "
      "[{from: up, to: down, when: x > 1}, {from: down, to: up, when: x < 0}]}\n";
  const std::string rest = "simulation: {stop: 5}\nrecord: [x, m.v]\n";
  const Signals one = run("blocks:\n" + x + m + rest), two = run("blocks:\n" + m + x + rest);
  EXPECT_EQ(one.column("x"), two.column("x"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
