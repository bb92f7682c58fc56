// S17: severities, `checks:` and strictness, and what is noticed during a run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

struct Outcome {
  std::string text, json, sarif;
  bool ran = false, wrong = false;
};

Outcome outcome(const std::string& text, bool strict = false) {
  Report report;
  if (strict) report.make_strict();
  Outcome o;
  if (const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report)) {
    try {
      o.ran = diagram->run({}, report).has_value();
    } catch (const RunError& e) {
      o.text = e.what();
    }
  }
  o.text += to_text(report);
  o.json = to_json(report);
  o.sarif = to_sarif(report);
  o.wrong = report.has_errors();
  return o;
}

// A machine with a state that no transition reaches: a warning.
const std::string unreachable = R"(
blocks:
  m: {type: state_machine, initial: a, states: {a: {set: {y: 1}}, b: {set: {y: 2}}}, transitions: [{from: b, to: a, when: elapsed > 1}]}
simulation: {stop: 1}
record: [m.y]
)";

TEST(S17Checks, AreWarningsThatDoNotStopARun) {
  const Outcome o = outcome(unreachable);
  EXPECT_TRUE(o.ran);
  EXPECT_FALSE(o.wrong);
  EXPECT_THAT(o.text, HasSubstr("warning: the state 'b' of 'm' cannot be reached from 'a'"));
  EXPECT_THAT(o.json, HasSubstr("\"severity\": \"warning\", \"id\": \"unreachable-state\""));
}

TEST(S17Checks, AreErrorsWhenStrict) {
  EXPECT_FALSE(outcome(unreachable, true).ran);
  EXPECT_THAT(outcome(unreachable, true).text, HasSubstr("error: the state 'b'"));
  std::string strict = unreachable;
  strict.replace(strict.find("{stop: 1}"), 9, "{stop: 1, strict: true}");
  EXPECT_THAT(outcome(strict).text, HasSubstr("error: the state 'b'"));
}

TEST(S17Checks, HaveTheSeverityThatTheFileGivesThem) {
  EXPECT_THAT(outcome(unreachable + "checks: {unreachable-state: error}\n").text, HasSubstr("error: the state 'b'"));
  EXPECT_THAT(outcome(unreachable + "checks: {unreachable-state: note}\n", true).text,
              HasSubstr("note: the state 'b'"));
}

TEST(S17Checks, ThatAreSilencedAreVisibleInTheReport) {
  const Outcome o = outcome(unreachable + "checks: {unreachable-state: off}\n");
  EXPECT_TRUE(o.ran);
  EXPECT_EQ(o.text, "checks: 'unreachable-state' is off in this file: 1 finding is not shown\n");
  EXPECT_THAT(o.json, HasSubstr("\"severity\": \"off\", \"id\": \"unreachable-state\""));
  EXPECT_THAT(o.sarif, HasSubstr(R"("suppressions": [{"kind": "inSource"}])"));
}

// What was noticed until a run fails is told with the failure: here sqrt of a negative number after 1 s.
TEST(S17Checks, TellWhatARunNoticedAlsoWhereItFails) {
  const Outcome o = outcome(R"(
blocks:
  y: {type: saturation, in: 5 + time, lower: -1, upper: 1}
  never: {type: gain, in: time, k: 2, enable: {when: time - 7, initial: 0}}
  x: {type: integrator, in: y + sqrt(1 - time)}
simulation: {stop: 10}
record: [x, never]
)");
  EXPECT_FALSE(o.ran);
  EXPECT_THAT(o.text, AllOf(HasSubstr("t = 1 s"), HasSubstr("warning: 'y' was at a limit for 100 % of the run"),
                            HasSubstr("warning: 'never' was never active")));
}

