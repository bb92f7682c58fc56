// The major step in the order of S8: outputs, events until they settle, log, update, then integrate to the next stop.

#include "engine/run/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "engine/base/error.h"
#include "engine/program/resolve.h"
#include "engine/run/blame.h"
#include "engine/run/checkpoint.h"
#include "engine/run/events.h"
#include "engine/run/grid.h"
#include "engine/run/kernel_advance.h"
#include "engine/run/program_system.h"
#include "engine/run/rows.h"
#include "engine/run/run_limits.h"
#include "engine/run/run_state.h"
#include "engine/solve/passes.h"

namespace plantloop {

namespace {

// Evaluations of the derivatives in one step.
std::int64_t stages_of(const std::string& solver) { return solver == "euler" ? 1 : solver == "heun" ? 2 : 4; }

class Runner {
 public:
  Runner(Frame& frame, const SimulationOptions& options, Recording& recording, const RunControl& control)
      : run_(frame, options),
        frame_(frame),
        program_(*frame.program),
        options_(options),
        control_(control),
        kernels_(run_),
        rows_(run_, recording),
        events_(run_, kernels_, rows_),
        limits_(run_, control),
        states_before_(frame.state_count()),
        held_before_(program_.held_in_derivatives.size()),
        step_grid_(options.start, options.step > 0       ? options.step
                                  : options.max_step > 0 ? options.max_step
                                                         : run_.gap) {}

  RunStatistics run() {
    try {
      go_through();
    } catch (...) {
      finish();
      if (control_.until_failure != nullptr) *control_.until_failure = run_.statistics;
      throw;
    }
    finish();
    return run_.statistics;
  }

 private:
  void go_through() {
    take_save_times();
    begin();
    while (run_.t < options_.stop && !run_.ended() && !options_.only_start) {
      stop_ = next_stop();
      const double grid = next_grid_stop();
      advance_to(grid < stop_ && !is_same_instant(grid, stop_) ? grid : stop_);
      if (run_.t >= stop_ && !run_.ended()) at_stop();
    }
  }

  // --- the start --------------------------------------------------------------------------------------------------

  void begin() {
    const Checkpoint* const from = control_.from.get();
    const bool resumes = from != nullptr && from->structure == structure_of(program_);
    run_.t = from != nullptr ? from->time : options_.start;
    if (resumes) {
      resume(*from);
    } else {
      start(from);
    }
  }

  // All but the states as at a start.
  void prepare() {
    execute(program_.parameter_list, frame_.arena);
    KernelFrame kernels = frame_.kernel_frame(false);
    reset_loops(program_, frame_.arena, kernels);
    for (const auto slot : program_.modes) frame_.arena[slot] = 0;
    run_.clockwork.emplace(frame_, run_.t, options_.stop);
    if (!options_.only_start) limits_.foresee(rows_.recording().columns.size());
    frame_.arena[program_.time] = run_.t;
    has_continuous_ = frame_.state_count() > 0 || !events_.none();
    for (const Mask mask : program_.watch_masks)
      has_continuous_ = has_continuous_ || (mask & (continuous_bit | event_bit)) != 0;
    const double steps = (options_.stop - options_.start) / (step_grid_.at(1) - options_.start);
    if (frame_.state_count() == 0 && has_continuous_ && !(steps <= static_cast<double>(options_.max_steps))) {
      throw LimitError(fmt::format("the run would take {:.0f} steps, the limit is {} (simulation: max_steps)", steps,
                                   options_.max_steps));
    }
    if (frame_.state_count() > 0) {
      system_.emplace(frame_, options_.step, run_.still);
      make_solver();
    }
  }

  // An integrator without any past.
  void make_solver() {
    if (!system_) return;
    if (run_.integrator) add_solver_statistics();
    SolverOptions solver;
    solver.solver = options_.solver;
    solver.start = options_.start;
    solver.stop = options_.stop;
    solver.step = options_.step;
    solver.rtol = options_.rtol;
    solver.atol = options_.atol;
    solver.max_step = options_.max_step;
    run_.integrator = make_integrator(*system_, solver);
  }

  void start(const Checkpoint* from) {
    rows_.begin();
    prepare();
    give_initial_values();
    for (const auto mode : program_.modes) frame_.arena[mode] = 0;
    if (from != nullptr) restore_by_path(*from, frame_);
    Mask bits = run_.clockwork->advance(run_.t);
    events_.settle(every_bit);
    run_.accept_loops();
    if (std::vector<int> due = events_.remember_guards(); !due.empty()) {
      bits = events_.settle_events(std::move(due), bits | event_bit);
      run_.accept_loops();
    }
    rows_.log_right(bits);
    update(bits);
    kernels_.after_event(1);
    run_.restart = true;
    save_if_due();
  }

