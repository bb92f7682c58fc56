// Signals from a file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

std::string reading(const std::string& parameters) {
  return "blocks:\n  y: {type: from_file, file: tests/blocks/signals.csv" + parameters +
         "}\n  x: {type: integrator, in: y.1}\nsimulation: {stop: 4}\n";
}

TEST(FromFile, HoldsEachRow) {
  const Signals r = run(reading(", column: \"v, i\""));
  EXPECT_EQ(r.at("y.1", 0), 1);  // before the first row
  EXPECT_EQ(r.at("y.1", 1, true), 1);
  EXPECT_EQ(r.at("y.1", 1), 3);
  EXPECT_EQ(r.at("y.2", 2.7), -6);
  EXPECT_EQ(r.at("y.1", 4), 2);
  EXPECT_NEAR(r.last("x"), 1 + 3 * 1.5 + 2 * 1.5, 1e-12);
}

TEST(FromFile, DrawsStraightLinesBetweenRows) {
  const Signals r = run(reading(", column: \"v, i\", interpolation: linear"));
  EXPECT_NEAR(r.last("x"), 0.5 * 1 + 0.5 * 2 + 1.5 * 2.5 + 1.5 * 2, 1e-12);
  EXPECT_EQ(r.at("y.2", 4), -6);
}

TEST(FromFile, JumpsWhereTwoRowsHaveOneTime) {
  const auto with = [](const std::string& interpolation) {
    return run("blocks:\n  y: {type: from_file, file: tests/blocks/jump.csv, interpolation: " + interpolation +
               "}\n  x: {type: integrator, in: y}\nsimulation: {stop: 3}\n");
  };
  const Signals held = with("hold"), lines = with("linear");
  EXPECT_EQ(held.at("y", 1, true), 0);
  EXPECT_EQ(held.at("y", 1), 5);
  EXPECT_NEAR(held.last("x"), 0 + 5 + 1, 1e-12);
  EXPECT_EQ(lines.at("y", 1, true), 2);
  EXPECT_EQ(lines.at("y", 1), 5);
  EXPECT_NEAR(lines.last("x"), 1 + 3 + 1, 1e-12);
}

TEST(FromFile, TakesTheSecondColumnByDefault) {
  const Signals r = run("blocks: {y: {type: from_file, file: tests/blocks/signals.csv}}\nsimulation: {stop: 4}\n");
  EXPECT_EQ(r.at("y", 1.2), 3);
}

TEST(FromFile, SaysWhatItCannotFind) {
  EXPECT_THAT(findings(reading(", column: w")), HasSubstr("has no column 'w'; it has: t, v, i"));
  EXPECT_THAT(findings(reading(", column: i, time_column: i")), HasSubstr("must ascend"));
  EXPECT_THAT(findings("blocks: {y: {type: from_file, file: tests/blocks/none.csv}}\nsimulation: {stop: 4}\n"),
              HasSubstr("cannot read 'tests/blocks/none.csv'"));
  EXPECT_THAT(findings("blocks: {y: {type: from_file}}\nsimulation: {stop: 4}\n"),
              HasSubstr("needs a value for 'file'"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
