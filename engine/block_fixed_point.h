// Whole numbers of a limited number of bits, as converters and fixed-point arithmetic use them. They are doubles that
// hold integers, exact as long as everything stays below 2^53; the blocks that use them limit their word lengths so.

#pragma once

#include <cmath>

#include "engine/block.h"

namespace plantloop {

// The parameters `rounding` and `overflow`, and what they do.
struct IntegerRules {
  explicit IntegerRules(Block* block)
      : rounding(block, "rounding",
                 {.of = {"nearest", "floor", "zero"},
                  .doc = "to the nearest whole number, halves away from zero; downwards, as a shift of bits does; or "
                         "towards zero"}),
        overflow(block, "overflow",
                 {.of = {"saturate", "wrap"},
                  .doc = "what does not fit into a word: its greatest or least number, or the lowest bits"}) {}
  Choice rounding, overflow;

  Array whole(const Array& x) const {
    if (rounding.is("floor")) return floor(x);
    if (rounding.is("zero")) return trunc(x);
    return round(x);
  }
  // A whole number in a signed word of so many bits (two's complement).
  Array fit(const Array& code, int bits) const {
    const double half = std::ldexp(1.0, bits - 1);
    return fit(code, -half, half - 1);
  }
  // A whole number from `least` to `greatest`.
  Array fit(const Array& code, double least, double greatest) const {
    if (overflow.is("saturate")) return min(max(code, Array(least)), Array(greatest));
    return mod(code - least, Array(greatest - least + 1)) + least;
  }
};

}  // namespace plantloop