TEST(S17Checks, MustExistAndMustNotBeFixed) {
  EXPECT_THAT(outcome("blocks: {y: 1}\nsimulation: {stop: 1}\nchecks: {unreachable-stat: off}\n").text,
              AllOf(HasSubstr("there is no check 'unreachable-stat'"), HasSubstr("did you mean 'unreachable-state'?")));
  EXPECT_THAT(outcome("blocks: {y: 1}\nsimulation: {stop: 1}\nchecks: {unconnected: off}\n").text,
              HasSubstr("'unconnected' is an error in any case: nothing runs with it"));
}

TEST(S17Checks, HaveNamesInOrderAndADescription) {
  for (std::size_t i = 0; i < checks().size(); ++i) {
    EXPECT_FALSE(checks()[i].doc.empty());
    if (i > 0) {
      EXPECT_LT(checks()[i - 1].id, checks()[i].id);
    }
  }
}

TEST(S17Run, SaysWhatWasAtALimitForNearlyAllTheTime) {
  const std::string text = R"(
blocks:
  u: {type: saturation, in: 5 - 0.1*time, upper: LIMIT}
simulation: {stop: 10}
)";
  const auto with = [&](const char* limit) {
    std::string t = text;
    return outcome(t.replace(t.find("LIMIT"), 5, limit)).text;
  };
  EXPECT_THAT(with("4.03"), HasSubstr("test.yaml:4:3: warning: 'u' was at a limit for 97 % of the run"));
  EXPECT_THAT(with("4.2"), IsEmpty());  // 80 %
}

// The same input, sampled: at 4.03 the last hit at the limit is at 9.6 s and holds until 9.7 s.
TEST(S17Run, SaysWhatSampledBlockWasAtALimit) {
  EXPECT_THAT(outcome(R"(
blocks:
  u: {type: saturation, in: 5 - 0.1*time, upper: 4.035, rate: 0.1}
  v: {type: saturation, in: 5 - 0.1*time, upper: 4.2, rate: 0.1}
simulation: {stop: 10}
)")
                  .text,
              AllOf(HasSubstr("'u' was at a limit for 97 % of the run"), Not(HasSubstr("'v'"))));
}

// Limits of controllers count, whatever anti-windup does with them; what clips a table's input is no limit of a block.
TEST(S17Run, SaysWhatControllerWasAtALimit) {
  EXPECT_THAT(outcome(R"(
blocks:
  a: {type: pi, in: 1 + time, kp: 2, ki: 1, upper: 1}
  b: {type: discrete_pid, in: 1 + time, kp: 2, ki: 1, upper: 1, rate: 0.1}
  c: {type: pid, in: 1 + time, kp: 2, ki: 1, lower: 0, upper: 1, anti_windup: clamp}
  d: {type: lookup_1d, in: 5 + time, x: [0, 1], y: [0, 1], outside: clip}
simulation: {stop: 1}
)")
                  .text,
              AllOf(HasSubstr("'a' was at a limit for 100 %"), HasSubstr("'b' was at a limit for 100 %"),
                    HasSubstr("'c' was at a limit for 100 %"), Not(HasSubstr("'d'"))));
}

TEST(S17Run, SaysWhatWasNeverActive) {
  EXPECT_THAT(
      outcome(R"(
blocks:
  a: {expr: 1, enable: {when: time > 5, initial: 0}}
  b: {expr: 1, trigger: {when: time > 5, initial: 0}}
  c: {expr: 1, enable: {when: time < 5, initial: 0}}
  d: {expr: 1, enable: {when: time > 0.5, initial: 0}}
simulation: {stop: 1}
)")
          .text,
      AllOf(HasSubstr("warning: 'a' was never active: its condition did not hold once in the run"),
            HasSubstr("warning: 'b' was not triggered once in the run"), Not(HasSubstr("'c'")), Not(HasSubstr("'d'"))));
}

