// plantloop draw: files, and what it says when it cannot draw.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* loop = R"(plantloop: 1
title: A loop
blocks:
  r: {type: step, time: 1}
  e: r - y
  controller: {type: lag, in: e}
  y: {type: first_order, in: controller}
types:
  lag:
    inputs: [u]
    blocks: {x: {type: integrator, in: u - x}}
    outputs: [x]
simulation: {stop: 3}
record: [y]
)";

class Draw : public testing::Test {
 protected:
  Draw() { place_.write("loop.yaml", loop); }
  Workplace place_;
};

TEST_F(Draw, WritesEveryFormat) {
  for (const char* name : {"a.png", "a.svg", "a.pdf", "a.json"}) {
    const Outcome o = place_.run(std::string("draw loop.yaml -o ") + name);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_EQ(o.out + o.err, "");
    EXPECT_TRUE(place_.has(name));
  }
  EXPECT_THAT(place_.read("a.pdf"), StartsWith("%PDF-"));
  EXPECT_THAT(place_.read("a.svg"),
              AllOf(HasSubstr("aria-label=\"controller\""), HasSubstr("id=\"block/controller\"")));
}

TEST_F(Draw, WritesTheValuesOfARunOnTheWires) {
  EXPECT_EQ(place_.run("run loop.yaml --stop 1 --out loop.npz").status, 0);
  EXPECT_EQ(place_.run("draw loop.yaml -o end.json --values loop.npz").status, 0);
  EXPECT_THAT(place_.read("end.json"), HasSubstr("\"= 0\""));  // the step comes at 1 s
  EXPECT_EQ(place_.run("run loop.yaml --stop 100 --out loop.npz").status, 0);
  EXPECT_EQ(place_.run("draw loop.yaml -o end.json --values loop.npz").status, 0);
  EXPECT_THAT(place_.read("end.json"), HasSubstr("\"= 0.5\""));  // at rest y = 1 - y
  EXPECT_EQ(place_.run("draw loop.yaml -o end.json --values loop.npz --at 0.5").status, 0);
  EXPECT_THAT(place_.read("end.json"), HasSubstr("\"= 0\""));
  const Outcome early = place_.run("draw loop.yaml -o end.json --values loop.npz --at -1");
  EXPECT_EQ(early.status, 2);
  EXPECT_EQ(early.err, "plantloop: --at -1: loop.npz begins at 0 s\n");
  EXPECT_EQ(place_.run("draw loop.yaml -o end.json --values none.npz").status, 2);
}

TEST_F(Draw, OpensSubsystemsAndLooksInsideThem) {
  EXPECT_EQ(place_.run("draw loop.yaml -o open.svg --depth 1").status, 0);
  EXPECT_THAT(place_.read("open.svg"), AllOf(HasSubstr("frame/controller"), HasSubstr("block/controller.x")));
  EXPECT_EQ(place_.run("draw loop.yaml -o inside.svg --inside controller").status, 0);
  EXPECT_THAT(place_.read("inside.svg"), HasSubstr("id=\"block/x\""));
}

TEST_F(Draw, GivesSubsystemsPagesOfTheirOwn) {
  EXPECT_EQ(place_.run("draw loop.yaml -o pages.pdf --pages").status, 0);
  EXPECT_THAT(place_.read("pages.pdf"), HasSubstr("/Count 2"));
  EXPECT_EQ(place_.run("draw loop.yaml -o pages.svg --pages").status, 0);
  EXPECT_THAT(place_.read("pages.svg"), HasSubstr("block/controller"));
  EXPECT_THAT(place_.read("pages.controller.svg"), HasSubstr("block/x"));
}

TEST_F(Draw, FollowsHints) {
  place_.write("hints.yaml", "hide: [r]\n");
  EXPECT_EQ(place_.run("draw loop.yaml -o a.svg --hints hints.yaml").status, 0);
  EXPECT_THAT(place_.read("a.svg"), Not(HasSubstr("id=\"block/r\"")));
  place_.write("wrong.yaml", "forward: [controler]\nback: [e]\n");
  const Outcome o = place_.run("draw loop.yaml -o a.svg --hints wrong.yaml");
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, AllOf(HasSubstr("wrong.yaml:1:11: error: the diagram has no block 'controler'"),
                           HasSubstr("did you mean 'controller'?"), HasSubstr("wrong.yaml:2:1: error:")));
}

TEST_F(Draw, SaysWhatIsWrong) {
  Outcome o = place_.run("draw loop.yaml -o a.gif");
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.err, "plantloop: -o a.gif: the name must end in .json, .pdf, .png, .svg\n");
  o = place_.run("draw loop.yaml -o a.svg --inside motor");
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.err, "plantloop: --inside motor: there is no subsystem of this name; there are: controller\n");
  o = place_.run("draw loop.yaml -o loop.yaml/a.svg");
  EXPECT_EQ(o.status, 1);
  EXPECT_THAT(o.err, StartsWith("plantloop: cannot write 'loop.yaml/a.svg': "));
  place_.write("wrong.yaml", "plantloop: 1\nblocks: {y: x}\n");
  o = place_.run("draw wrong.yaml -o a.svg");
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, HasSubstr("wrong.yaml:2:13: error:"));
}

}  // namespace
}  // namespace plantloop::testing_program
