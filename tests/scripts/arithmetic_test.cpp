// Vectors and matrices of scripts against values worked out by hand.

#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;
using Arithmetic = Workshop;

TEST_F(Arithmetic, WorksElementByElementAndWithNumbers) {
  EXPECT_EQ(value("pl.vector{1, 2, 3} + pl.vector{10, 20, 30}"), "[11, 22, 33]");
  EXPECT_EQ(value("pl.vector{1, 2, 3} * pl.vector{2, 2, 2} - 1"), "[1, 3, 5]");
  EXPECT_EQ(value("1 / pl.vector{1, 2, 4}"), "[1, 0.5, 0.25]");
  EXPECT_EQ(value("-pl.vector{1, -2}^2"), "[-1, -4]");
  EXPECT_EQ(value("pl.vector{5, -5} % 3"), "[2, 1]");
  EXPECT_EQ(value("2^pl.vector{1, 2, 3}"), "[2, 4, 8]");
  EXPECT_EQ(value("pl.vector{1, 2} + {10, 20}"), "[11, 22]");
}

TEST_F(Arithmetic, RefusesSizesThatDoNotAgree) {
  EXPECT_EQ(complaint("print(pl.vector{1, 2} + pl.vector{1, 2, 3})"),
            "experiment.lua:1: a vector of 2 and a vector of 3 do not go together element by element");
  EXPECT_THAT(complaint("print(pl.vector{1, 2} + 'x')"),
              HasSubstr("must be a vector or a list of numbers, it is the text 'x'"));
}

TEST_F(Arithmetic, ComparesWholeVectorsAndElements) {
  EXPECT_EQ(value("pl.vector{1, 2} == pl.vector{1, 2}, pl.vector{1, 2} == pl.vector{1, 3}"), "true\tfalse");
  EXPECT_EQ(value("pl.less(pl.vector{1, 2, 3}, 2)"), "[1, 0, 0]");
  EXPECT_EQ(value("pl.where(pl.greater({1, 2, 3}, 2), 10, 0)"), "[0, 0, 10]");
  EXPECT_THAT(complaint("print(pl.vector{1} < pl.vector{2})"), HasSubstr("pl.less(a, b)"));
}

TEST_F(Arithmetic, CountsElementsFromOneAndChecksThem) {
  EXPECT_EQ(value("#pl.vector{4, 5, 6}, pl.vector{4, 5, 6}[3]"), "3\t6.0");
  EXPECT_EQ(complaint("print(pl.vector{4, 5}[3])"),
            "experiment.lua:1: there is no element 3: the vector has elements 1 to 2");
  EXPECT_THAT(complaint("print(pl.vector{4, 5}[0])"), HasSubstr("there is no element 0"));
  EXPECT_THAT(complaint("print(pl.vector{4, 5}[1.5])"), HasSubstr("there is no element 1.5"));
  EXPECT_EQ(printed("local v = pl.zeros(3); v[2] = 7; print(v)"), "[0, 7, 0]");
  EXPECT_THAT(complaint("local v = pl.zeros(3); v[4] = 7"), HasSubstr("there is no element 4"));
  EXPECT_EQ(printed("for i, x in ipairs(pl.vector{5, 6}) do print(i, x) end"), "1\t5.0\n2\t6.0");
  EXPECT_EQ(value("table.unpack(pl.vector{5, 6})"), "5.0\t6.0");
}

TEST_F(Arithmetic, MakesVectors) {
  EXPECT_EQ(value("pl.linspace(0, 1, 5)"), "[0, 0.25, 0.5, 0.75, 1]");
  EXPECT_EQ(value("pl.range(1, 2, 0.25)"), "[1, 1.25, 1.5, 1.75, 2]");
  EXPECT_EQ(value("#pl.range(0, 1, 0.1)"), "11");
  EXPECT_EQ(value("pl.range(3, 1, -1)"), "[3, 2, 1]");
  EXPECT_EQ(value("#pl.range(3, 1)"), "0");
  EXPECT_EQ(value("pl.logspace(1, 100, 3)"), "[1, 10, 100]");
  EXPECT_EQ(value("pl.join(pl.ones(2), 5, {6, 7})"), "[1, 1, 5, 6, 7]");
  EXPECT_EQ(value("pl.range(1, 100)"), "[1, 2, 3, ..., 99, 100] (100 numbers)");
  EXPECT_THAT(complaint("pl.vector{1, 'x'}"), HasSubstr("element 2 is the text 'x'"));
}

