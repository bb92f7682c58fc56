// The clock is looked at now and then only: a step of a small model is shorter than the question.

#include "engine/run/run_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "engine/base/error.h"

namespace plantloop {

void RunLimits::watch() {
  if (run_.statistics.solver.steps >= run_.options.max_steps) {
    throw LimitError(fmt::format("at time {} s the run has taken {} steps, the limit (simulation: max_steps){}", run_.t,
                                 run_.options.max_steps, run_.watch.hint()),
                     run_.t);
  }
  if (control_.cancel != nullptr && control_.cancel->load(std::memory_order_relaxed)) {
    throw LimitError(fmt::format("the run was stopped at time {} s", run_.t), run_.t);
  }
  if ((control_.time_limit > 0 || control_.progress) && (++ticks_ & 255) == 0) look_at_the_clock();
}

void RunLimits::foresee(std::size_t columns) const {
  const Program& program = run_.program;
  const SimulationOptions& o = run_.options;
  double most = 0;
  std::string what;
  const auto count = [&](double first, double period, const std::string& text) {
    const double stops = (o.stop - std::max(run_.t, first)) / period;
    if (stops > most) most = stops, what = fmt::format("{} {:.4g} times until {:g} s", text, stops, o.stop);
  };
  for (std::size_t r = 1; r < program.rates.size(); ++r) {
    const RecordedRate& rate = program.rates[r];
    if (rate.triggered) continue;
    std::string name;
    for (std::size_t i = 0; i < program.discretes.size() && name.empty(); ++i) {
      if (program.discrete_rates[i] == r) name = fmt::format(", that of '{}',", program.discrete_names[i]);
    }
    count(rate.offset.to_double(), rate.period.to_double(),
          fmt::format("the rate of {:g} s{} has its hit", rate.period.to_double(), name));
  }
  for (const Program::Schedule& schedule : program.schedules) {
    if (!schedule.periodic) continue;
    count(run_.frame.arena[schedule.first], run_.frame.arena[schedule.period],
          fmt::format("the source '{}' has an edge", program.sites[schedule.site].path));
  }
  constexpr const char* remedy = "a longer period or an earlier stop makes fewer";
  if (most > static_cast<double>(o.max_steps)) {
    throw LimitError(fmt::format("{}, each of which ends a step; the limit is {} (simulation: max_steps); {}", what,
                                 o.max_steps, remedy));
  }
  if (o.output_interval > 0) return;
  if (most > static_cast<double>(o.max_rows)) {
    throw LimitError(fmt::format(
        "{}, each of which is a row; the limit is {} (simulation: max_rows); an output_interval makes fewer rows, {}",
        what, o.max_rows, remedy));
  }
  const double bytes = most * static_cast<double>(columns + 1) * sizeof(double);
  if (bytes > o.max_memory) {
    throw LimitError(
        fmt::format("{}, each of which is a row; the result would take {:.1f} GB of memory, the limit is {:.1f} GB; an "
                    "output_interval makes fewer rows",
                    what, bytes / 1e9, o.max_memory / 1e9));
  }
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
