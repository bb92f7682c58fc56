// Play, speed limits, friction and tables of two inputs against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/error.h"
#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const double pi = std::acos(-1);

TEST(Backlash, IsPushedByASineAndLeftWhereItTurns) {
  // u = 2 sin t, play 1: at rest until u = 0.5, then u - 0.5 to pi/2, 1.5 until u = 1, u + 0.5 to 3 pi/2, and so on.
  const Signals r = run(R"(
blocks:
  u: {type: sine, amplitude: 2}
  y: {type: backlash, in: u}
  up: where(time < asin(0.25), 0, where(time < pi/2, u - 0.5, where(time < 5*pi/6, 1.5, u + 0.5)))
  down: where(time < 3*pi/2, up, where(time < 11*pi/6, -1.5, u - 0.5))
  difference: y - down
simulation: {stop: 2*pi + 1}
)");
  // Instants are located to 3e-13 s.
  EXPECT_LT(r.greatest("difference"), 1e-11);
}

TEST(Backlash, LocatesTurnsOfStates) {
  // The same with x'' = -x: the peaks 2 and -2 are no steps of the solver by chance.
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: v}
  v: {type: integrator, in: -x, initial: 2}
  y: {type: backlash, in: x}
simulation: {stop: 6, rtol: 1e-11, atol: 1e-12}
expect: [{signal: y, at: 2, value: 0}, {signal: y, at: 3, value: 0}, {signal: y, at: 5, value: 0}, {signal: y, at: 6, value: 0}]
)");
  EXPECT_NEAR(r.sampled("y", 2), 1.5, 1e-9);
  EXPECT_NEAR(r.sampled("y", 3), 2 * std::sin(3) + 0.5, 1e-9);
  EXPECT_NEAR(r.sampled("y", 5), -1.5, 1e-9);
  EXPECT_NEAR(r.sampled("y", 6), 2 * std::sin(6) - 0.5, 1e-9);
}

TEST(Backlash, IsPushedByJumps) {
  const std::string input =
      "blocks:\n  u: {type: staircase, times: [0, 1, 2, 3], values: [0, 3, 2.2, 1]}\n"
      "  y: {type: backlash, in: [u, -u], width: 1, initial: 0.2";
  const Signals r = run(input + "}\nsimulation: {stop: 4}\n");
  EXPECT_EQ(r.at("y.1", 0.5), 0.2);
  EXPECT_EQ(r.at("y.1", 1), 2.5);
  EXPECT_EQ(r.at("y.1", 2), 2.5);
  EXPECT_EQ(r.at("y.1", 3), 1.5);
  EXPECT_EQ(r.at("y.2", 3.5), -1.5);
  const Signals s = run(input + ", rate: 1}\nsimulation: {stop: 4}\n");
  EXPECT_THAT(s.samples("y.1"), ElementsAre(0.2, 2.5, 2.5, 1.5, 1.5));
}

TEST(RateLimiter, FallsBehindASineAndMeetsItAgain) {
  // u = 2 sin t with speeds within 1: y = t until t = 2 sin t, u until cos t = -1/2, then sqrt 3 - (t - 2 pi/3).
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: v}
  v: {type: integrator, in: -x, initial: 2}
  y: {type: rate_limiter, in: x}
  of_time: {type: rate_limiter, in: 2*sin(time)}
simulation: {stop: 3, rtol: 1e-11, atol: 1e-12}
expect: [{signal: y, at: 1, value: 0}, {signal: y, at: 2, value: 0}, {signal: y, at: 2.5, value: 0},
         {signal: of_time, at: 1, value: 0}, {signal: of_time, at: 2, value: 0}, {signal: of_time, at: 2.5, value: 0}]
)");
  for (const char* y : {"y", "of_time"}) {
    EXPECT_NEAR(r.sampled(y, 1), 1, 1e-9);
    EXPECT_NEAR(r.sampled(y, 2), 2 * std::sin(2), 1e-9);
    EXPECT_NEAR(r.sampled(y, 2.5), std::sqrt(3) - (2.5 - 2 * pi / 3), 1e-9);
  }
}

TEST(RateLimiter, RunsAfterJumpsBothWays) {
  const std::string input =
      "blocks:\n  u: {type: staircase, times: [0, 1, 3], values: [1, 4, 0]}\n"
      "  y: {type: rate_limiter, in: u, lower: -4, upper: 2";
  const Signals r = run(input + "}\nsimulation: {stop: 5}\n");
  EXPECT_EQ(r.at("y", 0.5), 1);
  EXPECT_EQ(r.at("y", 1), 1);
  EXPECT_NEAR(r.at("y", 2), 3, 1e-12);
  EXPECT_NEAR(r.at("y", 2.75), 4, 1e-12);
  EXPECT_NEAR(r.at("y", 3.5), 2, 1e-12);
  EXPECT_EQ(r.last("y"), 0);
  const Signals s = run(input + ", initial: 0, rate: 0.5}\nsimulation: {stop: 5}\n");
  EXPECT_THAT(s.samples("y"), ElementsAre(0, 1, 2, 3, 4, 4, 2, 0, 0, 0, 0));
}

