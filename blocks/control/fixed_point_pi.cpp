// A PI controller in integer arithmetic.

#include <fmt/format.h>

#include <cmath>

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/block_fixed_point.h"

namespace plantloop {
namespace {

struct FixedPointPi final : Block {
  static constexpr auto summary = "Control samples by a PI controller in the integer arithmetic of a small processor.";
  static constexpr auto details =
      "With the period T and the words e = [e 2^f], K = [kp 2^g], L = [ki T 2^g] of word_length bits (f = "
      "fraction_length, g = gain_fraction):  sum = I + K e in accumulator_length bits,  u = [sum 2^-g] in word_length "
      "bits and between the limits,  I+ = I + L e in accumulator_length bits.  [] rounds as `rounding` says; what does "
      "not fit saturates or wraps.  anti_windup clamp keeps I within the limits; none does nothing.  The integral is "
      "forward Euler's, as in discrete_pid.  Everything is a whole number, so the codes are those of any "
      "processor.";
  static constexpr auto example = R"(
title: Words of 16 bits with 8 behind the point
blocks:
  c: {type: fixed_point_pi, in: 0.5, kp: 2, ki: 1, fraction_length: 8, gain_fraction: 8, upper: 1.25, rate: 0.125}
simulation: {stop: 2}
expect:
  - {signal: c.u, at: 0, value: 1}
  - {signal: c.u, at: 0.125, value: 1.0625}
  - {signal: c.code, at: 2, value: 320}
)";

  Input e{this, "e", {.doc = "control error, set point minus measured value"}};
  Input kp{this, "kp", {.doc = "proportional gain", .init = 1}};
  Input ki{this, "ki", {.doc = "integral gain, per second", .init = 1}};
  Count word_length{this, "word_length", {.init = 16, .doc = "bits of error, gains and output", .min = 2, .max = 26}};
  Count fraction_length{this,
                        "fraction_length",
                        {.init = 12, .doc = "bits behind the point, of error and output", .min = -30, .max = 50}};
  Count gain_fraction{this, "gain_fraction", {.init = 12, .doc = "bits behind the point, of both gains", .max = 50}};
  Count accumulator_length{
      this, "accumulator_length", {.init = 32, .doc = "bits of the integral and of the sum", .min = 4, .max = 52}};
  IntegerRules rules{this};
  Choice anti_windup{
      this, "anti_windup", {.of = {"clamp", "none"}, .doc = "whether the integral stays within the limits"}};
  Limits limits{this, "least value of the output", "greatest value of the output"};
  Number initial_value{this, "initial", {.init = 0, .doc = "integral at the start; may read signals", .initial = true}};
  Discrete x{this, "I", {.doc = "integral, a whole number with both fractions behind the point"}};
  Output u{this, "u", {.doc = "the output"}};
  Output code{this, "code", {.doc = "its word, a whole number"}};
  Output integral{this, "integral", {.doc = "its integral part"}};

  void check(Checking& checking) const override {
    limits.check(checking);
    if (accumulator_length.value() < word_length.value())
      checking.problem(accumulator_length, fmt::format("the accumulator has {} bits, fewer than a word's {}",
                                                       accumulator_length.value(), word_length.value()));
  }
  void initial(Now now, Init init) const override {
    init[x] = within(now, rules.fit(rules.whole(now[initial_value] * (one() * gain_one())), sum_bits()));
  }
  void outputs(Now now, Out out) const override {
    const Array sum = rules.fit(now[x] + word(now[kp] * gain_one()) * word(now[e] * one()), sum_bits());
    const Array short_sum = limited(now, word(sum * (1 / gain_one())), 1);
    out[code] = short_sum;
    out[u] = short_sum * (1 / one());
    out[integral] = now[x] * (1 / (one() * gain_one()));
  }
  void update(Now now, Next next) const override {
    const Array gain = word(now[ki] * now.period() * gain_one());
    next[x] = within(now, rules.fit(now[x] + gain * word(now[e] * one()), sum_bits()));
  }

 private:
  // What 1 is as a word, and as a gain.
  double one() const { return std::ldexp(1.0, fraction_length.value()); }
  double gain_one() const { return std::ldexp(1.0, gain_fraction.value()); }
  int sum_bits() const { return accumulator_length.value(); }
  Array word(const Array& scaled) const { return rules.fit(rules.whole(scaled), word_length.value()); }
  // A word between the limits, which are words themselves; `scale` times that for the accumulator.
  Array limited(Now now, Array code_, double scale) const {
    if (now.given(limits.lower)) code_ = max(code_, scale * word(now[limits.lower] * one()));
    if (now.given(limits.upper)) code_ = min(code_, scale * word(now[limits.upper] * one()));
    return code_;
  }
  Array within(Now now, const Array& sum) const {
    return anti_windup.is("clamp") ? limited(now, sum, gain_one()) : sum;
  }
};

}  // namespace

PLANTLOOP_BLOCK(fixed_point_pi, FixedPointPi)

}  // namespace plantloop
