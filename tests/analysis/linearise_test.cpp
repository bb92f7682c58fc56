// S16: linear models of diagrams against closed forms, to 1e-8 and better.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/analysis/linearise.h"

namespace plantloop {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

LinearModel linear(const std::string& text, const LineariseRequest& request, std::string* findings = nullptr) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  auto model = diagram ? linearise(diagram->model_pointer(), request, report) : std::nullopt;
  if (findings) {
    *findings = to_text(report);
  } else {
    EXPECT_TRUE(model) << to_text(report);
  }
  return model.value_or(LinearModel{});
}

std::size_t place(const LinearModel& m, const std::string& state) {
  return static_cast<std::size_t>(std::find(m.states.begin(), m.states.end(), state) - m.states.begin());
}

// theta'' = -g/l sin(theta) - d theta' + u, at 0.5 rad.
constexpr const char* pendulum = R"(
parameters: {g: 9.81, d: 0.3, torque: 0}
blocks:
  u: torque
  theta: {type: integrator, in: omega, initial: 0.5}
  omega: {type: integrator, in: u - g*sin(theta) - d*omega}
simulation: {stop: 1, rtol: 1e-11, atol: 1e-13}
)";

TEST(S16Linearise, AtTheInitialValues) {
  const LinearModel m = linear(pendulum, {.inputs = {"u"}, .outputs = {"theta"}});
  const std::size_t th = place(m, "theta"), om = place(m, "omega");
  ASSERT_EQ(m.states.size(), 2u);
  EXPECT_EQ(m.A(th, th), 0);
  EXPECT_EQ(m.A(th, om), 1);
  EXPECT_NEAR(m.A(om, th), -9.81 * std::cos(0.5), 1e-14);
  EXPECT_EQ(m.A(om, om), -0.3);
  EXPECT_EQ(m.B(om, 0), 1);
  EXPECT_EQ(m.B(th, 0), 0);
  EXPECT_EQ(m.C(0, th), 1);
  EXPECT_EQ(m.D(0, 0), 0);
  EXPECT_EQ(m.y[0], 0.5);
}

// A step changes at its event only, and what is added to it reaches the states all the same.
TEST(S16Linearise, AnInputMayBeASourceThatJumps) {
  const LinearModel m = linear(
      "blocks:\n  r: {type: step, time: 0.5}\n  x: {type: integrator, in: 3*(r - x)}\n"
      "simulation: {stop: 1}\n",
      {.inputs = {"r"}, .outputs = {"x"}});
  EXPECT_EQ(m.A(0, 0), -3);
  EXPECT_EQ(m.B(0, 0), 3);
  EXPECT_TRUE(zeros(m).empty());
}

TEST(S16Linearise, AtATimeOfARun) {
  const LinearModel m = linear(pendulum, {.at = 0.7});
  EXPECT_EQ(m.time, 0.7);
  EXPECT_NEAR(m.A(place(m, "omega"), place(m, "theta")), -9.81 * std::cos(m.x[place(m, "theta")]), 1e-13);
}

TEST(S16Linearise, AtARest) {
  const LinearModel m = linear(pendulum, {.set = {{"torque", "4.905"}}, .trim = true});
  // sin(theta) = 0.5
  EXPECT_NEAR(m.x[place(m, "theta")], std::asin(0.5), 1e-10);
  EXPECT_NEAR(m.A(place(m, "omega"), place(m, "theta")), -9.81 * std::sqrt(0.75), 1e-9);
}

constexpr const char* loop = R"(
blocks:
  r: 1
  u: {type: gain, in: r - y, k: 4}
  y: {type: first_order, in: u, tau: 0.5}
simulation: {stop: 1}
)";

TEST(S16Linearise, ClosedAndOpened) {
  const LinearModel closed = linear(loop, {.inputs = {"r"}, .outputs = {"y"}});
  EXPECT_NEAR(closed.A(0, 0), -10, 1e-13);
  EXPECT_NEAR(gains_at_rest(closed)[0], 0.8, 1e-14);
  // What drives y.u counts as constant: the lag alone, from its input to the controller's output.
  const LinearModel opened = linear(loop, {.inputs = {"y.u"}, .outputs = {"u"}, .open = {"y.u"}});
  EXPECT_NEAR(opened.A(0, 0), -2, 1e-14);
  EXPECT_NEAR(gains_at_rest(opened)[0], -4, 1e-14);
  EXPECT_EQ(opened.y[0], 4);  // at the operating point of the closed loop
}

TEST(S16Linearise, DelaysAreNamedSinceTheyAreNotInTheModel) {
  const std::string delays = R"(
blocks:
  u: {type: step}
  x: {type: first_order, in: u - 0.5*back, tau: 1}
  back: {type: variable_delay, in: {u: x, delay: 0.5}, longest: 1}
  d: {type: transport_delay, in: x, delay: 1}
simulation: {stop: 10}
)";
  EXPECT_THAT(linear(delays, {.inputs = {"u"}, .outputs = {"d"}}).without_derivative,
              UnorderedElementsAre("back", "d"));
  EXPECT_THAT(linear(delays, {.inputs = {"u"}, .outputs = {"x"}}).without_derivative, ElementsAre("back"));
}

TEST(S16Linearise, AnOutputThatHasTheNameOfABlockInsideIsOne) {
  const std::string text = R"(
types:
  tank: {inputs: [q], blocks: {h: {type: integrator, in: q - 0.5*h}}, outputs: [h]}
blocks:
  q: 0
  a: {type: tank, in: q}
simulation: {stop: 10}
)";
  const LinearModel m = linear(text, {.inputs = {"q"}, .outputs = {"a.h"}});
  EXPECT_THAT(m.outputs, ElementsAre("a.h"));
  EXPECT_NEAR(gains_at_rest(m)[0], 2, 1e-12);
}

