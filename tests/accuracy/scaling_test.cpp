// S9: large stiff diagrams cost in proportion to their size: sparse exact Jacobians, as many steps for any length.

#include <gtest/gtest.h>

#include <string>

#include "engine/run/diagram.h"

namespace plantloop::accuracy {
namespace {

// Heat in a rod of n cells, heated at one end; eigenvalues from nearly 0 to -4e4 1/s.
std::string rod(int n) {
  std::string text = "plantloop: 1\nblocks:\n";
  for (int i = 1; i <= n; ++i) {
    const std::string left = i == 1 ? "1" : "x" + std::to_string(i - 1);
    const std::string right = i == n ? "0" : "x" + std::to_string(i + 1);
    const std::string name = "x" + std::to_string(i);
    text += "  " + name + ": {type: integrator, in: 1e4*(" + left + " - 2*" + name + " + " + right + ")}\n";
  }
  return text + "simulation: {stop: 1, solver: bdf}\nrecord: [x1, x10]\n";
}

struct Cost {
  double operations = 0, nonzeros = 0, steps = 0, evaluations = 0, jacobians = 0, at_10 = 0;
};

Cost cost_of(int n) {
  Report report;
  const auto diagram = Diagram::from_text(rod(n), "rod.yaml", report);
  const auto run = diagram->run({}, report);
  EXPECT_TRUE(run) << to_text(report);
  const auto program = diagram->prepare({}, report)->compiled->program;
  const SolverStatistics& s = run->statistics.solver;
  return {static_cast<double>(program->derivative_list.operation_count),
          static_cast<double>(program->jacobian_row.size()),
          static_cast<double>(s.steps),
          static_cast<double>(s.evaluations),
          static_cast<double>(s.jacobians),
          run->recording.at(run->recording.rows() - 1, 1)};
}

TEST(S9Scaling, AStiffChainCostsInProportionToItsLength) {
  const Cost one = cost_of(1000), four = cost_of(4000);
  EXPECT_EQ(one.nonzeros, 3 * 1000 - 2);  // of a tridiagonal matrix
  EXPECT_EQ(four.nonzeros, 3 * 4000 - 2);
  EXPECT_LT(four.operations, 4.1 * one.operations);
  EXPECT_LT(four.steps, 1.2 * one.steps);
  EXPECT_LT(four.evaluations, 1.2 * one.evaluations);  // none are spent on differences
  EXPECT_LT(four.jacobians, 1.2 * one.jacobians + 2);
  EXPECT_LT(one.evaluations, 3 * one.steps);
  // A half-infinite rod: erfc(10/(2 sqrt(1e4))), to the width of a cell.
  EXPECT_NEAR(one.at_10, 0.9436, 2e-3);
  EXPECT_NEAR(four.at_10, one.at_10, 1e-5);
}

}  // namespace
}  // namespace plantloop::accuracy
