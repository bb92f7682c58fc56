// The weighted sum of local models' outputs.

#include <fmt/format.h>
#include <vector>

#include "engine/block.h"

namespace plantloop {
namespace {

struct Blend final : Block {
  static constexpr auto summary = "Blend signals by weights.";
  static constexpr auto details =
      "y = weights_1 values_1 + ... + weights_n values_n.  values is [a, b, ...], or a matrix with one row for each "
      "weight; entries may be vectors of one size, and then y is such a vector.  in: {weights: mu, values: [a, b, c]}";
  static constexpr auto example = R"(
blocks:
  mu: {type: triangular_weights, in: time, centres: [0, 1]}
  y: {type: blend, in: {weights: mu, values: [10, 20]}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.25, value: 12.5, abs: 1e-9}]
)";

  Input weights{this, "weights", {.doc = "the weights, as of gaussian_weights", .size = any_size}};
  Input values{this, "values", {.doc = "one scalar or vector for each weight", .size = any_size}};
  Output y{this, "y", {.doc = "the blended signal", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    const Shape w = sizing.of(weights), v = sizing.of(values);
    if (!w.is_known() || !v.is_known()) return;
    const int width = v.size() / w.size();
    if (width * w.size() != v.size() || (v.rank == 2 && v.rows != w.size())) {
      return sizing.problem(values,
                            fmt::format("{} weights cannot be spread over values that are {}", w.size(), to_string(v)));
    }
    sizing.set(y, width == 1 ? Shape::scalar() : Shape::vector(width));
  }

  void outputs(Now now, Out out) const override {
    const Array w = now[weights], v = now[values];
    const int n = w.size(), width = v.size() / n;
    Array result(width == 1 ? Shape::scalar() : Shape::vector(width));
    for (int k = 0; k < width; ++k) {
      std::vector<Value> terms;
      for (int i = 0; i < n; ++i) terms.push_back(w[i] * v[i * width + k]);
      result[k] = sum(terms);
    }
    out[y] = result;
  }
};

}  // namespace

PLANTLOOP_BLOCK(blend, Blend)

}  // namespace plantloop
