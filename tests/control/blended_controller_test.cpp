// Blended controllers: what each way of blending does at a switch, at limits, and against closed forms.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::HasSubstr;

constexpr const char* folder = "tests/control/models/";

// A loop for each way around a lag of gain 2, at rest at y = w when the weight goes from the first controller to the
// second one.
std::string switched(double w, double at) {
  std::string text = fmt::format(
      "blocks:\n  second: {{type: step, time: {}, before: 0, after: 1}}\n  w: {{type: step, time: 0.5, before: 0, "
      "after: "
      "{}}}\n",
      at, w);
  for (const char* way : {"velocity", "parameters", "signals", "untracked"}) {
    const std::string name(way);
    text += fmt::format(
        "  {0}: {{type: blended_controller, model: {1}two_controllers.yaml, in: {{e: w - y_{0}, weights: [1 - second, "
        "second]}}, blending: {2}{3}}}\n  y_{0}: {{type: first_order, in: {0}, k: 2}}\n",
        name, folder, name == "untracked" ? "signals" : name, name == "untracked" ? ", anti_windup: none" : "");
  }
  return text + "simulation: {stop: 40, rtol: 1e-9}\nrecord: [velocity, parameters, signals, untracked, y_velocity]\n";
}

TEST(BlendedController, SwitchedWithoutAnErrorMovesTheSignalInConventionalFormsOnly) {
  for (const double w : {1.0, -3.0, 0.2}) {
    const Signals r = run(switched(w, 30));
    const auto bump = [&](const char* name) { return r.at(name, 30) - r.at(name, 30, true); };
    // At rest u = w/2 = ki times the error's integral; behind the switch it is the other ki times the same.
    EXPECT_NEAR(bump("velocity"), 0, 1e-12) << w;
    EXPECT_NEAR(bump("parameters"), (12 - 2) * w / 4, 1e-5 * std::abs(w)) << w;
    EXPECT_NEAR(bump("untracked"), (12 - 2) * w / 4, 1e-5 * std::abs(w)) << w;
    // A controller that waits and follows u has been led to it, to what 30 time constants and the last error leave.
    EXPECT_LT(std::abs(bump("signals")), 1e-4 * std::abs(w)) << w;
    // Behind the switch the velocity form stays at rest.
    EXPECT_NEAR(r.at("y_velocity", 40), w, 1e-5 * std::abs(w));
  }
}

TEST(BlendedController, BlendedSignalsWithoutTrackingAreBlendedParameters) {
  // All local integrals see the same error, so the two conventional ways are one (book section 6.2).
  const Signals r =
      run(fmt::format("blocks:\n"
                      "  mu: {{type: gaussian_weights, in: a, centres: [0, 2], widths: 0.6}}\n"
                      "  w: {{type: staircase, times: [0, 1, 4, 7], values: [0, 2, -1, 1.3]}}\n"
                      "  a: {{type: first_order, in: p, k: 0.8}}\n  b: {{type: first_order, in: s, k: 0.8}}\n"
                      "  nu: {{type: gaussian_weights, in: b, centres: [0, 2], widths: 0.6}}\n"
                      "  p: {{type: blended_controller, model: {0}two_controllers.yaml, in: {{e: w - a, weights: mu}}, "
                      "blending: parameters, anti_windup: none, initial: 0.3}}\n"
                      "  s: {{type: blended_controller, model: {0}two_controllers.yaml, in: {{e: w - b, weights: nu}}, "
                      "blending: signals, anti_windup: none, initial: 0.3}}\n"
                      "  error: p - s\nsimulation: {{stop: 10, rtol: 1e-10}}\nrecord: [error, p]\n",
                      folder));
  EXPECT_LT(r.greatest("error"), 1e-7);
  EXPECT_GT(r.greatest("p"), 1);
}

TEST(BlendedController, WithOneWeightIsThePidControllerBehindTheFilterInEveryWay) {
  const auto text = [](const char* way) {
    return fmt::format(
        "blocks:\n"
        "  e: {{type: step, time: 0.2, before: 0, after: 1.5}}\n"
        "  c: {{type: blended_controller, model: {}pid_family.yaml, in: {{e: e, weights: [2, 0]}}, blending: {}, "
        "anti_windup: none, p: 40, N: 60, initial: -0.7}}\n"
        "  z: {{type: first_order, in: e, tau: 1/40}}\n"
        "  pid: {{type: pid, in: z, kp: 3, ki: 1.5, kd: 0.4, N: 60, initial: -0.7}}\n"
        "  error: c - pid\nsimulation: {{stop: 3, rtol: 1e-10}}\nrecord: [error, c]\n",
        folder, way);
  };
  for (const char* way : {"velocity", "parameters", "signals"})
    EXPECT_LT(run(text(way)).greatest("error"), 1e-6) << way;
}

