// A digital-to-analogue converter.

#include "engine/block.h"
#include "engine/block_fixed_point.h"

namespace plantloop {
namespace {

struct Dac final : Block {
  static constexpr auto summary = "Give a signal out through a digital-to-analogue converter.";
  static constexpr auto details =
      "y = lower + step code, held between the hits, with code between 0 and 2^bits - 1.  takes value: code = "
      "round((u - lower)/step); takes code: the input is the code.  span ends: step = (upper - lower)/(2^bits - 1), "
      "the "
      "last code gives `upper`; span steps: step = (upper - lower)/2^bits.  Behind a transport_delay the output "
      "changes that much later than the hit, as a computation takes its time: "
      "diagrams/parts/programmable_controller.yaml.";
  static constexpr auto example = R"(
title: Two bits from -1 to 2
blocks: {valve: {type: dac, in: 0.3*time, bits: 2, lower: -1, upper: 2, rate: 1}}
simulation: {stop: 10}
expect:
  - {signal: valve.y, at: 1, value: 0}
  - {signal: valve.y, at: 2, value: 1}
  - {signal: valve.y, at: 10, value: 2}
)";

  Input u{this, "u", {.doc = "what is to be given out"}};
  ConverterRange range{this};
  Choice takes{this, "takes", {.of = {"value", "code"}, .doc = "what the input is"}};
  Output y{this, "y", {.doc = "the signal"}};
  Output code{this, "code", {.doc = "the code, a whole number"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void check(Checking& checking) const override { range.check(checking); }
  void outputs(Now now, Out out) const override {
    const Array whole = range.clip(round(takes.is("code") ? now[u] : range.steps_to(now, now[u])));
    out[code] = whole;
    out[y] = range.value_of(now, whole);
  }
};

}  // namespace

PLANTLOOP_BLOCK(dac, Dac)

}  // namespace plantloop
