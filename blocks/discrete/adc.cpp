// An analogue-to-digital converter.

#include <cmath>

#include "engine/block.h"
#include "engine/block_algebra.h"

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
  Count bits{this, "bits", {.init = 12, .doc = "length of the code", .min = 1, .max = 32}};
  Number lower{this, "lower", {.init = 0, .doc = "what the code 0 stands for"}};
  Number upper{this, "upper", {.init = 1, .doc = "the upper end of the range"}};
  Choice span{this, "span", {.of = {"ends", "steps"}, .doc = "whether 2^bits - 1 or 2^bits steps fill the range"}};
  Choice rounding{this, "rounding", {.of = {"nearest", "floor"}, .doc = "to the nearest code, or to the one below"}};
  Output y{this, "y", {.doc = "what was read, in the unit of the signal"}};
  Output code{this, "code", {.doc = "the code, a whole number"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void check(Checking& checking) const override { check_order(checking, lower, upper, true); }
  void outputs(Now now, Out out) const override {
    const double last = std::ldexp(1.0, bits.value()) - 1;
    const Array step = (now[upper] - now[lower]) / (span.is("ends") ? last : last + 1);
    const Array steps = (now[u] - now[lower]) / step;
    const Array whole = rounding.is("floor") ? floor(steps) : round(steps);
    const Array clipped = min(max(whole, Array(0.0)), Array(last));
    out[code] = clipped;
    out[y] = now[lower] + step * clipped;
  }
};

}  // namespace

PLANTLOOP_BLOCK(adc, Adc)

}  // namespace plantloop
