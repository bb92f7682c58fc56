// S2 and S3: what is wrong is collected phase by phase, and sizes follow from the wires whatever their order.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(S2Phases, CollectWhatIsWrongInAllSoundParts) {
  // A name, a parameter, a size, a rate and an input: each in a part that the others do not touch.
  const std::string text = findings(R"(
parameters: {p: q, q: p}
blocks:
  a: nothing + 1
  b: "[1, 2] + [1, 2, 3]"
  c: {type: unit_delay, in: time}
  d: {type: gain}
  e: {type: first_order, in: 1, tau: -1}
simulation: {stop: 1}
)");
  EXPECT_THAT(text, AllOf(HasSubstr("there is no 'nothing'"), HasSubstr("p -> q"), HasSubstr("vector of 3"),
                          HasSubstr("'c' (unit_delay) is sampled and needs a rate"),
                          HasSubstr("the input 'u' of 'd' (gain) is not connected"), HasSubstr("must be")));
}

TEST(S2Phases, SayNothingThatFollowsFromAnError) {
  const std::string text =
      findings("blocks:\n  a: nothing\n  b: 2*a\n  c: {type: integrator, in: b}\nsimulation: {stop: 1}\n");
  EXPECT_THAT(text, HasSubstr("there is no 'nothing'"));
  EXPECT_EQ(text.find("error"), text.rfind("error"));
}

TEST(S2Phases, AnUnconnectedInputIsAnErrorUnlessItHasADefault) {
  EXPECT_THAT(findings("blocks: {x: {type: integrator}}\nsimulation: {stop: 1}\n"), HasSubstr("is not connected"));
  EXPECT_EQ(findings("blocks: {u: {type: pi, in: 1}}\nsimulation: {stop: 1}\n"), "");  // kp and ki have defaults
}

TEST(S2Phases, FoldingAndSharingKeepEveryNamedSignal) {
  const Signals r = run(R"(
parameters: {k: 3}
blocks:
  a: k*time
  b: k*time
  constant_one: 2 - 1
  same: a
simulation: {stop: 1}
record: [a, b, constant_one, same]
)");
  EXPECT_EQ(r.column("a"), r.column("b"));
  EXPECT_EQ(r.column("a"), r.column("same"));
  EXPECT_EQ(r.last("constant_one"), 1);
  EXPECT_EQ(r.recording().columns.size(), 4U);
}

TEST(S3Sizes, AndResultsDoNotDependOnTheOrderOfTheBlocks) {
  std::vector<std::string> blocks{"  x: {type: integrator, in: y - x, initial: [1, 2, 3]}\n", "  y: z + 1\n",
                                  "  z: {type: gain, k: 2, in: w}\n", "  w: -x\n", "  total: sum(x)\n"};
  std::sort(blocks.begin(), blocks.end());
  std::vector<double> first;
  do {
    std::string text = "blocks:\n";
    for (const std::string& block : blocks) text += block;
    const Signals r = run(text + "simulation: {stop: 1}\nrecord: [x, y, total]\n");
    ASSERT_EQ(r.recording().columns.size(), 7U);
    if (first.empty()) first = r.column("total");
    ASSERT_EQ(r.column("total"), first);
  } while (std::next_permutation(blocks.begin(), blocks.end()));
}

TEST(S3Sizes, ThatNothingDecidesAreScalars) {
  const Signals r = run("blocks: {x: {type: first_order, in: 1 - x}}\nsimulation: {stop: 1}\n");
  EXPECT_EQ(r.recording().columns.size(), 1U);
  EXPECT_THAT(findings("blocks:\n  x: {type: integrator, in: \"[x, x]\"}\nsimulation: {stop: 1}\n"),
              Not(HasSubstr("internal")));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
