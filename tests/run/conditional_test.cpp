// Conditional subsystems (S12): enabled, triggered, both; held and reset; against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;

constexpr double pi = 3.14159265358979323846;

TEST(S12Enabled, ContinuousStatesStandStillWhileDisabled) {
  // Enabled while sin > 1/2: for 2 pi/3 in each turn.
  const Signals r = run(R"(
blocks:
  x: {type: integrator, in: 1, enable: sin(time) > 0.5}
  y: {type: integrator, in: 2*x, enable: sin(time) - 0.5}
simulation: {stop: 10, rtol: 1e-10, atol: 1e-12}
expect: [{signal: x, at: 4, value: 0}, {signal: x, at: 7, value: 0}, {signal: y, at: 4, value: 0}]
)");
  const double turn = 2 * pi / 3;
  EXPECT_NEAR(r.sampled("x", 4), turn, 1e-10);
  EXPECT_NEAR(r.sampled("x", 7), turn + 7 - (2 * pi + pi / 6), 1e-10);
  EXPECT_NEAR(r.sampled("y", 4), turn * turn, 1e-9);  // a bare condition holds above 0
  EXPECT_EQ(r.recording().events.at("x.enable").size(), 2U);
}

TEST(S12Enabled, OutputsAreInitialBeforeTheFirstActivationThenHeldOrReset) {
  const std::string text = R"(
blocks:
  on: where(time < 1, 0, where(time < 2, 1, where(time < 3, 0, 1)))
  s: {type: sub, in: {u: time}, enable: {when: on, HOW}}
types:
  sub:
    inputs: [u]
    blocks: {x: {type: integrator, in: 1, initial: 10}, y: x + 100*u}
    outputs: {y: {from: y, initial: 7}, x: {from: x, initial: -1}}
simulation: {stop: 4, rtol: 1e-10, atol: 1e-12}
record: [s.y, s.x, s.u]
expect:
  - {signal: s.y, at: 0.5, value: 0}
  - {signal: s.y, at: 1.5, value: 0}
  - {signal: s.y, at: 2.5, value: 0}
  - {signal: s.y, at: 3.5, value: 0}
)";
  const auto with = [&](const std::string& how) {
    std::string t = text;
    return run(t.replace(t.find("HOW"), 3, how));
  };
  const Signals held = with("states: held, outputs: held");
  EXPECT_EQ(held.sampled("s.y", 0.5), 7);
  EXPECT_EQ(held.sampled("s.x", 0.5), -1);
  EXPECT_NEAR(held.sampled("s.y", 1.5), 10.5 + 150, 1e-9);
  EXPECT_NEAR(held.sampled("s.y", 2.5), 11 + 200, 1e-7);  // the value at the instant at which it was disabled
  EXPECT_NEAR(held.sampled("s.u", 2.5), 2, 1e-9);         // what is inside stands still as well
  EXPECT_NEAR(held.sampled("s.y", 3.5), 11.5 + 350, 1e-9);
  const Signals reset = with("states: reset, outputs: reset");
  EXPECT_EQ(reset.sampled("s.y", 2.5), 7);
  EXPECT_EQ(reset.sampled("s.x", 2.5), -1);
  EXPECT_NEAR(reset.sampled("s.y", 3.5), 10.5 + 350, 1e-9);
}

TEST(S12Enabled, AnOutputKeepsTheValueOfTheOnlyInstantAtWhichItWasActive) {
  // sin is zero at the start and then positive: active at the start instant alone.
  const Signals r = run(R"(
blocks:
  u: sin(time)
  lo: {expr: 2 + u, enable: {when: u <= 0, initial: 0}}
  seven: {expr: 7, enable: {when: time <= 0, initial: 0}}
  high: {expr: 3 + u, enable: {when: u > 0, initial: 3}}
  y: {type: merge, in: [lo, high]}
simulation: {stop: 3}
record: [lo, seven, y]
)");
  EXPECT_EQ(r.at("lo", 0), 2);
  EXPECT_NEAR(r.last("lo"), 2, 1e-12);
  EXPECT_EQ(r.last("seven"), 7);
  for (const double lo : r.column("lo")) ASSERT_NEAR(lo, 2, 1e-11);
  for (const double y : r.column("y")) ASSERT_GE(y, 2);
}

