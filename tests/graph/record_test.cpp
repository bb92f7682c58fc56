// Graph -> Record: the recorded operations compute what the diagram says; values worked out by hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/graph/helpers.h"

namespace plantloop {
namespace {

TEST(Record, ComputesTheDerivativesOfTheDiagram) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {Q: 29.46, b: 1.21}
blocks:
  force: {type: staircase, times: [0, 1, 7], values: [0, 8, 16]}
  theta: {type: integrator, in: omega, initial: 0.3}
  omega: {type: integrator, in: b*force - Q*omega - Q*sin(theta)}
)");
  const RecordedGraph recorded = record(*graph);
  Evaluated at(recorded, 2.0);
  at.states["omega"] = 0.5;
  EXPECT_DOUBLE_EQ(at.derivative("omega"), 1.21 * 8 - 29.46 * 0.5 - 29.46 * std::sin(0.3));
  EXPECT_EQ(at.derivative("theta"), 0.5);
  Evaluated other(recorded, 0.5);
  other.parameters = {{"Q", 1}, {"theta.initial", 0}};
  other.states["omega"] = 2;
  EXPECT_EQ(other.derivative("omega"), -2);
}

TEST(Record, MakesLiteralNumbersTunableAndKeepsExpressionsLinked) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {k: 2, twice: 2*k, v: [1, -2], mixed: "[k, 5]"}
blocks:
  a: {type: gain, in: 3, k: twice}
  b: {type: gain, in: v, k: mixed}
)");
  const RecordedGraph recorded = record(*graph);
  std::vector<std::string> names;
  for (const RecordedParameter& p : recorded.record.parameters) names.push_back(p.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"k", "mixed.2", "v.1", "v.2"}));
  Evaluated at(recorded);
  at.parameters = {{"k", 10}, {"v.2", 7}, {"mixed.2", 3}};
  EXPECT_EQ(at.signal("a"), 60);
  EXPECT_EQ(at.signal("b.1"), 10);
  EXPECT_EQ(at.signal("b.2"), 21);
}

TEST(Record, DoesNotDependOnTheOrderOfBlocks) {
  const std::string blocks[] = {"  x: {type: integrator, in: y - 2*x}\n",
                                "  y: {type: integrator, in: g + u, initial: 1}\n",
                                "  g: {type: gain, in: x, k: 3}\n",
                                "  u: {type: step}\n",
                                "  d: {type: unit_delay, in: x, rate: 0.1}\n",
                                "  s: {type: sum, in: [d, e]}\n",
                                "  e: {type: unit_delay, in: s, rate: 0.3}\n"};
  std::vector<int> order{0, 1, 2, 3, 4, 5, 6};
  std::string first;
  for (int turn = 0; turn < 50; ++turn) {
    std::string text = "plantloop: 1\nblocks:\n";
    for (const int i : order) text += blocks[i];
    const RecordedGraph recorded = record(*graph_of(text));
    std::string all;
    for (const RecordedNode& n : recorded.record.nodes) {
      all += fmt::format("{} {} {} {} {};", name_of(n.op), n.a, n.b, n.c, n.rate);
    }
    for (const RecordedState& s : recorded.record.states) all += s.name + ";";
    for (const RecordedParameter& p : recorded.record.parameters) all += p.name + ";";
    for (const RecordedSignal& s : recorded.record.signals) all += s.name + ";";
    if (turn == 0) first = all;
    ASSERT_EQ(all, first);
    std::next_permutation(order.begin(), order.end());
    std::swap(order[0], order[static_cast<std::size_t>(turn % 7)]);
  }
}

TEST(Record, StartsStatesFromSignals) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  force: {type: step, time: 0, after: 8}
  filtered: {type: integrator, in: force - filtered, initial: force}
  both: {type: integrator, in: filtered, initial: 2*filtered + 1}
)");
  const RecordedGraph recorded = record(*graph);
  Evaluated at(recorded);
  EXPECT_EQ(at.signal("filtered"), 8);
  EXPECT_EQ(at.signal("both"), 17);
}

