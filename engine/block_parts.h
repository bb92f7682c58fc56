// Parts of which several blocks are made: what they declare in common, and what it means. A part is a member of a
// block; `Memory` is State for what runs in s and Discrete for what runs in z.

#pragma once

#include <type_traits>

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {

// A filter of one signal by a transfer function: its input, states and output.
template <typename Memory>
struct Filter {
  explicit Filter(Block* block)
      : u(block, "u", {.doc = "signal to filter"}),
        initial_value(block, "initial",
                      {.doc = "output before the start, where everything has come to rest; default: all states are 0",
                       .optional = true,
                       .initial = true}),
        x(block, "x", {.doc = "states of the observable canonical form", .size = Block::any_size}),
        y(block, "y", {.doc = "the filtered signal"}) {}
  Input u;
  Number initial_value;
  Memory x;
  Output y;

  // `den`: the shape of the denominator's coefficients.
  void sizes(Sizing& sizing, const Shape& den) const {
    const Shape shape = TransferFunction::state_shape(den, sizing.of(y));
    if (shape.is_known()) sizing.set(x, shape);
  }
  void initial(Now now, Init init, const TransferFunction& system) const {
    constexpr bool sampled = std::is_same_v<Memory, Discrete>;
    if (now.given(initial_value)) init[x] = system.at_rest(now[initial_value], input(now), sampled);
  }
  void outputs(Now now, Out out, const TransferFunction& system) const { out[y] = system.output(now[x], input(now)); }
  // The derivative of x, or its value at the next hit.
  Array change(Now now, const TransferFunction& system) const { return system.change(now[x], input(now)); }

 private:
  Array input(Now now) const { return TransferFunction::as_wide_as(now[x], now[u]); }
};

// A linear system by its matrices.
template <typename Memory>
struct MatrixSystem {
  explicit MatrixSystem(Block* block)
      : u(block, "u", {.doc = "inputs", .size = Block::any_size}),
        A(block, "A", {.doc = "n by n", .zeros_matter = true}),
        B(block, "B", {.doc = "n by the number of inputs", .zeros_matter = true}),
        C(block, "C", {.doc = "the number of outputs by n", .zeros_matter = true}),
        D(block, "D",
          {.doc = "the number of outputs by that of inputs; default: 0", .zeros_matter = true, .optional = true}),
        initial_value(
            block, "initial",
            {.init = "0", .doc = "states at the start, n numbers or one for all; may read signals", .initial = true}),
        x(block, "x", {.doc = "states", .size = Block::any_size}),
        y(block, "y", {.doc = "outputs", .size = Block::any_size}) {}
  Input u;
  Table A, B, C, D, initial_value;
  Memory x;
  Output y;

  void sizes(Sizing& sizing) const { LinearSystem::sizes(sizing, {A, B, C, D, initial_value}, u, x, y); }
  void initial(Now now, Init init) const { init[x] = now[initial_value]; }
  void outputs(Now now, Out out) const { out[y] = system(now).output(now[x], now[u]); }
  // The derivative of x, or its value at the next hit.
  Array change(Now now) const { return system(now).change(now[x], now[u]); }

 private:
  LinearSystem system(Now now) const {
    return {now[A], now[B], now[C], now.given(D) ? now[D] : Array(Shape::vector(0))};
  }
};

// The limits of a controller's output, and what they do to its integral, so that it does not wind up (K. Astrom and
// T. Hagglund, PID Controllers, 3.5).
struct AntiWindup {
  explicit AntiWindup(Block* block);
  Input track;
  Limits limits;
  Choice method;
  Number t_track, initial_value;

  void check(Checking& checking) const { limits.check(checking); }
  bool clamps() const { return method.is("clamp"); }
  // What the integral may be: itself, unless it is clamped.
  Array within(Now now, const Array& integral) const { return clamps() ? limits.clamp(now, integral) : integral; }
  Array start(Now now) const { return within(now, now[initial_value]); }
  // What tracking adds to the integral's derivative for an output `raw` before the limits: below 0 at an upper limit.
  Array correction(Now now, const Array& raw) const;
};

// The declarations of a wave that has two values in turn.
struct RectangularWave {
  explicit RectangularWave(Block* block);
  Number period, width, delay;

  void check(Checking& checking) const;  // the width is at most the period
  // Whether the upper value holds.
  Truth is_up(Now now) const;
};

}  // namespace plantloop
