// What the parts of one run share: where it stands, the integrator, and what has been counted.

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/program/solve_loop.h"
#include "engine/run/clockwork.h"
#include "engine/run/frame.h"
#include "engine/run/simulation.h"
#include "engine/run/watch.h"
#include "engine/solve/integrator.h"

namespace plantloop {

struct RunState {
  RunState(Frame& run_frame, const SimulationOptions& run_options)
      : frame(run_frame),
        program(*run_frame.program),
        options(run_options),
        gap((run_options.stop - run_options.start) / gaps),
        search_gap(run_options.span > 0 ? run_options.span / gaps : gap),
        watch(run_frame, run_options) {}

  static constexpr int gaps = 500;  // rows are no further apart than (stop - start)/gaps

  Frame& frame;
  const Program& program;
  const SimulationOptions& options;
  double gap;         // s
  double search_gap;  // s; the parts in which a step is searched for events
  RunWatch watch;
  double t = 0;  // s; everything until here has happened
  std::optional<Clockwork> clockwork;
  std::unique_ptr<Integrator> integrator;  // null without continuous states
  Mask triggered = 0;                      // rates that a located event triggered: their states are to be updated
  bool restart = true;  // the states, or what their derivatives read, changed: the integrator must forget the past
  std::vector<std::uint32_t> still;  // places of states that a Zeno policy holds: their derivatives count as zero
  RunStatistics statistics;
  bool ended() const { return !statistics.ended_by.empty(); }

  // At an accepted step or after an event: the unknowns of all loops at the frame's states and time are where the next
  // search begins.
  void accept_loops() {
    if (program.loops.empty()) return;
    KernelFrame kernels = frame.kernel_frame(false);
    frame.arena[program.time] = t;
    if (!program.loop_list.empty()) execute(program.loop_list, frame.arena, &kernels);
    plantloop::accept_loops(program, frame.arena, kernels);
  }
  // The states and the time of an instant inside the last step.
  void put_states_of(double time) {
    if (integrator) integrator->interpolate(time, frame.states());
    frame.arena[program.time] = time;  // after the interpolation, which may evaluate derivatives elsewhere
  }
};

}  // namespace plantloop
