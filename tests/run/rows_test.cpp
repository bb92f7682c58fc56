// S15: which rows a run writes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;

std::vector<std::size_t> rows_at(const Signals& r, double t) {
  std::vector<std::size_t> rows;
  const auto& time = r.recording().time();
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] == t) rows.push_back(i);
  }
  return rows;
}

TEST(S15Rows, AJumpHasTwoTheLeftOneFirst) {
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 0.5, before: 1, after: 3}
  x: {type: integrator, in: u}
simulation: {stop: 1}
record: [u, x]
)");
  const auto rows = rows_at(r, 0.5);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(r.column("u")[rows[0]], 1);
  EXPECT_EQ(r.column("u")[rows[1]], 3);
  EXPECT_EQ(r.recording().side()[rows[0]], -1);
  EXPECT_EQ(r.recording().side()[rows[1]], 1);
  EXPECT_NEAR(r.last("x"), 0.5 + 1.5, 1e-14);
}

TEST(S15Rows, AnEdgeThatShowsInNoColumnHasOne) {
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 0.5}
  x: {type: integrator, in: u}
simulation: {stop: 1}
record: [x]
)");
  EXPECT_EQ(rows_at(r, 0.5).size(), 1u);
}

TEST(S15Rows, AJumpOfASampledColumnOnlyHasOne) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: 1}
  z: {type: zero_order_hold, in: x, rate: 0.5}
simulation: {stop: 1}
record: [x, z]
)");
  EXPECT_EQ(rows_at(r, 0.5).size(), 1u);
  EXPECT_EQ(r.at("z", 0.5), r.at("x", 0.5));
  EXPECT_EQ(r.at("z", 0.499), 0);
}

TEST(S15Rows, AreNowhereFurtherApartThanAFiveHundredthOfTheRun) {
  for (const char* solver : {"dopri5", "bogacki_shampine", "adams", "bdf"}) {
    const Signals r =
        run(std::string("blocks:\n  x: {type: integrator, in: -x/1000, initial: 1}\n") +
            "  s: {type: step, time: 3.3}\nsimulation: {start: 1, stop: 11, solver: " + solver + "}\nrecord: [x]\n");
    const auto& time = r.recording().time();
    EXPECT_EQ(time.front(), 1);
    EXPECT_EQ(time.back(), 11);
    for (std::size_t i = 1; i < time.size(); ++i) EXPECT_LE(time[i] - time[i - 1], 0.02 * (1 + 1e-9)) << solver;
  }
}

TEST(S15Rows, OfAnOutputGridStandOnItWithTheValueAfterAJump) {
  const Signals r = run(R"(
blocks:
  u: {type: step, time: 0.5}
  z: {type: zero_order_hold, in: x, rate: 0.15}
  x: {type: integrator, in: 1, reset: {when: time > 0.75, to: 0}}
simulation: {stop: 1, output_interval: 0.25}
record: [u, x, z]
)");
  EXPECT_THAT(r.recording().time(), ElementsAre(0, 0.25, 0.5, 0.75, 1));
  EXPECT_THAT(r.column("u"), ElementsAre(0, 0, 1, 1, 1));
  EXPECT_NEAR(r.column("x")[1], 0.25, 1e-14);
  EXPECT_NEAR(r.column("z")[1], 0.15, 1e-14);
  EXPECT_NEAR(r.column("x")[4], 0.25, 1e-10);  // events are located to 1e-12 s
}

TEST(S15Rows, OfAnOutputGridStandOnItInASampledDiagramToo) {
  const Signals r = run(R"(
blocks:
  n: {type: discrete_integrator, in: 10, rate: 0.1}
simulation: {stop: 1, output_interval: 0.25}
record: [n]
)");
  EXPECT_THAT(r.recording().time(), ElementsAre(0, 0.25, 0.5, 0.75, 1));
  EXPECT_NEAR(r.column("n")[1], 2, 1e-12);
  EXPECT_NEAR(r.column("n")[2], 5, 1e-12);
}

TEST(S15Rows, OfASampledDiagramAreItsHitsAndTheStop) {
  const Signals r = run(R"(
blocks:
  n: {type: discrete_integrator, in: 1, rate: 0.5}
  m: {type: discrete_integrator, in: 1, rate: 0.75}
simulation: {stop: 2.1}
record: [n, m]
)");
  EXPECT_THAT(r.recording().time(), ElementsAre(0, 0.5, 0.75, 1, 1.5, 2, 2.1));
}

TEST(S15Rows, OfADiagramWithoutStatesAreFiveHundredParts) {
  const Signals r = run(R"(
blocks:
  y: sin(time)
simulation: {stop: 10}
record: [y]
)");
  ASSERT_EQ(r.recording().rows(), 501u);
  const auto y = r.column("y");
  for (std::size_t k = 0; k <= 500; ++k) {
    EXPECT_EQ(r.recording().time()[k], static_cast<double>(k) / 50);
    EXPECT_EQ(y[k], std::sin(static_cast<double>(k) / 50));
  }
}

TEST(S15Rows, OfADiagramWithoutStatesFollowMaxStep) {
  const Signals r = run(R"(
blocks:
  y: 2*time
simulation: {stop: 0.3, max_step: 0.1}
record: [y]
)");
  EXPECT_THAT(r.recording().time(), ElementsAre(0, 0.1, 0.2, 0.3));
}

TEST(S15Rows, OfALocatedEventShowBothSides) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: 1, reset: {when: x > 0.7, to: 0.2}}
simulation: {stop: 1, rtol: 1e-10, atol: 1e-12}
record: [x]
)");
  const auto& times = r.recording().events.begin()->second;
  ASSERT_EQ(times.size(), 1u);
  EXPECT_NEAR(times[0], 0.7, 2e-12);
  const auto rows = rows_at(r, times[0]);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(r.column("x")[rows[0]], 0.7, 2e-12);
  EXPECT_EQ(r.column("x")[rows[1]], 0.2);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