TEST(Record, LocatesResetsExactlyWhereComparisonsTurn) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {c: 0.8}
blocks:
  h: {type: integrator, in: v, initial: 1, reset: {when: h <= 0.25, to: 0.25}}
  v: {type: integrator, in: -9.81, reset: {when: h <= 0.25 and v < 0, to: -c*v, edge: either}}
  w: {type: integrator, in: 1, initial: 5, reset: {when: not (w < 7 or h > 9)}}
)");
  const RecordedGraph recorded = record(*graph);
  ASSERT_EQ(recorded.record.jumps.size(), 3U);
  const RecordedJump& h = recorded.record.jumps[0];
  EXPECT_EQ(h.name, "h.reset");
  EXPECT_EQ(h.direction, 1);
  Evaluated at(recorded);
  at.states = {{"h", 0.75}, {"v", -3}, {"w", 6.5}};
  EXPECT_EQ(at.of(h.function), -0.5);  // rises through 0 at h = 0.25
  ASSERT_EQ(h.assignments.size(), 1U);
  EXPECT_EQ(at.of(h.assignments[0].value), 0.25);
  const RecordedJump& v = recorded.record.jumps[1];
  EXPECT_EQ(v.direction, 0);
  EXPECT_EQ(at.of(v.function), -0.5);  // min(0.25 - h, -v)
  EXPECT_DOUBLE_EQ(at.of(v.assignments[0].value), 0.8 * 3);
  const RecordedJump& w = recorded.record.jumps[2];
  EXPECT_EQ(at.of(w.function), -0.5);  // -max(7 - w, h - 9)
  EXPECT_EQ(at.of(w.assignments[0].value), 5);
}

TEST(Record, ResetsEveryStateOfASubsystem) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  u: {type: step}
  plant: {type: plant, in: u, reset: {when: u > 0.5}}
types:
  plant:
    inputs: [u]
    blocks:
      x: {type: integrator, in: u, initial: 3}
      inner: {type: first_order, in: x, initial: 4}
    outputs: {y: inner}
)");
  const RecordedGraph recorded = record(*graph);
  ASSERT_EQ(recorded.record.jumps.size(), 1U);
  EXPECT_EQ(recorded.record.jumps[0].name, "plant.reset");
  ASSERT_EQ(recorded.record.jumps[0].assignments.size(), 2U);
  Evaluated at(recorded);
  EXPECT_EQ(at.of(recorded.record.jumps[0].assignments[0].value), 4);  // plant.inner before plant.x, by path
  EXPECT_EQ(at.of(recorded.record.jumps[0].assignments[1].value), 3);
}

TEST(Record, HoldsWhatSampledBlocksShow) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  x: {type: integrator, in: 1 - s}
  s: {type: zero_order_hold, in: x, rate: 0.5}
)");
  const RecordedGraph recorded = record(*graph);
  for (const RecordedSignal& s : recorded.record.signals) {
    if (s.name != "s") continue;
    const RecordedNode& node = recorded.record.nodes[s.value.id()];
    EXPECT_EQ(node.op, Op::copy);
    EXPECT_EQ(node.rate, 1);
    EXPECT_EQ(s.rate, 1);
  }
}

TEST(Record, ShowsColumnsByTheNamesThatRecordGives) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  u: {type: step}
  plant: {type: plant, in: u}
record: {p: plant.x, both: "[u, plant.x.1]", u: 2*u}
expect:
  - {signal: p, max: 1}
  - {signal: both.2 - u, max: 3}
  - {signal: plant.u, max: 3}
types:
  plant:
    inputs: [u]
    blocks: {x: {type: integrator, in: u - x}}
    outputs: {y: 2*x}
simulation: {stop: 1}
)");
  const RecordedGraph recorded = record(*graph);
  std::vector<std::string> names;
  for (const ShownColumn& c : recorded.columns) names.push_back(c.name);
  ASSERT_GE(names.size(), 4U);
  EXPECT_EQ(names[0], "p");
  EXPECT_EQ(names[1], "both.1");
  EXPECT_EQ(names[2], "both.2");
  EXPECT_EQ(names[3], "u");
  EXPECT_EQ(recorded.find(graph->model->expect[0].signal)->first, 0U);  // the column, not another one
  Evaluated at(recorded, 1.0);
  at.states["plant.x"] = 0.25;
  const auto value = [&](std::size_t expect) {
    return at.of(recorded.columns[recorded.find(graph->model->expect[expect].signal)->first].value);
  };
  EXPECT_EQ(value(0), 0.25);
  EXPECT_EQ(value(2), 1);
}