TEST(S12Enabled, HitsAreSkippedWhileDisabledAndNotQueued) {
  // Counts the hits of a rate of 0.25 s that fall into [0.6, 1.6) and [2.1, 4]: 0.75 1 1.25 1.5 | 2.25 ... 4.
  const Signals r = run(R"(
blocks:
  on: {type: staircase, times: [0, 0.6, 1.6, 2.1], values: [0, 1, 0, 1]}
  c: {type: tally, rate: 0.25, enable: on}
  z: {type: tally, rate: 0.25, enable: {when: on, states: reset}}
types:
  tally: {blocks: {n: {type: unit_delay, in: n + 1}, y: n + 1}, outputs: {y: {from: y, initial: 0}}}
simulation: {stop: 4}
)");
  EXPECT_EQ(r.at("c.y", 0.5), 0);
  EXPECT_EQ(r.at("c.y", 1.5), 4);
  EXPECT_EQ(r.at("c.y", 2), 4);
  EXPECT_EQ(r.at("c.y", 2.2), 4);  // enabled between two hits: nothing has run yet
  EXPECT_EQ(r.at("c.y", 2.25), 5);
  EXPECT_EQ(r.at("c.y", 4), 4 + 8);
  EXPECT_EQ(r.at("z.y", 4), 8);
}

TEST(S12Enabled, TheConditionMayStartTheRunOrBeAConstant) {
  const Signals r = run(R"(
parameters: {p: 1, q: 0}
blocks:
  a: {type: integrator, in: 1, enable: p}
  b: {type: integrator, in: 1, enable: q, initial: 3}
  c: {type: integrator, in: 1, enable: time < 0.5}
  d: {expr: time, enable: {when: 1, initial: 5}}
simulation: {stop: 1}
)");
  EXPECT_NEAR(r.last("a"), 1, 1e-9);
  EXPECT_EQ(r.last("b"), 3);
  EXPECT_NEAR(r.last("c"), 0.5, 1e-9);
  EXPECT_EQ(r.at("d", 0), 0);
  EXPECT_EQ(r.last("d"), 1);
}

TEST(S12Enabled, OneInsideAnotherRunsWhenBothAreEnabled) {
  // Outer [1, 4), inner [0, 2) and [3, 5): both on [1, 2) and [3, 4).
  const Signals r = run(R"(
blocks:
  outer: {type: outer, enable: {when: time >= 1 and time < 4}}
types:
  outer:
    blocks: {inner: {type: inner, enable: {when: time < 2 or time >= 3, states: reset}}, x: {type: integrator, in: 1}}
    outputs: {y: {from: inner.x, initial: -1}, x: {from: x, initial: 0}}
  inner: {blocks: {x: {type: integrator, in: 1}}, outputs: {x: {from: x, initial: -2}}}
simulation: {stop: 5, rtol: 1e-10, atol: 1e-12}
expect: [{signal: outer.y, at: 1.5, value: 0}, {signal: outer.y, at: 2.5, value: 0}, {signal: outer.y, at: 3.5, value: 0}]
)");
  EXPECT_EQ(r.at("outer.y", 0.5), -1);
  EXPECT_NEAR(r.sampled("outer.y", 1.5), 0.5, 1e-9);
  EXPECT_NEAR(r.sampled("outer.y", 2.5), 1, 1e-9);
  EXPECT_NEAR(r.sampled("outer.y", 3.5), 0.5, 1e-9);  // reset when enabled again
  EXPECT_NEAR(r.last("outer.y"), 1, 1e-9);
  EXPECT_NEAR(r.last("outer.x"), 3, 1e-9);
}

TEST(S12Enabled, WhatADisabledBlockWouldComputeIsNotLookedAt) {
  const Signals r = run(R"(
blocks:
  level: 1 - time
  flow: {expr: sqrt(level), enable: {when: level > 0, initial: 0}}
  sunk: {type: integrator, in: sqrt(level), enable: level > 0}
simulation: {stop: 3, rtol: 1e-8, atol: 1e-10}
)");
  EXPECT_NEAR(r.last("flow"), 0, 1e-5);
  EXPECT_NEAR(r.last("sunk"), 2.0 / 3, 1e-6);
}

TEST(S12Enabled, EventsInsideDoNotHappenWhileDisabled) {
  // The condition of the reset crosses at 0.5 (disabled), 1.5 and 2.5 (enabled from 1).
  const Signals r = run(R"(
blocks:
  s: {type: s, in: time, enable: time >= 1}
types:
  s:
    inputs: [u]
    blocks: {x: {type: integrator, in: 1, reset: {when: "sin(2*pi*(u - 0.5)) > 0", to: 0}}}
    outputs: {x: {from: x, initial: 0}}
simulation: {stop: 3, rtol: 1e-10, atol: 1e-12}
)");
  EXPECT_THAT(r.recording().events.at("s.x.reset").size(), 2U);
  EXPECT_NEAR(r.last("s.x"), 0.5, 1e-9);
}

