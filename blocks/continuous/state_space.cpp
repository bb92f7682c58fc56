// A linear system by its matrices.

#include "engine/block.h"
#include "engine/block_parts.h"

namespace plantloop {
namespace {

struct StateSpace final : Block {
  static constexpr auto summary = "Simulate a linear system given by matrices.";
  static constexpr auto details =
      "x' = A x + B u,  y = C x + D u.  B may be a vector where there is one input, C where there is one output. Where "
      "an entry of D is 0, that input does not reach that output at the same instant.";
  static constexpr auto icon = "x' = A x + B u; y = C x + D u";
  static constexpr auto example = R"(
blocks: {y: {type: state_space, in: 0, A: [[0, 1], [-4, 0]], B: [0, 1], C: [1, 0], initial: [1, 0]}}
simulation: {stop: 2}
expect: [{signal: y, at: pi/2, value: -1, abs: 1e-5}]
)";

  MatrixSystem<State> system{this};

  void sizes(Sizing& sizing) const override { system.sizes(sizing); }
  void initial(Now now, Init init) const override { system.initial(now, init); }
  void outputs(Now now, Out out) const override { system.outputs(now, out); }
  void derivatives(Now now, Rates rate) const override { rate[system.x] = system.change(now); }
};

}  // namespace

PLANTLOOP_BLOCK(state_space, StateSpace)

}  // namespace plantloop
