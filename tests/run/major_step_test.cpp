// S7 and S8: what happens at a hit, and in which order.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;

TEST(S8MajorStep, AUnitDelayShowsThePreviousSampleAtEachHit) {
  const Signals r = run(R"(
blocks:
  t: {type: clock}
  d: {type: unit_delay, in: t, rate: 0.5, initial: -1}
simulation: {stop: 2}
record: [d]
)");
  EXPECT_THAT(r.samples("d"), ElementsAre(-1, 0, 0.5, 1, 1.5));
}

TEST(S8MajorStep, StatesAreSwappedAtOnceSoThatTwoDelaysExchangeTheirValues) {
  for (const auto& [first, second] : {std::pair{"a", "b"}, {"b", "a"}}) {
    const Signals r = run(std::string("blocks:\n") + "  " + first + ": {type: unit_delay, in: " + second +
                          ", rate: 1, initial: 1}\n" + "  " + second + ": {type: unit_delay, in: " + first +
                          ", rate: 1, initial: 2}\nsimulation: {stop: 4}\nrecord: [" + first + ", " + second + "]\n");
    EXPECT_THAT(r.samples(first), ElementsAre(1, 2, 1, 2, 1));
    EXPECT_THAT(r.samples(second), ElementsAre(2, 1, 2, 1, 2));
  }
}

TEST(S8MajorStep, AHeldSampleFeedsTheContinuousPartUntilTheNextHit) {
  // x' = -k sampled(x): x[k+1] = x[k] (1 - k T), straight in between.
  const Signals r = run(R"(
blocks:
  z: {type: zero_order_hold, in: x, rate: 0.1}
  x: {type: integrator, in: -2*z, initial: 1}
simulation: {stop: 1, rtol: 1e-10, atol: 1e-12}
record: [x, z]
)");
  double x = 1;
  for (int k = 0; k <= 10; ++k, x *= 0.8) {
    EXPECT_NEAR(r.at("x", k / 10.0), x, 1e-13);
    EXPECT_EQ(r.at("z", k / 10.0), r.at("x", k / 10.0));
  }
  EXPECT_NEAR(r.at("x", 0.05), 0.9, 1e-13);
}

TEST(S8MajorStep, ReadsAcrossRatesSampleAndHold) {
  // fast counts tenths; slow adds up what it sees at 0.3 s; the fast one reads the held sum.
  const Signals r = run(R"(
blocks:
  fast: {type: discrete_integrator, in: 10, rate: 0.1}
  slow: {type: unit_delay, in: fast, rate: 0.3}
  back: {type: zero_order_hold, in: slow, rate: 0.1}
simulation: {stop: 1}
record: [fast, slow, back]
)");
  const auto slow = r.samples("slow");
  ASSERT_EQ(slow.size(), 4u);
  EXPECT_EQ(slow[0], 0);
  EXPECT_EQ(slow[1], 0);
  EXPECT_NEAR(slow[2], 3, 1e-12);
  EXPECT_NEAR(slow[3], 6, 1e-12);
  const auto back = r.samples("back");
  ASSERT_EQ(back.size(), 11u);
  for (std::size_t k = 0; k < back.size(); ++k) EXPECT_EQ(back[k], slow[k / 3]) << k;
}

TEST(S8MajorStep, AnOffsetDelaysTheHitsAndTheInitialValueHoldsUntilThen) {
  const Signals r = run(R"(
blocks:
  t: {type: clock}
  d: {type: unit_delay, in: t, rate: {period: 0.1, offset: 0.04}, initial: 7}
simulation: {stop: 0.4}
record: [d]
)");
  EXPECT_EQ(r.at("d", 0), 7);
  EXPECT_THAT(r.samples("d"), ElementsAre(7, 0.04, 0.14, 0.24));
}

TEST(S8MajorStep, MinorStepsAreNotRecorded) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: -x, initial: 1}
simulation: {stop: 1, solver: rk4, step: 0.1}
record: [x]
)");
  const auto& time = r.recording().time();
  EXPECT_EQ(time.size(), static_cast<std::size_t>(r.whole().statistics.rows));
  for (std::size_t i = 1; i < time.size(); ++i) EXPECT_GT(time[i], time[i - 1]);
  EXPECT_EQ(r.whole().statistics.solver.evaluations, 40);
}

