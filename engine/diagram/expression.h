// Expressions as they are written in wires and parameters: text -> tree.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/mark.h"
#include "engine/base/report.h"

namespace plantloop {

// A node of an expression's tree. Trees are immutable and shared.
//   number   `number` is its value, `text` its decimal text (periods are evaluated in exact rationals from it)
//   name     `parts` are the dotted parts: "plant.ps.2" -> {"plant", "ps", "2"}; `slice_end` of "T.2:100" is 100 (0: no
//   slice) unary    `text` is "-", "+" or "not"; one argument binary   `text` is one of ^ * / + - < <= > >= == != and
//   or; two arguments call     `text` is the function's name; any number of arguments vector   [a, b, ...]: the
//   arguments, joined; a vector of equally long vectors of numbers is a matrix
struct Expression {
  enum class Kind { number, name, unary, binary, call, vector };
  Kind kind = Kind::number;
  double number = 0;
  std::string text;
  std::vector<std::string> parts;
  long slice_end = 0;
  std::vector<std::shared_ptr<const Expression>> arguments;
  Mark mark;  // the operator, name, number or bracket itself
};
using ExpressionPtr = std::shared_ptr<const Expression>;

// How the characters of an expression's text lie in their source: for a text that stands there unquoted on one line,
// `start` is its first character and column i is start.column + i. For folded, quoted and escaped scalars
// `positions[i]` is the place of byte i of the text.
struct TextPlace {
  Mark start;
  std::vector<Mark> positions;
};

// The tree of the text, or null after reporting every finding.
ExpressionPtr parse_expression(std::string_view text, const TextPlace& place, Report& report);

// A number as an expression without place, for defaults.
ExpressionPtr number_expression(double value);

// The text again, with the fewest brackets; parsing it gives the same tree.
std::string to_string(const Expression& expression);

// The functions an expression may call, with their least and greatest number of arguments (-1: any number).
struct FunctionSignature {
  std::string_view name;
  int least = 1;
  int most = 1;
  std::string_view doc;
};
const std::vector<FunctionSignature>& expression_functions();

// Whether a function or block of this name is asked for the derivative of a signal, which none gives exactly.
bool asks_for_derivative(std::string_view name);
// Names that no parameter, input or block may take.
const std::vector<std::string>& reserved_names();

}  // namespace plantloop
