// Copies of a block and groups of signals: elaboration only, so a diagram written out by hand gives the same equations.

#include <gtest/gtest.h>

#include "tests/graph/helpers.h"

namespace plantloop {
namespace {

TEST(Repeat, CopiesReadTheirNeighboursAndTheEndsWhatStandsForThem) {
  const auto graph = graph_of(R"(
plantloop: 1
parameters: {n: 3}
blocks:
  left: {type: constant, value: 5}
  cell: {type: cell, repeat: n, in: {from: previous.y, to: next.y}, first: {from: left}, last: {to: 0}, k: 2*index}
types:
  cell:
    parameters: {k: 1}
    inputs: [from, to]
    blocks: {y: {type: integrator, in: k*(from - 2*y + to)}}
    outputs: [y]
)");
  const RecordedGraph recorded = record(*graph);
  Evaluated at(recorded);
  at.states = {{"cell.1.y", 1}, {"cell.2.y", 10}, {"cell.3.y", 100}};
  EXPECT_EQ(at.derivative("cell.1.y"), 2 * (5 - 2 * 1 + 10));
  EXPECT_EQ(at.derivative("cell.2.y"), 4 * (1 - 2 * 10 + 100));
  EXPECT_EQ(at.derivative("cell.3.y"), 6 * (10 - 2 * 100 + 0));
}

TEST(Repeat, TheNameAloneIsTheVectorOfMainOutputs) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  x: {type: first_order, repeat: 4, in: 1, tau: index}
  e: {expr: previous + index, repeat: 4, first: 1}
  all: sum(x) + sum(x.2:3)
  total: "[e, e.4, sum(e)]"
)");
  const RecordedGraph recorded = record(*graph);
  Evaluated at(recorded);
  at.states = {{"x.1", 1}, {"x.2", 10}, {"x.3", 100}, {"x.4", 1000}};
  EXPECT_EQ(at.signal("all"), 1111 + 110);
  EXPECT_EQ(at.signal("total.3"), 1 + 2 + 3);
  EXPECT_EQ(at.signal("total.5"), 10);
  EXPECT_EQ(at.signal("total.6"), 1 + 3 + 6 + 10);
}

TEST(Repeat, TheNumberOfCopiesFollowsParametersInAnyOrderAndOverrides) {
  const std::string text = R"(
plantloop: 1
parameters: {cells: m.2 - half, half: k/2, k: 4, m: [1, 5]}
blocks:
  row: {type: row, n: cells}
types:
  row:
    parameters: {n: 1, twice: 2*n}
    blocks:
      x: {type: constant, repeat: twice, value: index}
      y: sum(x)
    outputs: [y]
)";
  const RecordedGraph six = record(*graph_of(text));
  EXPECT_EQ(Evaluated(six).signal("row.y"), 21);
  const RecordedGraph ten = record(*graph_of(text, {{"k", "0"}}));
  EXPECT_EQ(Evaluated(ten).signal("row.y"), 55);
  // A new value of a number of copies is another diagram.
  const auto graph = graph_of(text);
  EXPECT_EQ(graph->parameters[find_named(*graph, "k").index].structural, 2);
}

TEST(Repeat, AParameterIsSetForAllCopiesOrForOne) {
  const std::string text = R"(
plantloop: 1
blocks: {x: {type: x, repeat: 3, k: 1}, y: "[x, 0]"}
types: {x: {parameters: {k: 0, q: 10}, blocks: {y: {type: constant, value: k + q}}, outputs: [y]}}
)";
  const RecordedGraph recorded = record(*graph_of(text, {{"x.k", "2"}, {"x.2.k", "3"}, {"x.3.q", "20"}}));
  Evaluated at(recorded);
  EXPECT_EQ(at.signal("y.1"), 12);
  EXPECT_EQ(at.signal("y.2"), 13);
  EXPECT_EQ(at.signal("y.3"), 22);
  EXPECT_EQ(errors_of(text, {{"x.4.k", "2"}}), "there is no copy 'x.4': 'x' is repeated 3 times");
  EXPECT_EQ(errors_of(text, {{"x.2.j", "2"}}), "'x.2' (x) has no parameter 'j' | it has: k, q, y");
}

TEST(Bus, MembersAreReadThroughSubsystemsAndOtherBuses) {
  const auto graph = graph_of(R"(
plantloop: 1
blocks:
  filter: {type: filter, in: {m: imu}}
  imu: {type: bus, in: {ax: 1 + 1, pose: pose}}
  pose: {type: bus, in: {x: "[3, 4]", y: 5}}
  out: filter.all.own + filter.all.outer.x.2 + imu.pose.y
types:
  filter:
    inputs: [m]
    blocks:
      inner: {type: inner, in: {p: m.pose}}
      all: {type: bus, in: {own: 100*inner, outer: m.pose}}
    outputs: [inner, all]
  inner: {inputs: [p], blocks: {y: p.x.1*p.y}, outputs: [y]}
record: [out, filter.m.ax, imu.pose.x]
)");
  const RecordedGraph recorded = record(*graph);
  Evaluated at(recorded);
  EXPECT_EQ(at.signal("out"), 1500 + 4 + 5);
  EXPECT_EQ(at.of(recorded.columns[1].value), 2);
  EXPECT_EQ(recorded.columns[2].name, "imu.pose.x.1");
  EXPECT_EQ(at.of(recorded.columns[3].value), 4);
}

}  // namespace
}  // namespace plantloop
