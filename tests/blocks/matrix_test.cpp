// Blocks on vectors and matrices.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/blocks/diagrams.h"

namespace plantloop::testing_diagrams {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string brief = "simulation: {stop: 1e-9}\n";

// The elements of y at time 0; t is a signal that is 0 there, so that nothing is folded away while compiling.
std::vector<double> outputs(const std::string& blocks) {
  const Signals r =
      run("blocks:\n  t: {type: clock}\n  A: \"[[1, 2, 3], [4, 5, 6]] + t\"\n" + blocks + "record: [y]\n" + brief);
  std::vector<double> values;
  for (std::size_t i = 0; i < r.recording().columns.size(); ++i) values.push_back(r.recording().at(0, i));
  return values;
}
std::string wrong(const std::string& block) {
  return findings("parameters: {A: [[1, 2, 3], [4, 5, 6]]}\nblocks: {y: " + block + "}\n" + brief);
}

TEST(Polynomial, HasItsHighestPowerFirst) {
  EXPECT_THAT(outputs("  y: {type: polynomial, in: [t + 2, t - 1], coefficients: [3, 0, -4, 5]}\n"),
              ElementsAre(21, 6));
  EXPECT_THAT(outputs("  y: {type: polynomial, in: t + 2, coefficients: 7}\n"), ElementsAre(7));
  EXPECT_THAT(wrong("{type: polynomial, in: 1, coefficients: [[1, 2], [3, 4]]}"), HasSubstr("are a vector"));
}

TEST(MatrixGain, MultipliesColumnsAndMatrices) {
  EXPECT_THAT(outputs("  y: {type: matrix_gain, in: [t + 1, t + 2], K: [[1, 2], [3, 4], [5, 6]]}\n"),
              ElementsAre(5, 11, 17));
  EXPECT_THAT(outputs("  y: {type: matrix_gain, in: [t + 1, t + 2], K: [3, 4]}\n"), ElementsAre(11));
  EXPECT_THAT(outputs("  y: {type: matrix_gain, in: t + 3, K: [[1], [2]]}\n"), ElementsAre(3, 6));
  EXPECT_THAT(outputs("  y: {type: matrix_gain, in: A, K: [[1, 1], [0, 2]]}\n"), ElementsAre(5, 7, 9, 8, 10, 12));
  EXPECT_THAT(wrong("{type: matrix_gain, in: [1, 2, 3], K: [[1, 2], [3, 4]]}"),
              HasSubstr("K has 2 columns, but the input is a vector of 3"));
}

TEST(MatrixGain, HasNoPathWhereAnEntryIsZero) {
  // y.1 feeds u.2, and y.2 nothing: with K.1.2 = 0 no loop is algebraic.
  const Signals r = run("blocks: {y: {type: matrix_gain, in: [time + 1, y.1], K: [[2, 0], [0, 3]]}}\n" + brief);
  EXPECT_EQ(r.at("y.2", 0), 6);
}

TEST(MatrixMultiply, FollowsTheRulesOfRowsAndColumns) {
  EXPECT_THAT(outputs("  y: {type: matrix_multiply, in: {u: A, v: [t + 1, 0, 1]}}\n"), ElementsAre(4, 10));
  EXPECT_THAT(outputs("  y: {type: matrix_multiply, in: {u: [t + 1, 2], v: A}}\n"), ElementsAre(9, 12, 15));
  EXPECT_THAT(outputs("  y: {type: matrix_multiply, in: {u: [t + 1, 2], v: [3, t + 4]}}\n"), ElementsAre(11));
  EXPECT_THAT(outputs("  y: {type: matrix_multiply, in: {u: t + 2, v: A}}\n"), ElementsAre(2, 4, 6, 8, 10, 12));
  EXPECT_THAT(wrong("{type: matrix_multiply, in: {u: A, v: A}}"), HasSubstr("3 columns meet 2 rows"));
}

TEST(Norm, IsEuclideanSumOrMax) {
  EXPECT_THAT(outputs("  y: {type: norm, in: [t + 2, -3, 6]}\n"), ElementsAre(7));
  EXPECT_THAT(outputs("  y: {type: norm, in: [t + 2, -3, 6], norm: sum}\n"), ElementsAre(11));
  EXPECT_THAT(outputs("  y: {type: norm, in: [t + 2, -7, 6], norm: max}\n"), ElementsAre(7));
  EXPECT_THAT(outputs("  y: {type: norm, in: t - 2}\n"), ElementsAre(2));
  EXPECT_DOUBLE_EQ(outputs("  y: {type: norm, in: [t + 3e200, 4e200]}\n")[0], 5e200);
}

TEST(Reshape, CountsRowByRowOrColumnByColumn) {
  const Signals r =
      run("blocks:\n  u: [time + 1, 2, 3, 4, 5, 6]\n  M: {type: reshape, in: u, columns: 3}\n"
          "  N: {type: reshape, in: u, rows: 2, by: columns}\n  v: {type: reshape, in: M}\n" +
          brief);
  EXPECT_EQ(r.at("M.2.1", 0), 4);
  EXPECT_EQ(r.at("N.2.1", 0), 2);
  EXPECT_EQ(r.at("N.1.3", 0), 5);
  EXPECT_EQ(r.at("v.6", 0), 6);
  EXPECT_THAT(wrong("{type: reshape, in: [1, 2, 3], rows: 2}"), HasSubstr("3 elements do not fill 2 rows"));
  EXPECT_THAT(wrong("{type: reshape, in: [1, 2, 3], rows: 2, columns: 2}"),
              HasSubstr("2 by 2 elements are 4, but the input has 3"));
}

}  // namespace
}  // namespace plantloop::testing_diagrams