TEST_F(Arithmetic, ReducesVectors) {
  EXPECT_EQ(value("pl.sum{1, 2, 3}, pl.mean{1, 2, 6}, pl.prod{2, 3}, pl.median{5, 1, 3}"), "6.0\t3.0\t6.0\t3.0");
  EXPECT_EQ(value("pl.var{1, 3}, pl.std{1, 3}^2 - 2 < 1e-15, pl.norm{3, 4}, pl.dot({1, 2}, {3, 4})"),
            "2.0\ttrue\t5.0\t11.0");
  EXPECT_EQ(value("pl.max{1, 5, 2}, pl.min{1, 5, 2}, pl.argmax{1, 5, 2}, pl.max({1, 5}, 3)"), "5.0\t1.0\t2\t[3, 5]");
  EXPECT_EQ(value("pl.any{0, 1}, pl.all{0, 1}"), "true\tfalse");
  EXPECT_EQ(value("pl.vector{1, 2, 3}:sum(), pl.vector{4, 1}:min()"), "6.0\t1.0");
  EXPECT_THAT(complaint("pl.mean{}"), HasSubstr("mean: it needs at least 1 numbers"));
}

TEST_F(Arithmetic, KnowsTheFunctionsOfExpressions) {
  EXPECT_EQ(value("pl.sin(0), pl.cos(pl.vector{0}), pl.exp(0), pl.sqrt{4, 9}"), "0.0\t[1]\t1.0\t[2, 3]");
  EXPECT_EQ(value("pl.round{0.5, -0.5, 2.4}, pl.sign{-3, 0, 2}, pl.clamp({-1, 0.5, 9}, 0, 1)"),
            "[1, -1, 2]\t[-1, 0, 1]\t[0, 0.5, 1]");
  EXPECT_EQ(value("pl.mod(-1, 3), pl.abs{-2}, pl.floor(1.5)"), "2.0\t[2]\t1.0");
}

TEST_F(Arithmetic, WalksAlongVectors) {
  EXPECT_EQ(value("pl.cumsum{1, 2, 3}, pl.diff{1, 4, 9}, pl.trapz({0, 2}, {1, 3})"), "[1, 3, 6]\t[3, 5]\t4.0");
  EXPECT_EQ(value("pl.interp1({0, 1, 2}, {0, 10, 0}, {0.5, 1, 1.75})"), "[5, 10, 2.5]");
  EXPECT_EQ(value("pl.interp1({0, 1, 1, 2}, {0, 0, 5, 5}, 1)"), "5.0");
  EXPECT_EQ(value("pl.interp1({0, 1}, {0, 2}, {-1, 3}, {outside = 'clip'})"), "[0, 2]");
  EXPECT_EQ(value("pl.interp1({0, 1}, {0, 2}, {-1, 3}, {outside = 'linear'})"), "[-2, 6]");
  EXPECT_THAT(complaint("pl.interp1({0, 1}, {0, 2}, 3)"), HasSubstr("interp1: 3 lies outside of 0 to 1"));
  EXPECT_EQ(value("pl.find{0, 1, 1}, pl.select({5, 6, 7}, {3, 1}), pl.sort{3, 1, 2}, pl.reverse{1, 2}"),
            "[2, 3]\t[7, 5]\t[1, 2, 3]\t[2, 1]");
  EXPECT_EQ(value("pl.range(1, 9):slice(3, 5), pl.range(1, 9):slice(8)"), "[3, 4, 5]\t[8, 9]");
}

TEST_F(Arithmetic, MultipliesAndSolves) {
  EXPECT_EQ(value("pl.mul(pl.matrix{{1, 2}, {3, 4}}, pl.vector{1, 1})"), "[3, 7]");
  EXPECT_EQ(value("pl.mul(pl.matrix{{1, 2}, {3, 4}}, pl.matrix{{0, 1}, {1, 0}})"), "[[2, 1],\n [4, 3]]");
  EXPECT_EQ(value("pl.matrix{{1, 2}, {3, 4}}:transpose()"), "[[1, 3],\n [2, 4]]");
  EXPECT_EQ(printed("local x = pl.solve(pl.matrix{{2, 0}, {0, 4}}, {2, 2}); print(pl.norm(x - {1, 0.5}) < 1e-14)"),
            "true");
  EXPECT_EQ(printed("local A = pl.matrix{{1, 2}, {3, 4}}; A:set(1, 2, 9); print(A(1, 2), A[2], A:column(1))"),
            "9.0\t[3, 4]\t[1, 3]");
  EXPECT_THAT(complaint("local A = pl.zeros(2, 2); A[1][1] = 5"), HasSubstr("these numbers are fixed"));
  EXPECT_THAT(complaint("pl.mul(pl.eye(2), pl.vector{1, 2, 3})"), HasSubstr("a matrix of 2 x 2 times a vector of 3"));
  // (x - 1)(x - 2) has the companion matrix below.
  EXPECT_EQ(printed("local r = pl.eigenvalues(pl.matrix{{3, -2}, {1, 0}}); print(pl.norm(r - {1, 2}) < 1e-12)"),
            "true");
  EXPECT_EQ(printed("local p = pl.polyfit({0, 1, 2}, {1, 2, 5}, 2); print(pl.norm(p - {1, 0, 1}) < 1e-12)"), "true");
  EXPECT_EQ(value("pl.polyval({1, 0, 1}, {2, 3})"), "[5, 10]");
}

}  // namespace
}  // namespace plantloop
