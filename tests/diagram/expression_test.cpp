// Expressions: precedence, names, places, and the way back to text.

#include "engine/diagram/expression.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace plantloop {
namespace {

ExpressionPtr parse(const std::string& text) {
  Report report;
  ExpressionPtr tree = parse_expression(text, TextPlace{}, report);
  EXPECT_EQ(tree == nullptr, report.has_errors()) << text;
  return tree;
}

// Every operation in brackets, so that precedence can be read off.
std::string bracketed(const Expression& e) {
  if (e.kind == Expression::Kind::unary) return "(" + e.text + " " + bracketed(*e.arguments[0]) + ")";
  if (e.kind != Expression::Kind::binary) return to_string(e);
  return "(" + bracketed(*e.arguments[0]) + e.text + bracketed(*e.arguments[1]) + ")";
}

std::string shape(const std::string& text) {
  const ExpressionPtr tree = parse(text);
  return tree ? bracketed(*tree) : "";
}

bool same(const Expression& a, const Expression& b) {
  if (a.kind != b.kind || a.text != b.text || a.parts != b.parts || a.slice_end != b.slice_end) return false;
  if (a.number != b.number || a.arguments.size() != b.arguments.size()) return false;
  for (std::size_t i = 0; i < a.arguments.size(); ++i) {
    if (!same(*a.arguments[i], *b.arguments[i])) return false;
  }
  return true;
}

TEST(Expression, BindsPowersFromTheRightAndTighterThanASign) {
  EXPECT_EQ(shape("-x^2"), "(- (x^2))");
  EXPECT_EQ(shape("a^b^c"), "(a^(b^c))");
  EXPECT_EQ(shape("2^-x*3"), "((2^(- x))*3)");
  EXPECT_EQ(shape("a*-b^2"), "(a*(- (b^2)))");
}

TEST(Expression, BindsProductsBeforeSumsBeforeComparisonsBeforeLogic) {
  EXPECT_EQ(shape("a - b - c*d/e"), "((a-b)-((c*d)/e))");
  EXPECT_EQ(shape("a + 1 > b and not c < d or e"), "((((a+1)>b)and(not (c<d)))ore)");
  EXPECT_EQ(shape("not not a"), "(not (not a))");
}

TEST(Expression, ReadsNamesWithOutputsElementsAndSlices) {
  const ExpressionPtr name = parse("plant.ps.2");
  EXPECT_EQ(name->parts, (std::vector<std::string>{"plant", "ps", "2"}));
  EXPECT_EQ(name->slice_end, 0);
  const ExpressionPtr slice = parse("T.2:100");
  EXPECT_EQ(slice->parts, (std::vector<std::string>{"T", "2"}));
  EXPECT_EQ(slice->slice_end, 100);
  EXPECT_EQ(parse("A.1.2")->parts.size(), 3U);
}

TEST(Expression, ReadsNumbersToTheLastBit) {
  EXPECT_EQ(parse("0.1")->number, 0.1);
  EXPECT_EQ(parse("1e-3")->number, 1e-3);
  EXPECT_EQ(parse(".5")->number, 0.5);
  EXPECT_EQ(parse("2.5E+2")->number, 250);
  EXPECT_EQ(parse("1e-400")->number, 0);
  EXPECT_EQ(parse("0.1")->text, "0.1");
}

TEST(Expression, KnowsVectorsAndCalls) {
  const ExpressionPtr matrix = parse("[[1, 2], [3, 4]]");
  EXPECT_EQ(matrix->kind, Expression::Kind::vector);
  EXPECT_EQ(matrix->arguments[1]->arguments[0]->number, 3);
  const ExpressionPtr call = parse("where(a > 0, b, max(c, d, 1))");
  EXPECT_EQ(call->text, "where");
  EXPECT_EQ(call->arguments[2]->arguments.size(), 3U);
  EXPECT_EQ(to_string(*parse("pow(x, 2)")), "x^2");
}

TEST(Expression, MarksCountCharactersNotBytes) {
  const auto source = std::make_shared<const Source>(Source{"x.yaml", "θθ: a + é"});
  Report report;
  const TextPlace place{.start = {source.get(), 1, 5, 5}, .positions = {}};
  EXPECT_EQ(parse_expression("a + é", place, report), nullptr);
  ASSERT_EQ(report.findings().size(), 1U);
  EXPECT_EQ(report.findings()[0].mark.column, 9U);
}

TEST(Expression, RefusesDepthInsteadOfOverflowing) {
  for (const std::string& text :
       {std::string(100000, '('), std::string(100000, '-') + "x", "x" + std::string(100000, '^'),
        [] {
          std::string chain = "x";
          for (int i = 0; i < 100000; ++i) chain += "+x";
          return chain;
        }(),
        [] {
          std::string chain;
          for (int i = 0; i < 50000; ++i) chain += "not ";
          return chain + "x";
        }()}) {
    Report report;
    EXPECT_EQ(parse_expression(text, TextPlace{}, report), nullptr);
    EXPECT_EQ(report.error_count(), 1U);
  }
}

TEST(Expression, EveryFunctionIsDocumentedOnceAndReserved) {
  std::set<std::string_view> names;
  const std::set<std::string> reserved(reserved_names().begin(), reserved_names().end());
  for (const FunctionSignature& function : expression_functions()) {
    EXPECT_TRUE(names.insert(function.name).second) << function.name;
    EXPECT_FALSE(function.doc.empty()) << function.name;
    EXPECT_TRUE(function.most < 0 || function.most >= function.least) << function.name;
    EXPECT_TRUE(reserved.contains(std::string(function.name)));
  }
}

// A random tree as text with brackets wherever they may stand.
std::string random_text(std::mt19937& random, int depth) {
  const auto pick = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const auto inner = [&] { return "(" + random_text(random, depth - 1) + ")"; };
  if (depth == 0) {
    constexpr const char* leaves[] = {"x", "y.2", "T.1:9", "3", "0.5e-2", "plant.a.1.2", "pi"};
    return leaves[pick(7)];
  }
  constexpr const char* operators[] = {"+", "-", "*", "/", "^", "<", "<=", ">", ">=", "==", "!=", " and ", " or "};
  switch (pick(6)) {
    case 0:
      return "-" + inner();
    case 1:
      return "not " + inner();
    case 2:
      return "max(" + random_text(random, depth - 1) + "," + inner() + ")";
    case 3:
      return "[" + random_text(random, depth - 1) + ", " + inner() + "]";
    default:
      return inner() + operators[pick(13)] + inner();
  }
}

TEST(Expression, PrintedWithFewestBracketsReadsAsTheSameTree) {
  std::mt19937 random(20261123);
  for (int i = 0; i < 3000; ++i) {
    const std::string text = random_text(random, 1 + i % 5);
    const ExpressionPtr tree = parse(text);
    ASSERT_TRUE(tree) << text;
    const std::string printed = to_string(*tree);
    const ExpressionPtr again = parse(printed);
    ASSERT_TRUE(again) << printed;
    EXPECT_TRUE(same(*tree, *again)) << text << " printed as " << printed;
    EXPECT_EQ(to_string(*again), printed);
  }
}

TEST(Expression, PrintsNoNeedlessBrackets) {
  for (const char* text : {"b*force - Q*omega - Q*sin(theta)", "-c*v", "a^b^c", "(a^b)^c", "-(a + b)", "a - (b - c)",
                           "(a < b) == c", "not a < b and c or d", "2^-x", "(-2)^x", "a/(b*c)", "x.1:2 + [1, 2]"}) {
    EXPECT_EQ(to_string(*parse(text)), text);
  }
}

TEST(Expression, NumbersWithoutPlaceReadBack) {
  for (const double value : {0.0, 1.5, 1e-300, 0.1, 123456789.0}) {
    EXPECT_EQ(parse(to_string(*number_expression(value)))->number, value);
  }
}

}  // namespace
}  // namespace plantloop