TEST(BlendedController, FeedsBackStatesWithTheDesignedPoles) {
  // x'' = u with u = ki (integral of e) - K x: s^3 + K2 s^2 + K1 s + ki = (s + 2)^3, and (s + 3)^3 at the other point.
  for (const auto& [weights, a] : {std::pair{"[1, 0]", 2.0}, std::pair{"[0, 1]", 3.0}}) {
    for (const char* way : {"velocity", "parameters", "signals"}) {
      const Signals r =
          run(fmt::format("blocks:\n"
                          "  w: {{type: step, time: 0, before: 0, after: 1}}\n"
                          "  x: {{type: integrator, in: v, initial: 0}}\n  v: {{type: integrator, in: c}}\n"
                          "  c: {{type: blended_controller, model: {}feedback_family.yaml, in: {{e: w - x, x: \"[x, "
                          "v]\", weights: {}}}, blending: "
                          "{}, anti_windup: none, p: 2e4}}\n"
                          "  one: 1\n  exact: {{type: transfer_function, in: one, num: [{}], den: [1, {}, {}, {}]}}\n"
                          "  error: x - exact\nsimulation: {{stop: 4, solver: bdf, rtol: 1e-9}}\nrecord: [error, x]\n",
                          folder, weights, way, a * a * a, 3 * a, 3 * a * a, a * a * a));
      EXPECT_LT(r.greatest("error"), 2e-3) << way << a;  // the filter's lag of 1/p, some ten times over
      EXPECT_GT(r.last("x"), 0.98);
    }
  }
}

TEST(BlendedController, KeepsLimitsAndSpeedAndDoesNotWindUp) {
  // The set point asks for more than the limit gives for 20 s; then it is within reach. Without anti-windup u stays at
  // its limit for long.
  const auto text = [](const std::string& more) {
    return fmt::format(
        "blocks:\n"
        "  w: {{type: staircase, times: [0, 1, 21], values: [0, 5, 1]}}\n"
        "  c: {{type: blended_controller, model: {}two_controllers.yaml, in: {{e: w - y, weights: [1, 1]}}, lower: "
        "-0.2, upper: 0.9, {}}}\n"
        "  y: {{type: first_order, in: c, k: 2, tau: 0.5}}\nsimulation: {{stop: 60, rtol: 1e-8}}\nrecord: [c, y]\n",
        folder, more);
  };
  const auto late = [](const Signals& r) {  // until when u stands at its upper limit behind 21 s
    double last = 21;
    const std::vector<double> c = r.column("c");
    for (std::size_t i = 0; i < c.size(); ++i) {
      if (c[i] > 0.9 - 1e-9) last = std::max(last, r.recording().time()[i]);
    }
    return last - 21;
  };
  for (const char* way :
       {"blending: velocity", "blending: parameters, t_track: 0.2", "blending: signals, t_track: 0.2"}) {
    const Signals r = run(text(way));
    EXPECT_LE(r.greatest("c"), 0.9 + 1e-12) << way;
    EXPECT_LT(late(r), 0.3) << way;
    EXPECT_NEAR(r.last("y"), 1, 1e-4) << way;
  }
  EXPECT_GT(late(run(text("blending: parameters, anti_windup: none"))), 20);
  // The speed: from one row to the next never faster than told.
  const Signals r = run(text("blending: velocity, slowest: -0.5, fastest: 0.25"));
  const std::vector<double> c = r.column("c"), &time = r.recording().time();
  for (std::size_t i = 1; i < c.size(); ++i) {
    EXPECT_LE(c[i] - c[i - 1], 0.25 * (time[i] - time[i - 1]) + 1e-9);
    EXPECT_GE(c[i] - c[i - 1], -0.5 * (time[i] - time[i - 1]) - 1e-9);
  }
}

TEST(BlendedController, SaysWhatDoesNotFit) {
  const auto found = [](const std::string& in, const std::string& more, const char* file = "two_controllers") {
    return findings(
        fmt::format("blocks:\n  c: {{type: blended_controller, model: {}{}.yaml, in: {{e: 1, weights: {}}}{}}}\n"
                    "simulation: {{stop: 1}}\n",
                    folder, file, in, more));
  };
  EXPECT_THAT(found("[1, 2, 3]", ""), HasSubstr("the file has 2 points, but there are 3 weights"));
  EXPECT_THAT(
      found("[1, 2]", ", blending: parameters, fastest: 1"),
      HasSubstr("'fastest' is for blending velocity; with parameters put a rate_limiter behind the controller and lead "
                "its output to 'track'"));
  EXPECT_THAT(found("[1, 2]", ", blending: signals", "pid_family"),
              HasSubstr("the controller at 1 has no integral part that could follow; write anti_windup: none"));
  EXPECT_THAT(found("[1, 2]", "", "sampled_family"),
              HasSubstr("a model of type 'velocity_family' is no controller_family"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
