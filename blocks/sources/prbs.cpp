// A pseudo-random binary sequence from a shift register.

#include "engine/block.h"
#include "identify/data/prbs_taps.h"

namespace plantloop {
namespace {

struct Prbs final : Block {
  static constexpr auto summary = "Give a pseudo-random binary sequence of the greatest length.";
  static constexpr auto details =
      "A register of `bits` ones is shifted every `hold` samples; y = bias + amplitude where its last bit is 1, else "
      "bias - amplitude. The first bit gets the exclusive or of some others, so that the sequence repeats after 2^bits "
      "- 1 levels (for 7 bits: of bits 7 and 6). The mean over a period is bias + amplitude/(2^bits - 1).";
  static constexpr auto example = R"(
blocks: {u: {type: prbs, bits: 3, amplitude: 2, rate: 1}}
simulation: {stop: 20}
expect: [{signal: u, at: 0, value: 2}, {signal: u, at: 7, value: 2}]
)";

  Count bits{
      this,
      "bits",
      {.init = 7, .doc = "length of the register", .min = identify::fewest_prbs_bits, .max = identify::most_prbs_bits}};
  Count hold{this, "hold", {.init = 1, .doc = "samples that each level lasts", .min = 1}};
  Number amplitude{this, "amplitude", {.init = 1, .doc = "distance of both levels from the bias", .size = scalar}};
  Number bias{this, "bias", {.init = 0, .doc = "middle of both levels", .size = scalar}};
  Discrete reg{this, "register", {.init = 1, .doc = "the bits, 0 or 1", .size = bits}};
  Discrete age{this, "age", {.init = 0, .doc = "samples since the last shift", .size = scalar}};
  Output y{this, "y", {.doc = "the sequence", .size = scalar}};

  void outputs(Now now, Out out) const override {
    const Value last = now[reg][bits.value() - 1];
    out[y] = now[bias] + where(last > 0.5, now[amplitude], -now[amplitude]);
  }

  void update(Now now, Next next) const override {
    const Array r = now[reg];
    Value parity = 0;
    for (const int tap : identify::prbs_taps(bits.value())) {
      if (tap > 0) parity = parity + r[tap - 1];
    }
    Array shifted = r;
    shifted[0] = mod(parity, Value(2));
    for (int i = 1; i < r.size(); ++i) shifted[i] = r[i - 1];
    const Truths full = now[age] >= hold.value() - 1.0;
    next[age] = where(full, 0.0, now[age] + 1.0);
    next[reg] = where(full[0], shifted, r);
  }
};

}  // namespace

PLANTLOOP_BLOCK(prbs, Prbs)

}  // namespace plantloop
