// A Gaussian process from a model file.

#include <memory>
#include <vector>

#include "learned/map_block.h"

namespace plantloop {
namespace {

struct GaussianProcess final : MapBlock {
  GaussianProcess() : MapBlock("gaussian_process") {}
  static constexpr auto summary = "Run a Gaussian process that was identified from data, with its variance.";
  static constexpr auto details =
      "y = k(x)' K^-1 (t - m) + m(x),  variance = k(x, x) - k(x)' K^-1 k(x): that of the function itself; a "
      "measurement adds the noise v0 of the model file. Derivatives of both are exact. A model with regressors of the "
      "past runs in the block narx.";
  static constexpr auto example = R"(
blocks:
  gp: {type: gaussian_process, model: models/gaussian_process.yaml, in: {x: 0.5}}
  deviation: sqrt(gp.variance)
simulation: {stop: 1}
record: [gp.y, deviation]
expect:
  - {signal: gp.y, at: 1, value: -0.3612, abs: 1e-4}
  - {signal: deviation, at: 1, value: 0.0557, abs: 1e-4}
)";

  Output variance{this, "variance", {.doc = "of each output, the function's without noise", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    MapBlock::sizes(sizing);
    if (const auto loaded = model_of(model)) sizing.set(variance, shape_of(loaded->map->outputs()));
  }
  void outputs(Now now, Out out) const override {
    const auto loaded = model_of(model);
    if (!loaded) return;
    const int count = loaded->map->outputs();
    const Array in = now[x].spread(shape_of(loaded->map->inputs()));
    std::vector<Value> values;
    for (int i = 0; i < in.size(); ++i) values.push_back(in[i]);
    const std::vector<Value> result = now.kernel(std::make_shared<MapKernel>(loaded->map, true), values);
    out[y] = array_of(result, 0, count);
    out[variance] = array_of(result, count, count);
  }
};

}  // namespace

PLANTLOOP_BLOCK(gaussian_process, GaussianProcess)

}  // namespace plantloop
