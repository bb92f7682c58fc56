// Runs the code of expressions on values.

#include "engine/graph/evaluate.h"

#include <cassert>
#include <limits>
#include <utility>
#include <vector>

namespace plantloop {
namespace {

Array one_if_single(const Array& a) { return a.size() == 1 && !a.is_scalar() ? a.spread(Shape::scalar()) : a; }

// A matrix of one column takes a scalar as its column; a product with one row and one column is a scalar.
Array matrix_product(const Array& a, const Array& b) {
  if (a.shape().rank == 2 && b.is_scalar() && a.columns() == 1)
    return one_if_single(mul(a, b.spread(Shape::vector(1))));
  return one_if_single(mul(a, b));
}

Array join(std::span<const Array> entries, bool rows) {
  std::vector<Value> values;
  for (const Array& entry : entries) values.insert(values.end(), entry.values().begin(), entry.values().end());
  if (!rows) return Array::vector(std::move(values));
  const int count = static_cast<int>(entries.size());
  const int columns = static_cast<int>(values.size()) / count;
  return Array::matrix(count, columns, std::move(values));
}

Array identity(int n) {
  Array a(Shape::matrix(n, n));
  for (int i = 0; i < n; ++i) a(i, i) = 1.0;
  return a;
}

// 2 exp(x/2) sinh(x/2): exact for small x, as no difference is taken.
Array expm1_of(const Array& x) { return 2.0 * exp(x * 0.5) * sinh(x * 0.5); }
// 2 atanh(x / (x + 2)) near 0, else log(1 + x), where nothing is lost any more.
Array log1p_of(const Array& x) {
  const Truths small{map(Op::less, abs(x), Array(0.5))};
  return where(small, 2.0 * atanh(x / (x + 2.0)), log(x + 1.0));
}

class Machine {
 public:
  Machine(const Code& code, Names& names) : code_(code), names_(names) {}

  Array run(std::size_t from, std::size_t until) {
    for (std::size_t i = from; i < until; ++i) step(code_.steps[i]);
    assert(stack_.size() == 1);
    return std::move(stack_.back());
  }

 private:
  void step(const Step& s) {
    switch (s.kind) {
      case Step::Kind::number:
        stack_.emplace_back(s.number);
        return;
      case Step::Kind::name:
        stack_.push_back(names_.value(s.name));
        return;
      case Step::Kind::unary:
        stack_.back() = map(s.op, stack_.back());
        return;
      case Step::Kind::binary: {
        Array result = s.swap ? map(s.op, argument(s, 1), argument(s, 0)) : map(s.op, argument(s, 0), argument(s, 1));
        return give(s, s.negate ? map(Op::logical_not, result) : std::move(result));
      }
      case Step::Kind::ternary:
        return give(s, map(s.op, argument(s, 0), argument(s, 1), argument(s, 2)));
      case Step::Kind::join:
        return give(s, join(std::span(stack_).last(s.arguments), s.rows));
      case Step::Kind::function:
        return give(s, call(s));
    }
  }

  Array call(const Step& s) {
    const Array& a = argument(s, 0);
    switch (s.function) {
      case Function::extreme:
        return extreme(s);
      case Function::clamp:
        return map(Op::min, map(Op::max, a, argument(s, 1)), argument(s, 2));
      case Function::dot:
        return {dot(a, argument(s, 1))};
      case Function::sum:
        return {sum(a)};
      case Function::norm:
        return {a.is_scalar() ? abs(a[0]) : sqrt(dot(a, a))};
      case Function::mul:
        return matrix_product(a, argument(s, 1));
      case Function::transpose:
        return transpose(a);
      case Function::zeros:
        return Array(size_of(s));
      case Function::ones:
        return Array(size_of(s), 1.0);
      case Function::eye:
        return identity(size_of(s).rows);
      case Function::expm1:
        return expm1_of(a);
      case Function::log1p:
        return log1p_of(a);
    }
    return {};
  }

  Array extreme(const Step& s) {
    const Array& a = argument(s, 0);
    if (s.arguments == 1) return {s.op == Op::min ? least(a) : greatest(a)};
    Array result = a;
    for (std::uint32_t i = 1; i < s.arguments; ++i) result = map(s.op, result, argument(s, i));
    return result;
  }

