// A network of local models from a model file.

#include "learned/map_block.h"

namespace plantloop {
namespace {

struct LocalModelNetwork final : MapBlock {
  LocalModelNetwork() : MapBlock("local_model_network") {}
  static constexpr auto summary = "Run a network of local models that was identified from data.";
  static constexpr auto details =
      "y = mu_1 P_1 [x; 1] + ... + mu_M P_M [x; 1], normalised Gaussian weights mu of the scheduling variables among "
      "x. Derivatives are exact. A model with regressors of the past runs in the block narx.";
  static constexpr auto example = R"(
blocks:
  net: {type: local_model_network, model: models/local_model_network.yaml, in: {x: 0}}  # halfway between x and 2 x + 1
simulation: {stop: 1}
record: [net]
expect: [{signal: net, at: 1, value: 0.5, abs: 1e-12}]
)";
};

}  // namespace

PLANTLOOP_BLOCK(local_model_network, LocalModelNetwork)

}  // namespace plantloop
