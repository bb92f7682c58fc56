// A number in a word of few bits.

#include <cmath>

#include "engine/block.h"
#include "engine/block_fixed_point.h"

namespace plantloop {
namespace {

struct FixedPoint final : Block {
  static constexpr auto summary = "Round a signal to a fixed-point number.";
  static constexpr auto details =
      "code = rounding(u 2^fraction_length) in a word of word_length bits,  y = code 2^-fraction_length.  A signed "
      "word "
      "holds -2^(word_length-1) to 2^(word_length-1) - 1 (two's complement), an unsigned one 0 to 2^word_length - 1.";
  static constexpr auto example = R"(
title: A byte with 4 bits behind the point, which saturates or wraps
blocks:
  kept: {type: fixed_point, in: time, word_length: 8, fraction_length: 4}
  wrapped: {type: fixed_point, in: time, word_length: 8, fraction_length: 4, overflow: wrap}
simulation: {stop: 10}
expect:
  - {signal: kept.y, at: 0.34, value: 0.3125}
  - {signal: kept.code, at: 10, value: 127}
  - {signal: wrapped.y, at: 10, value: -6}
)";

  Input u{this, "u", {.doc = "signal to round"}};
  Count word_length{this, "word_length", {.init = 16, .doc = "bits of the word", .min = 1, .max = 52}};
  Count fraction_length{
      this, "fraction_length", {.init = 8, .doc = "bits behind the binary point", .min = -100, .max = 100}};
  Choice sign{this, "sign", {.of = {"signed", "unsigned"}, .doc = "whether one bit is the sign"}};
  IntegerRules rules{this};
  Output y{this, "y", {.doc = "the rounded signal"}};
  Output code{this, "code", {.doc = "the whole number in the word"}};

  void outputs(Now now, Out out) const override {
    const Array whole = rules.whole(now[u] * std::ldexp(1.0, fraction_length.value()));
    const Array word = sign.is("signed") ? rules.fit(whole, word_length.value())
                                         : rules.fit(whole, 0, std::ldexp(1.0, word_length.value()) - 1);
    out[code] = word;
    out[y] = word * std::ldexp(1.0, -fraction_length.value());
  }
};

}  // namespace

PLANTLOOP_BLOCK(fixed_point, FixedPoint)

}  // namespace plantloop
