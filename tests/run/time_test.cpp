// S1: time is counted, never accumulated.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;

// The times of the rows at which a column had its hits.
std::vector<double> hit_times(const Signals& r, const std::string& column) {
  const Recording& recording = r.recording();
  const auto index = static_cast<std::size_t>(recording.find(column));
  std::vector<double> times;
  for (const std::size_t row : recording.hits[static_cast<std::size_t>(recording.columns[index].rate)])
    times.push_back(recording.time()[row]);
  return times;
}

TEST(S1Time, AMillionHitsOfATenthOfASecondStandAtTheCorrectlyRoundedTenths) {
  const Signals r = run(R"(
blocks:
  n: {type: discrete_integrator, in: 10, rate: 0.1}
simulation: {stop: 100000}
record: [n]
)");
  const std::vector<double> times = hit_times(r, "n");
  ASSERT_EQ(times.size(), 1'000'001u);
  for (std::size_t k = 0; k < times.size(); ++k) ASSERT_EQ(times[k], static_cast<double>(k) / 10);
  EXPECT_EQ(r.whole().statistics.rows, 1'000'001);
  EXPECT_NEAR(r.last("n"), 1e6, 1e-3);  // a million roundings of a sum of 1e6
}

TEST(S1Time, HitsOfDifferentRatesAtOneTickAreSimultaneous) {
  // 0.1 * 3 is not 0.3 in doubles; the ticks are.
  const Signals r = run(R"(
blocks:
  a: {type: discrete_integrator, in: 1, rate: 0.1}
  b: {type: discrete_integrator, in: 1, rate: 0.3}
  c: {type: discrete_integrator, in: 1, rate: {period: 0.2, offset: 0.1}}
simulation: {stop: 3}
record: [a, b, c]
)");
  EXPECT_EQ(r.recording().rows(), 31u);
  EXPECT_THAT(hit_times(r, "b"), ElementsAre(0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.8, 2.1, 2.4, 2.7, 3));
  EXPECT_THAT(hit_times(r, "c"),
              ElementsAre(0.1, 0.3, 0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 1.7, 1.9, 2.1, 2.3, 2.5, 2.7, 2.9));
}

TEST(S1Time, TheStopTimeIsIncludedWhetherOrNotItIsAHit) {
  for (const auto& [stop, rows] : {std::pair{"0.3", 4u}, {"0.35", 5u}}) {
    const Signals r =
        run(std::string("blocks:\n  n: {type: discrete_integrator, in: 1, rate: 0.1}\nsimulation: {stop: ") + stop +
            "}\nrecord: [n]\n");
    EXPECT_EQ(r.recording().time().back(), std::stod(stop));
    EXPECT_EQ(r.recording().rows(), rows);
  }
}

TEST(S1Time, ARationalPeriodHasRoundedHits) {
  const Signals r = run(R"(
blocks:
  n: {type: discrete_integrator, in: 1, rate: 1/3}
simulation: {stop: 100}
record: [n]
)");
  const std::vector<double> times = hit_times(r, "n");
  ASSERT_EQ(times.size(), 301u);
  for (std::size_t k = 0; k < times.size(); ++k) EXPECT_EQ(times[k], static_cast<double>(k) / 3);
}

TEST(S1Time, ARunFromALaterStartHitsTheSameInstants) {
  const Signals r = run(R"(
blocks:
  n: {type: discrete_integrator, in: 1, rate: 0.1}
simulation: {start: 0.25, stop: 0.6}
record: [n]
)");
  EXPECT_THAT(hit_times(r, "n"), ElementsAre(0.3, 0.4, 0.5, 0.6));
}

TEST(S1Time, ARunFromBeforeTimeZeroHasHitsAllAlong) {
  const Signals r = run(R"(
blocks:
  t: {type: clock}
  z: {type: zero_order_hold, in: t, rate: 0.25}
  levels: {type: random_levels, rate: 0.25}
simulation: {start: -1, stop: 0.5}
record: [z, levels]
)");
  EXPECT_THAT(r.samples("z"), ElementsAre(-1, -0.75, -0.5, -0.25, 0, 0.25, 0.5));
}

TEST(S1Time, ASourceTimeEqualToAHitIsSimultaneousWithIt) {
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 0.3}
  z: {type: zero_order_hold, in: u, rate: 0.1}
simulation: {stop: 0.5}
record: [z]
)");
  EXPECT_THAT(r.samples("z"), ElementsAre(0, 0, 0, 1, 1, 1));
}

TEST(S1Time, TheOutputGridHasTheTimesThatOneWouldWrite) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: 1}
simulation: {stop: 0.7, output_interval: 0.1}
record: [x]
)");
  EXPECT_THAT(r.recording().time(), ElementsAre(0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7));
}

TEST(S1Time, RatesNeedNoCommonTick) {
  // Their greatest common divisor is 1e-13 s: 2^53 of such ticks are 900 s.
  const Signals r = run(R"(
blocks:
  a: {type: discrete_integrator, in: 1, rate: 0.1}
  b: {type: discrete_integrator, in: 1, rate: 0.1000000000001}
simulation: {stop: 2000}
record: [a, b]
)");
  const std::vector<double> a = hit_times(r, "a"), b = hit_times(r, "b");
  ASSERT_EQ(a.size(), 20001u);
  ASSERT_EQ(b.size(), 20000u);
  EXPECT_EQ(a[19999], 1999.9);
  EXPECT_EQ(b[19999], 1999.9000000019999);
}

TEST(S1Time, PeriodsThatCannotBeCountedAreRefused) {
  EXPECT_THROW(run(R"(
blocks:
  n: {type: discrete_integrator, in: 1, rate: 1e-15}
simulation: {stop: 100}
)"),
               std::exception);
  EXPECT_THROW(run(R"(
blocks:
  n: {type: pulse, period: 1e-300}
simulation: {start: 1, stop: 100}
)"),
               std::exception);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
