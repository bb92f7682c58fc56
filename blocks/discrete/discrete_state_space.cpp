// A sampled linear system by its matrices.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct DiscreteStateSpace final : Block {
  static constexpr auto summary = "Simulate a sampled linear system given by matrices.";
  static constexpr auto details =
      "x[k+1] = A x[k] + B u[k],  y[k] = C x[k] + D u[k].  B may be a vector where there is one input, C where there "
      "is one "
      "output. Where an entry of D is 0, that input does not reach that output at the same instant.";
  static constexpr auto icon = "x⁺ = A x + B u; y = C x + D u";
  static constexpr auto example = R"(
blocks: {y: {type: discrete_state_space, in: 1, A: 0.5, B: 1, C: 1, rate: 1}}
simulation: {stop: 4}
expect: [{signal: y, at: 3, value: 1.75}]
)";

  Input u{this, "u", {.doc = "inputs", .size = any_size}};
  Table A{this, "A", {.doc = "n by n", .zeros_matter = true}};
  Table B{this, "B", {.doc = "n by the number of inputs", .zeros_matter = true}};
  Table C{this, "C", {.doc = "the number of outputs by n", .zeros_matter = true}};
  Table D{this,
          "D",
          {.doc = "the number of outputs by that of inputs; default: 0", .zeros_matter = true, .optional = true}};
  Table initial_value{
      this,
      "initial",
      {.init = "0", .doc = "states at the start, n numbers or one for all; may read signals", .initial = true}};
  Discrete x{this, "x", {.doc = "states", .size = any_size}};
  Output y{this, "y", {.doc = "outputs", .size = any_size}};

  void sizes(Sizing& sizing) const override { LinearSystem::sizes(sizing, {A, B, C, D, initial_value}, u, x, y); }
  void initial(Now now, Init init) const override { init[x] = now[initial_value]; }
  void outputs(Now now, Out out) const override { out[y] = system(now).output(now[x], now[u]); }
  void update(Now now, Next next) const override { next[x] = system(now).change(now[x], now[u]); }

 private:
  LinearSystem system(Now now) const {
    return {now[A], now[B], now[C], now.given(D) ? now[D] : Array(Shape::vector(0))};
  }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_state_space, DiscreteStateSpace)

}  // namespace plantloop
