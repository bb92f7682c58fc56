// Finds the unknowns of a loop: damped Newton iteration on exact Jacobians.

#pragma once

#include <cstddef>

#include "engine/base/error.h"
#include "engine/program/program.h"

namespace plantloop {

// No values were found that satisfy a loop; the message names its path, the nearest values and what would help.
class LoopError : public RunError {
 public:
  using RunError::RunError;
};

// Doubles of room that a loop of n unknowns needs in the Frame.
std::size_t loop_room(std::size_t n);

// To be called whenever parameter_list has run: the search begins at the declared guesses again, and what was kept for
// the old parameters is dropped. Throws LoopError when parameters leave a loop without a solution.
void reset_loops(const Program& program, double* arena, KernelFrame& frame);

// Writes values into the loop's unknowns that satisfy its equations to rounding, beginning at the last accepted ones.
// Never leaves values that do not: throws LoopError. After an event (frame.left is false) the solution may be far away,
// and one unknown is also looked for between its bounds.
void solve_loop(const Program::Loop& loop, double* arena, KernelFrame& frame);

// Takes the present values of all unknowns as those to begin at.
void accept_loops(const Program& program, const double* arena, KernelFrame& frame);

}  // namespace plantloop
