// Whole numbers of a limited number of bits, as converters and fixed-point arithmetic use them. They are doubles that
// hold integers, exact as long as everything stays below 2^53; the blocks that use them limit their word lengths so.

#pragma once

#include <cmath>

#include "engine/block.h"
#include "engine/block_algebra.h"

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

// The range of a converter, in the unit of its signal, and the codes 0 to 2^bits - 1 that fill it.
struct ConverterRange {
  explicit ConverterRange(Block* block)
      : bits(block, "bits", {.init = 12, .doc = "length of the code", .min = 1, .max = 32}),
        lower(block, "lower", {.init = 0, .doc = "what the code 0 stands for"}),
        upper(block, "upper", {.init = 1, .doc = "the upper end of the range"}),
        span(block, "span", {.of = {"ends", "steps"}, .doc = "whether 2^bits - 1 or 2^bits steps fill the range"}) {}
  Count bits;
  Number lower, upper;
  Choice span;

  void check(Checking& checking) const { check_order(checking, lower, upper, true); }
  double last() const { return std::ldexp(1.0, bits.value()) - 1; }
  Array step(Now now) const { return (now[upper] - now[lower]) / (span.is("ends") ? last() : last() + 1); }
  // How many steps a signal is above the lower end; and the signal of a code.
  Array steps_to(Now now, const Array& u) const { return (u - now[lower]) / step(now); }
  Array value_of(Now now, const Array& code) const { return now[lower] + step(now) * code; }
  Array clip(const Array& code) const { return min(max(code, Array(0.0)), Array(last())); }
};

}  // namespace plantloop
