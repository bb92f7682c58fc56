// Shapes of expressions, with findings where they do not fit.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/numbers.h"
#include "engine/graph/evaluate.h"

namespace plantloop {
namespace {

constexpr int largest_size = 1000000;

class ShapeMachine {
 public:
  ShapeMachine(const Code& code, Names& names, Findings* findings) : code_(code), names_(names), findings_(findings) {}

  Shape run() {
    for (const Step& s : code_.steps) step(s);
    return stack_.back();
  }

 private:
  void step(const Step& s) {
    switch (s.kind) {
      case Step::Kind::number:
        stack_.push_back(Shape::scalar());
        return;
      case Step::Kind::name:
        stack_.push_back(names_.shape(s.name));
        return;
      case Step::Kind::unary:
        return;
      case Step::Kind::binary:
      case Step::Kind::ternary:
        return give(s, elementwise(s));
      case Step::Kind::join:
        return give(s, s.rows ? matrix(s) : joined(s));
      case Step::Kind::function:
        return give(s, call(s));
    }
  }

  // The common shape of all operands: a scalar meets anything.
  Shape elementwise(const Step& s) {
    Shape common = Shape::scalar();
    bool unknown = false;
    for (std::uint32_t i = 0; i < s.arguments; ++i) {
      const Shape shape = argument(s, i);
      if (!shape.is_known()) {
        unknown = true;
      } else if (common.is_scalar()) {
        common = shape;
      } else if (!shape.is_scalar() && shape != common) {
        return wrong(s, fmt::format("{} meets {} in '{}'", to_string(common), to_string(shape), s.node->text),
                     "element by element, both need one size, or one of them is a scalar");
      }
    }
    return unknown && common.is_scalar() ? Shape::unknown() : common;
  }

  Shape joined(const Step& s) {
    int size = 0;
    for (std::uint32_t i = 0; i < s.arguments; ++i) {
      const Shape shape = argument(s, i);
      if (!shape.is_known()) return shape;
      if (shape.rank == 2) {
        return wrong(s, fmt::format("{} stands in [ ]", to_string(shape)), "brackets join scalars and vectors");
      }
      size += shape.size();
    }
    return Shape::vector(size);
  }

  Shape matrix(const Step& s) {
    int columns = -1;
    for (std::uint32_t i = 0; i < s.arguments; ++i) {
      const Shape shape = argument(s, i);
      if (!shape.is_known()) return shape;
      if (shape.rank == 2)
        return wrong(s, fmt::format("{} stands in a row of a matrix", to_string(shape)),
                     "a row joins scalars and vectors");
      if (columns >= 0 && columns != shape.size()) {
        return wrong(
            s, fmt::format("row {} of this matrix has {} entries, the first one has {}", i + 1, shape.size(), columns));
      }
      columns = shape.size();
    }
    return Shape::matrix(static_cast<int>(s.arguments), columns);
  }

  Shape call(const Step& s) {
    const Shape a = argument(s, 0);
    const Shape b = s.arguments > 1 ? argument(s, 1) : Shape::scalar();
    switch (s.function) {
      case Function::extreme:
        if (s.arguments > 1) return elementwise(s);
        if (a.is_known() && a.size() == 0) return wrong(s, fmt::format("an empty vector has no {}", s.node->text));
        return Shape::scalar();
      case Function::clamp:
        return elementwise(s);
      case Function::dot:
        if (a.is_known() && b.is_known() && (a.size() != b.size() || a.rank == 2 || b.rank == 2)) {
          return wrong(s, fmt::format("dot needs two vectors of one size, got {} and {}", to_string(a), to_string(b)),
                       "the matrix product is mul(A, x)");
        }
        return Shape::scalar();
      case Function::sum:
      case Function::norm:
        return Shape::scalar();
      case Function::mul:
        return product(s, a, b);
      case Function::transpose:
        if (!a.is_known() || a.is_scalar()) return a;
        return Shape::matrix(a.columns, a.rows);
      case Function::zeros:
      case Function::ones:
      case Function::eye:
        return sized(s);
      case Function::expm1:
      case Function::log1p:
        return a;
    }
    return Shape::unknown();
  }

