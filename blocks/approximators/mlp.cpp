// A multilayer perceptron from a model file.

#include "learned/map_block.h"

namespace plantloop {
namespace {

struct Mlp final : MapBlock {
  Mlp() : MapBlock("mlp") {}
  static constexpr auto summary = "Run a multilayer perceptron that was identified from data.";
  static constexpr auto details =
      "y = f(x), layer by layer h = activation(W [h; 1]), with the normalisation of the model file. Derivatives are "
      "exact. A model with regressors of the past runs in the block narx, which keeps them.";
  static constexpr auto example = R"(
blocks:
  net: {type: mlp, model: models/mlp.yaml, in: {x: "[0.5, -0.6]"}}
simulation: {stop: 1}
record: [net]
expect: [{signal: net, at: 1, value: 0.3590354863, abs: 1e-9}]
)";
};

}  // namespace

PLANTLOOP_BLOCK(mlp, Mlp)

}  // namespace plantloop
