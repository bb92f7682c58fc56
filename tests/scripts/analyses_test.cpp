// S16: linear models and rests from scripts, against closed forms to 1e-8; and what is said to wrong words.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;

class S16FromLua : public Workshop {
 protected:
  S16FromLua() {
    // level' = (inflow - c sqrt(level))/A: at rest level = (inflow/c)^2, and there the pole is -c/(2 A sqrt(level)).
    write("tank.yaml", R"(plantloop: 1
parameters: {c: 0.4, A: 2}
blocks:
  inflow: {type: constant, value: 0.8}
  level: {type: integrator, in: (inflow - c*sqrt(level))/A, initial: 1}
simulation: {stop: 1}
)");
  }
};

TEST_F(S16FromLua, ALinearModelHasTheMatricesOfTheClosedForm) {
  EXPECT_EQ(printed(R"(
local m = pl.load('tank.yaml'):linearise{inputs = {'inflow'}, outputs = {'level'}, trim = true}
local a = -0.4/(2*2*2)
local function near(x, y) return math.abs(x - y) < 1e-8 end
print(near(m.A[1][1], a), near(m.B[1][1], 0.5), m.C[1][1], m.D[1][1], m.states[1], m.inputs[1], near(m.poles[1][1], a)))"),
            "true\ttrue\t1.0\t0.0\tlevel\tinflow\ttrue");
}

TEST_F(S16FromLua, AFrequencyResponseIsThatOfTheLinearModel) {
  // b/(i w - a) with b = 1/2, a = -0.05.
  EXPECT_EQ(printed(R"(
local m = pl.load('tank.yaml'):linearise{inputs = {'inflow'}, outputs = {'level'}, trim = true, frequencies = pl.vector{0.05, 1}}
local w, a = m.response.frequency[1], -0.05
local re, im = m.response.real[1], m.response.imaginary[1]
print(w, math.abs(re - 0.5*-a/(w^2 + a^2)) < 1e-8, math.abs(im + 0.5*w/(w^2 + a^2)) < 1e-8))"),
            "0.05\ttrue\ttrue");
}

TEST_F(S16FromLua, ARestIsThatOfTheClosedForm) {
  EXPECT_EQ(printed("local t = pl.load('tank.yaml'):trim{}\n"
                    "print(t.converged, math.abs(t.states.level - 4) < 1e-8)"),
            "true\ttrue");
  EXPECT_EQ(printed("local t = pl.load('tank.yaml'):trim{inputs = {'inflow'}, outputs = {level = 9}}\n"
                    "print(t.converged, math.abs(t.inputs.inflow - 1.2) < 1e-8)"),
            "true\ttrue");
}

TEST_F(S16FromLua, SayWhatIsNotThere) {
  const auto said = [&](const char* script) {
    return run(std::string("local pl = require 'plantloop'; ") + script).messages;
  };
  EXPECT_THAT(said("pl.load('tank.yaml'):linearise{inputs = {'inflw'}}"),
              HasSubstr("the input 'inflw' is no signal of the diagram"));
  EXPECT_THAT(said("pl.load('tank.yaml'):trim{fix = {levl = 1}}"), HasSubstr("there is no state 'levl'"));
  EXPECT_THAT(complaint("pl.load('tank.yaml'):linearise{input = {'inflow'}}"), HasSubstr("'input'"));
}

}  // namespace
}  // namespace plantloop
