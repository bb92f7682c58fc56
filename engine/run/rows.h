// The rows that a run writes: at steps, between them, and on both sides of what jumps.

#pragma once

#include <cstdint>
#include <vector>

#include "engine/run/grid.h"
#include "engine/run/recording.h"
#include "engine/run/run_state.h"

namespace plantloop {

// Every function throws RunError when a recorded value is not finite and LimitError when there are too many rows.
class Rows {
 public:
  Rows(RunState& run, Recording& recording);

  Recording& recording() { return recording_; }
  // Refuses what is known to be too long; makes room for what is known to come.
  void begin();
  // The same for a run that goes on from a checkpoint, with a row at the run's time.
  void resume();
  // Rows inside an accepted step: the output grid, or as many as keep the gaps small; and samples there.
  void log_between(double before, double after);
  // The row at the end of a step: the left one, should something jump here. On a grid a stop is left to log_right.
  void log_left(double t, bool is_stop);
  // The same where an event was located: nothing has crossed at `before`, and its actions may set states (`jumps`).
  void log_left_of_event(double t, double before, bool jumps);
  // The row after everything at the run's time has settled; it takes the place of the left one unless a continuous
  // column jumped. `bits` are those of the hits there.
  void log_right(Mask bits);
  // The row at the end of a step where nothing can happen.
  void log_step(double t);
  // The time (s) of the next sample, infinity after the last.
  double next_sample() const;

 private:
  void evaluate_row(double t, bool left);
  bool row_is_finite(double t, bool left);
  [[noreturn]] void throw_blame(double t);
  void append(double t, std::int8_t side);
  void row_inside(double t);
  void take_sample_times();
  void sample_between(double before, double after);
  bool sampled_with(double t) const;
  void sample_at(bool left);

  RunState& run_;
  Frame& frame_;
  const Program& program_;
  const SimulationOptions& options_;
  Recording& recording_;
  std::vector<double> row_;
  std::vector<double> states_after_;  // at the end of the step that is looked into
  std::size_t most_rows_in_memory_;
  TimeGrid grid_;  // of output_interval
  std::int64_t next_grid_ = 0;
  std::size_t next_sample_ = 0;
};

}  // namespace plantloop
