// A linear neuron that learns while the plant runs.
//
// B. Widrow and M. Hoff, Adaptive switching circuits, 1960 (book chapter 1); normalised: S. Haykin, Adaptive Filter
// Theory.

#include <fmt/format.h>

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct DeltaRule final : Block {
  static constexpr auto summary = "Learn the weights of a linear neuron from sample to sample, by the delta rule.";
  static constexpr auto details =
      "error = y - w' phi,  w+ = w + learning_rate error phi/(phi' phi + offset) when normalised, which converges for "
      "0 < learning_rate < 2, and w+ = w + learning_rate error phi when plain. The regressors phi may be any signals: "
      "delayed ones, or the outputs of fixed basis functions such as gaussian_weights, which makes it a radial basis "
      "function network that learns. While the error is within the dead_zone nothing is learned; lower and upper "
      "limit each weight. recursive_least_squares needs fewer samples and more arithmetic.";
  static constexpr auto example = R"(
title: A gain that is learned, by three quarters of its error at each sample
blocks:
  u: {type: sine, amplitude: 2}
  gain: {type: delta_rule, in: {y: 3*u, phi: u}, learning_rate: 0.75, offset: 0, rate: 0.1, initial: 1}
simulation: {stop: 1}
expect:
  - {signal: gain.w, at: 0.15, value: 1, abs: 1e-12}
  - {signal: gain.w, at: 0.25, value: 2.5, abs: 1e-12}
)";

  Input y{this, "y", {.doc = "what the neuron should give", .size = scalar}};
  Input phi{this, "phi", {.doc = "regressors, one for each weight", .size = any_size}};
  Number learning_rate{this, "learning_rate", {.init = 0.5, .doc = "how far a sample moves the weights", .above = 0}};
  Choice step{this, "step", {.of = {"normalised", "plain"}, .doc = "whether it is divided by the regressors' square"}};
  Number offset{this, "offset", {.init = 1e-6, .doc = "added to that square, for regressors near zero", .min = 0}};
  Number dead_zone{this, "dead_zone", {.init = 0, .doc = "errors up to this one teach nothing", .min = 0}};
  Limits limits{this, "least value of a weight", "greatest value of a weight"};
  Table initial_value{
      this,
      "initial",
      {.init = "0", .doc = "weights at the start, n numbers or one for all; may read signals", .initial = true}};
  Discrete weights{this, "weights", {.doc = "the weights", .size = any_size}};
  Output w{this, "w", {.doc = "the weights, before the present sample", .size = any_size}};
  Output fitted{this, "fitted", {.doc = "w' phi"}};
  Output error{this, "error", {.doc = "y - w' phi"}};

  void sizes(Sizing& sizing) const override {
    const Shape regressors = sizing.of(phi), start = sizing.of(initial_value);
    if (!regressors.is_known()) return;
    const int n = regressors.size();
    sizing.set(weights, Shape::vector(n));
    sizing.set(w, n == 1 ? Shape::scalar() : Shape::vector(n));
    if (start.is_known() && start.size() != 1 && start.size() != n)
      sizing.problem(initial_value, fmt::format("initial must have {} elements, one for each regressor, but it is {}",
                                                n, to_string(start)));
  }
  void check(Checking& checking) const override { limits.check(checking); }
  void initial(Now now, Init init) const override { init[weights] = limits.clamp(now, now[initial_value]); }
  void outputs(Now now, Out out) const override {
    const Value fit = dot(now[weights], row(now));
    out[w] = now[weights].size() == 1 ? now[weights].spread(Shape::scalar()) : now[weights];
    out[fitted] = fit;
    out[error] = now[y][0] - fit;
  }
  void update(Now now, Next next) const override {
    const Array phi_now = row(now), before = now[weights];
    const Value miss = now[y][0] - dot(before, phi_now);
    Array change = now[learning_rate] * (phi_now * miss);
    if (step.is("normalised")) {
      const Value square = dot(phi_now, phi_now) + now[offset][0];
      change = where(square > 0.0, change / square, 0.0 * change);
    }
    next[weights] = where(abs(miss) >= now[dead_zone][0], limits.clamp(now, before + change), before);
  }

 private:
  Array row(Now now) const { return now[phi].spread(Shape::vector(now[phi].size())); }
};

}  // namespace

PLANTLOOP_BLOCK(delta_rule, DeltaRule)

}  // namespace plantloop