TEST(S17Run, NamesTheFastestStateWhenStepsCollapse) {
  // fast follows x within 1e-7 s; an explicit method must follow it for 1 s, in steps of some 3e-7 s.
  EXPECT_THAT(outcome(R"(
blocks:
  x: {type: integrator, in: -x, initial: 1}
  fast: {type: integrator, in: 1e7*(x - fast)}
simulation: {stop: 1, max_steps: 5000}
)")
                  .text,
              HasSubstr("the run has taken 5000 steps"));
  EXPECT_THAT(outcome(R"yaml(
blocks:
  x: {type: integrator, in: -x, initial: 1}
  fast: {type: integrator, in: "where(time < 1e-3, 1e7*(x - fast), 0)"}
simulation: {stop: 1}
)yaml")
                  .text,
              AllOf(HasSubstr("the steps have collapsed to"), HasSubstr("the fastest state is 'fast'"),
                    HasSubstr("solver: bdf is made for stiff equations")));
}

TEST(S17Run, CallsOnlyStiffWhatIsStiff) {
  // Driven fast, and moving fast by itself: short steps, but none that an implicit method would lengthen.
  EXPECT_THAT(outcome(R"yaml(
blocks:
  x: {type: integrator, in: cos(1000*time)}
  p: {type: integrator, in: 1000*q, initial: 1}
  q: {type: integrator, in: -1000*p}
  end: {type: stop, in: time > 0.01}
simulation: {stop: 4, max_step: 3e-6}
)yaml")
                  .text,
              Not(HasSubstr("stiff")));
  EXPECT_THAT(outcome(R"yaml(
blocks:
  x: {type: integrator, in: cos(1000*time)}
simulation: {stop: 2000, output_interval: 10}
)yaml")
                  .text,
              IsEmpty());
}

TEST(S17Run, NamesWhatChatters) {
  // A sliding mode with a tiny hysteresis: some 1e-7 s between events.
  const std::string text = outcome(R"(
blocks:
  x: {type: integrator, in: 1 - 2*on, initial: -1e-6}
  on: {type: relay, in: x, on: 1e-8, off: -1e-8}
  end: {type: stop, in: time > 1e-5}
simulation: {stop: 1}
)")
                               .text;
  EXPECT_THAT(text, AllOf(HasSubstr("warning: 'on."), HasSubstr("chatters: 100 events within")));
}

TEST(S17Run, NamesTheEventsThatMakeTheSolverStartAnew) {
  EXPECT_THAT(outcome(R"(
blocks:
  wave: sin(1000*time)
  high: {type: hysteresis, in: wave, lower: -0.5, upper: 0.5}
  x: {type: integrator, in: high - x}
simulation: {stop: 2}
)")
                  .text,
              AllOf(HasSubstr("warning: the solver started anew at"), HasSubstr("of them are of 'high.")));
}

TEST(S17Run, OfALivelyButHealthyDiagramSaysNothing) {
  EXPECT_THAT(outcome(R"(
blocks:
  h: {type: integrator, in: v, initial: 1, reset: {when: h <= 0, to: 0}}
  v: {type: integrator, in: -9.81, reset: {when: h <= 0, to: -0.8*v}}
  u: {type: saturation, in: v, lower: -1, upper: 1}
simulation: {stop: 2.5}
)")
                  .text,
              IsEmpty());
}

TEST(S17Run, StrictTakesWhatIsNoticedAsAnError) {
  const Outcome o = outcome("blocks:\n  u: {type: saturation, in: 5 + time, upper: 1}\nsimulation: {stop: 1}\n", true);
  EXPECT_TRUE(o.ran);
  EXPECT_TRUE(o.wrong);
  EXPECT_THAT(o.text, HasSubstr("error: 'u' was at a limit for 100 % of the run"));
}

TEST(S17UnusedOutput, IsANoteForBlocksThatNobodyReads) {
  const std::string text =
      "blocks:\n  a: {type: sine}\n  b: {type: gain, k: 2, in: a}\n  c: 3*a\nsimulation: {stop: 1}\n";
  EXPECT_THAT(findings(text), IsEmpty());  // everything is recorded
  EXPECT_THAT(findings(text + "record: [c]\n"),
              AllOf(HasSubstr("note: nobody reads, records or draws 'b'"), Not(HasSubstr("'a'"))));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
