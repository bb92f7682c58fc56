// How expressions and names look on paper.

#include "app/drawing/formulas.h"

#include <gtest/gtest.h>

#include <string>

#include "engine/base/report.h"

namespace plantloop {
namespace {

std::string shown(const std::string& text) {
  Report report;
  const ExpressionPtr e = parse_expression(text, {}, report);
  return e ? spoken(formula_of(*e)) : "?";
}

TEST(Formulas, NamesBecomeSymbolsWithIndices) {
  EXPECT_EQ(pretty_name("theta0"), "θ_{0}");
  EXPECT_EQ(pretty_name("omega_n"), "ω_{n}");
  EXPECT_EQ(pretty_name("kp"), "k_{p}");
  EXPECT_EQ(pretty_name("x"), "x");
  EXPECT_EQ(pretty_name("set_point"), "set point");
  EXPECT_EQ(pretty_name("tire"), "tire");
}

TEST(Formulas, NumbersHaveNoLetterE) {
  EXPECT_EQ(pretty_number(0.05), "0.05");
  EXPECT_EQ(pretty_number(-2), "−2");
  EXPECT_EQ(pretty_number(1.5e-9), "1.5·10^{−9}");
  EXPECT_EQ(pretty_number(1e300), "10^{300}");
}

TEST(Formulas, SetFractionsPowersAndSigns) {
  EXPECT_EQ(shown("a/b"), "(a)/(b)");
  EXPECT_EQ(shown("x^2"), "x^(2)");
  EXPECT_EQ(shown("a - (b - c)"), "a − (b − c)");
  EXPECT_EQ(shown("2*x + y*3"), "2 x + y · 3");
  EXPECT_EQ(shown("exp(-p*time)"), "e^(−p t)");
  EXPECT_EQ(shown("1*x"), "x");
  EXPECT_EQ(shown("1/tau*s"), "(s)/(τ)");
  EXPECT_EQ(shown("outlet*sqrt(level)"), "outlet · √level");
  EXPECT_EQ(shown("where(x <= 1, 2, y)"), "2  if x ≤ 1; y  else");
}

TEST(Formulas, PolynomialsLeaveOutOnesAndZeros) {
  EXPECT_EQ(spoken(polynomial({"1", "0.4", "0"}, {1, 0.4, 0}, "s")), "s^{2} + 0.4 s");
  EXPECT_EQ(spoken(polynomial({"-1", "a", "2"}, {-1, std::nullopt, 2}, "s")), "−s^{2} + a s + 2");
  EXPECT_EQ(spoken(polynomial({"0"}, {0}, "s")), "0");
}

}  // namespace
}  // namespace plantloop