  void resume(const Checkpoint& from) {
    prepare();
    restore(from, frame_);
    run_.clockwork->resume();
    events_.restore(from);
    rows_.resume();
    run_.restart = true;
  }

  // --- save points ------------------------------------------------------------------------------------------------

  void take_save_times() {
    save_times_ = options_.save_times;
    std::sort(save_times_.begin(), save_times_.end());
    const double begin = control_.from ? control_.from->time : options_.start;
    while (next_save_ < save_times_.size() && save_times_[next_save_] < begin) ++next_save_;
    if (control_.from && next_save_ < save_times_.size() && save_times_[next_save_] == begin) ++next_save_;
  }

  double next_save() const {
    return next_save_ < save_times_.size() ? save_times_[next_save_] : std::numeric_limits<double>::infinity();
  }
  bool save_is_due() const {
    return next_save_ < save_times_.size() && (next_save() <= run_.t || is_same_instant(next_save(), run_.t));
  }

  // What follows a save point knows nothing of the steps before it, whether it is the same run or another one.
  void save_if_due() {
    if (!save_is_due()) return;
    while (save_is_due()) ++next_save_;
    if (control_.save) {
      Checkpoint checkpoint;
      checkpoint.start = options_.start;
      checkpoint.time = run_.t;
      save(frame_, checkpoint);
      events_.save(checkpoint);
      control_.save(checkpoint);
    }
    make_solver();
    events_.forget_steps();
    run_.restart = true;
  }

  void give_initial_values() {
    KernelFrame kernels = frame_.kernel_frame(false);
    execute(program_.initial_list, frame_.arena, &kernels);
    const std::size_t n = frame_.state_count();
    for (std::size_t i = 0; i < n; ++i) states_before_[i] = frame_.arena[program_.initial_list.roots[i]];
    for (std::size_t i = 0; i < n; ++i) {
      if (!std::isfinite(states_before_[i])) {
        throw not_finite(
            frame_, program_.resolved->initial_states[program_.state_at[i]],
            fmt::format("the initial value of '{}' is {}", program_.state_names[i], number_in_words(states_before_[i])),
            run_.t);
      }
      frame_.states()[i] = states_before_[i];
    }
    for (std::size_t i = 0; i < program_.discretes.size(); ++i) {
      const double value = frame_.arena[program_.initial_list.roots[n + i]];
      if (!std::isfinite(value)) {
        throw not_finite(
            frame_, program_.resolved->initial_discretes[i],
            fmt::format("the initial value of '{}' is {}", program_.discrete_names[i], number_in_words(value)), run_.t);
      }
      frame_.arena[program_.discretes[i]] = value;
    }
  }

  // --- between stops ----------------------------------------------------------------------------------------------

  // The next hit, edge or break of a kernel, or the end; what differs by rounding only is one stop.
  double next_stop() {
    double stop = options_.stop;
    if (const double next = run_.clockwork->next(); next < stop && !is_same_instant(next, stop)) stop = next;
    if (const double saved = next_save(); saved < stop && !is_same_instant(saved, stop)) stop = saved;
    if (const double wanted = events_.wanted_stop(); wanted > run_.t && wanted < stop) stop = wanted;
    if (const double next = kernels_.next_break(); next < stop && !is_same_instant(next, stop)) stop = next;
    return stop;
  }

  double next_grid_stop() {
    if (frame_.state_count() > 0 || !has_continuous_) return std::numeric_limits<double>::infinity();
    while (step_grid_.at(next_step_) <= run_.t) ++next_step_;
    return step_grid_.at(next_step_);
  }

  void advance_to(double stop) {
    if (frame_.state_count() == 0) {
      advance_without_states(stop);
      return;
    }
    if (can_run_step_list()) run_step_list(stop);
    if (run_.restart && run_.t < stop) {
      run_.integrator->limit_step(kernels_.longest_step());
      run_.integrator->restart(run_.t);
      run_.restart = false;
    }
    while (run_.t < stop) {
      limits_.watch();
      const double before = run_.t;
      run_.watch.before_step(frame_.state_count());
      const double after = take_step(stop);
      if (options_.step <= 0 && after < stop) run_.watch.after_step(before, after, frame_.state_count());
      ++run_.statistics.solver.steps;
      if (!events_.none() && events_.crossing_between(before, after)) return update_triggered();
      rows_.log_between(before, after);
      run_.t = after;
      rows_.log_left(run_.t, run_.t >= stop_);
      run_.accept_loops();
      if (!kernels_.none()) {
        kernels_.through(before, after);
        if (run_.ended()) return;
        run_.integrator->limit_step(kernels_.longest_step());
      }
    }
  }

