// Expressions back to text, with the fewest brackets.

#include "engine/diagram/expression.h"

#include "engine/base/numbers.h"

namespace plantloop {
namespace {

// How tightly an operator binds; a primary binds tightest.
enum Binding { loose, disjunctive, conjunctive, negating, comparing, adding, multiplying, signing, raising, tight };

Binding binding(const Expression& e) {
  if (e.kind == Expression::Kind::number) return e.text.starts_with('-') || e.number < 0 ? signing : tight;
  if (e.kind == Expression::Kind::unary) return e.text == "not" ? negating : signing;
  if (e.kind != Expression::Kind::binary) return tight;
  if (e.text == "or") return disjunctive;
  if (e.text == "and") return conjunctive;
  if (e.text == "+" || e.text == "-") return adding;
  if (e.text == "*" || e.text == "/") return multiplying;
  if (e.text == "^") return raising;
  return comparing;
}

void print(const Expression& e, std::string& out);

void print_bracketed(const Expression& e, bool brackets, std::string& out) {
  if (brackets) out += '(';
  print(e, out);
  if (brackets) out += ')';
}

void print_list(const Expression& e, std::string& out) {
  for (std::size_t i = 0; i < e.arguments.size(); ++i) {
    if (i > 0) out += ", ";
    print(*e.arguments[i], out);
  }
}

void print_name(const Expression& e, std::string& out) {
  for (std::size_t i = 0; i < e.parts.size(); ++i) {
    if (i > 0) out += '.';
    out += e.parts[i];
  }
  if (e.slice_end > 0) out.append(":").append(std::to_string(e.slice_end));
}

void print_unary(const Expression& e, std::string& out) {
  const Expression& argument = *e.arguments[0];
  out += e.text == "not" ? "not " : e.text;
  print_bracketed(argument, binding(argument) < binding(e), out);
}

void print_binary(const Expression& e, std::string& out) {
  const Expression& left = *e.arguments[0];
  const Expression& right = *e.arguments[1];
  const Binding own = binding(e);
  const bool from_right = own == raising;
  const bool chains = own != comparing;  // comparisons do not
  print_bracketed(left, binding(left) < own || (binding(left) == own && (from_right || !chains)), out);
  const bool spaced = own == adding || own <= comparing;
  if (spaced) out += ' ';
  out += e.text;
  if (spaced) out += ' ';
  // The right side of a power may carry a sign without brackets: 2^-x.
  const Binding least = from_right ? signing : static_cast<Binding>(own + 1);
  print_bracketed(right, binding(right) < least, out);
}

void print(const Expression& e, std::string& out) {
  switch (e.kind) {
    case Expression::Kind::number:
      out += e.text.empty() ? shortest(e.number) : e.text;
      break;
    case Expression::Kind::name:
      print_name(e, out);
      break;
    case Expression::Kind::unary:
      print_unary(e, out);
      break;
    case Expression::Kind::binary:
      print_binary(e, out);
      break;
    case Expression::Kind::call:
    case Expression::Kind::vector:
      out.append(e.text).append(e.kind == Expression::Kind::call ? "(" : "[");
      print_list(e, out);
      out += e.kind == Expression::Kind::call ? ")" : "]";
      break;
  }
}

}  // namespace

ExpressionPtr number_expression(double value) {
  auto tree = std::make_shared<Expression>();
  tree->number = value;
  tree->text = shortest(value);
  return tree;
}

std::string to_string(const Expression& expression) {
  std::string out;
  print(expression, out);
  return out;
}

}  // namespace plantloop
