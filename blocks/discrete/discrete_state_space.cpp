// A sampled linear system by its matrices.

#include "engine/block.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct DiscreteStateSpace final : Block {
  static constexpr auto summary = "Simulate a sampled linear system given by matrices.";
  static constexpr auto details =
      "x[k+1] = A x[k] + B u[k],  y[k] = C x[k] + D u[k].  B may be a vector where there is one input, C where there "
      "is one output. Where an entry of D is 0, that input does not reach that output at the same instant.";
  static constexpr auto icon = "x⁺ = A x + B u; y = C x + D u";
  static constexpr auto example = R"(
blocks: {y: {type: discrete_state_space, in: 1, A: 0.5, B: 1, C: 1, rate: 1}}
simulation: {stop: 4}
expect: [{signal: y, at: 3, value: 1.75}]
)";

  MatrixSystem<Discrete> system{this};

  void sizes(Sizing& sizing) const override { system.sizes(sizing); }
  void initial(Now now, Init init) const override { system.initial(now, init); }
  void outputs(Now now, Out out) const override { system.outputs(now, out); }
  void update(Now now, Next next) const override { next[system.x] = system.change(now); }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_state_space, DiscreteStateSpace)

}  // namespace plantloop
