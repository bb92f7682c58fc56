// plantloop compare and plot: results against results, pictures against pictures, figures from results.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

using ::testing::HasSubstr;

TEST(Compare, TheSameAgree) {
  const Workplace place;
  place.write("a.csv", "time,x\n0,1\n1,2\n");
  const Outcome o = place.run("compare a.csv a.csv");
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.out, "a.csv and a.csv agree\n");
}

TEST(Compare, TellsWhereItDiffersMostAndDrawsIt) {
  const Workplace place;
  place.write("a.csv", "time,x,y\n0,1,0\n1,2,0\n2,3,0\n");
  place.write("b.csv", "time,x,y\n0,1,0\n1,2.5,0\n2,3.125,0\n");
  const Outcome o = place.run("compare a.csv b.csv");
  EXPECT_EQ(o.status, 1);
  EXPECT_EQ(o.out,
            "a.csv and b.csv differ\n"
            "  x: differs most at 1 s, 2 in a.csv and 2.5 in b.csv: by 0.5, allowed 0\n"
            "  drawn in out/difference.png\n");
  EXPECT_TRUE(place.has("out/difference.png"));
  EXPECT_EQ(place.run("compare a.csv b.csv --atol 0.5").status, 0);
  EXPECT_EQ(place.run("compare a.csv b.csv --rtol 0.2").status, 0);
  EXPECT_EQ(place.run("compare a.csv b.csv --rtol 0.19 --figure ''").status, 1);
}

// One that starts early, ends late or lacks a column is not the same, whichever comes first.
TEST(Compare, WhatOnlyOneHasIsADifference) {
  const Workplace place;
  place.write("a.csv", "time,x\n0,1\n1,2\n");
  place.write("long.csv", "time,x\n0,1\n1,2\n2,3\n");
  place.write("wide.csv", "time,x,y\n0,1,0\n1,2,0\n");
  EXPECT_THAT(place.run("compare a.csv long.csv").out, HasSubstr("x: at 2 s only one of them has a value"));
  EXPECT_EQ(place.run("compare long.csv a.csv").status, 1);
  EXPECT_THAT(place.run("compare a.csv wide.csv").out, HasSubstr("  y: only in wide.csv\n"));
  EXPECT_EQ(place.run("compare wide.csv a.csv").status, 1);
}

// A line between samples is the same line with more samples, and so are stairs: a file does not say which it means.
TEST(Compare, TimesMayDiffer) {
  const Workplace place;
  place.write("coarse.csv", "time,line,stairs\n0,0,0\n2,2,1\n");
  place.write("fine.csv", "time,line,stairs\n0,0,0\n1,1,0\n1.5,1.5,0\n2,2,1\n");
  EXPECT_EQ(place.run("compare coarse.csv fine.csv").status, 0);
  place.write("other.csv", "time,line,stairs\n0,0,0\n1,1.25,0\n2,2,1\n");
  EXPECT_EQ(place.run("compare coarse.csv other.csv").status, 1);
}

TEST(Compare, BothSidesOfAJumpCount) {
  const Workplace place;
  place.write("a.csv", "time,x\n0,0\n1,0\n1,1\n2,1\n");
  place.write("b.csv", "time,x\n0,0\n1,0\n1,1.5\n2,1\n");
  place.write("late.csv", "time,x\n0,0\n1.01,0\n1.01,1\n2,1\n");
  EXPECT_THAT(place.run("compare a.csv b.csv").out, HasSubstr("at 1 s, 1 in a.csv and 1.5 in b.csv"));
  EXPECT_EQ(place.run("compare a.csv late.csv").status, 1);
  EXPECT_EQ(place.run("compare a.csv late.csv --shift 0.02").status, 0);
  EXPECT_EQ(place.run("compare a.csv late.csv --shift 0.005").status, 1);
}

TEST(Compare, WhatCannotBeReadIsWrong) {
  const Workplace place;
  place.write("a.csv", "time,x\n0,1\n");
  place.write("b.csv", "t,x\n0,1\n");
  place.write("c.csv", "time,x\n0,one\n");
  place.write("d.png", "no picture");
  const auto error = [&](const std::string& files) {
    const Outcome o = place.run("compare " + files);
    EXPECT_EQ(o.status, 2) << files;
    return o.err;
  };
  EXPECT_EQ(error("a.csv b.csv"), "plantloop: cannot read 'b.csv': it has no column 'time'\n");
  EXPECT_THAT(error("a.csv c.csv"), HasSubstr("plantloop: cannot read 'c.csv': line 2: 'one' is no number"));
  EXPECT_EQ(error("a.csv d.png"), "plantloop: a.csv and d.png: a picture can be compared with a picture only\n");
  EXPECT_THAT(error("d.png d.png"), HasSubstr("plantloop: cannot read 'd.png': this is no PNG file"));
}

constexpr const char* lag = R"(plantloop: 1
parameters: {tau: 1}
blocks:
  u: {type: step, time: 0.5}
  x: {type: first_order, in: u, tau: tau}
  y: {type: unit_delay, in: x, rate: 0.2}
simulation: {stop: 3}
record: [x, y]
figures:
  f: {title: lag, panels: [{y: [x, y], label: x, bands: [{lower: 1 - tau/10, upper: 1 + tau/10}]}]}
)";

// The picture from the file is the picture of the run, to the pixel, also with another value of a parameter.
TEST(Plot, DrawsFromAFileWhatTheRunDrew) {
  const Workplace place;
  place.write("lag.yaml", lag);
  ASSERT_EQ(place.run("run lag.yaml --set tau=0.3 --out lag.npz --figures direct").status, 0);
  const Outcome o = place.run("plot lag.npz lag.yaml --figures again --format png,svg");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(place.run("compare again/f.png direct/f.png").status, 0);
  EXPECT_TRUE(place.has("again/f.svg"));
  ASSERT_EQ(place.run("run lag.yaml --out other.npz --figures other").status, 0);
  const Outcome differs = place.run("compare again/f.png other/f.png --figure d.png");
  EXPECT_EQ(differs.status, 1);
  EXPECT_THAT(differs.out, HasSubstr(" pixels, by up to "));
  EXPECT_TRUE(place.has("d.png"));
}

TEST(Plot, SaysWhatIsMissing) {
  const Workplace place;
  std::string text = lag;
  place.write("lag.yaml", text.replace(text.find("[x, y]"), 6, "[x]"));
  ASSERT_EQ(place.run("run lag.yaml --out lag.npz").status, 0);
  const Outcome o = place.run("plot lag.npz lag.yaml");
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.err,
            "plantloop: lag.npz does not have what the figures show: y. Name it in 'record:', too, and run again\n");
  EXPECT_THAT(place.run("plot lag.csv lag.yaml").err, HasSubstr("figures are drawn from a .npz file"));
}

}  // namespace
}  // namespace plantloop::testing_program
