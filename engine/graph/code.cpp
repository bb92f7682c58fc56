// Tree -> postfix code.

#include "engine/graph/code.h"

#include <cassert>
#include <cmath>
#include <string_view>
#include <utility>

namespace plantloop {
namespace {

struct Meaning {
  std::string_view name;
  Step::Kind kind;
  Op op;
  Function function;
};

// What a function's name stands for; min and max of one argument reduce it.
constexpr Meaning meanings[] = {
#define UNARY(name)                        \
  {                                        \
#name, Step::Kind::unary, Op::name, {} \
  }
    UNARY(sin),
    UNARY(cos),
    UNARY(tan),
    UNARY(asin),
    UNARY(acos),
    UNARY(atan),
    UNARY(sinh),
    UNARY(cosh),
    UNARY(tanh),
    UNARY(asinh),
    UNARY(acosh),
    UNARY(atanh),
    UNARY(exp),
    UNARY(log),
    UNARY(log2),
    UNARY(log10),
    UNARY(sqrt),
    UNARY(cbrt),
    UNARY(erf),
    UNARY(abs),
    UNARY(sign),
    UNARY(floor),
    UNARY(ceil),
    UNARY(round),
    UNARY(trunc),
#undef UNARY
#define BINARY(name)                        \
  {                                         \
#name, Step::Kind::binary, Op::name, {} \
  }
    BINARY(atan2),
    BINARY(pow),
    BINARY(hypot),
    BINARY(mod),
#undef BINARY
    {"where", Step::Kind::ternary, Op::where, {}},
    {"min", Step::Kind::function, Op::min, Function::extreme},
    {"max", Step::Kind::function, Op::max, Function::extreme},
#define FUNCTION(name) \
  { #name, Step::Kind::function, Op::copy, Function::name }
    FUNCTION(clamp),
    FUNCTION(dot),
    FUNCTION(sum),
    FUNCTION(norm),
    FUNCTION(mul),
    FUNCTION(transpose),
    FUNCTION(zeros),
    FUNCTION(ones),
    FUNCTION(eye),
    FUNCTION(expm1),
    FUNCTION(log1p),
#undef FUNCTION
};

struct Operator {
  std::string_view text;
  Op op;
  bool swap;
  bool negate;
};
constexpr Operator operators[] = {
    {"+", Op::add, false, false},         {"-", Op::sub, false, false},   {"*", Op::mul, false, false},
    {"/", Op::div, false, false},         {"^", Op::pow, false, false},   {"<", Op::less, false, false},
    {"<=", Op::less_equal, false, false}, {">", Op::less, true, false},   {">=", Op::less_equal, true, false},
    {"==", Op::equal, false, false},      {"!=", Op::equal, false, true}, {"and", Op::logical_and, false, false},
    {"or", Op::logical_or, false, false},
};

Step step_of(const Expression& node) {
  Step step;
  step.node = &node;
  step.arguments = static_cast<std::uint32_t>(node.arguments.size());
  switch (node.kind) {
    case Expression::Kind::number:
      step.number = node.number;
      break;
    case Expression::Kind::name:
      step.kind = Step::Kind::name;
      break;
    case Expression::Kind::unary:
      step.kind = Step::Kind::unary;
      step.op = node.text == "-" ? Op::neg : node.text == "not" ? Op::logical_not : Op::copy;
      break;
    case Expression::Kind::binary:
      step.kind = Step::Kind::binary;
      for (const Operator& o : operators) {
        if (o.text == node.text) step.op = o.op, step.swap = o.swap, step.negate = o.negate;
      }
      break;
    case Expression::Kind::call:
      for (const Meaning& m : meanings) {
        if (m.name == node.text) step.kind = m.kind, step.op = m.op, step.function = m.function;
      }
      assert(step.kind != Step::Kind::number && "the parser knows a function that elaboration does not");
      break;
    case Expression::Kind::vector:
      step.kind = Step::Kind::join;
      step.rows = !node.arguments.empty();
      for (const ExpressionPtr& entry : node.arguments) step.rows &= entry->kind == Expression::Kind::vector;
      break;
  }
  return step;
}

bool is_literal_number(const Expression& node) {
  if (node.kind == Expression::Kind::number) return true;
  if (node.kind == Expression::Kind::name) return node.parts.size() == 1 && node.parts[0] == "inf";
  return node.kind == Expression::Kind::unary && node.text != "not" && is_literal_number(*node.arguments[0]);
}

bool is_literal(const Expression& node) {
  if (node.kind != Expression::Kind::vector) return is_literal_number(node);
  for (const ExpressionPtr& entry : node.arguments) {
    if (!is_literal(*entry)) return false;
  }
  return true;
}

}  // namespace

const Code* CodeCache::of(const ExpressionPtr& tree) {
  if (!tree) return nullptr;
  const auto [known, is_new] = by_tree_.try_emplace(tree.get());
  if (!is_new) return known->second;

  Code& code = codes_.emplace_back();
  known->second = &code;
  code.tree = tree;
  code.literal = is_literal(*tree);
  if (tree->arguments.empty() && tree->kind != Expression::Kind::call && tree->kind != Expression::Kind::vector) {
    code.steps.push_back(step_of(*tree));
    if (tree->kind == Expression::Kind::name) code.names.push_back(tree.get());
    return &code;
  }
  struct Open {
    const Expression* node;
    std::size_t next;     // argument
    std::uint32_t begin;  // step
  };
  std::vector<Open> open{{tree.get(), 0, 0}};
  while (!open.empty()) {
    Open& top = open.back();
    if (top.next < top.node->arguments.size()) {
      const Expression* argument = top.node->arguments[top.next++].get();
      open.push_back({argument, 0, static_cast<std::uint32_t>(code.steps.size())});
      continue;
    }
    Step step = step_of(*top.node);
    step.begin = top.begin;
    if (step.kind == Step::Kind::name) {
      step.name = static_cast<std::uint32_t>(code.names.size());
      code.names.push_back(top.node);
    }
    if (step.kind == Step::Kind::function && step.function >= Function::zeros && step.function <= Function::eye) {
      code.has_sizes = true;
    }
    if (step.kind != Step::Kind::unary || step.op != Op::copy) code.steps.push_back(step);  // a plus sign does nothing
    open.pop_back();
  }
  return &code;
}

}  // namespace plantloop
