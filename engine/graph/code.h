// Expressions as flat code: a tree is read once, and evaluated anywhere without recursion.

#pragma once

#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "engine/diagram/expression.h"
#include "engine/program/operations.h"

namespace plantloop {

// Functions of expressions that are more than one operation for each element.
enum class Function : std::uint8_t {
  extreme,  // min and max: `op`
  clamp,
  dot,
  sum,
  norm,
  mul,
  transpose,
  zeros,
  ones,
  eye,
  expm1,
  log1p,
};

// One step of a postfix program: its operands are the topmost values.
struct Step {
  enum class Kind : std::uint8_t { number, name, unary, binary, ternary, function, join };
  Kind kind = Kind::number;
  Op op = Op::copy;
  Function function = Function::extreme;
  bool swap = false;    // a > b is recorded as b < a
  bool negate = false;  // a != b is not (a == b)
  bool rows = false;    // a join whose entries are brackets: a matrix
  std::uint32_t arguments = 0;
  std::uint32_t begin = 0;  // first step of this subexpression
  std::uint32_t name = 0;   // of kind name: which one of Code::names
  double number = 0;
  const Expression* node = nullptr;
};

struct Code {
  std::vector<Step> steps;
  std::vector<const Expression*> names;  // in order of evaluation
  ExpressionPtr tree;                    // keeps the nodes alive
  bool literal = false;                  // a number, a signed number, or a vector or matrix of such
  bool has_sizes = false;                // calls zeros, ones or eye
  bool is_name() const { return steps.size() == 1 && steps[0].kind == Step::Kind::name; }
};

// The code of trees, by their address; a tree that many instances share is read once.
class CodeCache {
 public:
  const Code* of(const ExpressionPtr& tree);

 private:
  std::unordered_map<const Expression*, const Code*> by_tree_;
  std::deque<Code> codes_;
};

}  // namespace plantloop
