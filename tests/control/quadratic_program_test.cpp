// Quadratic programs against the conditions of optimality, and against problems whose answers are known.

#include "control/quadratic_program.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

namespace plantloop {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Outcome = QuadraticProgram::Outcome;

struct Problem {
  MatrixXd H;
  VectorXd g;
  MatrixXd A;
  VectorXd b;
};
struct Answer {
  Outcome outcome;
  VectorXd x, multipliers;
};

Answer solve(const Problem& problem) {
  const auto n = static_cast<int>(problem.H.rows()), m = static_cast<int>(problem.A.rows());
  Room count;
  QuadraticProgram counted(n, m, count);
  std::vector<double> memory(count.taken());
  Room room(memory.data());
  QuadraticProgram program(n, m, room);
  for (Index i = 0; i < n; ++i) {
    program.g[i] = problem.g[i];
    for (Index j = 0; j < n; ++j) program.H[i * n + j] = problem.H(i, j);
  }
  for (Index i = 0; i < m; ++i) {
    program.b[i] = problem.b[i];
    for (Index j = 0; j < n; ++j) program.A[i * n + j] = problem.A(i, j);
  }
  Answer answer{program.solve(n, m), VectorXd(n), VectorXd(m)};
  answer.x = VectorXd::Map(program.x, n);
  answer.multipliers = VectorXd::Map(program.multiplier, m);
  return answer;
}

MatrixXd random(Index rows, Index columns, std::mt19937& source) {
  std::normal_distribution<double> normal;
  MatrixXd m(rows, columns);
  for (double& value : m.reshaped()) value = normal(source);
  return m;
}

// Stationary, feasible, multipliers not negative and zero where there is room: of a convex problem that is the optimum.
TEST(QuadraticProgram, MeetsTheConditionsOfOptimality) {
  std::mt19937 source(7);
  int active = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Index n = 1 + trial % 9, m = (trial * 7) % 31;
    const MatrixXd root = random(n, n, source);
    Problem problem{root.transpose() * root + 0.01 * MatrixXd::Identity(n, n), random(n, 1, source),
                    random(m, n, source), VectorXd()};
    // Some point keeps all constraints.
    problem.b = problem.A * random(n, 1, source) - random(m, 1, source).cwiseAbs();
    if (m > 4) {  // two that say the same, and two that are opposite
      problem.A.row(1) = 2 * problem.A.row(0);
      problem.b[1] = 2 * problem.b[0];
    }
    const Answer answer = solve(problem);
    ASSERT_EQ(answer.outcome, Outcome::solved) << trial;
    const VectorXd slack = problem.A * answer.x - problem.b;
    const double scale = 1 + answer.x.norm();
    EXPECT_LT((problem.H * answer.x + problem.g - problem.A.transpose() * answer.multipliers).norm(),
              1e-8 * (1 + problem.H.norm()) * scale)
        << trial;
    for (Index i = 0; i < m; ++i) {
      EXPECT_GT(slack[i], -1e-9 * scale) << trial;
      EXPECT_GE(answer.multipliers[i], 0) << trial;
      EXPECT_LT(answer.multipliers[i] * slack[i], 1e-7 * scale * (1 + answer.multipliers[i])) << trial;
      active += answer.multipliers[i] > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(active, 300);  // constraints did matter
}

TEST(QuadraticProgram, FindsOutThatNothingKeepsTheConstraints) {
  std::mt19937 source(11);
  for (int trial = 0; trial < 100; ++trial) {
    const Index n = 1 + trial % 6;
    const VectorXd normal = random(n, 1, source);
    Problem problem{MatrixXd::Identity(n, n), random(n, 1, source), MatrixXd(4, n), VectorXd(4)};
    problem.A << normal.transpose(), -normal.transpose(), random(2, n, source);
    problem.b << 1, -0.9, -100, -100;  // normal x >= 1 and normal x <= 0.9
    EXPECT_EQ(solve(problem).outcome, Outcome::infeasible) << trial;
  }
}

TEST(QuadraticProgram, TakesEqualLimitsAsAnEquation) {
  Problem problem{MatrixXd::Identity(2, 2), VectorXd::Zero(2), MatrixXd(2, 2), VectorXd(2)};
  problem.A << 1, 1, -1, -1;
  problem.b << 2, -2;
  const Answer answer = solve(problem);
  ASSERT_EQ(answer.outcome, Outcome::solved);
  EXPECT_NEAR(answer.x[0], 1, 1e-14);
  EXPECT_NEAR(answer.x[1], 1, 1e-14);
}

TEST(QuadraticProgram, SaysWhenItIsNotConvex) {
  Problem problem{MatrixXd::Zero(2, 2), VectorXd::Ones(2), MatrixXd(0, 2), VectorXd(0)};
  problem.H(0, 0) = 1;
  EXPECT_EQ(solve(problem).outcome, Outcome::not_convex);
}

}  // namespace
}  // namespace plantloop
