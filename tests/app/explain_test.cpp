// plantloop explain: what the engine made of a diagram, in words.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace plantloop::testing_program {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* loop = R"(plantloop: 1
parameters: {Ts: 0.1}
blocks:
  w: {type: step, time: 1}
  ys: {type: zero_order_hold, in: x, rate: Ts}
  e: w - ys
  es: {type: zero_order_hold, in: e, rate: Ts}
  twice: 2*es
  u: {type: saturation, in: x - 3*twice, lower: -1, upper: 1}
  x: {type: first_order, in: [u], tau: 0.5}
  v: [x, u, 1]
  D: {type: state_space, A: "[[-1]]", B: "[[1]]", C: "[[1]]", D: "[[0]]", in: u}
simulation: {stop: 3}
)";

class Explain : public testing::Test {
 protected:
  Explain() { place_.write("loop.yaml", loop); }
  std::string operator()(const std::string& name = "") {
    const Outcome o = place_.run("explain loop.yaml " + name);
    EXPECT_EQ(o.status, 0) << o.err;
    return o.out;
  }
  Workplace place_;
};

TEST_F(Explain, TellsAmountsRatesEventsAndRestarts) {
  EXPECT_THAT((*this)(),
              AllOf(HasSubstr("9 blocks in 0 subsystems, 2 continuous states and 0 sampled"),
                    HasSubstr("  sampled every 0.1 s: e, es, twice, w, ys\n"), HasSubstr("modes change in: u\n"),
                    HasSubstr("every 0.1 s twice changes, in the derivative of D.1, x\n"),
                    HasSubstr("expression, continuous, vector of 3")));
}

TEST_F(Explain, OrderFollowsTheEquations) {
  const std::string text = (*this)();
  const auto place = [&](const std::string& name) {
    const std::size_t at = text.find("\n  " + name + " ", text.find("\norder"));
    EXPECT_NE(at, std::string::npos) << name;
    return at;
  };
  EXPECT_LT(place("w"), place("e"));
  EXPECT_LT(place("ys"), place("e"));
  EXPECT_LT(place("es"), place("twice"));
  EXPECT_LT(place("twice"), place("u"));
  EXPECT_LT(place("u"), place("v"));
}

TEST_F(Explain, GivesTheChainOfReasonsForARate) {
  EXPECT_THAT((*this)("twice"), HasSubstr("    'twice' is sampled every 0.1 s: it follows 'es'\n"
                                          "    'es' is sampled every 0.1 s: 'rate:' says so (loop.yaml:7:"));
}

// Feedthrough is read off the operations: D is zero, so no input reaches the output of the state space.
TEST_F(Explain, TellsWhatReachesAnOutputAtTheSameInstant) {
  EXPECT_THAT((*this)("D"), HasSubstr("output D: scalar; no input reaches it at the same instant"));
  EXPECT_THAT((*this)("u"), HasSubstr("at the same instant it depends on u.u"));
}

TEST_F(Explain, TellsOfAParameterWhoUsesItAndWhatAChangeCosts) {
  EXPECT_THAT((*this)("Ts"), AllOf(HasSubstr("value: 0.1"), HasSubstr("a new value needs a new compilation")));
  EXPECT_THAT((*this)("x.tau"), AllOf(HasSubstr("value: 0.5 s"), HasSubstr("needs no new compilation")));
}

TEST_F(Explain, ANameThatIsNotThereIsWrong) {
  const Outcome o = place_.run("explain loop.yaml twicf");
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.err, "error: the diagram has nothing named 'twicf'\n  did you mean 'twice'?\n");
}

TEST_F(Explain, ListsReadsAcrossRates) {
  place_.write("loop.yaml", R"(plantloop: 1
blocks:
  t: {type: clock}
  fast: {type: zero_order_hold, in: t, rate: 0.1}
  slow: {type: gain, k: 2, in: fast + 1, rate: 0.4}
  again: {expr: slow + fast, rate: 0.2}
  carried: {type: rate_transition, in: slow, rate: 0.1}
simulation: {stop: 1}
)");
  EXPECT_THAT((*this)(), HasSubstr("\nacross rates, always the present value (a rate_transition defines a latency)\n"
                                   "  again holds slow\n  again samples fast\n  slow samples fast\n"));
}

}  // namespace
}  // namespace plantloop::testing_program
