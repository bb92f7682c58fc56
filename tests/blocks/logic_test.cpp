// Conditions with memory, edges and counts: continuous ones at located instants, sampled ones at samples.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const double pi = std::acos(-1);
constexpr double located = 1e-9;  // s

// Samples at 0, 1, 2, ... of what changes there.
std::string sampled(const std::string& blocks) {
  return "blocks:\n  u: {type: staircase, times: [0, 1, 2, 3, 4, 5], values: [0, 1, 1, 0, 2, -1]}\n"
         "  v: {type: staircase, times: [0, 1, 2, 3, 4, 5], values: [0, 0, 1, 0, 0, 1]}\n" +
         blocks + "simulation: {stop: 5}\n";
}

TEST(Relay, SwitchesWhereTheSignalJumpsExactlyToItsLevel) {
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 2, 3], values: [0.5, 1, 0.5, 0]}
  relay: {type: relay, in: u, on: 1, off: 0}
  band: {type: hysteresis, in: u, lower: 0, upper: 1}
simulation: {stop: 4}
)");
  for (const char* name : {"relay", "band"}) {
    EXPECT_EQ(r.at(name, 0.9), 0);
    EXPECT_EQ(r.at(name, 1), 1);
    EXPECT_EQ(r.at(name, 2.5), 1);
    EXPECT_EQ(r.at(name, 3), 0);
  }
}

TEST(Relay, SwitchesWhereTheSignalStopsAtItsLevel) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: 1, upper: 1}
  relay: {type: relay, in: x, on: 1, off: 0}
simulation: {stop: 2}
)");
  EXPECT_EQ(r.at("relay", 0.9), 0);
  EXPECT_EQ(r.last("relay"), 1);
}

TEST(Hysteresis, KeepsItsAnswerInsideTheBand) {
  const Signals r = run(R"(
blocks:
  u: {type: sine}
  y: {type: hysteresis, in: [u, -u], lower: -0.5, upper: 0.5}
  x: {type: integrator, in: y}
  started: {type: hysteresis, in: u, lower: -0.5, upper: 0.5, initial: 1}
simulation: {stop: 2*pi}
)");
  EXPECT_NEAR(r.last("x.1"), pi, located);  // from pi/6 to 7 pi/6
  EXPECT_NEAR(r.last("x.2"), 2 * pi - 7 * pi / 6 + pi / 6 - pi / 6, located);
  EXPECT_EQ(r.at("started", 0.1), 1);
  EXPECT_THAT(findings("blocks: {y: {type: hysteresis, in: 1, lower: 2, upper: 1}}\nsimulation: {stop: 1}\n"),
              HasSubstr("'upper' must not be less than 'lower'"));
}