TEST(S16Linearise, ModesAreFrozen) {
  const std::string text = R"(
blocks:
  x: {type: integrator, in: s, initial: 3}
  s: {type: saturation, in: -2*x, lower: -1, upper: 1}
simulation: {stop: 10}
)";
  EXPECT_EQ(linear(text, {}).A(0, 0), 0);
  EXPECT_EQ(linear(text, {.at = 9}).A(0, 0), -2);
}

TEST(S16Linearise, AlgebraicLoopsAreEliminated) {
  // z = 1 - 0.5 z x, so dz/dx = -0.5 z / (1 + 0.5 x); at x = 2: z = 0.5.
  const LinearModel m = linear(R"(
blocks:
  z: 1 - 0.5*z*x
  x: {type: integrator, in: z - x, initial: 2}
simulation: {stop: 1}
)",
                               {.outputs = {"z"}});
  EXPECT_NEAR(m.y[0], 0.5, 1e-9);
  EXPECT_NEAR(m.C(0, 0), -0.125, 1e-9);
  EXPECT_NEAR(m.A(0, 0), -1.125, 1e-9);
}

TEST(S16Linearise, ElementsOfVectors) {
  const LinearModel m = linear(R"(
blocks:
  u: "[1, 2]"
  x: {type: integrator, in: "[u.1 + 3*u.2, u.2]"}
simulation: {stop: 1}
)",
                               {.inputs = {"u.2"}, .outputs = {"x"}});
  EXPECT_THAT(m.inputs, ElementsAre("u.2"));
  EXPECT_THAT(m.outputs, ElementsAre("x.1", "x.2"));
  EXPECT_EQ(m.B(place(m, "x.1"), 0), 3);
}

// A lag under a zero-order hold: x[k+1] = e^-aT x[k] + (1 - e^-aT)/a u[k], with u[k] = -K x[k] + v.
TEST(S16Linearise, ASampledLoopIsLiftedExactly) {
  const LinearModel m = linear(R"(
blocks:
  v: {type: constant, value: 0, rate: 0.2}
  u: {expr: v - 3*x, rate: 0.2}
  x: {type: integrator, in: u - 2*x}
simulation: {stop: 1}
)",
                               {.inputs = {"v"}, .outputs = {"x", "u"}});
  EXPECT_EQ(m.period, 0.2);
  ASSERT_THAT(m.states, ElementsAre("x"));
  const double phi = std::exp(-0.4), gamma = (1 - phi) / 2;
  EXPECT_NEAR(m.A(0, 0), phi - 3 * gamma, 1e-14);
  EXPECT_NEAR(m.B(0, 0), gamma, 1e-14);
  EXPECT_EQ(m.C(0, 0), 1);
  EXPECT_EQ(m.C(1, 0), -3);
  EXPECT_EQ(m.D(1, 0), 1);
}

TEST(S16Linearise, ADelayOfASampleIsAState) {
  const LinearModel m = linear(R"(
blocks:
  v: {type: constant, value: 0, rate: 0.1}
  d: {type: unit_delay, in: v, rate: 0.1}
simulation: {stop: 1}
)",
                               {.inputs = {"v"}, .outputs = {"d"}});
  ASSERT_THAT(m.states, ElementsAre("d"));
  EXPECT_EQ(m.A(0, 0), 0);
  EXPECT_EQ(m.B(0, 0), 1);
  EXPECT_EQ(m.C(0, 0), 1);
  EXPECT_EQ(m.D(0, 0), 0);
}

// Two rates, 0.1 and 0.2 s: over 0.2 s the fast integrator takes the slow one's value twice.
TEST(S16Linearise, SeveralRatesAreLiftedToTheirCommonPeriod) {
  const LinearModel m = linear(R"(
blocks:
  fast: {type: unit_delay, in: fast + 0.1*slow, rate: 0.1, initial: 1}
  slow: {type: unit_delay, in: slow - fast, rate: 0.2, initial: 1}
simulation: {stop: 1}
)",
                               {});
  EXPECT_EQ(m.period, 0.2);
  const std::size_t f = place(m, "fast"), s = place(m, "slow");
  EXPECT_NEAR(m.A(f, f), 1, 1e-15);
  EXPECT_NEAR(m.A(f, s), 0.2, 1e-15);
  EXPECT_NEAR(m.A(s, s), 1, 1e-15);
  EXPECT_NEAR(m.A(s, f), -1, 1e-15);
}

TEST(S16Linearise, WithHoldTheContinuousPartIsAlone) {
  const LinearModel m = linear(R"(
blocks:
  u: {expr: -3*x, rate: 0.2}
  x: {type: integrator, in: u - 2*x, initial: 1}
simulation: {stop: 1}
)",
                               {.inputs = {"x.u"}, .hold = true});
  EXPECT_EQ(m.period, 0);
  EXPECT_EQ(m.A(0, 0), -2);
  EXPECT_EQ(m.B(0, 0), 1);
}

TEST(S16Linearise, SaysWhatIsWrong) {
  std::string text;
  linear(loop, {.inputs = {"uu"}}, &text);
  EXPECT_EQ(text, "error: the input 'uu' is no signal of the diagram\n  did you mean 'u.u'?\n");
  linear("types: {}\n", {}, &text);
  EXPECT_THAT(text, HasSubstr("is a library: it has types, but no blocks to linearise"));
}

}  // namespace
}  // namespace plantloop