TEST(CoulombFriction, IsOddWithAStepAtZero) {
  const Signals r = run(R"(
blocks:
  y: {type: coulomb_friction, in: time - 1, coulomb: 2, viscous: 3}
  x: {type: integrator, in: y}
simulation: {stop: 3}
)");
  EXPECT_NEAR(r.at("y", 0), -5, 1e-12);
  EXPECT_NEAR(r.last("y"), 8, 1e-12);
  EXPECT_NEAR(r.last("x"), -2 - 1.5 + 4 + 6, 1e-10);
}

TEST(CoulombFriction, SticksAndSlipsOnABelt) {
  // A mass on a spring (m = k = 1) on a belt of speed 1, coulomb 1, static 1.5: it sticks until x = 1.5, slips about
  // x = 1 and sticks again at x = 0.5 after 2 pi - 2 atan(0.5), then rides 1 s to x = 1.5, and so on.
  const double slip = 2 * pi - 2 * std::atan(0.5), period = slip + 1;
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: v}
  v: {type: integrator, in: -x - friction, initial: 1}
  friction: {type: coulomb_friction, in: {v: v - 1, force: -x}, coulomb: 1, static: 1.5}
  slips: {type: hit_crossing, in: x, level: 1.5 - 1e-9, edge: rising}
simulation: {stop: 31, rtol: 1e-11, atol: 1e-13}
record: [x, v, slips.instant, slips.count]
)");
  // 1.5 + 4 periods = 1.5 + 4 * 6.3559... < 31
  EXPECT_EQ(r.last("slips.count"), 5);
  EXPECT_NEAR(r.last("slips.instant"), 1.5 + 4 * period, 1e-8);
  EXPECT_NEAR(r.at("v", 1.2), 1, 1e-12);
}

TEST(CoulombFriction, TurnsRoundWithoutSticking) {
  // v' = -3 - 1 until v = 0 at 0.5, then v' = -3 + 1.
  const Signals r = run(R"(
blocks:
  v: {type: integrator, in: -3 - friction, initial: 2}
  friction: {type: coulomb_friction, in: {v: v, force: -3}}
simulation: {stop: 2}
)");
  EXPECT_NEAR(r.last("v"), -3, 1e-9);
  EXPECT_THAT(findings("blocks: {y: {type: coulomb_friction, in: 1, coulomb: 2, static: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("'static' must not be less than 'coulomb'"));
}

std::string table(const std::string& u, const std::string& v, const std::string& outside) {
  return "blocks:\n  y: {type: lookup_2d, in: {u: \"" + u + "\", v: \"" + v +
         "\"}, x: [0, 1, 3], y: [0, 2], z: [[0, 4], [2, 2], [6, 0]], outside: " + outside +
         "}\n  x: {type: integrator, in: y}\nsimulation: {stop: 1}\n";
}

TEST(Lookup2d, InterpolatesInBothDirections) {
  const auto at = [](const std::string& u, const std::string& v, const std::string& outside) {
    return run(table("0*time + " + u, "0*time + " + v, outside)).last("y");
  };
  EXPECT_DOUBLE_EQ(at("0", "0", "clip"), 0);
  EXPECT_DOUBLE_EQ(at("0.5", "1", "clip"), 2);
  EXPECT_DOUBLE_EQ(at("2", "0.5", "clip"), 3.25);
  EXPECT_DOUBLE_EQ(at("3", "2", "error"), 0);
  EXPECT_DOUBLE_EQ(at("5", "-1", "clip"), 6);
  EXPECT_DOUBLE_EQ(at("5", "0", "linear"), 10);
  EXPECT_DOUBLE_EQ(at("0", "3", "linear"), 6);
  EXPECT_DOUBLE_EQ(at("-1", "3", "linear"), 10);  // f = -1, g = 1.5 in the corner's cell
}

TEST(Lookup2d, IntegratesAcrossItsCellsExactly) {
  // u = 4 t - 0.5, v = 1: along the middle, 2 until u = 0, 2 to u = 1, then (u + 1) to 3 at u = 3, and 3.
  const Signals r = run(table("4*time - 0.5", "1", "clip"));
  EXPECT_NEAR(r.last("x"), (0.5 * 2 + 1 * 2 + 2 * 2.5 + 0.5 * 3) / 4, 1e-10);
}

TEST(Lookup2d, SaysWhatIsWrong) {
  EXPECT_THAT(
      findings("blocks: {y: {type: lookup_2d, in: {u: 1, v: 1}, x: [0, 1], y: [0, 1, 2], z: [[1, 2], [3, 4]]}}\n"
               "simulation: {stop: 1}\n"),
      HasSubstr("2 points x and 3 points y need a 2 by 3 matrix z, but it is a 2 by 2 matrix"));
  try {
    run(table("1", "4*time", "error"));
    FAIL() << "the run went on";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the input 'v' of block 'y' is"));
    EXPECT_THAT(error.what(), HasSubstr("outside its table from 0 to 2"));
    EXPECT_LT(error.time(), 0.51);
  }
}

}  // namespace
}  // namespace plantloop::testing_diagrams
