// Families of controllers from scripts, against closed forms and the book's robot arm.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;

class ControllersFromLua : public Workshop {
 protected:
  // J phi'' = M - G sin phi - kv phi', section 6.2 of the book.
  ControllersFromLua() {
    write("arm.yaml", R"(plantloop: 1
parameters: {J: 1/3, kv: 5, G: 4.905, phi0: 0}
blocks:
  M: G*sin(phi0)
  phi: {type: integrator, in: omega, initial: phi0}
  omega: {type: integrator, in: (M - G*sin(phi) - kv*omega)/J}
simulation: {stop: 1}
)");
  }
  static std::string with_arm(const std::string& script) {
    return "local arm = pl.load('arm.yaml')\nlocal function near(a, b) return math.abs(a - b) < 1e-6 end\n" + script;
  }
};

TEST_F(ControllersFromLua, OfTheRobotArmAreTheBooksThreeControllers) {
  // Cancelling the slow pole leaves 2/s: K0 = 2 J p_fast, K1 = K0 p_slow at 0, 36 and 72 degrees.
  EXPECT_EQ(printed(with_arm(R"(
local path = arm:controller_family{path = 'c.yaml', input = 'M', output = 'phi', scheduling = 'y',
  points = {{at = 0.7, diagram = arm:with{phi0 = '72*pi/180'}}, {at = 0}, {at = 0.2, diagram = arm:with{phi0 = '36*pi/180'}}},
  design = {method = 'lambda_tuning', controller = 'pi', lambda = 0.5}}
local expected, i = {9.296510, 9.810000, 9.439485, 7.936457, 9.793645, 3.031457}, 0
local met = 0
for kp, ki in pl.read(path):gmatch('kp: (%S+)%s+ki: (%S+)') do
  if near(tonumber(kp), expected[i + 1]) and near(tonumber(ki), expected[i + 2]) then met = met + 1 end
  i = i + 2
end
print(path, met, pl.read(path):match('scheduling: (%S+)')))")),
            "c.yaml\t3\t\"y\"");
}

TEST_F(ControllersFromLua, AreDesignedInOneCallForALinearisedModel) {
  EXPECT_EQ(printed(with_arm(R"(
local m = arm:linearise{inputs = 'M', outputs = 'phi'}
local c = pl.tune(m, {method = 'lambda_tuning', controller = 'pid', lambda = 0.5})
print(near(c.kp, 10), near(c.ki, 9.81), near(c.kd, 2/3))
c = pl.tune(m, {method = 'pole_placement', controller = 'pid', poles = {-2, -3, -4}})  -- J s^3 + (kv + kd) s^2 + ...
print(near(c.ki, 8), near(c.kp, 26/3 - 4.905), near(c.kd, -2))
c = pl.tune(m, {method = 'pole_placement', controller = 'state_feedback', poles = {{-2, 1}, {-2, -1}, {-4, 0}}})
-- s^3 + (15 + 3 K2) s^2 + (14.715 + 3 K1) s + 3 ki = (s^2 + 4 s + 5)(s + 4)
print(near(c.ki, 20/3), near(c.K[1], (21 - 14.715)/3), near(c.K[2], (8 - 15)/3)))")),
            "true\ttrue\ttrue\ntrue\ttrue\ttrue\ntrue\ttrue\ttrue");
}

TEST_F(ControllersFromLua, ByQuadraticWeightsAreThoseOfTheRiccatiEquation) {
  // x' = u with the error's integral q' = -x: Q = diag(q1, q2), R = r. ki = sqrt(q2/r), K = sqrt(q1/r + 2 ki).
  write("integrator.yaml", "plantloop: 1\nblocks:\n  u: 0\n  x: {type: integrator, in: u}\nsimulation: {stop: 1}\n");
  EXPECT_EQ(printed(R"(
local m = pl.load('integrator.yaml'):linearise{inputs = 'u', outputs = 'x'}
local c = pl.tune(m, {method = 'lqr', controller = 'state_feedback', Q = {3, 8}, R = 2})
print(math.abs(c.ki - 2) < 1e-9, math.abs(c.K[1] - math.sqrt(3/2 + 4)) < 1e-9))"),
            "true\ttrue");
}

TEST_F(ControllersFromLua, ByAStepTestKnowALagForWhatItIs) {
  write("lag.yaml",
        "plantloop: 1\nblocks:\n  u: 0\n  y: {type: first_order, in: u, tau: 3, k: -2}\nsimulation: {stop: 1}\n");
  EXPECT_EQ(printed(R"(
local lag = pl.load('lag.yaml')
local m = lag:linearise{inputs = 'u', outputs = 'y'}
for _, method in ipairs{'step_test', 'lambda_tuning'} do
  local c = pl.tune(m, {method = method, lambda = 1.5})
  print(math.abs(c.kp + 1) < 1e-4, math.abs(c.ki + 1/3) < 1e-4)
end)"),
            "true\ttrue\ntrue\ttrue");
}

TEST_F(ControllersFromLua, AreDesignedForAnIdentifiedModel) {
  // y(k+1) = 0.8 y(k) + 0.4 u(k) every 0.5 s: gain 2, T = -0.5/ln 0.8.
  EXPECT_EQ(printed(R"(
local u, y = {}, {}
local last, input = 0, 0
for k = 1, 200 do
  u[k] = (k*k % 7) - 3
  y[k] = 0.8*last + 0.4*input
  last, input = y[k], u[k]
end
local data = pl.identify.data{u = pl.vector(u), y = pl.vector(y), Ts = 0.5}
local model = pl.identify.arx(data, {na = 1, nb = 1})
local c = pl.tune(model, {method = 'lambda_tuning', lambda = 1})
local T = -0.5/math.log(0.8)
print(math.abs(c.kp - T/2) < 1e-6, math.abs(c.ki - 0.5) < 1e-6))"),
            "true\ttrue");
}

TEST_F(ControllersFromLua, SayWhatIsWrong) {
  const auto wrong = [&](const std::string& design) {
    return complaint(with_arm("pl.tune(arm:linearise{inputs = 'M', outputs = 'phi'}, {" + design + "})"));
  };
  EXPECT_THAT(wrong("method = 'guess'"),
              HasSubstr("'method' is pole_placement, lambda_tuning, step_test or lqr, it is 'guess'"));
  EXPECT_THAT(wrong("method = 'lqr', controller = 'pd'"),
              HasSubstr("'controller' is pi, pid or state_feedback, it is 'pd'"));
  EXPECT_THAT(wrong("method = 'pole_placement', poles = {-1, -2}"),
              HasSubstr("a pi controller places the poles of a model of order 1, this one has 2"));
  EXPECT_THAT(wrong("method = 'pole_placement', controller = 'pid', poles = {-1, -2}"),
              HasSubstr("the loop with this controller has 3 poles, here are 2"));
  EXPECT_THAT(wrong("method = 'lambda_tuning'"), HasSubstr("'lambda' must be a number greater than 0"));
  EXPECT_THAT(wrong("method = 'lqr', controller = 'state_feedback', Q = {1}"),
              HasSubstr("'Q' has 3 weights, of each state and of the error's integral"));
  EXPECT_THAT(
      complaint(with_arm("arm:controller_family{path = 'c.yaml', input = 'M', output = 'phi', points = {{at = 0}}}")),
      HasSubstr("'design' tells how, as in {method = \"lambda_tuning\", controller = \"pi\", lambda = 2}"));
}

}  // namespace
}  // namespace plantloop
