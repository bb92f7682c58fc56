// Sampled blocks against recursions and closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string sampled(const std::string& blocks, const std::string& stop = "4") {
  return "blocks:\n  u: {type: staircase, times: [0, 1, 2, 3, 4], values: [1, 4, 2, 8, 5]}\n" + blocks +
         "simulation: {stop: " + stop + "}\n";
}

TEST(UnitDelay, ShowsThePreviousSample) {
  const Signals r = run(sampled(R"(
  y: {type: unit_delay, in: u, initial: 7, rate: 1}
  z: {type: unit_delay, in: y}
  v: {type: unit_delay, in: [u, -u], initial: [1, 2], rate: 1}
)"));
  EXPECT_THAT(r.samples("y"), ElementsAre(7, 1, 4, 2, 8));
  EXPECT_THAT(r.samples("z"), ElementsAre(0, 7, 1, 4, 2));
  EXPECT_THAT(r.samples("v.2"), ElementsAre(2, -1, -4, -2, -8));
}

TEST(UnitDelay, SimulatesARecursionOverItsOwnName) {
  const Signals r = run("blocks: {y: {type: unit_delay, in: 0.5*y + 1, rate: 0.1}}\nsimulation: {stop: 0.4}\n");
  EXPECT_THAT(r.samples("y"), ElementsAre(0, 1, 1.5, 1.75, 1.875));
}

TEST(ZeroOrderHold, HoldsBetweenHits) {
  const Signals r = run(R"(
blocks:
  y: {type: zero_order_hold, in: time, rate: {period: 0.5, offset: 0.25}}
  x: {type: integrator, in: y}
simulation: {stop: 1.75}
)");
  EXPECT_THAT(r.samples("y"), ElementsAre(0.25, 0.75, 1.25, 1.75));
  EXPECT_NEAR(r.last("x"), 0.5 * (0.25 + 0.75 + 1.25), 1e-12);
  EXPECT_THAT(findings("blocks: {y: {type: zero_order_hold, in: time}}\nsimulation: {stop: 1}\n"),
              HasSubstr("needs a rate"));
}

TEST(DiscreteTransferFunction, IsItsRecursion) {
  // y[k] = 1.5 y[k-1] - 0.7 y[k-2] + u[k-1] + 0.5 u[k-2]
  const Signals r = run(sampled(R"(
  y: {type: discrete_transfer_function, in: u, num: [2, 1], den: [2, -3, 1.4], rate: 1}
)"));
  const double u[] = {1, 4, 2, 8, 5};
  double before = 0, earlier = 0;
  const std::vector<double> y = r.samples("y");
  for (std::size_t k = 0; k < 5; ++k) {
    const double expected = 1.5 * before - 0.7 * earlier + (k > 0 ? u[k - 1] : 0) + 0.5 * (k > 1 ? u[k - 2] : 0);
    EXPECT_NEAR(y[k], expected, 1e-12) << k;
    earlier = before;
    before = expected;
  }
}

TEST(DiscreteTransferFunction, PassesTheInputOnWhereDegreesAreEqual) {
  // (z - 0.2)/(z - 0.5): y[k] = 0.5 y[k-1] + u[k] - 0.2 u[k-1]
  const Signals r =
      run(sampled("  y: {type: discrete_transfer_function, in: [u, 2*u], num: [1, -0.2], den: [1, -0.5], rate: 1}\n"));
  EXPECT_THAT(r.samples("y.1"), ElementsAre(1, DoubleNear(4.3, 1e-12), DoubleNear(3.35, 1e-12),
                                            DoubleNear(9.275, 1e-12), DoubleNear(8.0375, 1e-12)));
  EXPECT_NEAR(r.samples("y.2")[4], 2 * 8.0375, 1e-12);
}

TEST(DiscreteTransferFunction, StartsAtRestAtItsInitialOutput) {
  // Static gain 3/0.2 with u = 2: at rest at 30.
  const Signals r = run(R"(
blocks: {y: {type: discrete_transfer_function, in: 2, num: [1, 2], den: [1, -1.5, 0.7], initial: 30, rate: 1}}
simulation: {stop: 20}
)");
  for (const double v : r.samples("y")) EXPECT_NEAR(v, 30, 1e-11);
}

TEST(DiscreteStateSpace, IsItsRecursion) {
  const Signals r = run(sampled(R"(
  y: {type: discrete_state_space, in: u, A: [[0, 1], [-0.7, 1.5]], B: [0, 1], C: [0.5, 1], D: 0, rate: 1}
  same: {type: discrete_transfer_function, in: u, num: [1, 0.5], den: [1, -1.5, 0.7], rate: 1}
  difference: y - same
)"));
  EXPECT_LT(r.greatest("difference"), 1e-12);
}

TEST(DiscreteIntegrator, CountsSamplesByItsMethod) {
  const Signals r = run(sampled(R"(
  f: {type: discrete_integrator, in: u, initial: 10, rate: 1}
  b: {type: discrete_integrator, in: u, initial: 10, method: backward, rate: 1}
  t: {type: discrete_integrator, in: u, initial: 10, method: trapezoidal, rate: 1}
)"));
  EXPECT_THAT(r.samples("f"), ElementsAre(10, 11, 15, 17, 25));
  EXPECT_THAT(r.samples("b"), ElementsAre(11, 15, 17, 25, 30));
  EXPECT_THAT(r.samples("t"), ElementsAre(10.5, 13, 16, 21, 27.5));
}

TEST(DiscreteIntegrator, UsesItsPeriodAndStaysInItsLimits) {
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 0.45], values: [4, -4]}
  y: {type: discrete_integrator, in: u, upper: 1, rate: 0.1}
simulation: {stop: 0.8}
)");
  EXPECT_THAT(r.samples("y"), ElementsAre(0, DoubleNear(0.4, 1e-12), DoubleNear(0.8, 1e-12), 1, 1, 1,
                                          DoubleNear(0.6, 1e-12), DoubleNear(0.2, 1e-12), DoubleNear(-0.2, 1e-12)));
}

TEST(TappedDelay, HoldsTheNewestSampleFirst) {
  const Signals r = run(sampled("  y: {type: tapped_delay, in: u, taps: 3, initial: -1, rate: 1}\n"));
  EXPECT_THAT(r.samples("y.1"), ElementsAre(-1, 1, 4, 2, 8));
  EXPECT_THAT(r.samples("y.2"), ElementsAre(-1, -1, 1, 4, 2));
  EXPECT_THAT(r.samples("y.3"), ElementsAre(-1, -1, -1, 1, 4));
  EXPECT_THAT(findings("blocks: {y: {type: tapped_delay, in: 1, taps: 0, rate: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("whole number from 1"));
}

TEST(MovingAverage, TakesAVectorElementByElement) {
  const Signals r = run(sampled(R"(
  y: {type: moving_average, in: [u, 10 - u], samples: 3, initial: [1, 9], rate: 1}
  one: {type: moving_average, in: u, samples: 3, initial: 1, rate: 1}
)"));
  EXPECT_THAT(r.samples("y.1"), ElementsAre(1, 2, DoubleNear(7.0 / 3, 1e-15), DoubleNear(14.0 / 3, 1e-15), 5));
  EXPECT_EQ(r.samples("y.1"), r.samples("one"));
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(r.samples("y.2")[k], 10 - r.samples("y.1")[k], 1e-14);
}

TEST(SampleDelay, ShowsWhatWasSoManySamplesBefore) {
  const Signals r = run(sampled(R"(
  y: {type: sample_delay, in: [u, -u], samples: 2, initial: 7, rate: 1}
  one: {type: sample_delay, in: u, rate: 1}
  same: {type: unit_delay, in: u, rate: 1}
  long: {type: sample_delay, in: u, samples: 100000, initial: -1, rate: 1}
)"));
  EXPECT_THAT(r.samples("y.1"), ElementsAre(7, 7, 1, 4, 2));
  EXPECT_THAT(r.samples("y.2"), ElementsAre(7, 7, -1, -4, -2));
  EXPECT_EQ(r.samples("one"), r.samples("same"));
  EXPECT_EQ(r.last("long"), -1);
}

TEST(SampleDelay, MayStandInALoop) {
  // y[k] = y[k-3] + 1 from 0: 0 0 0 1 1 1 2 ...
  const Signals r =
      run("blocks: {y: {type: sample_delay, in: y + 1, samples: 3, rate: 0.1}}\nsimulation: {stop: 0.7}\n");
  EXPECT_THAT(r.samples("y"), ElementsAre(0, 0, 0, 1, 1, 1, 2, 2));
}

TEST(MovingAverage, AveragesThePresentSampleToo) {
  const Signals r = run(sampled("  y: {type: moving_average, in: u, samples: 2, rate: 1}\n"));
  EXPECT_THAT(r.samples("y"), ElementsAre(1, 2.5, 3, 5, 6.5));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
