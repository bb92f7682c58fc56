// A sine wave whose frequency changes.

#include <fmt/format.h>
#include <algorithm>
#include <cstddef>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Chirp final : Block {
  static constexpr auto summary = "Give a sine wave whose frequency sweeps from one value to another.";
  static constexpr auto details =
      "y = bias + amplitude sin(phase + phi(time)).  The frequency w = phi' goes from `frequency` at time 0 to "
      "`final_frequency` at `final_time`, and on in the same way.  sweep linear: phi = w0 t + (w1 - w0) t^2/(2 T);  "
      "logarithmic: w = w0 (w1/w0)^(t/T), phi = T (w - w0)/log(w1/w0), with different frequencies greater than 0.";
  static constexpr auto example = R"(
blocks: {u: {type: chirp, frequency: 1, final_frequency: 5, final_time: 10}}
simulation: {stop: 10}
expect: [{signal: u, at: 10, value: sin(30), abs: 1e-12}]
)";

  Number amplitude{this, "amplitude", {.init = 1, .doc = "greatest distance from the bias"}};
  Number frequency{this, "frequency", {.init = 1, .unit = "rad/s", .doc = "angular frequency at time 0", .min = 0}};
  Number final_frequency{
      this, "final_frequency", {.init = 10, .unit = "rad/s", .doc = "angular frequency at final_time", .min = 0}};
  Number final_time{this,
                    "final_time",
                    {.init = 10, .unit = "s", .doc = "when final_frequency is reached", .above = 0, .size = scalar}};
  Choice sweep{this, "sweep", {.of = {"linear", "logarithmic"}, .doc = "how the frequency changes"}};
  Number phase{this, "phase", {.init = 0, .unit = "rad", .doc = "angle at time 0; pi/2 makes a cosine"}};
  Number bias{this, "bias", {.init = 0, .doc = "mean value"}};
  Output y{this, "y", {.doc = "the wave"}};

  void check(Checking& checking) const override {
    const auto first = checking.of(frequency), last = checking.of(final_frequency);
    if (!sweep.is("logarithmic") || first.empty() || last.empty()) return;
    for (std::size_t i = 0; i < std::max(first.size(), last.size()); ++i) {
      const double w0 = first[std::min(i, first.size() - 1)], w1 = last[std::min(i, last.size() - 1)];
      if (w0 > 0 && w1 > 0 && w0 != w1) continue;
      return checking.problem(w0 > 0 ? final_frequency : frequency,
                              fmt::format("a logarithmic sweep goes between two different frequencies greater than 0, "
                                          "but they are {:g} and {:g}",
                                          w0, w1));
    }
  }

  void outputs(Now now, Out out) const override {
    const Value t = now.time(), length = now[final_time][0];
    const Array w0 = now[frequency], w1 = now[final_frequency];
    Array angle = w0 * t + (w1 - w0) * (t * t / (2.0 * length));
    if (sweep.is("logarithmic")) {
      const Array rate = log(w1 / w0) / length;
      angle = w0 * (exp(rate * t) - 1.0) / rate;
    }
    out[y] = now[bias] + now[amplitude] * sin(now[phase] + angle);
  }
};

}  // namespace

PLANTLOOP_BLOCK(chirp, Chirp)

}  // namespace plantloop
