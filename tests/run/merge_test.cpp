// S12: several conditional blocks that write one signal.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(S12Merge, ShowsTheActiveOneThenTheOneThatWasActiveLast) {
  const Signals r = run(R"(
blocks:
  a: {expr: 10 + time, enable: {when: time > 1 and time < 2, initial: 0}}
  b: {expr: 20 + time, enable: {when: time > 3 and time < 4, initial: 0}}
  y: {type: merge, in: [a, b], initial: -1}
simulation: {stop: 5}
record: [y]
expect:
  - {signal: y, at: 0.5, value: -1}
  - {signal: y, at: 1.5, value: 11.5}
  - {signal: y, at: 2.5, value: 12, abs: 1e-9}
  - {signal: y, at: 3.5, value: 23.5}
  - {signal: y, at: 4.5, value: 24, abs: 1e-9}
)");
  for (const Verdict& verdict : r.whole().verdicts)
    EXPECT_TRUE(verdict.met) << verdict.text << ": " << verdict.measured;
}

TEST(S12Merge, OfSubsystemsWithStates) {
  // Each integrates while it is active and stands still otherwise.
  const Signals r = run(R"(
blocks:
  a: {type: ramp_of, in: 1, enable: time < 1}
  b: {type: ramp_of, in: 2, enable: time >= 1}
  y: {type: merge, in: [a.y, b.y]}
types:
  ramp_of: {inputs: [u], blocks: {x: {type: integrator, in: u}}, outputs: {y: {from: x, initial: 0}}}
simulation: {stop: 2}
record: [y]
expect: [{signal: y, at: 0.5, value: 0.5, abs: 1e-9}, {signal: y, at: 1.5, value: 1, abs: 1e-9}]
)");
  for (const Verdict& verdict : r.whole().verdicts)
    EXPECT_TRUE(verdict.met) << verdict.text << ": " << verdict.measured;
}

TEST(S12Merge, OfTriggeredBlocksShowsTheOneThatRanLast) {
  const Signals r = run(R"(
blocks:
  a: {expr: 1 + time, trigger: {when: time > 1, initial: 0}}
  b: {expr: 2 + time, trigger: {when: time > 2, initial: 0}}
  y: {type: merge, in: [a, b], initial: 7}
simulation: {stop: 3}
record: [y]
expect:
  - {signal: y, at: 0.5, value: 7}
  - {signal: y, at: 1.5, value: 2, abs: 1e-9}
  - {signal: y, at: 2.5, value: 4, abs: 1e-9}
)");
  for (const Verdict& verdict : r.whole().verdicts)
    EXPECT_TRUE(verdict.met) << verdict.text << ": " << verdict.measured;
}

TEST(S12Merge, OfTwoThatAreActiveAtOnceIsARunErrorThatNamesBothAndTheTime) {
  Report report;
  const auto diagram = Diagram::from_text(R"(plantloop: 1
blocks:
  a: {expr: 1, enable: {when: time < 2, initial: 0}}
  b: {expr: 2, enable: {when: time > 1.5, initial: 0}}
  y: {type: merge, in: [a, b]}
simulation: {stop: 3}
)",
                                          "test.yaml", report);
  try {
    diagram->run({}, report);
    FAIL() << "both wrote";
  } catch (const RunError& e) {
    EXPECT_STREQ(e.what(), "at time 1.5 s 'y' merges 'a' and 'b', and both are active");
  }
}

TEST(S12Merge, TakesConditionalBlocksByTheirNames) {
  EXPECT_THAT(findings("blocks:\n  a: time\n  b: {expr: 1, enable: {when: time - 1, initial: 0}}\n"
                       "  y: {type: merge, in: [a, b]}\nsimulation: {stop: 1}\n"),
              AllOf(HasSubstr("'a' is always active, so 'y' (merge) would never show another entry"),
                    HasSubstr("give its block an enable: or trigger:")));
  EXPECT_THAT(findings("blocks:\n  b: {expr: 1, enable: {when: time - 1, initial: 0}}\n"
                       "  y: {type: merge, in: [2*b, b]}\nsimulation: {stop: 1}\n"),
              HasSubstr("'y' (merge) takes outputs of conditional blocks by their names, not '2*b'"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
