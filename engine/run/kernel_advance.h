// Moves the states and histories of kernels on during a run.

#pragma once

#include "engine/run/run_state.h"

namespace plantloop {

class KernelAdvance {
 public:
  explicit KernelAdvance(RunState& run) : run_(run), frame_(run.frame), program_(run.program) {}

  bool none() const { return program_.kernels.empty(); }
  // The continuous ones, by the values that hold at the run's time: just before an event there (left) or after it.
  void continuous(bool left);
  // The accepted step from `before` to `after`, or the part of it until an event: some points inside it for kernels
  // with a history, which interpolate between them, then its end.
  void through(double before, double after);
  // Those of rates that have one of these bits.
  void discrete(Mask bits);

  // The next instant (s) at which a continuous kernel's output jumps.
  double next_jump();
  bool jumps_by(double t);
  // The longest step (s) that continuous kernels allow from now on.
  double longest_step();

 private:
  // Inside a subsystem that is not active nothing goes on.
  bool is_on(const Program::KernelState& kernel) const {
    return kernel.gate == no_gate || frame_.arena[kernel.gate] != 0;
  }
  KernelCall call_of(const Program::KernelState& kernel);
  void advance(const Program::KernelState& kernel, bool left);

  RunState& run_;
  Frame& frame_;
  const Program& program_;
};

}  // namespace plantloop
