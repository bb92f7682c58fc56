// An analogue-to-digital converter.

#include "engine/block.h"
#include "engine/block_fixed_point.h"

namespace plantloop {
namespace {

struct Adc final : Block {
  static constexpr auto summary = "Read a signal through an analogue-to-digital converter.";
  static constexpr auto details =
      "code = rounding((u - lower)/step) between 0 and 2^bits - 1,  y = lower + step code.  span ends: the last code "
      "stands for `upper`, step = (upper - lower)/(2^bits - 1), as controllers scale their inputs; span steps: step = "
      "(upper - lower)/2^bits, as converters are made.  A signal outside the range reads as its end.  To read it at "
      "instants that differ from the hits, delay it by a variable_delay: "
      "diagrams/parts/programmable_controller.yaml.";
  static constexpr auto example = R"(
title: A converter of 4 bits from 0 to 3
blocks: {read: {type: adc, in: time, bits: 4, lower: 0, upper: 3, rate: 0.25}}
simulation: {stop: 4}
expect:
  - {signal: read.code, at: 0.5, value: 3}
  - {signal: read.y, at: 0.5, value: 0.6, abs: 1e-12}
  - {signal: read.y, at: 4, value: 3, abs: 1e-12}
)";

  Input u{this, "u", {.doc = "the signal, in its own unit"}};
  ConverterRange range{this};
  Choice rounding{this, "rounding", {.of = {"nearest", "floor"}, .doc = "to the nearest code, or to the one below"}};
  Output y{this, "y", {.doc = "what was read, in the unit of the signal"}};
  Output code{this, "code", {.doc = "the code, a whole number"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void check(Checking& checking) const override { range.check(checking); }
  void outputs(Now now, Out out) const override {
    const Array steps = range.steps_to(now, now[u]);
    const Array whole = range.clip(rounding.is("floor") ? floor(steps) : round(steps));
    out[code] = whole;
    out[y] = range.value_of(now, whole);
  }
};

}  // namespace

PLANTLOOP_BLOCK(adc, Adc)

}  // namespace plantloop
