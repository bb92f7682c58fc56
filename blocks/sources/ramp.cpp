// A signal that rises evenly from a given time on.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Ramp final : Block {
  static constexpr auto summary = "Rise evenly from a given time on.";
  static constexpr auto details = "y = initial until time start, then initial + slope (time - start)";
  static constexpr auto example = R"(
blocks: {u: {type: ramp, start: 1, slope: 2}}
simulation: {stop: 3}
expect: [{signal: u, at: 2, value: 2}]
)";

  Number start{this, "start", {.init = 0, .unit = "s", .doc = "when the ramp begins", .size = scalar}};
  Number slope{this, "slope", {.init = 1, .doc = "change per second"}};
  Number initial_value{this, "initial", {.init = 0, .doc = "value until the ramp begins"}};
  Output y{this, "y", {.doc = "the ramp"}};

  void outputs(Now now, Out out) const override {
    const Value begun = segment(now[start]);
    const Value elapsed = where(begun > 0.0, now.time() - now[start][0], Value(0));
    out[y] = now[initial_value] + now[slope] * elapsed;
  }
};

}  // namespace

PLANTLOOP_BLOCK(ramp, Ramp)

}  // namespace plantloop