TEST(SrLatch, FollowsItsTruthTableSampled) {
  const Signals r = run(sampled(R"(
  q: {type: sr_latch, in: {s: u, r: v}, rate: 1}
  wins: {type: sr_latch, in: {s: u, r: v}, both: set, initial: 1, rate: 1}
)"));
  EXPECT_THAT(r.samples("q.q"), ElementsAre(0, 1, 0, 0, 1, 0));
  EXPECT_THAT(r.samples("q.not_q"), ElementsAre(1, 0, 1, 1, 0, 1));
  EXPECT_THAT(r.samples("wins.q"), ElementsAre(1, 1, 1, 1, 1, 0));
}

TEST(SrLatch, ChangesAtLocatedInstants) {
  // Set while sin > 0.5, reset while sin < -0.5: on from pi/6 to 7 pi/6.
  const Signals r = run(R"(
blocks:
  u: {type: sine}
  q: {type: sr_latch, in: {s: u > 0.5, r: u < -0.5}}
  smooth: {type: sr_latch, in: {s: u - 0.5, r: -0.5 - u}}
  both: {type: sr_latch, in: {s: u + 0.5, r: u - 0.5}}
  x: {type: integrator, in: [q, smooth, both]}
simulation: {stop: 2*pi}
)");
  EXPECT_NEAR(r.last("x.1"), pi, located);
  EXPECT_NEAR(r.last("x.2"), pi, located);
  // s from the start, r wins from pi/6 to 5 pi/6, s again at once until it ends at 7 pi/6, and kept: to the end.
  EXPECT_NEAR(r.last("x.3"), pi / 6 + 2 * pi - 5 * pi / 6, located);
}

TEST(SrLatch, RemembersWhatHeldAtTheStart) {
  const Signals r = run(R"(
blocks:
  s: {type: step, time: 1, before: 1, after: 0}
  r: {type: step, time: 2}
  q: {type: sr_latch, in: {s: s, r: r}}
  open: {type: d_latch, in: {d: s, c: 1 - r}, takes: level}
  closed: {type: d_latch, in: {d: 2 - time, c: s}, takes: level}
simulation: {stop: 3}
record: [q, open, closed]
)");
  EXPECT_EQ(r.at("q", 0.5), 1);
  EXPECT_EQ(r.at("q", 1.5), 1);
  EXPECT_EQ(r.last("q"), 0);
  EXPECT_EQ(r.at("open", 0.5), 1);
  EXPECT_EQ(r.at("open", 1.5), 0);
  EXPECT_EQ(r.last("closed"), 1);
}

TEST(DLatch, TakesAnEdgeOrFollowsALevel) {
  const Signals r = run(sampled(R"(
  edge: {type: d_latch, in: {d: u, c: v}, rate: 1}
  level: {type: d_latch, in: {d: u, c: v}, takes: level, rate: 1}
)"));
  EXPECT_THAT(r.samples("edge.q"), ElementsAre(0, 0, 1, 1, 1, 0));
  EXPECT_THAT(r.samples("level.q"), ElementsAre(0, 0, 1, 1, 1, 0));
  const Signals c = run(R"(
blocks:
  u: {type: sine}
  c: {type: pulse, period: 4, width: 2, delay: 1}
  edge: {type: d_latch, in: {d: u, c: c}}
  level: {type: d_latch, in: {d: u, c: c}, takes: level}
simulation: {stop: 8}
record: [edge, level, level.not_q]
)");
  EXPECT_EQ(c.at("edge", 4.9), 1);
  EXPECT_EQ(c.at("edge", 5), 0);  // sin 5 < 0
  EXPECT_EQ(c.at("level", 4.9), 1);
  EXPECT_EQ(c.at("level", 6), 0);
  EXPECT_EQ(c.at("level", 6.9), 1);  // followed beyond 2 pi
  EXPECT_EQ(c.last("level"), 1);
  EXPECT_EQ(c.last("level.not_q"), 0);
}

TEST(EdgeDetector, ShowsEdgesForOneSample) {
  const Signals r = run(sampled(R"(
  rising: {type: edge_detector, in: u, rate: 1}
  falling: {type: edge_detector, in: u, edge: falling, rate: 1}
  either: {type: edge_detector, in: u, edge: either, rate: 1}
  high: {type: edge_detector, in: u + 1, rate: 1}
)"));
  EXPECT_THAT(r.samples("rising"), ElementsAre(0, 1, 0, 0, 1, 0));
  EXPECT_THAT(r.samples("falling"), ElementsAre(0, 0, 0, 1, 0, 1));
  EXPECT_THAT(r.samples("either"), ElementsAre(0, 1, 0, 1, 1, 1));
  EXPECT_THAT(r.samples("high"), ElementsAre(0, 0, 0, 0, 0, 0));  // what holds at the start is no edge
  EXPECT_THAT(findings("blocks: {y: {type: edge_detector, in: time}}\nsimulation: {stop: 1}\n"),
              HasSubstr("needs a rate"));
}

TEST(DetectChange, ComparesWithTheSampleBefore) {
  const Signals r = run(sampled(R"(
  change: {type: detect_change, in: u, rate: 1}
  more: {type: detect_change, in: u, of: increase, initial: -1, rate: 1}
  less: {type: detect_change, in: u, of: decrease, rate: 1}
)"));
  EXPECT_THAT(r.samples("change"), ElementsAre(0, 1, 0, 1, 1, 1));
  EXPECT_THAT(r.samples("more"), ElementsAre(1, 1, 0, 0, 1, 0));
  EXPECT_THAT(r.samples("less"), ElementsAre(0, 0, 0, 1, 0, 1));
}

TEST(Counter, CountsEdges) {
  const Signals r = run(sampled(R"(
  n: {type: counter, in: u, rate: 1}
  either: {type: counter, in: u, edge: either, initial: 5, step: -2, rate: 1}
  around: {type: counter, in: u, edge: either, lower: 1, upper: 2, initial: 1, rate: 1}
)"));
  EXPECT_THAT(r.samples("n"), ElementsAre(0, 1, 1, 1, 2, 2));
  EXPECT_THAT(r.samples("either"), ElementsAre(5, 3, 3, 1, -1, -3));
  EXPECT_THAT(r.samples("around"), ElementsAre(1, 2, 2, 1, 2, 1));
}

TEST(Counter, CountsAtLocatedInstantsAndIsReset) {
  const Signals r = run(R"(
blocks:
  u: {type: sine, frequency: 2*pi}
  n: {type: counter, in: "[u > 0.5, u - 0.5]", reset: {when: time > 2.5}}
  down: {type: counter, in: u, edge: falling}
  clicks: {type: counter, in: click > 0}
  click: {type: pulse, period: 0.1, width: 0.05, delay: 0.1}
  x: {type: integrator, in: n.1}
simulation: {stop: 4}
)");
  EXPECT_EQ(r.at("n.1", 2.4), 3);
  EXPECT_EQ(r.at("n.2", 2.4), 3);
  EXPECT_EQ(r.at("n.1", 2.6), 0);
  EXPECT_EQ(r.last("n.1"), 1);
  EXPECT_EQ(r.last("down"), 4);
  EXPECT_EQ(r.last("clicks"), 40);
  // 1 from 1/12 on, 2 from 13/12, 3 from 25/12 to 2.5, 1 from 37/12.
  EXPECT_NEAR(r.last("x"), 1 + 2 + 3 * (2.5 - 25.0 / 12) + 4 - 37.0 / 12, located);
}

TEST(SampleCounter, CountsSamples) {
  const Signals r = run(R"(
blocks:
  k: {type: sample_counter, lower: 1, rate: 1}
  around: {type: sample_counter, lower: 2, upper: 4, rate: 1}
simulation: {stop: 4}
)");
  EXPECT_THAT(r.samples("k"), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(r.samples("around"), ElementsAre(2, 3, 4, 2, 3));
}

TEST(HitCrossing, LocatesInstants) {
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: cos(time)}
  either: {type: hit_crossing, in: x, level: 0.5}
  down: {type: hit_crossing, in: x, level: 0.5, edge: falling}
  start: {type: hit_crossing, in: x}
simulation: {stop: 6, rtol: 1e-10, atol: 1e-12}
record: [either.count, either.toggle, either.instant, down.count, down.instant, start.count]
)");
  EXPECT_EQ(r.at("either.count", 1), 1);
  EXPECT_EQ(r.at("either.toggle", 1), 1);
  EXPECT_NEAR(r.at("either.instant", 1), pi / 6, located);
  EXPECT_EQ(r.last("either.count"), 2);
  EXPECT_EQ(r.last("either.toggle"), 0);
  EXPECT_EQ(r.last("down.count"), 1);
  EXPECT_NEAR(r.last("down.instant"), 5 * pi / 6, located);
  EXPECT_EQ(r.last("start.count"), 1);  // at pi, not where it starts
}

TEST(HitCrossing, FindsSamplesBeyondTheLevel) {
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 2, 3, 4, 5], values: [-1, 0, 1, 0, 0, 3]}
  y: {type: hit_crossing, in: u, rate: 1}
simulation: {stop: 5}
)");
  EXPECT_THAT(r.samples("y.count"), ElementsAre(0, 1, 1, 2, 2, 2));
  EXPECT_THAT(r.samples("y.instant"), ElementsAre(0, 1, 1, 3, 3, 3));
}

TEST(SampleAndHold, TakesEdgesAndFollowsLevels) {
  const Signals r = run(sampled(R"(
  rising: {type: sample_and_hold, in: {u: time, gate: u}, initial: -1, rate: 1}
  falling: {type: sample_and_hold, in: {u: time, gate: u}, takes: falling, rate: 1}
  either: {type: sample_and_hold, in: {u: time, gate: u}, takes: either, rate: 1}
  level: {type: sample_and_hold, in: {u: time, gate: u}, takes: level, rate: 1}
)"));
  EXPECT_THAT(r.samples("rising"), ElementsAre(-1, 1, 1, 1, 4, 4));
  EXPECT_THAT(r.samples("falling"), ElementsAre(0, 0, 0, 3, 3, 5));
  EXPECT_THAT(r.samples("either"), ElementsAre(0, 1, 1, 3, 4, 5));
  EXPECT_THAT(r.samples("level"), ElementsAre(0, 1, 2, 2, 4, 4));
  const Signals c = run(R"(
blocks:
  gate: {type: sine}
  rising: {type: sample_and_hold, in: {u: time, gate: gate - 0.5}}
  level: {type: sample_and_hold, in: {u: time, gate: gate - 0.5}, takes: level}
simulation: {stop: 8}
)");
  EXPECT_EQ(c.at("rising", 0.5), 0);
  EXPECT_NEAR(c.at("rising", 5), pi / 6, located);
  EXPECT_NEAR(c.last("rising"), 2 * pi + pi / 6, located);
  EXPECT_NEAR(c.at("level", 5), 5 * pi / 6, located);
  EXPECT_NEAR(c.last("level"), 8, located);
}

}  // namespace
}  // namespace plantloop::testing_diagrams
