// A nonlinear system as a blend of linear models in velocity form.

#include <fmt/format.h>

#include "engine/block_algebra.h"
#include "learned/map_block.h"
#include "learned/velocity_block.h"

namespace plantloop {
namespace {

struct VelocityBlend final : VelocityBlock {
  static constexpr auto summary = "Simulate a nonlinear system by blended linear models in velocity form.";
  static constexpr auto details =
      "ud = N (u - uf), uf' = ud;  w' = A w + B ud,  y' = C w + D ud, where each matrix is the sum of those of the "
      "file's "
      "points by the weights, which are divided by their sum. Since the models are of derivatives, none has an affine "
      "part, and between the points no wrong rest appears. The file has one model for each value of a scheduling "
      "variable; the weights, as gaussian_weights or triangular_weights give them, are in its order.";
  static constexpr auto example = R"(
blocks:
  u: {type: step, time: 1, before: 0, after: 2}
  mu: {type: triangular_weights, in: plant, centres: [0, 2]}
  plant: {type: velocity_blend, model: models/velocity_blend.yaml, in: {u: u, weights: mu}}
simulation: {stop: 10}
record: [u, plant]
expect:   # y'' = -(1 + y/2) y' behind a step that makes y' = 2: it rests where y + y^2/4 = 2
  - {signal: plant, measure: final, value: 2*(sqrt(3) - 1), abs: 0.01}
)";

  Input mu{this, "weights", {.doc = "weight of each point, not all 0", .size = any_size}};
  Output y{this, "y", {.doc = "outputs of the blended model", .size = any_size}};

  void check(Checking& checking) const override { checked(checking); }
  void sizes(Sizing& sizing) const override {
    set_sizes(sizing, y);
    const auto f = family();
    const Shape given = sizing.of(mu);
    if (!f || !given.is_known() || given.size() == static_cast<int>(f->points.size())) return;
    sizing.problem(mu, fmt::format("the file has {} points, but there are {} weights", f->points.size(), given.size()));
  }
  void outputs(Now now, Out out) const override { out[y] = now[integral]; }

 protected:
  std::vector<Value> weights(Now now, const identify::VelocityFamily& f) const override {
    const Array given = now[mu];
    const Value whole = sum(given);
    std::vector<Value> result;
    for (int i = 0; i < static_cast<int>(f.points.size()); ++i) result.push_back(given[i] / whole);
    return result;
  }
};

}  // namespace

PLANTLOOP_BLOCK(velocity_blend, VelocityBlend)

}  // namespace plantloop
