// The operations that a Program is made of: one line each gives name, arity and meaning.

#pragma once

#include <cmath>
#include <cstdint>

namespace plantloop {

// `mod` with the sign of the divisor, as in the diagram file: mod(-1, 3) = 2.
inline double floored_mod(double a, double b) {
  const double r = std::fmod(a, b);
  return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}
inline double sign_of(double a) { return a > 0 ? 1.0 : a < 0 ? -1.0 : a; }  // a NaN stays one

// PLANTLOOP_UNARY(X) X(name, expression in a); conditions are 0 and 1.
#define PLANTLOOP_UNARY_OPERATIONS(X) \
  X(copy, a)                          \
  X(neg, -a)                          \
  X(abs, std::fabs(a))                \
  X(sqrt, std::sqrt(a))               \
  X(cbrt, std::cbrt(a))               \
  X(exp, std::exp(a))                 \
  X(log, std::log(a))                 \
  X(log2, std::log2(a))               \
  X(log10, std::log10(a))             \
  X(sin, std::sin(a))                 \
  X(cos, std::cos(a))                 \
  X(tan, std::tan(a))                 \
  X(asin, std::asin(a))               \
  X(acos, std::acos(a))               \
  X(atan, std::atan(a))               \
  X(sinh, std::sinh(a))               \
  X(cosh, std::cosh(a))               \
  X(tanh, std::tanh(a))               \
  X(asinh, std::asinh(a))             \
  X(acosh, std::acosh(a))             \
  X(atanh, std::atanh(a))             \
  X(erf, std::erf(a))                 \
  X(floor, std::floor(a))             \
  X(ceil, std::ceil(a))               \
  X(round, std::round(a))             \
  X(trunc, std::trunc(a))             \
  X(sign, sign_of(a))                 \
  X(logical_not, a == 0 ? 1.0 : 0.0)

#define PLANTLOOP_BINARY_OPERATIONS(X)         \
  X(add, a + b)                                \
  X(sub, a - b)                                \
  X(mul, a* b)                                 \
  X(div, a / b)                                \
  X(pow, std::pow(a, b))                       \
  X(atan2, std::atan2(a, b))                   \
  X(hypot, std::hypot(a, b))                   \
  X(mod, floored_mod(a, b))                    \
  X(min, b < a || b != b ? b : a)              \
  X(max, b > a || b != b ? b : a)              \
  X(less, a < b ? 1.0 : 0.0)                   \
  X(less_equal, a <= b ? 1.0 : 0.0)            \
  X(equal, a == b ? 1.0 : 0.0)                 \
  X(logical_and, a != 0 && b != 0 ? 1.0 : 0.0) \
  X(logical_or, a != 0 || b != 0 ? 1.0 : 0.0)

// The last four exist only after fusing: both roundings are kept.
#define PLANTLOOP_TERNARY_OPERATIONS(X) \
  X(where, a != 0 ? b : c)              \
  X(mul_add, a* b + c)                  \
  X(mul_sub, a* b - c)                  \
  X(sub_mul, c - a * b)                 \
  X(sub_scale, (a - b) * c)             \
  X(add_scale, (a + b) * c)

// Leaves have no operand that is a node; `a` is an index.
enum class Op : std::uint8_t {
  constant,       // a: index into the constants
  parameter,      // a: index of a tunable number
  time,           // the simulated time in s
  state,          // a: index of a continuous state
  discrete,       // a: index of a discrete state (read through a copy at its rate)
  mode,           // a: index of a mode; changes only at events
  segment,        // a: index of a schedule: how many of its instants have passed
  hit,            // a: index of a rate: number k of its latest hit
  step,           // the step size of a fixed-step method, in s
  implicit,       // a: index of a declared unknown, in a record only
  wire,           // a: index of a forward reference, bound before sorting
  kernel,         // a: index of a use of a kernel
  loop,           // a: index of a loop: finds the values of its unknowns
  kernel_output,  // a: the kernel node, b: number of the output
  unknown,        // a: the loop, b: number of the unknown
#define X(name, expression) name,
  PLANTLOOP_UNARY_OPERATIONS(X) PLANTLOOP_BINARY_OPERATIONS(X) PLANTLOOP_TERNARY_OPERATIONS(X)
#undef X
};

const char* name_of(Op op);
// Number of operands that are nodes: 0 for leaves, and for `kernel` and `loop` (their operands stand beside the graph).
int arity_of(Op op);
inline bool is_leaf(Op op) { return op <= Op::wire; }
// Read lists of operands from beside the graph, and give several results.
inline bool is_compound(Op op) { return op == Op::kernel || op == Op::loop; }
// One of the results of a compound operation.
inline bool is_result(Op op) { return op == Op::kernel_output || op == Op::unknown; }
// The value of an operation on numbers; leaves and kernels are not allowed.
double apply(Op op, double a, double b, double c);

}  // namespace plantloop
