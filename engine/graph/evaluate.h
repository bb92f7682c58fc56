// The one evaluator of expressions: shapes, numbers and recorded operations.

#pragma once

#include <cstdint>
#include <optional>

#include "engine/graph/code.h"
#include "engine/graph/findings.h"
#include "engine/program/value.h"

namespace plantloop {

// What the names of a code are at one place of use.
class Names {
 public:
  virtual ~Names() = default;
  // May be unknown while sizes are being found.
  virtual Shape shape(std::uint32_t name) = 0;
  // The value that evaluation uses: a number, or operations that are being recorded.
  virtual Array value(std::uint32_t name) = 0;
  // The value known while compiling; null for a signal.
  virtual const Array* known(std::uint32_t name) = 0;
};

// The shape of an expression, unknown as long as it depends on unknown ones. With `findings`, reports what does not
// fit, and unknown is also what a wrong expression gives.
Shape shape_of(const Code& code, Names& names, Findings* findings);

// The value of an expression whose shapes fit.
Array evaluate(const Code& code, Names& names);

// The value of the subexpression of steps [from, until).
Array evaluate(const Code& code, std::size_t from, std::size_t until, Names& names);

// A function that is positive where the condition holds and negative where it does not, and crosses zero in between: of
// a comparison the difference of its sides, of a bare number the number itself. `at_zero` says whether the condition
// holds where the function is zero: 1 it does, -1 it does not.
struct ConditionFunction {
  Array value;
  int at_zero = -1;
};
ConditionFunction crossing_of(const Code& code, Names& names);

// The number that steps [from, until) give, if all of their names are known and it is one.
std::optional<double> known_number(const Code& code, std::size_t from, std::size_t until, Names& names);

// The elements `first`, `first..last` or (`first`, `column`) of an array; 0 is none.
Array element_of(const Array& array, int first, int last, int column);

}  // namespace plantloop
