// The solver writes the states in place; each question sets the time and runs one list.

#include "engine/run/program_system.h"

#include <algorithm>

#include "engine/solve/passes.h"

namespace plantloop {

ProgramSystem::ProgramSystem(Frame& frame, double step, const std::vector<std::uint32_t>& still)
    : frame_(frame), program_(*frame.program), kernels_(frame.kernel_frame(true)), step_(step), still_(still) {
  for (const auto k : program_.dae_loops) {
    const Program::Loop& loop = program_.loops[k];
    for (std::uint32_t i = 0; i < loop.size(); ++i) {
      unknowns_.push_back(loop.unknowns + i);
      values_.push_back(loop.first_value + i);
    }
  }
  algebraic_.resize(unknowns_.size());
  if (!program_.dae_column_start.empty()) {
    dae_pattern_.size = static_cast<int>(program_.dae_column_start.size()) - 1;
    dae_pattern_.column_start = program_.dae_column_start;
    dae_pattern_.row = program_.dae_row;
    dae_entries_.resize(dae_pattern_.row.size());
  }
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
  double* const derivatives = frame_.arena + program_.derivative_list.roots.front();
  for (const auto place : still_) derivatives[place] = 0;
  return derivatives;
}

const double* ProgramSystem::jacobian(double t) {
  frame_.arena[program_.time] = t;
  execute(program_.jacobian_list, frame_.arena, &kernels_);
  for (std::size_t i = 0; i < entries_.size(); ++i) entries_[i] = frame_.arena[program_.jacobian_list.roots[i]];
  for (std::size_t i = 0; i < entries_.size() && !still_.empty(); ++i) {
    const auto row = static_cast<std::uint32_t>(pattern_.row[i]);
    if (std::find(still_.begin(), still_.end(), row) != still_.end()) entries_[i] = 0;
  }
  return entries_.data();
}

const double* ProgramSystem::algebraic() {
  for (std::size_t i = 0; i < values_.size(); ++i) algebraic_[i] = frame_.loop_values[values_[i]];
  return algebraic_.data();
}

void ProgramSystem::take_algebraic(const double* z) {
  for (std::size_t i = 0; i < values_.size(); ++i) frame_.loop_values[values_[i]] = z[i];
}

void ProgramSystem::put_algebraic(const double* z) {
  for (std::size_t i = 0; i < unknowns_.size(); ++i) frame_.arena[unknowns_[i]] = z[i];
}

const double* ProgramSystem::equations(double t, const double* z) {
  frame_.arena[program_.time] = t;
  if (follows_modes) follow_modes();
  put_algebraic(z);
  execute(program_.dae_list, frame_.arena, &kernels_);
  double* const values = frame_.arena + program_.dae_list.roots.front();
  for (const auto place : still_) values[place] = 0;
  return values;
}

const double* ProgramSystem::equations_jacobian(double t, const double* z) {
  frame_.arena[program_.time] = t;
  put_algebraic(z);
  execute(program_.dae_jacobian_list, frame_.arena, &kernels_);
  for (std::size_t i = 0; i < dae_entries_.size(); ++i) {
    const auto row = static_cast<std::uint32_t>(dae_pattern_.row[i]);
    const bool moves = std::find(still_.begin(), still_.end(), row) == still_.end();
    dae_entries_[i] = moves ? frame_.arena[program_.dae_jacobian_list.roots[i]] : 0;
  }
  return dae_entries_.data();
}

bool ProgramSystem::fixed_step(std::string_view, double t, double h) {
  if (program_.step_list.empty() || h != step_ || follows_modes || !still_.empty()) return false;
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