TEST(S12Triggered, RunsOncePerEdgeWithTheTimeElapsedAndHoldsItsOutputs) {
  // sin(2 pi t) rises through 0.5 at 1/12 + k and falls at 5/12 + k.
  const std::string text = R"(
blocks:
  s: {type: s, in: time, trigger: {when: "sin(2*pi*time) > 0.5", edge: EDGE}}
types:
  s:
    inputs: [u]
    blocks: {n: {type: unit_delay, in: n + 1, initial: 1}, y: u, dt: elapsed}
    outputs: {y: {from: y, initial: -5}, n: {from: n, initial: 0}, dt: {from: dt, initial: 0}}
simulation: {stop: 3, rtol: 1e-10, atol: 1e-12}
)";
  const auto with = [&](const std::string& edge) {
    std::string t = text;
    return run(t.replace(t.find("EDGE"), 4, edge));
  };
  const Signals rising = with("rising");
  EXPECT_EQ(rising.at("s.y", 0.05), -5);
  EXPECT_EQ(rising.at("s.n", 0.05), 0);
  EXPECT_NEAR(rising.at("s.y", 0.9), 1.0 / 12, 1e-10);
  EXPECT_NEAR(rising.at("s.dt", 0.9), 1.0 / 12, 1e-10);  // the first one counts from the start
  EXPECT_NEAR(rising.at("s.y", 1.9), 13.0 / 12, 1e-10);
  EXPECT_NEAR(rising.at("s.dt", 1.9), 1, 1e-10);
  EXPECT_EQ(rising.last("s.n"), 3);
  EXPECT_EQ(with("falling").last("s.n"), 3);
  EXPECT_NEAR(with("falling").last("s.y"), 2 + 5.0 / 12, 1e-10);
  EXPECT_EQ(with("either").last("s.n"), 6);
}

TEST(S12Triggered, AnEdgeAtAHitTriggersThereAndChainsOfTriggersRunAtOneInstant) {
  const Signals r = run(R"(
blocks:
  tick: {expr: 'mod(k, 2)', rate: 0.5}
  k: {type: unit_delay, in: k + 1, rate: 0.5}
  a: {type: count, trigger: {when: tick > 0.5}}
  b: {type: count, trigger: {when: 'mod(a, 2) > 0.5'}}
types:
  count: {blocks: {n: {type: unit_delay, in: n + 1}, y: n + 1}, outputs: {y: {from: y, initial: 0}}}
simulation: {stop: 4}
)");
  // k = 1, 3, 5, 7 at 0.5, 1.5, 2.5, 3.5; a = 1, 2, 3, 4 there; b at the first and third.
  EXPECT_EQ(r.at("a.y", 0.4), 0);
  EXPECT_EQ(r.at("a.y", 0.5), 1);
  EXPECT_EQ(r.at("b.y", 0.5), 1);
  EXPECT_EQ(r.at("b.y", 2.4), 1);
  EXPECT_EQ(r.at("b.y", 2.5), 2);
  EXPECT_EQ(r.last("a.y"), 4);
  EXPECT_EQ(r.recording().events.at("a.trigger"), (std::vector<double>{0.5, 1.5, 2.5, 3.5}));
}

TEST(S12Triggered, AnIntegratorInsideAdvancesByTheTimeElapsed) {
  // Backward Euler over the times between triggers: x gains u elapsed at each trigger.
  const Signals r = run(R"(
blocks:
  s: {type: s, in: 2, trigger: {when: "sin(2*pi*time) > 0.5"}}
types:
  s:
    inputs: [u]
    blocks: {x: {type: discrete_integrator, in: u, method: backward}}
    outputs: {x: {from: x, initial: 0}}
simulation: {stop: 3, rtol: 1e-10, atol: 1e-12}
)");
  EXPECT_NEAR(r.last("s.x"), 2 * (2 + 1.0 / 12), 1e-9);
}

TEST(S12EnabledAndTriggered, ATriggerCountsOnlyWhileEnabled) {
  // Triggers at 1/12 + k for k = 0 to 4; enabled from 1 to 3, so k = 1 and 2 count.
  const Signals r = run(R"(
blocks:
  s: {type: s, trigger: {when: "sin(2*pi*time) > 0.5"}, enable: {when: time >= 1 and time < 3}}
types:
  s: {blocks: {n: {type: unit_delay, in: n + 1}, y: n + 1}, outputs: {y: {from: y, initial: -1}}}
simulation: {stop: 5, rtol: 1e-10, atol: 1e-12}
)");
  EXPECT_EQ(r.at("s.y", 1.05), -1);
  EXPECT_EQ(r.at("s.y", 1.5), 1);
  EXPECT_EQ(r.last("s.y"), 2);
  EXPECT_EQ(r.recording().events.at("s.trigger").size(), 2U);
}

