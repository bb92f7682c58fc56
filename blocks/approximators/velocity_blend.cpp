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
      "variable; the weights, as gaussian_weights or triangular_weights give them, are in its order. The matrices of "
      "the "
      "input may follow weights of their own, where another variable decides about them.  Of a file with a sampling "
      "time "
      "Ts, w(t) = A w(t - Ts) + B ud(t - Ts), with the weights of then too: just before k Ts y is what the sampled "
      "system "
      "is at (k - 1) Ts (book equations 5.15 to 5.21).";
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
  Input input_mu{
      this, "input_weights", {.doc = "weight of each point in B and D; default: weights", .init = 0, .size = any_size}};
  Output y{this, "y", {.doc = "outputs of the blended model", .size = any_size}};
  Output filtered{this, "uf", {.doc = "the filtered inputs, on which weights may depend", .size = any_size}};

  void check(Checking& checking) const override { checked(checking); }
  void sizes(Sizing& sizing) const override {
    set_sizes(sizing, y, filtered);
    const auto f = family();
    if (!f) return;
    for (const Input* port : {&mu, &input_mu}) {
      const Shape given = sizing.of(*port);
      const bool may_be_default = port == &input_mu && given.is_scalar();
      if (!given.is_known() || may_be_default || given.size() == static_cast<int>(f->points.size())) continue;
      sizing.problem(*port,
                     fmt::format("the file has {} points, but there are {} weights", f->points.size(), given.size()));
    }
  }
  void outputs(Now now, Out out) const override {
    out[y] = now[integral];
    out[filtered] = now[uf];
  }

 protected:
  Weights weights(Now now, const identify::VelocityFamily& f) const override {
    const auto normalised = [&](const Array& given) {
      const Value whole = sum(given.spread(Shape::vector(static_cast<int>(f.points.size()))));
      std::vector<Value> result;
      for (int i = 0; i < static_cast<int>(f.points.size()); ++i) result.push_back(given.at(i) / whole);
      return result;
    };
    const std::vector<Value> of_states = normalised(now[mu]);
    return {of_states, now.connected(input_mu) ? normalised(now[input_mu]) : of_states};
  }
};

}  // namespace

PLANTLOOP_BLOCK(velocity_blend, VelocityBlend)

}  // namespace plantloop
