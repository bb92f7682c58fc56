// S17: --strict and the exit status of check, run and test; the list of checks.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class S17Commands : public testing::Test {
 protected:
  S17Commands() {
    // A warning before the run, and one that only a run can give.
    place_.write("machine.yaml", R"(plantloop: 1
blocks:
  m: {type: state_machine, initial: a, states: {a: {set: {y: 1}}, b: {set: {y: 2}}}, transitions: []}
simulation: {stop: 1}
record: [m.y]
expect: [{signal: m.y, final: 1}]
)");
    place_.write("limited.yaml", R"(plantloop: 1
blocks: {u: {type: saturation, in: 3 + time, upper: 1}}
simulation: {stop: 1}
expect: [{signal: u, max: 1}]
)");
  }
  Workplace place_;
};

TEST_F(S17Commands, WarningsLeaveTheExitStatus) {
  EXPECT_EQ(place_.run("check machine.yaml").status, 0);
  EXPECT_EQ(place_.run("run machine.yaml --out a.csv").status, 0);
  EXPECT_EQ(place_.run("test machine.yaml limited.yaml").status, 0);
  const Outcome o = place_.run("run limited.yaml --out a.csv");
  EXPECT_EQ(o.status, 0);
  EXPECT_THAT(o.err, HasSubstr("warning: 'u' was at a limit for 100 % of the run"));
}

TEST_F(S17Commands, StrictMakesThemErrors) {
  EXPECT_EQ(place_.run("check machine.yaml --strict").status, 2);
  EXPECT_EQ(place_.run("run machine.yaml --strict").status, 2);
  EXPECT_EQ(place_.run("test machine.yaml --strict").status, 2);
  EXPECT_EQ(place_.run("check limited.yaml --strict").status, 0);
  const Outcome run = place_.run("run limited.yaml --strict --out b.csv");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("error: 'u' was at a limit for 100 % of the run"));
  EXPECT_TRUE(place_.has("b.csv"));  // the result is not lost
  const Outcome test = place_.run("test limited.yaml --strict");
  EXPECT_EQ(test.status, 1);
  EXPECT_THAT(test.out, HasSubstr("FAILED limited.yaml  checks\n"));
}

TEST_F(S17Commands, ListTheChecks) {
  const Outcome o = place_.run("check --list");
  EXPECT_EQ(o.status, 0);
  EXPECT_THAT(o.out, AllOf(HasSubstr("| `units` | off |"), HasSubstr("| `unit-clash` | error |"),
                           HasSubstr("| `unconnected` | error, always |")));
  EXPECT_EQ(place_.run("check").err, "plantloop: check: name at least one file\n");
  EXPECT_EQ(place_.run("check").status, 2);
}

TEST_F(S17Commands, FindingsForMachinesCarryTheirIdentity) {
  EXPECT_THAT(place_.run("check machine.yaml --format json").out, HasSubstr("\"id\": \"unreachable-state\""));
  EXPECT_THAT(place_.run("check machine.yaml --format sarif").out, HasSubstr("\"ruleId\": \"unreachable-state\""));
}

}  // namespace
}  // namespace plantloop::testing_program