TEST(Record, FlagsParametersThatTheStructureDependsOn) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {n: 3, T: 0.5, k: 2}
blocks:
  x: {type: integrator, in: n*k - x, initial: zeros(n)}
  d: {type: unit_delay, in: T*k, rate: T}
)");
  const RecordedGraph recorded = record(*graph);
  ASSERT_EQ(recorded.uses.size(), recorded.record.parameters.size());
  for (std::size_t i = 0; i < recorded.uses.size(); ++i) {
    const std::string& name = recorded.record.parameters[i].name;
    EXPECT_EQ(recorded.uses[i] == ParameterUse::structural, name == "n" || name == "T") << name;
  }
}

TEST(Record, ListsBoundsOfNumbersThatMayChange) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {tau: 2}
blocks:
  u: {type: step}
  x: {type: first_order, in: u, tau: tau/2}
)");
  const RecordedGraph recorded = record(*graph);
  ASSERT_EQ(recorded.bounds.size(), 1U);
  EXPECT_EQ(recorded.bounds[0].name, "x.tau");
  EXPECT_EQ(recorded.bounds[0].min, 1e-9);
  Evaluated at(recorded);
  at.parameters["tau"] = -4;
  EXPECT_EQ(at.of(recorded.bounds[0].value), -2);
}

TEST(Record, NamesEveryInputAndOutput) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  u: {type: step, unit: V}
  plant: {type: plant, in: u}
  c: {type: gain, in: plant}
types:
  plant:
    inputs: {u: {unit: V}, d: {default: 2}}
    blocks: {x: {type: integrator, in: "[u, d]"}}
    outputs: {y: x.1, both: x}
)");
  const RecordedGraph recorded = record(*graph);
  std::vector<std::string> names;
  for (const RecordedSignal& s : recorded.record.signals) names.push_back(s.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"c", "c.u", "plant.both.1", "plant.both.2", "plant.d", "plant.u",
                                             "plant.x.1", "plant.x.2", "plant.x.u.1", "plant.x.u.2", "plant.y", "u"}));
  Evaluated at(recorded);
  at.parameters["plant.d"] = 5;
  EXPECT_EQ(at.signal("plant.x.u.2"), 5);
}

TEST(Record, EvaluatesAllFunctions) {
  const auto value = [](const std::string& expression) {
    const auto graph =
        graph_of("plantloop: 1\nparameters: {a: 0.3, b: -1.7, A: [[1, 2], [3, 4]], v: [3, -4]}\nblocks:\n  y: \"" +
                 expression + "\"\n  z: {type: step}\n");
    const RecordedGraph recorded = record(*graph);
    Evaluated at(recorded);
    return at.signal("y");
  };
  EXPECT_DOUBLE_EQ(value("expm1(a/1e8)"), std::expm1(0.3 / 1e8));
  EXPECT_DOUBLE_EQ(value("log1p(a/1e8)"), std::log1p(0.3 / 1e8));
  EXPECT_DOUBLE_EQ(value("log1p(1e10*a)"), std::log1p(0.3e10));
  EXPECT_EQ(value("max(v)"), 3);
  EXPECT_EQ(value("sum(min(v, a, 2))"), 0.3 - 4);
  EXPECT_EQ(value("max(a, b, 2)"), 2);
  EXPECT_EQ(value("clamp(b, -1, 1)"), -1);
  EXPECT_EQ(value("norm(v)"), 5);
  EXPECT_EQ(value("sum(mul(A, v))"), -5 + -7);
  EXPECT_EQ(value("sum(mul(v, A))"), -9 + -10);
  EXPECT_EQ(value("sum(transpose(A)*[[0, 1], [0, 0]])"), 3);
  EXPECT_EQ(value("sum(eye(3)) + sum(zeros(2, 2)) + sum(ones(4))"), 7);
  EXPECT_EQ(value("where(a < 1 and not (b >= 0), 4, 5)"), 4);
  EXPECT_EQ(value("(a != b) + (a == a) + (a > b)"), 3);
  EXPECT_EQ(value("-2^2 + 2^3^0"), -2);
  EXPECT_DOUBLE_EQ(value("mod(b, 1)"), -1.7 + 2);
  EXPECT_EQ(value("A.2.1 + v.2 + sum(v.1:2)"), 3 - 4 - 1);
}

}  // namespace
}  // namespace plantloop
