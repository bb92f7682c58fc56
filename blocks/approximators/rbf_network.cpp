// A network of radial basis functions from a model file.

#include "learned/map_block.h"

namespace plantloop {
namespace {

struct RbfNetwork final : MapBlock {
  RbfNetwork() : MapBlock("rbf_network") {}
  static constexpr auto summary = "Run a network of radial basis functions that was identified from data.";
  static constexpr auto details =
      "y = W [phi(|x - c_1|); ...; phi(|x - c_M|); 1] with the function phi, centres, widths and normalisation of the "
      "model file. Derivatives are exact. A model with regressors of the past runs in the block narx.";
  static constexpr auto example = R"(
blocks:
  bump: {type: rbf_network, model: models/rbf_network.yaml, in: {x: 1.5}}  # 2 exp(-(x - 1)^2/2) + 0.5
simulation: {stop: 1}
record: [bump]
expect: [{signal: bump, at: 1, value: 2*exp(-0.125) + 0.5, abs: 1e-12}]
)";
};

}  // namespace

PLANTLOOP_BLOCK(rbf_network, RbfNetwork)

}  // namespace plantloop