  Shape product(const Step& s, const Shape& a, const Shape& b) {
    // A matrix with several columns times anything that is not known yet: a vector, in all likelihood.
    if (a.rank == 2 && !b.is_known() && a.columns > 1) return one_if_single(Shape::vector(a.rows));
    if (!a.is_known() || !b.is_known()) return Shape::unknown();
    if (a.is_scalar()) return b;
    if (a.rank == 1 && b.rank == 2 && a.rows == b.rows) return one_if_single(Shape::vector(b.columns));
    if (a.rank == 1 && b.is_scalar()) return a;
    if (a.rank == 2 && a.columns == b.rows) {
      return one_if_single(b.rank == 2 ? Shape::matrix(a.rows, b.columns) : Shape::vector(a.rows));
    }
    if (a.rank == 1 && b.rank == 1) {
      return wrong(s, fmt::format("{} cannot be multiplied with {} as matrices", to_string(a), to_string(b)),
                   "the scalar product is dot(a, b); element by element it is a*b");
    }
    return wrong(s, fmt::format("{} cannot be multiplied with {}: {} columns meet {} rows", to_string(a), to_string(b),
                                a.rank == 1 ? a.rows : a.columns, b.rows));
  }

  Shape sized(const Step& s) {
    const auto index = static_cast<std::size_t>(&s - code_.steps.data());
    const std::size_t second = code_.steps[index - 1].begin;
    const int rows = whole(s, s.begin, s.arguments == 1 ? index : second);
    if (rows < 0) return Shape::unknown();
    if (s.function == Function::eye)
      return rows * static_cast<long>(rows) > largest_size ? too_large(s) : Shape::matrix(rows, rows);
    if (s.arguments == 1) return Shape::vector(rows);
    const int columns = whole(s, second, index);
    if (columns < 0) return Shape::unknown();
    return rows * static_cast<long>(columns) > largest_size ? too_large(s) : Shape::matrix(rows, columns);
  }

  int whole(const Step& s, std::size_t from, std::size_t until) {
    const std::optional<double> number = known_number(code_, from, until, names_);
    if (!number) {
      // Names that are wrong have been reported; a signal has not.
      for (std::size_t i = from; i < until; ++i) {
        const Step& part = code_.steps[i];
        if (part.kind == Step::Kind::name && names_.shape(part.name).is_known() && !names_.known(part.name)) {
          wrong(s, fmt::format("the size in {}() must be known before the run, '{}' is a signal", s.node->text,
                               to_string(*part.node)));
        }
      }
      return -1;
    }
    if (*number != std::floor(*number) || *number < 1 || *number > largest_size) {
      wrong(s, fmt::format("the size in {}() must be a whole number from 1 to {}, got {}", s.node->text, largest_size,
                           shortest(*number)));
      return -1;
    }
    return static_cast<int>(*number);
  }
  Shape too_large(const Step& s) {
    return wrong(s, fmt::format("a matrix in {}() may have up to {} entries", s.node->text, largest_size));
  }

  static Shape one_if_single(Shape shape) { return shape.size() == 1 ? Shape::scalar() : shape; }

  Shape wrong(const Step& s, const std::string& message, const char* hint = "") {
    if (findings_) {
      Finding& finding = findings_->error(s.node->mark, "{}", message).named("sizes");
      if (*hint) finding.hint(hint);
    }
    return Shape::unknown();
  }

  const Shape& argument(const Step& s, std::uint32_t i) const { return stack_[stack_.size() - s.arguments + i]; }
  void give(const Step& s, Shape result) {
    stack_.resize(stack_.size() - s.arguments);
    stack_.push_back(result);
  }

  const Code& code_;
  Names& names_;
  Findings* findings_;
  std::vector<Shape> stack_;
};

}  // namespace

Shape shape_of(const Code& code, Names& names, Findings* findings) {
  const Step& first = code.steps.front();
  if (code.steps.size() == 1) {
    if (first.kind == Step::Kind::number) return Shape::scalar();
    if (first.kind == Step::Kind::name) return names.shape(first.name);
  }
  return ShapeMachine(code, names, findings).run();
}

}  // namespace plantloop
