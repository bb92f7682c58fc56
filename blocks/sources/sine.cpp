// A sine wave.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Sine final : Block {
  static constexpr auto summary = "Give a sine wave.";
  static constexpr auto details = "y = bias + amplitude sin(frequency time + phase)";
  static constexpr auto example = R"(
blocks: {u: {type: sine, amplitude: 2, frequency: 2*pi}}
simulation: {stop: 1}
expect: [{signal: u, at: 0.25, value: 2, abs: 1e-12}]
)";

  Number amplitude{this, "amplitude", {.init = 1, .doc = "greatest distance from the bias"}};
  Number frequency{this, "frequency", {.init = 1, .unit = "rad/s", .doc = "angular frequency; 2*pi*f for f in Hz"}};
  Number phase{this, "phase", {.init = 0, .unit = "rad", .doc = "angle at time 0; pi/2 makes a cosine"}};
  Number bias{this, "bias", {.init = 0, .doc = "mean value"}};
  Output y{this, "y", {.doc = "the wave"}};

  void outputs(Now now, Out out) const override {
    out[y] = now[bias] + now[amplitude] * sin(now[frequency] * now.time() + now[phase]);
  }
};

}  // namespace

PLANTLOOP_BLOCK(sine, Sine)

}  // namespace plantloop
