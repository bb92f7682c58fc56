// Kernels go on at accepted steps, events and hits only; in minor steps they are evaluated.

#include "engine/run/kernel_advance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace plantloop {

namespace {

// Kinks of higher derivatives are left to the error control: each pass through a loop of several delays brings more of
// them than the one before.
constexpr int finest_kink = 6;

// A polynomial through so many parts of a step is as good as the solver's dense output.
int parts_of_steps(int solver_order) { return std::max(6, solver_order); }

}  // namespace

// The points are those of Chebyshev and Lobatto, between which a polynomial does not swing.
KernelAdvance::KernelAdvance(RunState& run) : run_(run), frame_(run.frame), program_(run.program) {
  if (frame_.state_count() > 0) {
    for (const SolverInfo& solver : solvers()) {
      if (solver.name == run.options.solver) solver_order_ = solver.order;
    }
  }
  const int parts = parts_of_steps(solver_order_);
  for (int i = 1; i < parts && program_.history_count > 0; ++i) {
    const double swing = std::sin(std::numbers::pi * i / (2.0 * parts));
    inside_.push_back(swing * swing);
  }
}

void KernelAdvance::continuous(bool left, int order) {
  if (program_.kernels.empty()) return;
  KernelFrame kernels = frame_.kernel_frame(left);
  frame_.arena[program_.time] = run_.t;
  execute(program_.advance_list, frame_.arena, &kernels);
  for (const Program::KernelState& kernel : program_.kernels) {
    if (!kernel.continuous || !is_on(kernel)) continue;
    KernelCall call = call_of(kernel);
    call.left = left;
    call.order = left ? Break::smooth : order_at(kernel, order);
    advance(kernel, call);
  }
}

void KernelAdvance::through(double before, double after) {
  const double now = run_.t;
  for (const double part : inside_) {
    run_.t = before + (after - before) * part;
    run_.put_states_of(run_.t);
    KernelFrame kernels = frame_.kernel_frame(true);
    execute(program_.advance_list, frame_.arena, &kernels);
    for (const Program::KernelState& kernel : program_.kernels) {
      if (!kernel.continuous || !is_on(kernel) || kernel.kernel->histories() == 0) continue;
      KernelCall call = call_of(kernel);
      call.left = call.inside = true;
      advance(kernel, call);
    }
  }
  if (!inside_.empty()) run_.put_states_of(after);
  run_.t = after;
  before_event();
  run_.t = now;
}

KernelCall KernelAdvance::call_of(const Program::KernelState& kernel) {
  double* in = frame_.scratch.data();
  for (std::size_t i = 0; i < kernel.advance_inputs.size(); ++i) in[i] = frame_.arena[kernel.advance_inputs[i]];
  KernelCall call;
  call.time = run_.t;
  call.in = in;
  call.state = frame_.kernel_states.data() + kernel.first_state;
  call.scratch = in + kernel.advance_inputs.size();
  call.history = frame_.histories.data() + kernel.first_history;
  return call;
}

void KernelAdvance::advance(const Program::KernelState& kernel, KernelCall call) {
  bool end = false;
  call.end = &end;
  kernel.kernel->advance(call);
  if (end && !run_.ended()) run_.statistics.ended_by = program_.sites[kernel.site].path;
}

double KernelAdvance::next_break() {
  double next = std::numeric_limits<double>::infinity();
  for (const Program::KernelState& kernel : program_.kernels) {
    if (kernel.continuous && is_on(kernel)) next = std::min(next, kernel.kernel->next_break(call_of(kernel)).time);
  }
  return next;
}

int KernelAdvance::broken_by(double t) {
  came_out_.assign(program_.kernels.size(), Break::smooth);
  for (std::size_t k = 0; k < program_.kernels.size(); ++k) {
    const Program::KernelState& kernel = program_.kernels[k];
    if (!kernel.continuous || !is_on(kernel)) continue;
    const Break next = kernel.kernel->next_break(call_of(kernel));
    if (next.time <= t || is_same_instant(next.time, t)) came_out_[k] = next.order;
  }
  return came_out_.empty() ? Break::smooth : *std::min_element(came_out_.begin(), came_out_.end());
}

void KernelAdvance::after_event(int order) {
  continuous(false, order);
  came_out_.clear();
}

// What jumps at the input of a kernel when something happens that may make kinks of this order anywhere.
int KernelAdvance::order_at(const Program::KernelState& kernel, int order) const {
  for (const Smoothed& source : kernel.sources) {
    if (source.kernel < came_out_.size()) order = std::min(order, came_out_[source.kernel] + source.integrations);
  }
  return order <= std::min(solver_order_, finest_kink) ? order : Break::smooth;
}

double KernelAdvance::longest_step() {
  double longest = std::numeric_limits<double>::infinity();
  for (const Program::KernelState& kernel : program_.kernels) {
    double* in = frame_.scratch.data();
    for (std::size_t i = 0; i < kernel.advance_inputs.size(); ++i) in[i] = frame_.arena[kernel.advance_inputs[i]];
    if (kernel.continuous && is_on(kernel)) longest = std::min(longest, kernel.kernel->longest_step(in));
  }
  return longest;
}

void KernelAdvance::discrete(Mask bits) {
  for (const Program::KernelState& kernel : program_.kernels) {
    if (!kernel.continuous && is_on(kernel) && (kernel.mask & bits) != 0) advance(kernel, call_of(kernel));
  }
}

}  // namespace plantloop
