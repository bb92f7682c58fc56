// A linear system by its matrices.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct StateSpace final : Block {
  static constexpr auto summary = "Simulate a linear system given by matrices.";
  static constexpr auto details =
      "x' = A x + B u,  y = C x + D u.  B may be a vector where there is one input, C where there is one output. Where "
      "an entry "
      "of D is 0, that input does not reach that output at the same instant.";
  static constexpr auto icon = "x' = A x + B u; y = C x + D u";
  static constexpr auto example = R"(
blocks: {y: {type: state_space, in: 0, A: [[0, 1], [-4, 0]], B: [0, 1], C: [1, 0], initial: [1, 0]}}
simulation: {stop: 2}
expect: [{signal: y, at: pi/2, value: -1, abs: 1e-5}]
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
  State x{this, "x", {.doc = "states", .size = any_size}};
  Output y{this, "y", {.doc = "outputs", .size = any_size}};

  void sizes(Sizing& sizing) const override { LinearSystem::sizes(sizing, {A, B, C, D, initial_value}, u, x, y); }
  void initial(Now now, Init init) const override { init[x] = now[initial_value]; }
  void outputs(Now now, Out out) const override { out[y] = system(now).output(now[x], now[u]); }
  void derivatives(Now now, Rates rate) const override { rate[x] = system(now).change(now[x], now[u]); }

 private:
  LinearSystem system(Now now) const {
    return {now[A], now[B], now[C], now.given(D) ? now[D] : Array(Shape::vector(0))};
  }
};

}  // namespace

PLANTLOOP_BLOCK(state_space, StateSpace)

}  // namespace plantloop
