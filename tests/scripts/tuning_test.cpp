// Controllers from models and step tests, against closed forms.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;

class Tuning : public Workshop {};

TEST_F(Tuning, PolesAreWhereTheyWereWanted) {
  EXPECT_EQ(printed(R"(
local A, B = pl.matrix{{0, 1, 0}, {2, -1, 3}, {1, 0, -4}}, pl.vector{0, 1, 0.5}
local K = pl.pole_placement(A, B, {{-2, 1}, {-2, -1}, {-5, 0}})
local rows = {}
for i = 1, 3 do
  rows[i] = {}
  for j = 1, 3 do rows[i][j] = A[i][j] - B[i]*K[j] end
end
local re, im = pl.eigenvalues(pl.matrix(rows))
local function near(x, y) return math.abs(x - y) < 1e-9 end
print(near(re[1], -5), near(re[2], -2), near(re[3], -2), near(im[2], -1), near(im[3], 1)))"),
            "true\ttrue\ttrue\ttrue\ttrue");
  // A double integrator by hand: s^2 + k2 s + k1.
  EXPECT_EQ(printed("local K = pl.pole_placement({{0, 1}, {0, 0}}, {0, 1}, {-3, -4})\nprint(K[1], K[2])"), "12.0\t7.0");
}

TEST_F(Tuning, ALoopTunedByLambdaHasItAsItsTimeConstant) {
  // Without dead time the loop is 1/(lambda s + 1).
  write("loop.yaml", R"(plantloop: 1
parameters: {kp: 1, ki: 1}
blocks:
  e: 1 - y
  i: {type: integrator, in: ki*e}
  y: {type: first_order, in: kp*e + i, k: -2.5, tau: 7}
simulation: {stop: 20, rtol: 1e-9}
record: [y]
expect: [{signal: y, at: 3, value: 1 - exp(-3/1.5), abs: 1e-6}]
)");
  EXPECT_EQ(printed(R"(
local c = pl.lambda_tuning{gain = -2.5, time_constant = 7, lambda = 1.5}
print(pl.load('loop.yaml'):run{set = {kp = c.kp, ki = c.ki}}:verdicts()[1].met, c.kd))"),
            "true\t0.0");
  EXPECT_EQ(
      printed("local c = pl.lambda_tuning{gain = 2, time_constant = 10, dead_time = 4, lambda = 6, derivative = true}\n"
              "print(c.kp, c.ki, math.abs(c.kd/c.kp - 10*4/24) < 1e-12)"),
      "0.75\t0.0625\ttrue");
}

TEST_F(Tuning, AStepTestFindsTheLagAndTheDeadTime) {
  EXPECT_EQ(printed(R"(
local t, y = {}, {}
for k = 0, 4000 do
  t[k + 1] = 0.05*k
  y[k + 1] = 3 + (t[k + 1] > 12 and -0.8*1.5*(1 - math.exp(-(t[k + 1] - 12)/9)) or 0)
end
local m = pl.step_test(pl.vector(t), pl.vector(y), {size = 1.5, at = 10})
print(math.abs(m.gain + 0.8) < 1e-6, math.abs(m.time_constant - 9) < 1e-3, math.abs(m.dead_time - 2) < 1e-3))"),
            "true\ttrue\ttrue");
}

TEST_F(Tuning, SaysWhatIsWrong) {
  EXPECT_THAT(complaint("pl.pole_placement({{1, 0}, {0, 2}}, {1, 0}, {-1, -2})"),
              HasSubstr("the input reaches only 1 of the 2 states' directions, so not all poles can be moved"));
  EXPECT_THAT(complaint("pl.pole_placement({{1, 0}, {0, 2}}, {1, 1}, {{-1, 2}, {-1, 2}})"),
              HasSubstr("complex poles come in pairs: with -1 + 2i stands -1 - 2i"));
  EXPECT_THAT(complaint("pl.lambda_tuning{gain = 1, time_constant = 2}"),
              HasSubstr("'lambda' is missing, a number greater than 0"));
  EXPECT_THAT(complaint("pl.step_test({0, 1, 2}, {1, 1, 1}, {size = 1})"),
              HasSubstr("y ends where it began, so the step moved nothing"));
}

}  // namespace
}  // namespace plantloop
