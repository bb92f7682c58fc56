// The solver writes the states in place; each question sets the time and runs one list.

#include "engine/run/program_system.h"

#include "engine/solve/passes.h"

namespace plantloop {

ProgramSystem::ProgramSystem(Frame& frame, double step)
    : frame_(frame), program_(*frame.program), kernels_(frame.kernel_frame(true)), step_(step) {
  if (program_.jacobian_column_start.empty() || !program_.jacobian_is_exact) return;
  pattern_.size = size();
  pattern_.column_start = program_.jacobian_column_start;
  pattern_.row = program_.jacobian_row;
  entries_.resize(pattern_.row.size());
}

const double* ProgramSystem::derivatives(double t) {
  frame_.arena[program_.time] = t;
  if (follows_modes) follow_modes();
  execute(program_.derivative_list, frame_.arena, &kernels_);
  return frame_.arena + program_.derivative_list.roots.front();
}

const double* ProgramSystem::jacobian(double t) {
  frame_.arena[program_.time] = t;
  execute(program_.jacobian_list, frame_.arena, &kernels_);
  for (std::size_t i = 0; i < entries_.size(); ++i) entries_[i] = frame_.arena[program_.jacobian_list.roots[i]];
  return entries_.data();
}

bool ProgramSystem::fixed_step(std::string_view, double t, double h) {
  if (program_.step_list.empty() || h != step_ || follows_modes) return false;
  frame_.arena[program_.time] = t;
  execute(program_.step_list, frame_.arena);
  const double* const after = frame_.arena + program_.step_list.roots.front();
  double* const states = frame_.states();
  for_each_state(frame_.state_count(), [states, after](std::size_t i) { states[i] = after[i]; });
  return true;
}

void ProgramSystem::follow_modes() {
  constexpr int most = 10;  // modes that depend on modes
  bool changed = true;
  for (int pass = 0; changed && pass < most; ++pass) {
    changed = false;
    execute(program_.held_list, frame_.arena, &kernels_, event_bit);
    execute(program_.mode_list, frame_.arena, &kernels_);
    for (std::size_t m = 0; m < program_.modes.size(); ++m) {
      const double now = frame_.arena[program_.mode_list.roots[m]];
      double& mode = frame_.arena[program_.modes[m]];
      changed = changed || mode != now;
      mode = now;
    }
  }
}

}  // namespace plantloop
