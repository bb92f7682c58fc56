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

TEST_F(VelocityFamilyFromLua, OfASampledDiagramIsTheBooksBlendOfSevenModels) {
  // Equations (5.18) to (5.21), figure 5.23: A depends on the output, B on the input, each with weights of its own.
  write("sampled.yaml", R"(plantloop: 1
parameters: {y0: 0, u0: 0}
blocks:
  u: u0
  y: {type: unit_delay, in: y/(1 + y^2) + u^3, rate: 1, initial: y0}
simulation: {stop: 1}
)");
  write("seven.yaml", R"(plantloop: 1
blocks:
  u: {type: random_levels, lower: -1.2, upper: 1.2, seed: 12345, generator: lcg, rate: 1}
  y: {type: unit_delay, in: y/(1 + y^2) + u^3, rate: 1}
  mu_y: {type: gaussian_weights, in: v, centres: [-3, -2, -1, 0, 1, 2, 3], widths: 0.35}
  mu_u: {type: gaussian_weights, in: v.uf, centres: [-1.5, -1, -0.5, 0, 0.5, 1, 1.5], widths: 0.2}
  v: {type: velocity_blend, model: family.yaml, in: {u: u, weights: mu_y, input_weights: mu_u}, initial: 0, initial_input: 0}
  error: {type: zero_order_hold, in: v - y, rate: {period: 1, offset: 0.99}}
simulation: {stop: 24.99, rtol: 1e-9, atol: 1e-11}
record: [error]
expect:
  - {signal: v, at: 1.99, value: -1.04670, abs: 1e-5}
  - {signal: v, at: 2.99, value: 0.10614, abs: 1e-5}
  - {signal: v, at: 3.99, value: 1.48245, abs: 1e-5}
  - {signal: v, at: 10.99, value: 0.88353, abs: 1e-5}
  - {signal: v, at: 24.99, value: 0.18068, abs: 1e-5}
  - {signal: error, measure: max_abs, value: 0.2339, abs: 1e-4}
)");
  EXPECT_EQ(printed(R"(
local system, points = pl.load('sampled.yaml'), {}
for i = -3, 3 do points[#points + 1] = {at = i, diagram = system:with{y0 = i, u0 = i/2}} end
system:velocity_family{path = 'family.yaml', inputs = {'u'}, outputs = {'y'}, points = points}
local met = 0
for _, verdict in ipairs(pl.load('seven.yaml'):run():verdicts()) do if verdict.met then met = met + 1 end end
print(met, pl.read('family.yaml'):match('Ts: (%S+)')))"),
            "6\t1");
}

TEST_F(VelocityFamilyFromLua, SamplesAContinuousDiagramWithItsDeadTime) {
  // A lag of 2 s behind a dead time of 0.7 s, sampled every 0.5 s with a held input, from rest: exact at the samples.
  write("lag.yaml", "plantloop: 1\nblocks:\n  u: 0\n  y: {type: first_order, in: u, tau: 2}\nsimulation: {stop: 1}\n");
  write("late.yaml", R"(plantloop: 1
blocks:
  u: {type: random_levels, lower: -1, upper: 2, seed: 5, rate: 0.5}
  late: {type: transport_delay, in: u, delay: 0.7, initial: 0}
  y: {type: first_order, in: late, tau: 2}
  at_sample: {type: zero_order_hold, in: y, rate: 0.5}
  v: {type: velocity_model, model: family.yaml, in: u, initial_input: 0}
  error: {type: zero_order_hold, in: v - at_sample, rate: {period: 0.5, offset: 0.499}}
simulation: {stop: 12, rtol: 1e-9}
record: [error, y]
expect: [{signal: error, max_abs: 1e-7}, {signal: y, measure: max, value: 1, abs: 0.9}]
)");
  EXPECT_EQ(printed(R"(
local lag = pl.load('lag.yaml')
lag:velocity_family{path = 'family.yaml', inputs = {'u'}, outputs = {'y'}, points = {{at = 0}}, sampling_time = 0.5, dead_time = 0.7}
local verdicts = pl.load('late.yaml'):run():verdicts()
print(verdicts[1].met, verdicts[2].met))"),
            "true\ttrue");
  EXPECT_THAT(
      complaint("pl.load('lag.yaml'):velocity_family{path = 'f.yaml', inputs = {'u'}, outputs = {'y'}, points = "
                "{{at = 0}}, dead_time = 1}"),
      HasSubstr("'dead_time' goes with 'sampling_time'; in front of a continuous model stands a transport_delay"));
  EXPECT_THAT(
      complaint("pl.load('lag.yaml'):velocity_family{path = 'f.yaml', inputs = {'u'}, outputs = {'y'}, points = "
                "{{at = 0}}, sampling_time = -1}"),
      HasSubstr("'sampling_time' must be a number greater than 0, in s"));
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
