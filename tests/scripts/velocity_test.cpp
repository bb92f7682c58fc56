// Velocity-form families from scripts: the pendulum's matrices in closed form, and a blend of them against the book's
// blended pendulum.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;

class VelocityFamilyFromLua : public Workshop {
 protected:
  VelocityFamilyFromLua() {
    write("pendulum.yaml", R"(plantloop: 1
parameters: {Q: 29.46, b: 1.21, theta0: 0}
blocks:
  force: Q/b*sin(theta0)
  theta: {type: integrator, in: omega, initial: theta0}
  omega: {type: integrator, in: b*force - Q*omega - Q*sin(theta)}
simulation: {stop: 1}
)");
    // Figures 5.21 and 5.22: three models frozen at 0, pi/2 and pi, started at pi/4.
    write("blend.yaml", R"(plantloop: 1
blocks:
  F0: 29.46/1.21*sin(pi/4)
  force: {type: staircase, times: [0, 1, 9, 17, 25], values: [17.216005, 18.716005, 17.216005, 15.716005, 17.216005]}
  mu: {type: gaussian_weights, in: theta, centres: [0, pi/2, pi], widths: 0.7}
  theta: {type: velocity_blend, model: family.yaml, in: {u: force, weights: mu}, initial: pi/4}
simulation: {stop: 33, rtol: 1e-9}
record: [theta]
expect:
  - {signal: theta, at: 3, value: 0.864941, abs: 1e-5}
  - {signal: theta, at: 8.99, value: 0.920487, abs: 1e-5}
  - {signal: theta, at: 16.99, value: 0.788186, abs: 1e-5}
  - {signal: theta, at: 24.99, value: 0.672709, abs: 1e-5}
  - {signal: theta, at: 33, value: 0.783527, abs: 1e-5}
)");
  }
  static constexpr const char* make = R"(
local pendulum = pl.load('pendulum.yaml')
local path = pendulum:velocity_family{path = 'family.yaml', inputs = {'force'}, outputs = {'theta'}, points = {
  {at = math.pi, diagram = pendulum:with{theta0 = 'pi'}}, {at = 0}, {at = math.pi/2, diagram = pendulum:with{theta0 = 'pi/2'}}}}
)";
};

TEST_F(VelocityFamilyFromLua, HasTheMatricesOfThePendulum) {
  // States in the program's order; d omega'/d theta = -Q cos(theta).
  EXPECT_EQ(printed(std::string(make) + R"(
local text = pl.read('family.yaml')
local slopes = {}
for a in text:gmatch('A:%s+%- %[[^%]]*%]%s+%- %[([^,]+),') do slopes[#slopes + 1] = a end
local function near(x, y) return math.abs(tonumber(x) - y) < 1e-12 end
print(#slopes, near(slopes[1], -29.46), near(slopes[2], 0), near(slopes[3], 29.46), text:match('states: (%b[])'), text:match('scheduling: (%S+)')))"),
            "3\ttrue\ttrue\ttrue\t[theta, omega]\ttheta");
}

TEST_F(VelocityFamilyFromLua, ABlendOfItIsTheBooksBlendedPendulum) {
  EXPECT_EQ(printed(std::string(make) + R"(
local run = pl.load('blend.yaml'):run()
local met = 0
for _, verdict in ipairs(run:verdicts()) do if verdict.met then met = met + 1 end end
print(#run:verdicts(), met))"),
            "5\t5");
}

TEST_F(VelocityFamilyFromLua, SaysWhatIsWrong) {
  const std::string begin = "pl.load('pendulum.yaml'):velocity_family{path = 'f.yaml', ";
  EXPECT_THAT(complaint(begin + "inputs = {'force'}, outputs = {'theta'}}"),
              HasSubstr("'points' is a list, as in {{at = 0}, {at = 1, diagram = plant:with{level = 1}}}"));
  EXPECT_THAT(complaint(begin + "inputs = {'force'}, points = {{at = 0}}}"),
              HasSubstr("'inputs' and 'outputs' are lists of signals"));
  EXPECT_THAT(complaint(begin + "inputs = {'force'}, outputs = {'theta'}, points = {{}}}"),
              HasSubstr("each point has 'at', the value of the scheduling variable"));
  EXPECT_THAT(complaint(begin + "inputs = {'force'}, outputs = {'theta'}, points = {{at = 1}, {at = 1}}}"),
              HasSubstr("two points are at 1"));
}

}  // namespace
}  // namespace plantloop
