// Kernels go on at accepted steps, events and hits only; in minor steps they are evaluated.

#include "engine/run/kernel_advance.h"

#include <algorithm>
#include <limits>

namespace plantloop {

void KernelAdvance::continuous(bool left) {
  if (program_.kernels.empty()) return;
  KernelFrame kernels = frame_.kernel_frame(left);
  frame_.arena[program_.time] = run_.t;
  execute(program_.advance_list, frame_.arena, &kernels);
  for (const Program::KernelState& kernel : program_.kernels) {
    if (kernel.continuous && is_on(kernel)) advance(kernel, left);
  }
}

void KernelAdvance::through(double before, double after) {
  constexpr int parts = 4;
  const double now = run_.t;
  if (program_.history_count > 0) {
    for (int i = 1; i < parts; ++i) {
      run_.t = before + (after - before) * i / parts;
      run_.put_states_of(run_.t);
      KernelFrame kernels = frame_.kernel_frame(true);
      execute(program_.advance_list, frame_.arena, &kernels);
      for (const Program::KernelState& kernel : program_.kernels) {
        if (kernel.continuous && is_on(kernel) && kernel.kernel->histories() > 0) advance(kernel, true);
      }
    }
    run_.put_states_of(after);
  }
  run_.t = after;
  continuous(true);
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

void KernelAdvance::advance(const Program::KernelState& kernel, bool left) {
  KernelCall call = call_of(kernel);
  call.left = left;
  bool end = false;
  call.end = &end;
  kernel.kernel->advance(call);
  if (end && !run_.ended()) run_.statistics.ended_by = program_.sites[kernel.site].path;
}

double KernelAdvance::next_jump() {
  double next = std::numeric_limits<double>::infinity();
  for (const Program::KernelState& kernel : program_.kernels) {
    if (kernel.continuous && is_on(kernel)) next = std::min(next, kernel.kernel->next_jump(call_of(kernel)));
  }
  return next;
}

bool KernelAdvance::jumps_by(double t) {
  const double jump = next_jump();
  return jump <= t || is_same_instant(jump, t);
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
    if (!kernel.continuous && is_on(kernel) && (kernel.mask & bits) != 0) advance(kernel, false);
  }
}

}  // namespace plantloop
