// The clock is looked at now and then only: a step of a small model is shorter than the question.

#include "engine/run/run_limits.h"

#include <fmt/format.h>

#include "engine/base/error.h"

namespace plantloop {

void RunLimits::watch() {
  if (run_.statistics.solver.steps >= run_.options.max_steps) {
    throw LimitError(fmt::format("at time {} s the run has taken {} steps, the limit (simulation: max_steps)", run_.t,
                                 run_.options.max_steps),
                     run_.t);
  }
  if (control_.cancel != nullptr && control_.cancel->load(std::memory_order_relaxed)) {
    throw LimitError(fmt::format("the run was stopped at time {} s", run_.t), run_.t);
  }
  if ((control_.time_limit > 0 || control_.progress) && (++ticks_ & 255) == 0) look_at_the_clock();
}

void RunLimits::look_at_the_clock() {
  const auto now = std::chrono::steady_clock::now();
  const double elapsed = std::chrono::duration<double>(now - began_).count();
  if (control_.time_limit > 0 && elapsed > control_.time_limit) {
    throw LimitError(fmt::format("at time {} s the run has taken {:g} s, the time limit", run_.t, control_.time_limit),
                     run_.t);
  }
  if (control_.progress && std::chrono::duration<double>(now - reported_).count() > 0.1) {
    reported_ = now;
    control_.progress((run_.t - run_.options.start) / (run_.options.stop - run_.options.start));
  }
}

}  // namespace plantloop