  // A small model without events and histories, stepped on its grid: nothing can happen but the next row.
  bool can_run_step_list() const {
    return !program_.step_list.empty() && events_.none() && program_.kernels.empty() && options_.output_interval <= 0 &&
           (options_.max_step <= 0 || options_.step <= options_.max_step);
  }

  // Whole steps from grid point to grid point as far as the stop and the next sample allow; the integrator does the
  // rest.
  void run_step_list(double stop) {
    const double h = options_.step;
    const auto grid = [&](double k) { return options_.start + k * h; };
    const double end = std::min(stop, rows_.next_sample()) - 1e-10 * h;
    double k = std::round((run_.t - options_.start) / h);
    if (run_.t != grid(k)) return;
    double* const __restrict states = frame_.states();
    double* const __restrict before = states_before_.data();
    const double* const after = frame_.arena + program_.step_list.roots.front();
    const std::size_t n = frame_.state_count();
    while (grid(k + 1) < end) {
      limits_.watch();
      frame_.arena[program_.time] = run_.t;
      execute(program_.step_list, frame_.arena);
      double sum = 0;
      for_each_state(n, [&](std::size_t i) {
        before[i] = states[i];
        states[i] = after[i];
        sum += after[i];
      });
      if (!std::isfinite(sum) && !all_finite(n, states)) {
        const std::size_t bad = first_not_finite(n, states);
        std::copy(before, before + n, states);
        throw solver_failed(
            frame_, program_.resolved->derivatives[program_.state_at[bad]],
            RunError(fmt::format("at time {:g} s a step of {:g} s gives no finite state {}; it may be too long", run_.t,
                                 h, bad),
                     run_.t),
            fmt::format("state {}", bad), program_.state_names[bad]);
      }
      run_.t = grid(++k);
      ++run_.statistics.solver.steps;
      ++steps_by_list_;
      rows_.log_step(run_.t);
      run_.restart = true;  // the integrator has not seen this
    }
  }

  void advance_without_states(double stop) {
    limits_.watch();
    ++run_.statistics.solver.steps;
    if (!events_.none() && has_continuous_ && events_.crossing_between(run_.t, stop)) return update_triggered();
    const double before = run_.t;
    rows_.log_between(before, stop);
    run_.t = stop;
    if (has_continuous_) {
      rows_.log_left(run_.t, run_.t >= stop_);
      if (!kernels_.none()) kernels_.through(before, run_.t);
    }
  }

  double take_step(double stop) {
    try {
      return run_.integrator->step(stop);
    } catch (const StateError& e) {
      if (const auto after = step_following_modes(stop)) return *after;
      // The solver knows states by number; say which one, and where its value came from.
      const auto place = static_cast<std::size_t>(std::max(e.state(), 0));
      const std::string& name = program_.state_names[place];
      const std::uint32_t derivative = program_.resolved->derivatives[program_.state_at[place]];
      throw solver_failed(frame_, derivative, e, fmt::format("state {}", place), name);
    }
  }

  // What holds at the start of a step need not exist beyond its end, as in where(level > 0, sqrt(level), 0): with modes
  // frozen no step gets across the crossing. This one takes the modes as they come; the event is then located inside it
  // as ever. Nothing when that is not the trouble.
  std::optional<double> step_following_modes(double stop) {
    if (program_.modes.empty()) return std::nullopt;
    std::vector<double> modes;
    for (const auto slot : program_.modes) modes.push_back(frame_.arena[slot]);
    system_->follows_modes = true;
    std::optional<double> after;
    try {
      run_.integrator->restart(run_.t);
      after = run_.integrator->step(stop);
      run_.integrator->interpolate(*after, frame_.states());  // what it needs for others is evaluated now
    } catch (const StateError&) {
      after.reset();
    }
    system_->follows_modes = false;
    for (std::size_t m = 0; m < modes.size(); ++m) frame_.arena[program_.modes[m]] = modes[m];
    KernelFrame kernels = frame_.kernel_frame(true);
    execute(program_.held_list, frame_.arena, &kernels, event_bit);
    return after;
  }

  // --- stops ------------------------------------------------------------------------------------------------------