TEST(S8MajorStep, HitsThatChangeNothingDoNotRestartTheSolver) {
  // The sampled part reads, but does not feed, the continuous one; and then one that feeds a constant.
  const Signals read = run(R"(
blocks:
  x: {type: integrator, in: -x, initial: 1}
  z: {type: zero_order_hold, in: x, rate: 0.01}
simulation: {stop: 1}
record: [x, z]
)");
  EXPECT_EQ(read.whole().statistics.solver.cold_restarts, 0);
  EXPECT_GE(read.whole().statistics.solver.hot_restarts, 99);
  const Signals fed = run(R"(
blocks:
  x: {type: integrator, in: -x + z, initial: 1}
  z: {type: zero_order_hold, in: time, rate: 0.01}
simulation: {stop: 1}
record: [x, z]
)");
  EXPECT_GE(fed.whole().statistics.solver.cold_restarts, 99);
}

TEST(S6Rates, AreKeptApartUpToSixtyOneAndThenRefused) {
  const auto diagram = [](int rates) {
    std::string blocks = "blocks:\n  t: {type: clock}\n";
    for (int i = 1; i <= rates; ++i) {
      blocks +=
          "  d" + std::to_string(i) + ": {type: unit_delay, in: t, rate: " + std::to_string(i) + "/100, initial: -1}\n";
    }
    return blocks + "simulation: {stop: 5}\n";
  };
  const Signals r = run(diagram(61));
  for (int i = 1; i <= 61; ++i) {
    const auto samples = r.samples("d" + std::to_string(i));
    ASSERT_EQ(samples.size(), static_cast<std::size_t>(500 / i + 1)) << i;
    for (std::size_t k = 1; k < samples.size(); ++k)
      EXPECT_EQ(samples[k], static_cast<double>(k - 1) * i / 100) << "rate " << i << ", hit " << k;
  }
  EXPECT_NE(findings(diagram(62)).find("62 different rates"), std::string::npos);
}

TEST(S5Order, TheOrderOfTheBlocksInTheFileChangesNoByteOfTheResult) {
  const std::vector<std::string> blocks{
      "  u: {type: square, amplitude: 1, period: 0.7}\n",
      "  x: {type: integrator, in: v, initial: 0.3}\n",
      "  v: {type: integrator, in: force - 0.3*v - sin(x), lower: -2, upper: 2}\n",
      "  force: {type: saturation, in: command, lower: -1, upper: 1.5}\n",
      "  command: 3*(u - z) - 0.5*d\n",
      "  z: {type: zero_order_hold, in: x, rate: 0.05}\n",
      "  d: {type: unit_delay, in: z, rate: 0.1}\n",
      "  r: {type: random_levels, rate: 0.25}\n",
      "  lag: {type: first_order, in: abs(x) + r, tau: 0.2}\n",
  };
  const auto csv = [](const std::vector<std::string>& order, const std::string& solver) {
    std::string text = "blocks:\n";
    for (const auto& block : order) text += block;
    const Signals r = run(text + "simulation: {stop: 5, " + solver + "}\nrecord: [x, v, force, z, d, r, lag]\n");
    return to_csv(r.recording());
  };
  for (const char* solver : {"rtol: 1e-7", "solver: rk4, step: 0.01", "solver: bdf"}) {
    std::vector<std::string> order = blocks;
    const std::string reference = csv(order, solver);
    std::reverse(order.begin(), order.end());
    EXPECT_EQ(csv(order, solver), reference) << solver;
    for (int i = 0; i < 5; ++i) {
      std::rotate(order.begin(), order.begin() + 2, order.end());
      std::swap(order[0], order[5]);
      EXPECT_EQ(csv(order, solver), reference) << solver;
    }
  }
}

}  // namespace
}  // namespace plantloop::testing_diagrams
