// What ends a run before its time: too many steps, a limit of time, somebody who cancels it.

#pragma once

#include <chrono>

#include "engine/run/run_state.h"

namespace plantloop {

class RunLimits {
 public:
  RunLimits(RunState& run, const RunControl& control) : run_(run), control_(control) {}
  // To be called between steps; reports progress. Throws LimitError.
  void watch();
  // Throws LimitError when the hits of a rate or the edges of a source alone are more than the run may have steps or
  // rows; `columns`: of a row.
  void foresee(std::size_t columns) const;

 private:
  void look_at_the_clock();

  RunState& run_;
  const RunControl& control_;
  unsigned ticks_ = 0;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point reported_ = began_;
};

}  // namespace plantloop
