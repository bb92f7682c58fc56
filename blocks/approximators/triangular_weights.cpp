// Triangular weights of local models, which sum to one.

#include "engine/block.h"

namespace plantloop {
namespace {

struct TriangularWeights final : Block {
  static constexpr auto summary = "Weigh local models by triangular functions of a signal, which sum to 1.";
  static constexpr auto details =
      "mu_i is 1 at centres_i and falls evenly to 0 at the centres beside it; beyond the first and last centre the "
      "weight of that one stays 1. Blending with these weights is interpolation by straight lines. The kinks are "
      "events.";
  static constexpr auto example = R"(
blocks: {mu: {type: triangular_weights, in: time, centres: [0, 1, 3]}}
simulation: {stop: 3}
expect: [{signal: mu.2, at: 2, value: 0.5, abs: 1e-9}]
)";

  Input u{this, "u", {.doc = "signal that decides, the scheduling variable", .size = scalar}};
  Table centres{this, "centres", {.doc = "where each weight is 1, ascending", .ascending = true}};
  Output mu{this, "mu", {.doc = "the weights", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    if (sizing.of(centres).is_known()) sizing.set(mu, Shape::vector(sizing.of(centres).size()));
  }

  void outputs(Now now, Out out) const override {
    const Array c = now[centres];
    const Value at = now[u][0];
    // Each weight rises along one ramp and falls along the next one.
    Array weights(Shape::vector(c.size()));
    Value risen = 1;
    for (int i = 0; i + 1 < c.size(); ++i) {
      const Value inside = (at - c[i]) / (c[i + 1] - c[i]);
      const Value ramp = where(at <= c[i], Value(0), where(at >= c[i + 1], Value(1), inside));
      weights[i] = risen - ramp;
      risen = ramp;
    }
    weights[c.size() - 1] = risen;
    out[mu] = weights;
  }
};

}  // namespace

PLANTLOOP_BLOCK(triangular_weights, TriangularWeights)

}  // namespace plantloop
