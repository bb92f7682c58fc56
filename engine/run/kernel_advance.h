// Moves the states and histories of kernels on during a run.

#pragma once

#include <vector>

#include "engine/run/run_state.h"

namespace plantloop {

class KernelAdvance {
 public:
  explicit KernelAdvance(RunState& run);

  bool none() const { return program_.kernels.empty(); }
  // The continuous ones, by the values that hold at the run's time: just before an event there, or after it. Then
  // `order` is the lowest derivative that may jump there in any signal; Break::smooth: only what kernels say jumps.
  void before_event() { continuous(true, Break::smooth); }
  void after_event(int order);
  // The accepted step from `before` to `after`, or the part of it until an event: some points inside it for kernels
  // with a history, which interpolate between them, then its end.
  void through(double before, double after);
  // Those of rates that have one of these bits.
  void discrete(Mask bits);

  // The next instant (s) at which the output of a continuous kernel is not smooth.
  double next_break();
  // Looks which outputs are not smooth at time t, for the next after_event(): what they move has kinks there too, of a
  // derivative that is higher by the integrations in between. The lowest derivative that jumps.
  int broken_by(double t);
  // The longest step (s) that continuous kernels allow from now on.
  double longest_step();

 private:
  // Inside a subsystem that is not active nothing goes on.
  bool is_on(const Program::KernelState& kernel) const {
    return kernel.gate == no_gate || frame_.arena[kernel.gate] != 0;
  }
  int order_at(const Program::KernelState& kernel, int order) const;
  KernelCall call_of(const Program::KernelState& kernel);
  void continuous(bool left, int order);
  void advance(const Program::KernelState& kernel, KernelCall call);

  RunState& run_;
  Frame& frame_;
  const Program& program_;
  int solver_order_ = 0;        // jumps of higher derivatives do not matter to the solver
  std::vector<int> came_out_;   // of each kernel: the lowest derivative of its output that jumps now
  std::vector<double> inside_;  // where in a step kernels with histories are advanced, as parts of it
};

}  // namespace plantloop
