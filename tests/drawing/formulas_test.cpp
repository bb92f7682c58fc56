// How expressions and names look on paper.

#include "app/drawing/formulas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
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

double value_of(const Expression& e) {
  const auto argument = [&](std::size_t i) { return value_of(*e.arguments[i]); };
  if (e.kind == Expression::Kind::number) return e.number;
  if (e.kind == Expression::Kind::name) return 0.7 + 0.45 * (e.parts[0][0] - 'a');
  if (e.kind == Expression::Kind::unary) return e.text == "-" ? -argument(0) : argument(0);
  if (e.text == "+") return argument(0) + argument(1);
  if (e.text == "-") return argument(0) - argument(1);
  if (e.text == "*") return argument(0) * argument(1);
  if (e.text == "/") return argument(0) / argument(1);
  return std::pow(argument(0), argument(1));
}

std::string random_expression(std::minstd_rand& random, int depth) {
  const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random() >> 8) % n; };
  if (depth == 0 || pick(5) == 0) return pick(4) == 0 ? std::to_string(2 + pick(3)) : std::string(1, "abcd"[pick(4)]);
  const auto inner = [&] { return "(" + random_expression(random, depth - 1) + ")"; };
  switch (pick(6)) {
    case 0:
      return "-" + inner();
    case 1:
      return inner() + "^2";
    default:
      return inner() + "+-*/"[pick(4)] + inner();
  }
}

// What is drawn, read again as one reads a formula, has the value of what was written.
TEST(Formulas, MeanWhatWasWritten) {
  std::minstd_rand random(1);
  for (int i = 0; i < 3000; ++i) {
    const std::string text = random_expression(random, 4);
    std::string seen = shown(text);
    for (const auto& [from, to] : {std::pair{" + ", "+"}, {" − ", "-"}, {" · ", "*"}, {"−", "-"}, {" ", "*"}})
      for (std::size_t at = 0; (at = seen.find(from, at)) != std::string::npos; at += std::string(to).size())
        seen.replace(at, std::string(from).size(), to);
    Report report;
    const ExpressionPtr written = parse_expression(text, {}, report), read = parse_expression(seen, {}, report);
    ASSERT_TRUE(written && read) << text << "  " << shown(text);
    const double wanted = value_of(*written), got = value_of(*read);
    if (!std::isfinite(wanted)) continue;
    EXPECT_NEAR(got, wanted, 1e-9 * (1 + std::abs(wanted))) << text << "  " << shown(text);
  }
}

TEST(Formulas, BracketsStayWhereAFactorIsWrittenIntoAFraction) {
  EXPECT_EQ(shown("(1 - p)/b*(e - a)"), "((1 − p) (e − a))/(b)");
  EXPECT_EQ(shown("(a/b)^2"), "((a)/(b))^(2)");
}

TEST(Formulas, PolynomialsLeaveOutOnesAndZeros) {
  EXPECT_EQ(spoken(polynomial({"1", "0.4", "0"}, {1, 0.4, 0}, "s")), "s^{2} + 0.4 s");
  EXPECT_EQ(spoken(polynomial({"-1", "a", "2"}, {-1, std::nullopt, 2}, "s")), "−s^{2} + a s + 2");
  EXPECT_EQ(spoken(polynomial({"0"}, {0}, "s")), "0");
}

}  // namespace
}  // namespace plantloop