  // zeros(n), zeros(n, m): sizes are known while compiling, whatever is being recorded.
  Shape size_of(const Step& s) {
    const auto index = static_cast<std::size_t>(&s - code_.steps.data());
    if (s.arguments == 1) return Shape::vector(whole(s.begin, index));
    const std::size_t second = code_.steps[index - 1].begin;
    return Shape::matrix(whole(s.begin, second), whole(second, index));
  }
  int whole(std::size_t from, std::size_t until) {
    return static_cast<int>(known_number(code_, from, until, names_).value_or(0));
  }

  const Array& argument(const Step& s, std::uint32_t i) const { return stack_[stack_.size() - s.arguments + i]; }
  void give(const Step& s, Array result) {
    stack_.resize(stack_.size() - s.arguments);
    stack_.push_back(std::move(result));
  }

  const Code& code_;
  Names& names_;
  std::vector<Array> stack_;
};

// Names whose values are those known while compiling.
class KnownNames final : public Names {
 public:
  explicit KnownNames(Names& names) : names_(names) {}
  Shape shape(std::uint32_t name) override { return names_.shape(name); }
  Array value(std::uint32_t name) override { return *names_.known(name); }
  const Array* known(std::uint32_t name) override { return names_.known(name); }

 private:
  Names& names_;
};

}  // namespace

Array evaluate(const Code& code, Names& names) {
  const Step& first = code.steps.front();
  if (code.steps.size() == 1) {
    if (first.kind == Step::Kind::number) return {first.number};
    if (first.kind == Step::Kind::name) return names.value(first.name);
  }
  return Machine(code, names).run(0, code.steps.size());
}

Array evaluate(const Code& code, std::size_t from, std::size_t until, Names& names) {
  return Machine(code, names).run(from, until);
}

namespace {

// The same function, but never zero.
Array with_sign_at_zero(const ConditionFunction& f) {
  constexpr double least = std::numeric_limits<double>::min();
  return map(Op::where, map(Op::equal, f.value, Array(0.0)), Array(f.at_zero * least), f.value);
}

// The condition that ends with step `last`. The depth of trees is limited by the parser.
ConditionFunction crossing_at(const Code& code, std::size_t last, Names& names) {
  const Step& s = code.steps[last];
  if (s.kind == Step::Kind::unary && s.op == Op::logical_not) {
    const ConditionFunction f = crossing_at(code, last - 1, names);
    return {-f.value, -f.at_zero};
  }
  if (s.kind == Step::Kind::binary && !s.negate) {
    const std::size_t second = code.steps[last - 1].begin;  // first step of the right operand
    if (s.op == Op::logical_and || s.op == Op::logical_or) {
      const ConditionFunction left = crossing_at(code, second - 1, names), right = crossing_at(code, last - 1, names);
      const Op op = s.op == Op::logical_and ? Op::min : Op::max;
      if (left.at_zero == right.at_zero) return {map(op, left.value, right.value), left.at_zero};
      return {map(op, with_sign_at_zero(left), with_sign_at_zero(right)), -1};
    }
    if (s.op == Op::less || s.op == Op::less_equal) {
      const Array left = evaluate(code, s.begin, second, names);
      const Array right = evaluate(code, second, last, names);
      return {s.swap ? left - right : right - left, s.op == Op::less_equal ? 1 : -1};
    }
  }
  return {evaluate(code, s.begin, last + 1, names), -1};
}

}  // namespace

ConditionFunction crossing_of(const Code& code, Names& names) {
  return crossing_at(code, code.steps.size() - 1, names);
}

std::optional<double> known_number(const Code& code, std::size_t from, std::size_t until, Names& names) {
  for (std::size_t i = from; i < until; ++i) {
    const Step& s = code.steps[i];
    if (s.kind == Step::Kind::name && !names.known(s.name)) return {};
  }
  KnownNames known(names);
  const Array value = Machine(code, known).run(from, until);
  if (value.size() != 1 || !value.all_known()) return {};
  return value[0].number();
}

Array element_of(const Array& array, int first, int last, int column) {
  if (column > 0) return {array(first - 1, column - 1)};
  if (last == 0) return {array[first - 1]};
  std::vector<Value> values;
  for (int i = first; i <= last; ++i) values.push_back(array[i - 1]);
  return Array::vector(std::move(values));
}

}  // namespace plantloop
