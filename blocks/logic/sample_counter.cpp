// The number of the sample.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct SampleCounter final : Block {
  static constexpr auto summary = "Count samples.";
  static constexpr auto details =
      "y[k] = lower + k, the number of the sample from 0; with `upper` it begins again at `lower` after `upper`: "
      "lower + k mod (upper - lower + 1)";
  static constexpr auto example = R"(
blocks: {phase: {type: sample_counter, upper: 2, rate: 0.1}}
simulation: {stop: 1}
expect: [{signal: phase, at: 0.5, value: 2}, {signal: phase, at: 0.6, value: 0}]
)";

  Number lower{this, "lower", {.init = 0, .doc = "first count"}};
  Number upper{this, "upper", {.doc = "last count; default: none", .optional = true}};
  Output y{this, "y", {.doc = "the count"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void check(Checking& checking) const override { check_order(checking, lower, upper, false); }
  void outputs(Now now, Out out) const override {
    if (!now.given(upper)) {
      out[y] = now[lower] + now.hit();
    } else {
      out[y] = now[lower] + mod(Array(now.hit()), now[upper] - now[lower] + 1.0);
    }
  }
};

}  // namespace

PLANTLOOP_BLOCK(sample_counter, SampleCounter)

}  // namespace plantloop
