// plantloop test: verdicts, exit status, JUnit, baselines, pictures of what is not met.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// x = 1 - exp(-t)
std::string lag(const std::string& expect) {
  return "plantloop: 1\nblocks:\n  x: {type: first_order, in: 1}\nsimulation: {stop: 2}\n" + expect;
}

TEST(TestCommand, WhatIsMetIsDone) {
  const Workplace place;
  place.write("lag.yaml", lag("expect:\n  - {signal: x, at: 1, value: 1 - exp(-1), abs: 1e-5}\n"));
  const Outcome o = place.run("test lag.yaml");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("ok     lag.yaml  1 of 1 met"));
  EXPECT_THAT(o.out, HasSubstr("1 diagram, 1 expectation, all met\n"));
  EXPECT_FALSE(place.has("out"));
}

TEST(TestCommand, WhatIsNotMetIsToldWithItsPlaceAndDrawn) {
  const Workplace place;
  place.write("lag.yaml", lag("expect:\n  - {signal: x, max: 0.5}\n  - {signal: x, at: 2, value: 1, abs: 0.01}\n"));
  const Outcome o = place.run("test lag.yaml");
  EXPECT_EQ(o.status, 1);
  EXPECT_THAT(o.out, HasSubstr("FAILED lag.yaml  0 of 2 met"));
  EXPECT_THAT(o.out, HasSubstr("  lag.yaml:6: {signal: x, max: 0.5}\n    0.864664"));
  EXPECT_THAT(o.out, HasSubstr("wanted at most 0.5\n    drawn in out/lag.expect1.png\n"));
  EXPECT_THAT(place.read("out/lag.expect2.png"), HasSubstr("PNG"));
}

TEST(TestCommand, AWrongDiagramIsAnErrorAndTheOthersRun) {
  const Workplace place;
  place.write("a/lag.yaml", lag("expect:\n  - {signal: x, max: 1}\n"));
  place.write("a/wrong.yaml", "plantloop: 1\nblocks:\n  x: {type: first_ordr, in: 1}\nexpect: [{signal: x, max: 1}]\n");
  place.write("a/other.yaml", "title: no diagram at all\n");
  place.write("a/types.yaml", "plantloop: 1\ntypes: {t: {inputs: [u], outputs: [y], blocks: {y: u}}}\n");
  const Outcome o = place.run("test a --junit report.xml");
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.out, HasSubstr("ok     a/lag.yaml"));
  EXPECT_THAT(o.out, HasSubstr("ERROR  a/wrong.yaml\n"));
  EXPECT_THAT(o.out, HasSubstr("did you mean 'first_order'"));
  EXPECT_THAT(o.out, Not(HasSubstr("other.yaml")));
  EXPECT_THAT(o.out, HasSubstr("-      a/types.yaml  nothing expected"));
  EXPECT_THAT(o.out, HasSubstr("2 diagrams, 1 did not run, 1 expectation, all met\n"));
  const std::string report = place.read("report.xml");
  EXPECT_THAT(report, HasSubstr("<testsuites tests=\"2\" failures=\"0\" errors=\"1\""));
  EXPECT_THAT(report, HasSubstr("<testcase classname=\"a/lag.yaml\" name=\"{signal: x, max: 1}\""));
  EXPECT_THAT(report, HasSubstr("<error message=\"a/wrong.yaml:3:"));
  EXPECT_THAT(report, HasSubstr("&#10;"));
}

TEST(TestCommand, ARunThatFailsIsAnError) {
  const Workplace place;
  place.write("bad.yaml",
              "plantloop: 1\nblocks: {x: 1/(1 - time)}\nsimulation: {stop: 2}\nexpect: [{signal: x, max: 1}]\n");
  const Outcome o = place.run("test bad.yaml");
  EXPECT_EQ(o.status, 1);
  EXPECT_THAT(o.out, HasSubstr("ERROR  bad.yaml\nat time 1 s 'x' became infinite"));
}

TEST(TestCommand, NothingToTestIsWrong) {
  const Workplace place;
  place.write("lag.yaml", lag(""));
  EXPECT_EQ(place.run("test lag.yaml").status, 2);
  const Outcome o = place.run("test nowhere");
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.err, "plantloop: there is no file or folder 'nowhere'\n");
}

// The baseline's times are sampled exactly: another step size gives other rows, and the same values.
TEST(TestCommand, ABaselineHoldsWhateverTheRowsAre) {
  const Workplace place;
  place.write("lag.yaml", lag(""));
  ASSERT_EQ(place.run("run lag.yaml --rtol 1e-11 --atol 1e-13 --out lag.csv").status, 0);
  place.write("again.yaml",
              "plantloop: 1\nblocks:\n  x: {type: first_order, in: 1}\n"
              "simulation: {stop: 2, rtol: 1e-10, atol: 1e-12, output_interval: 0.3}\n"
              "expect:\n  - {baseline: lag.csv, abs: 1e-9}\n  - {signal: x, baseline: lag.csv, rel: 1e-8}\n");
  const Outcome o = place.run("test again.yaml");
  EXPECT_EQ(o.status, 0) << o.out << o.err;
}

TEST(TestCommand, ABaselineAllowsAShiftInTime) {
  const Workplace place;
  const auto step = [&](const std::string& time, const std::string& expect) {
    return "plantloop: 1\nblocks:\n  u: {type: step, time: " + time + "}\nsimulation: {stop: 2}\n" + expect;
  };
  place.write("a.yaml", step("1", ""));
  ASSERT_EQ(place.run("run a.yaml --out a.csv").status, 0);
  place.write("b.yaml", step("1.001", "expect:\n  - {baseline: a.csv}\n"));
  EXPECT_EQ(place.run("test b.yaml --figures ''").status, 1);
  EXPECT_FALSE(place.has("out"));
  place.write("b.yaml", step("1.001", "expect:\n  - {baseline: a.csv, shift: 0.002}\n"));
  const Outcome o = place.run("test b.yaml");
  EXPECT_EQ(o.status, 0) << o.out << o.err;
}

TEST(TestCommand, ABaselineThatSaysNothingAboutTheSignalIsNotMet) {
  const Workplace place;
  place.write("half.csv", "time,y\n0,0\n1,1\n");
  place.write("down.csv", "time,x\n1,0\n0,1\n");
  place.write("lag.yaml", lag("expect:\n  - {signal: x, baseline: half.csv}\n  - {baseline: down.csv}\n"
                              "  - {baseline: half.csv}\n"));
  const Outcome o = place.run("test lag.yaml");
  EXPECT_EQ(o.status, 1);
  EXPECT_THAT(o.out, HasSubstr("half.csv has no column 'x'"));
  EXPECT_THAT(o.out, HasSubstr("in down.csv the times do not ascend"));
  EXPECT_THAT(o.out, HasSubstr("the run has no column 'y'"));
}

}  // namespace
}  // namespace plantloop::testing_program