TEST(S12EnabledAndTriggered, BothAtOneInstantRunIt) {
  const Signals r = run(R"(
blocks:
  u: time - 0.7003
  s: {type: s, in: u, enable: u > 0, trigger: {when: u > 0}}
types:
  s: {inputs: [u], blocks: {n: {type: unit_delay, in: n + 1}, y: n + 1}, outputs: {y: {from: y, initial: 0}}}
simulation: {stop: 2}
)");
  EXPECT_EQ(r.last("s.y"), 1);
}

TEST(S12EnabledAndTriggered, BothRunItAlsoWhereAStepEndsExactlyThere) {
  // At the end of a step at 1 both functions are exactly zero. Without states, with a fixed step, and at a source's
  // edge.
  for (const char* rest :
       {"simulation: {stop: 2, max_step: 0.5}\n",
        "  x: {type: integrator, in: 1}\nsimulation: {stop: 2, solver: rk4, step: 0.25}\n",
        "  x: {type: integrator, in: edge}\n  edge: {type: step, time: 1}\nsimulation: {stop: 2}\n"}) {
    for (const char* when : {"time - 1", "time > 1", "time >= 1"}) {
      const std::string text = std::string("blocks:\n  n: {type: unit_delay, in: n + 1, initial: 1, enable: {when: ") +
                               when + ", initial: 0}, trigger: {when: " + when + "}}\n" + rest;
      const Signals r = run(text);
      EXPECT_EQ(r.at("n", 1.001), 1) << text;
      EXPECT_EQ(r.last("n"), 1) << text;
      EXPECT_THAT(r.recording().events.at("n.trigger"), ::testing::ElementsAre(::testing::DoubleNear(1, 1e-12)))
          << text;
    }
  }
}

TEST(S12Triggered, ABareNumberTriggersWhereItBecomesPositive) {
  const Signals r = run(R"(
blocks:
  n: {type: unit_delay, in: n + 1, trigger: {when: sin(time)}}
  flag: {type: staircase, times: [0, 1, 2, 3], values: [0, 1, 0, 1]}
  m: {type: unit_delay, in: m + 1, trigger: {when: flag}}
  h: {type: integrator, in: 1, reset: {when: h - 2, to: 0}}
simulation: {stop: 10}
record: [n, m, h]
)");
  // At the start sin(time) is zero and rises: it becomes positive there.
  const std::vector<double>& n = r.recording().events.at("n.trigger");
  ASSERT_EQ(n.size(), 2u);
  EXPECT_NEAR(n[0], 0, 1e-11);
  EXPECT_NEAR(n[1], 2 * pi, 1e-11);
  EXPECT_THAT(r.recording().events.at("m.trigger"), ::testing::ElementsAre(1, 3));
  const std::vector<double>& h = r.recording().events.at("h.reset");
  ASSERT_EQ(h.size(), 4u);
  EXPECT_NEAR(h[3], 8, 1e-11);
}

TEST(S12Triggered, AStrictComparisonDoesNotHoldOnItsBorder) {
  const Signals r = run(R"(
blocks:
  u: {type: staircase, times: [0, 1, 2, 3], values: [-1, 0, 1, 0]}
  n: {type: unit_delay, in: n + 1, trigger: {when: u > 0}}
  m: {type: unit_delay, in: m + 1, trigger: {when: u >= 0}}
  k: {type: unit_delay, in: k + 1, trigger: {when: u > 0, edge: falling}}
simulation: {stop: 4}
)");
  EXPECT_THAT(r.recording().events.at("n.trigger"), ::testing::ElementsAre(2));
  EXPECT_THAT(r.recording().events.at("m.trigger"), ::testing::ElementsAre(1));
  EXPECT_THAT(r.recording().events.at("k.trigger"), ::testing::ElementsAre(3));
}

TEST(S12Conditional, ShufflingTheBlocksChangesNoByte) {
  const std::string types = R"(
types:
  s:
    inputs: [u]
    blocks: {x: {type: integrator, in: u - x}, n: {type: unit_delay, in: n + u, rate: 0.1}}
    outputs: {x: {from: x, initial: 0}, n: {from: n, initial: 0}}
  t: {inputs: [u], blocks: {y: u + elapsed}, outputs: {y: {from: y, initial: 0}}}
simulation: {stop: 5}
record: [a.x, a.n, b, c]
)";
  const std::string a = "  a: {type: s, in: sin(3*time), enable: {when: c < 2, states: reset}}\n";
  const std::string b = "  b: {type: t, in: a.x, trigger: {when: \"sin(7*time) > 0.2\", edge: either}}\n";
  const std::string c = "  c: {type: integrator, in: 1 + b, reset: {when: c > 4, to: 0}}\n";
  const Signals one = run("blocks:\n" + a + b + c + types);
  const Signals two = run("blocks:\n" + c + b + a + types);
  EXPECT_EQ(to_csv(one.recording()), to_csv(two.recording()));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