  void at_stop() {
    for (std::size_t i = 0; i < held_before_.size(); ++i)
      held_before_[i] = frame_.arena[program_.held_in_derivatives[i]];
    events_.take_holds(run_.t);
    Mask bits = run_.clockwork->advance(run_.t);
    const int came_out = kernels_.broken_by(run_.t);
    if (bits == 0 && has_continuous_ && run_.t >= options_.stop && came_out == Break::smooth && !save_is_due()) {
      if (options_.output_interval > 0) rows_.log_right(0);
      return;  // else the last row stands already
    }
    const bool was_due = std::exchange(run_.restart, false);  // by something before this stop
    const std::int64_t mode_changes = run_.statistics.mode_changes;
    events_.release();
    bits = events_.settle_events({}, bits);
    for (std::size_t i = 0; i < held_before_.size() && !run_.restart; ++i) {
      run_.restart = held_before_[i] != frame_.arena[program_.held_in_derivatives[i]];
    }
    run_.accept_loops();
    rows_.log_right(bits);
    update(bits);
    const bool kinks = run_.restart || (bits & event_bit) != 0 || run_.statistics.mode_changes != mode_changes;
    kernels_.after_event(kinks ? 1 : Break::smooth);
    run_.restart = run_.restart || was_due || came_out == 0;
    run_.statistics.hits += static_cast<std::int64_t>(run_.clockwork->hit_rates().size());
    if (frame_.state_count() > 0)
      ++(run_.restart ? run_.statistics.solver.cold_restarts : run_.statistics.solver.hot_restarts);
    save_if_due();
  }

  // The discrete states of the rates that had a hit. What anybody reads are copies taken at the hit, so no order
  // matters.
  void update(Mask bits) {
    run_.watch.hit(run_.t, bits);
    for (std::size_t i = 0; i < program_.discretes.size(); ++i) {
      if ((rate_bit(program_.discrete_rates[i]) & bits) != 0 && had_hit(program_.discrete_rates[i])) {
        const double next = frame_.arena[program_.nexts[i]];
        if (!std::isfinite(next)) {
          throw not_finite(
              frame_, program_.resolved->nexts[i],
              fmt::format("the next value of '{}' is {}", program_.discrete_names[i], number_in_words(next)), run_.t);
        }
        frame_.arena[program_.discretes[i]] = next;
      }
    }
    kernels_.discrete(bits);
  }

  // The discrete states of what a located event triggered.
  void update_triggered() {
    if (run_.triggered == 0) return;
    update(run_.triggered);
    run_.triggered = 0;
  }

  bool had_hit(RateIndex rate) const {
    const auto& hits = run_.clockwork->hit_rates();
    return std::find(hits.begin(), hits.end(), rate) != hits.end();
  }

  void finish() {
    run_.statistics.rows = static_cast<std::int64_t>(rows_.recording().rows());
    run_.watch.finish(run_.t, control_.from == nullptr, run_.statistics);
    if (!run_.integrator) return;
    add_solver_statistics();
    run_.statistics.solver.evaluations += steps_by_list_ * stages_of(options_.solver);
  }

  // Of the present integrator, before another one takes its place.
  void add_solver_statistics() {
    const SolverStatistics& s = run_.integrator->statistics();
    run_.statistics.solver.rejected += s.rejected;
    run_.statistics.solver.evaluations += s.evaluations;
    run_.statistics.solver.jacobians += s.jacobians;
  }

  RunState run_;
  Frame& frame_;
  const Program& program_;
  const SimulationOptions& options_;
  const RunControl& control_;
  KernelAdvance kernels_;
  Rows rows_;
  Events events_;
  RunLimits limits_;
  std::vector<double> states_before_, held_before_;
  TimeGrid step_grid_;  // of a diagram without states
  std::int64_t next_step_ = 1;
  std::optional<ProgramSystem> system_;
  std::vector<double> save_times_;
  std::size_t next_save_ = 0;
  double stop_ = 0;  // s; where the present steps end at the latest
  bool has_continuous_ = true;
  std::int64_t steps_by_list_ = 0;
};

}  // namespace

RunStatistics simulate(Frame& frame, const SimulationOptions& options, std::vector<RecordedColumn> columns,
                       Recording& recording, const RunControl& control) {
  recording.columns = std::move(columns);
  recording.hits.assign(frame.program->rates.size(), {});
  recording.rates.clear();
  for (const RecordedRate& rate : frame.program->rates) {
    recording.rates.emplace_back(rate.period.to_double(), rate.offset.to_double());
  }
  return Runner(frame, options, recording, control).run();
}

}  // namespace plantloop
