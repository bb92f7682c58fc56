// Gaussian weights of local models, which sum to one.

#include <fmt/format.h>

#include "engine/block.h"

namespace plantloop {
namespace {

struct GaussianWeights final : Block {
  static constexpr auto summary = "Weigh local models by Gaussian functions of a signal, normalised to sum 1.";
  static constexpr auto details =
      "w_i = exp(-(u - centres_i)^2/(2 widths_i^2)), mu_i = w_i/(w_1 + ... + w_n).  Far away from all centres the "
      "nearest one (in its own widths) gets all the weight.";
  static constexpr auto example = R"(
blocks: {mu: {type: gaussian_weights, in: time, centres: [0, 2], widths: 0.5}}
simulation: {stop: 2}
expect: [{signal: mu.1, at: 1, value: 0.5, abs: 1e-9}]
)";

  Input u{this, "u", {.doc = "signal that decides, the scheduling variable", .size = scalar}};
  Table centres{this, "centres", {.doc = "where each weight is centred"}};
  Table widths{this, "widths", {.doc = "standard deviation of each, or one for all", .above = 0}};
  Output mu{this, "mu", {.doc = "the weights", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    const Shape c = sizing.of(centres), w = sizing.of(widths);
    if (!c.is_known()) return;
    sizing.set(mu, Shape::vector(c.size()));
    if (!w.is_known() || w.size() == 1 || w.size() == c.size()) return;
    sizing.problem(widths,
                   fmt::format("{} centres need as many widths, or one for all, but there are {}", c.size(), w.size()));
  }

  void outputs(Now now, Out out) const override {
    const Shape shape = Shape::vector(now[centres].size());
    const Array width = now[widths].size() == 1 ? Array(now[widths][0]) : now[widths].spread(shape);
    const Array distance = (now[u] - now[centres].spread(shape)) / width;
    const Array exponent = -0.5 * distance * distance;
    // Relative to the greatest one, so that at least one of them is 1. Which one is greatest does not show in the
    // result.
    const NoEvents no_events;
    const Array w = exp(exponent - greatest(exponent));
    out[mu] = w / sum(w);
  }
};

}  // namespace

PLANTLOOP_BLOCK(gaussian_weights, GaussianWeights)

}  // namespace plantloop
