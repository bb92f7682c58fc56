// Names, arities and values of the operations.

#include "engine/program/operations.h"

#include <array>
#include <cassert>

namespace plantloop {

namespace {

constexpr std::array names{"constant",
                           "parameter",
                           "time",
                           "state",
                           "discrete",
                           "mode",
                           "segment",
                           "hit",
                           "step",
                           "implicit",
                           "wire",
                           "kernel",
                           "loop",
                           "kernel_output",
                           "unknown",
#define X(name, expression) #name,
                           PLANTLOOP_UNARY_OPERATIONS(X) PLANTLOOP_BINARY_OPERATIONS(X) PLANTLOOP_TERNARY_OPERATIONS(X)
#undef X
};

}  // namespace

const char* name_of(Op op) { return names.at(static_cast<std::size_t>(op)); }

int arity_of(Op op) {
  if (op < Op::kernel_output) return 0;
  if (op < Op::add) return 1;
  if (op < Op::where) return 2;
  return 3;
}

double apply(Op op, double a, double b, double c) {
  switch (op) {
#define X(name, expression) \
  case Op::name:            \
    return expression;
    PLANTLOOP_UNARY_OPERATIONS(X)
    PLANTLOOP_BINARY_OPERATIONS(X)
    PLANTLOOP_TERNARY_OPERATIONS(X)
#undef X
    default:
      assert(false && "a leaf has no value of its own");
      return 0;
  }
}

}  // namespace plantloop
