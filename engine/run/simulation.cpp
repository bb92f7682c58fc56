// The major step in the order of S8: outputs, events until they settle, log, update, then integrate to the next stop.

#include "engine/run/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include "engine/base/error.h"
#include "engine/program/resolve.h"
#include "engine/run/blame.h"
#include "engine/run/clockwork.h"
#include "engine/run/grid.h"
#include "engine/solve/passes.h"
#include "engine/solve/root.h"

namespace plantloop {

namespace {

constexpr int most_passes = 100;            // of event iteration
constexpr int most_events_in_a_row = 1000;  // closer together than 1000 event tolerances
constexpr int gaps = 500;                   // rows are no further apart than (stop - start)/gaps

// The Program's derivatives as a solver sees them.
class ProgramSystem final : public OdeSystem {
 public:
  ProgramSystem(Frame& frame, const SimulationOptions& options)
      : frame_(frame), program_(*frame.program), kernels_(frame.kernel_frame(true)), step_(options.step) {
    if (!program_.jacobian_column_start.empty() && program_.jacobian_is_exact) {
      pattern_.size = size();
      pattern_.column_start = program_.jacobian_column_start;
      pattern_.row = program_.jacobian_row;
      entries_.resize(pattern_.row.size());
    }
  }

  int size() const override { return static_cast<int>(frame_.state_count()); }
  double* state() override { return frame_.states(); }
  const double* derivatives(double t) override {
    frame_.arena[program_.time] = t;
    if (follows_modes) follow_modes();
    execute(program_.derivative_list, frame_.arena, &kernels_);
    return frame_.arena + program_.derivative_list.roots.front();
  }
  const SparsityPattern* pattern() const override { return pattern_.size > 0 ? &pattern_ : nullptr; }
  const double* jacobian(double t) override {
    frame_.arena[program_.time] = t;
    execute(program_.jacobian_list, frame_.arena, &kernels_);
    for (std::size_t i = 0; i < entries_.size(); ++i) entries_[i] = frame_.arena[program_.jacobian_list.roots[i]];
    return entries_.data();
  }
  bool fixed_step(std::string_view, double t, double h) override {
    if (program_.step_list.empty() || h != step_ || follows_modes) return false;
    frame_.arena[program_.time] = t;
    execute(program_.step_list, frame_.arena);
    const double* const after = frame_.arena + program_.step_list.roots.front();
    double* const states = frame_.states();
    for_each_state(frame_.state_count(), [states, after](std::size_t i) { states[i] = after[i]; });
    return true;
  }

  // While true, modes are those of the present values and not those of the step's start.
  bool follows_modes = false;

 private:
  void follow_modes() {
    constexpr int most = 10;  // modes that depend on modes
    bool changed = true;
    for (int pass = 0; changed && pass < most; ++pass) {
      changed = false;
      execute(program_.held_list, frame_.arena, &kernels_, event_bit);
      execute(program_.mode_list, frame_.arena, &kernels_);
      for (std::size_t m = 0; m < program_.modes.size(); ++m) {
        const double now = frame_.arena[program_.mode_list.roots[m]];
        double& mode = frame_.arena[program_.modes[m]];
        changed = changed || mode != now;
        mode = now;
      }
    }
  }

  Frame& frame_;
  const Program& program_;
  KernelFrame kernels_;
  double step_;
  SparsityPattern pattern_;
  std::vector<double> entries_;
};

// Evaluations of the derivatives in one step.
std::int64_t stages_of(const std::string& solver) { return solver == "euler" ? 1 : solver == "heun" ? 2 : 4; }

class Runner {
 public:
  Runner(Frame& frame, const SimulationOptions& options, Recording& recording, const RunControl& control)
      : frame_(frame),
        program_(*frame.program),
        options_(options),
        recording_(recording),
        control_(control),
        gap_((options.stop - options.start) / gaps),
        row_(recording.columns.size()),
        most_rows_in_memory_(
            static_cast<std::size_t>(options.max_memory / static_cast<double>((row_.size() + 1) * sizeof(double)))),
        saved_states_(frame.state_count()),
        held_before_(program_.held_in_derivatives.size()),
        guard_values_(program_.guards.size()),
        output_grid_(options.start, options.output_interval),
        step_grid_(options.start, options.step > 0       ? options.step
                                  : options.max_step > 0 ? options.max_step
                                                         : gap_),
        roots_(guard_directions(program_), options.event_tol) {}

  RunStatistics run() {
    start();
    while (t_ < options_.stop) {
      const double stop = next_stop();
      const double grid = next_grid_stop();
      advance_to(grid < stop && !is_same_instant(grid, stop) ? grid : stop);
      if (t_ >= stop) at_stop();
    }
    finish();
    return statistics_;
  }

 private:
  static std::vector<Direction> guard_directions(const Program& program) {
    std::vector<Direction> directions;
    for (const Program::Guard& guard : program.guards) directions.push_back(static_cast<Direction>(guard.direction));
    return directions;
  }

  // --- the start --------------------------------------------------------------------------------------------------

  void start() {
    t_ = options_.start;
    take_sample_times();
    check_rows_beforehand();
    execute(program_.parameter_list, frame_.arena);
    for (const auto slot : program_.modes) frame_.arena[slot] = 0;
    clockwork_.emplace(frame_, options_.start, options_.stop);
    frame_.arena[program_.time] = t_;
    give_initial_values();
    for (std::size_t m = 0; m < program_.modes.size(); ++m) frame_.arena[program_.modes[m]] = 0;
    has_continuous_ = frame_.state_count() > 0 || !program_.guards.empty();
    for (const Mask mask : program_.watch_masks)
      has_continuous_ = has_continuous_ || (mask & (continuous_bit | event_bit)) != 0;
    const double steps = (options_.stop - options_.start) / (step_grid_.at(1) - options_.start);
    if (frame_.state_count() == 0 && has_continuous_ && !(steps <= static_cast<double>(options_.max_steps))) {
      throw LimitError(fmt::format("the run would take {:.0f} steps, the limit is {} (simulation: max_steps)", steps,
                                   options_.max_steps));
    }
    if (frame_.state_count() > 0) {
      system_.emplace(frame_, options_);
      SolverOptions solver;
      solver.solver = options_.solver;
      solver.start = options_.start;
      solver.stop = options_.stop;
      solver.step = options_.step;
      solver.rtol = options_.rtol;
      solver.atol = options_.atol;
      solver.max_step = options_.max_step;
      integrator_ = make_integrator(*system_, solver);
    }
    const Mask bits = clockwork_->advance(t_);
    settle(every_bit);
    remember_guards();
    log_right(bits);
    update(bits);
    advance_kernels(false);
    restart_ = true;
  }

  void give_initial_values() {
    KernelFrame kernels = frame_.kernel_frame(false);
    execute(program_.initial_list, frame_.arena, &kernels);
    const std::size_t n = frame_.state_count();
    for (std::size_t i = 0; i < n; ++i) saved_states_[i] = frame_.arena[program_.initial_list.roots[i]];
    for (std::size_t i = 0; i < n; ++i) {
      if (!std::isfinite(saved_states_[i])) {
        throw not_finite(
            frame_, program_.resolved->initial_states[program_.state_at[i]],
            fmt::format("the initial value of '{}' is {}", program_.state_names[i], number_in_words(saved_states_[i])),
            t_);
      }
      frame_.states()[i] = saved_states_[i];
    }
    for (std::size_t i = 0; i < program_.discretes.size(); ++i) {
      const double value = frame_.arena[program_.initial_list.roots[n + i]];
      if (!std::isfinite(value)) {
        throw not_finite(
            frame_, program_.resolved->initial_discretes[i],
            fmt::format("the initial value of '{}' is {}", program_.discrete_names[i], number_in_words(value)), t_);
      }
      frame_.arena[program_.discretes[i]] = value;
    }
  }

  // Refuses what is known to be too long; makes room for what is known to come.
  void check_rows_beforehand() {
    double rows = gaps;
    if (options_.output_interval > 0) {
      rows = (options_.stop - options_.start) / options_.output_interval;
    } else if (options_.step > 0) {
      rows = (options_.stop - options_.start) / options_.step;
    }
    const double bytes = rows * static_cast<double>(recording_.columns.size() + 1) * sizeof(double);
    if (rows > static_cast<double>(options_.max_rows)) {
      throw LimitError(fmt::format(
          "the result would have {:.0f} rows, the limit is {} (simulation: max_rows); an output_interval makes fewer",
          rows, options_.max_rows));
    }
    if (bytes > options_.max_memory) {
      throw LimitError(fmt::format(
          "the result would take {:.1f} GB of memory, the limit is {:.1f} GB; an output_interval makes fewer rows",
          bytes / 1e9, options_.max_memory / 1e9));
    }
    recording_.reserve(static_cast<std::size_t>(std::min(rows, 4e6)) + 64);
  }

  // --- between stops ----------------------------------------------------------------------------------------------

  // The next hit, edge or jump of a kernel, or the end; what differs by rounding only is one stop.
  double next_stop() {
    double stop = options_.stop;
    if (const double next = clockwork_->next(); next < stop && !is_same_instant(next, stop)) stop = next;
    if (const double jump = next_kernel_jump(); jump < stop && !is_same_instant(jump, stop)) stop = jump;
    return stop;
  }

  double next_grid_stop() {
    if (frame_.state_count() > 0 || !has_continuous_) return std::numeric_limits<double>::infinity();
    while (step_grid_.at(next_step_) <= t_) ++next_step_;
    return step_grid_.at(next_step_);
  }

  void advance_to(double stop) {
    if (frame_.state_count() == 0) {
      advance_without_states(stop);
      return;
    }
    if (can_run_step_list()) run_step_list(stop);
    if (restart_ && t_ < stop) {
      integrator_->limit_step(longest_step());
      integrator_->restart(t_);
      restart_ = false;
    }
    while (t_ < stop) {
      watch_limits();
      const double before = t_;
      const double after = take_step(stop);
      ++statistics_.solver.steps;
      if (!program_.guards.empty() && crossing_between(before, after)) return;
      log_between(before, after);
      t_ = after;
      log_at(t_);
      if (!program_.kernels.empty()) {
        advance_kernels_through(before, after);
        integrator_->limit_step(longest_step());
      }
    }
  }

  // A small model without events and histories, stepped on its grid: nothing can happen but the next row.
  bool can_run_step_list() const {
    return !program_.step_list.empty() && program_.guards.empty() && program_.kernels.empty() &&
           options_.output_interval <= 0 && (options_.max_step <= 0 || options_.step <= options_.max_step);
  }

  // Whole steps from grid point to grid point as far as the stop and the next sample allow; the integrator does the
  // rest.
  void run_step_list(double stop) {
    const double h = options_.step;
    const auto grid = [&](double k) { return options_.start + k * h; };
    const double end = std::min(stop, next_sample()) - 1e-10 * h;
    double k = std::round((t_ - options_.start) / h);
    if (t_ != grid(k)) return;
    double* const __restrict states = frame_.states();
    double* const __restrict before = saved_states_.data();
    const double* const after = frame_.arena + program_.step_list.roots.front();
    const std::size_t n = frame_.state_count();
    while (grid(k + 1) < end) {
      watch_limits();
      frame_.arena[program_.time] = t_;
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
            RunError(fmt::format("at time {:g} s a step of {:g} s gives no finite state; it may be too long", t_, h),
                     t_),
            program_.state_names[bad]);
      }
      t_ = grid(++k);
      ++statistics_.solver.steps;
      ++steps_by_list_;
      evaluate_row(t_, true);
      append(t_, 0);
      restart_ = true;  // the integrator has not seen this
    }
  }

  void advance_without_states(double stop) {
    watch_limits();
    ++statistics_.solver.steps;
    if (!program_.guards.empty() && has_continuous_ && crossing_between(t_, stop)) return;
    const double before = t_;
    log_between(before, stop);
    t_ = stop;
    if (has_continuous_) {
      log_at(t_);
      if (!program_.kernels.empty()) advance_kernels_through(before, t_);
    }
  }

  void put_states_of(double t) {
    if (integrator_) integrator_->interpolate(t, frame_.states());
    frame_.arena[program_.time] = t;  // after the interpolation, which may evaluate derivatives elsewhere
  }

  void guards_at(double t, double* values) {
    put_states_of(t);
    KernelFrame kernels = frame_.kernel_frame(true);
    execute(program_.guard_list, frame_.arena, &kernels);
    for (std::size_t i = 0; i < program_.guards.size(); ++i) values[i] = frame_.arena[program_.guard_list.roots[i]];
  }

  // Handles the first event on (before, after], if there is one: true, and t_ stands at the event. A long step is
  // looked at in parts as short as the gaps between rows, so that a function that changes its sign twice is seen.
  bool crossing_between(double before, double after) {
    const double parts = std::max(1.0, std::ceil((after - before) / gap_ * (1 - 1e-9)));
    double from = before;
    for (double i = 1; i <= parts; ++i) {
      const double to = i < parts ? before + (after - before) * i / parts : after;
      const auto found = roots_.first(from, to, [this](double t, double* values) { guards_at(t, values); });
      if (found) {
        const double at = found->time;
        before_event_ = found->before;
        fired_.assign(found->fired.begin(), found->fired.end());
        log_between(before, at);
        if (!program_.kernels.empty()) advance_kernels_through(before, at);
        put_states_of(at);
        t_ = at;
        watch_for_zeno(at);
        event(true);
        return true;
      }
      if (i == 1 || i == parts) {
        put_states_of(to);
        if (in_wrong_mode(before, to)) return true;
      }
      roots_.remember(roots_.values());
      from = to;
    }
    return false;
  }

  // A function that was zero at the start of a step has no sign to change. When the end of the step shows another mode
  // than the one that was used, the step is taken again in that mode.
  bool in_wrong_mode(double before, double after) {
    if (program_.modes.empty() || !modes_differ()) return false;
    if (retried_at_ == before) {  // it turns either way: go on from the end with what holds there
      log_between(before, after);
      t_ = before_event_ = after;
      if (!program_.kernels.empty()) advance_kernels_through(before, after);
      fired_.clear();
      event(true);
      return true;
    }
    retried_at_ = before;
    take_modes();
    put_states_of(before);
    KernelFrame kernels = frame_.kernel_frame(false);
    execute(program_.held_list, frame_.arena, &kernels, event_bit);
    t_ = before;
    restart_ = true;
    ++statistics_.mode_changes;
    return true;
  }

  void watch_for_zeno(double at) {
    const double tolerance = event_tolerance(at, options_.event_tol);
    events_in_a_row_ = at - last_event_ < 1e3 * tolerance ? events_in_a_row_ + 1 : 0;
    last_event_ = at;
    if (events_in_a_row_ > most_events_in_a_row) {
      throw RunError(fmt::format("at time {} s events follow each other without end: {}", at, names_of_fired()), at);
    }
  }

  bool a_jump_fired() const {
    return std::any_of(fired_.begin(), fired_.end(),
                       [this](int g) { return program_.guards[static_cast<std::size_t>(g)].is_jump; });
  }

  std::string names_of_fired() const {
    std::string names;
    for (const int g : fired_) {
      const Program::Guard& guard = program_.guards[static_cast<std::size_t>(g)];
      const std::string name = guard.is_jump ? program_.jumps[guard.index].name : mode_name(guard.index);
      if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
    }
    return names;
  }

  std::string mode_name(std::size_t mode) const {
    return program_.sites[program_.resolved->graph.modes[mode].site].path;
  }

  // --- events -----------------------------------------------------------------------------------------------------

  // Where the segments, held values or states may have changed at t_: the left row, jumps and modes until they settle,
  // the right row.
  void event(bool located) {
    if (located) {
      ++statistics_.events;
      log_at(t_, true);
    }
    settle_events(located ? fired_ : std::vector<int>{}, event_bit);
    log_right(event_bit);
    if (!program_.kernels.empty()) advance_kernels(false);
    restart_ = true;
  }

  // `fired` are guards that are known to have crossed; further ones are found by their signs.
  void settle_events(std::vector<int> fired, Mask bits) {
    bool states_changed = false;
    for (int pass = 0;; ++pass) {
      if (pass == most_passes) {
        fired_ = fired;
        throw RunError(fmt::format("at time {} s events do not settle: {}", t_, names_of_fired()), t_);
      }
      states_changed = jump(fired) || states_changed;
      settle(bits);
      if (program_.guards.empty()) break;
      const std::vector<int> before = std::move(fired);
      fired = guards_fired_by_now(before);
      if (fired.empty()) break;
    }
    restart_ = restart_ || states_changed;
  }

  // Applies the jumps among the guards; their values come from before any of them.
  bool jump(const std::vector<int>& fired) {
    bool any = false;
    for (const int g : fired) any = any || program_.guards[static_cast<std::size_t>(g)].is_jump;
    if (!any) return false;
    KernelFrame kernels = frame_.kernel_frame(true);
    execute(program_.jump_list, frame_.arena, &kernels);
    std::vector<std::pair<SlotIndex, double>> changes;
    for (const int g : fired) {
      const Program::Guard& guard = program_.guards[static_cast<std::size_t>(g)];
      if (!guard.is_jump) continue;
      const Program::Jump& jump = program_.jumps[guard.index];
      recording_.events[jump.name].push_back(t_);
      for (std::size_t i = 0; i < jump.targets.size(); ++i) {
        changes.emplace_back(jump.targets[i].slot, frame_.arena[program_.jump_list.roots[jump.first_value + i]]);
      }
    }
    for (const auto& [slot, value] : changes) frame_.arena[slot] = value;
    return true;
  }

  // Which jumps fire because something changed discontinuously; takes all signs into memory.
  std::vector<int> guards_fired_by_now(const std::vector<int>& just_fired) {
    KernelFrame kernels = frame_.kernel_frame(false);
    execute(program_.guard_list, frame_.arena, &kernels);
    std::vector<int> fired;
    std::vector<double>& values = guard_values_;
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = frame_.arena[program_.guard_list.roots[i]];
      const int sign = values[i] > 0 ? 1 : values[i] < 0 ? -1 : 0;
      const Program::Guard& guard = program_.guards[i];
      const bool new_one = std::find(just_fired.begin(), just_fired.end(), static_cast<int>(i)) == just_fired.end();
      if (guard.is_jump && new_one && sign != 0 && roots_.signs()[i] == -sign &&
          (guard.direction == 0 || guard.direction == sign)) {
        fired.push_back(static_cast<int>(i));
      }
    }
    roots_.remember_fired(just_fired, values);
    // The memory of those that fired is not touched again.
    for (const int g : just_fired) values[static_cast<std::size_t>(g)] = std::numeric_limits<double>::quiet_NaN();
    roots_.remember(values);
    return fired;
  }

  void remember_guards() {
    if (program_.guards.empty()) return;
    KernelFrame kernels = frame_.kernel_frame(false);
    execute(program_.guard_list, frame_.arena, &kernels);
    for (std::size_t i = 0; i < guard_values_.size(); ++i)
      guard_values_[i] = frame_.arena[program_.guard_list.roots[i]];
    roots_.remember(guard_values_);
  }

  // Runs the held operations of these bits, and takes modes by the present values until they stay.
  void settle(Mask bits) {
    frame_.arena[program_.time] = t_;
    KernelFrame kernels = frame_.kernel_frame(false);
    execute(program_.held_list, frame_.arena, &kernels, bits);
    if (program_.modes.empty()) return;
    for (int pass = 0; modes_differ(); ++pass) {
      if (pass == most_passes) {
        throw RunError(fmt::format("at time {} s events do not settle: {}", t_, name_of_differing_mode()), t_);
      }
      take_modes();
      ++statistics_.mode_changes;
      execute(program_.held_list, frame_.arena, &kernels, bits | event_bit);
    }
  }

  bool modes_differ() {
    KernelFrame kernels = frame_.kernel_frame(false);
    execute(program_.mode_list, frame_.arena, &kernels);
    for (std::size_t m = 0; m < program_.modes.size(); ++m) {
      const double now = frame_.arena[program_.mode_list.roots[m]];
      if (now != frame_.arena[program_.modes[m]] && !std::isnan(now)) return true;
    }
    return false;
  }

  std::string name_of_differing_mode() const {
    for (std::size_t m = 0; m < program_.modes.size(); ++m) {
      if (frame_.arena[program_.mode_list.roots[m]] != frame_.arena[program_.modes[m]]) return mode_name(m);
    }
    return {};
  }

  void take_modes() {
    for (std::size_t m = 0; m < program_.modes.size(); ++m) {
      frame_.arena[program_.modes[m]] = frame_.arena[program_.mode_list.roots[m]];
    }
  }

  // --- stops ------------------------------------------------------------------------------------------------------

  void at_stop() {
    for (std::size_t i = 0; i < held_before_.size(); ++i)
      held_before_[i] = frame_.arena[program_.held_in_derivatives[i]];
    const Mask bits = clockwork_->advance(t_);
    if (bits == 0 && has_continuous_ && t_ >= options_.stop) return;  // the last row stands already
    if (!program_.kernels.empty() && kernel_jumps_by(t_)) {
      advance_kernels(false);
      restart_ = true;
    }
    settle_events({}, bits);
    for (std::size_t i = 0; i < held_before_.size() && !restart_; ++i) {
      restart_ = held_before_[i] != frame_.arena[program_.held_in_derivatives[i]];
    }
    log_right(bits);
    update(bits);
    if (!program_.kernels.empty()) advance_kernels(false);
    statistics_.hits += static_cast<std::int64_t>(clockwork_->hit_rates().size());
    if (frame_.state_count() > 0) ++(restart_ ? statistics_.solver.cold_restarts : statistics_.solver.hot_restarts);
  }

  // The discrete states of the rates that had a hit. What anybody reads are copies taken at the hit, so no order
  // matters.
  void update(Mask bits) {
    for (std::size_t i = 0; i < program_.discretes.size(); ++i) {
      if ((rate_bit(program_.discrete_rates[i]) & bits) != 0 && had_hit(program_.discrete_rates[i])) {
        const double next = frame_.arena[program_.nexts[i]];
        if (!std::isfinite(next)) {
          throw not_finite(
              frame_, program_.resolved->nexts[i],
              fmt::format("the next value of '{}' is {}", program_.discrete_names[i], number_in_words(next)), t_);
        }
        frame_.arena[program_.discretes[i]] = next;
      }
    }
    for (const Program::KernelState& kernel : program_.kernels) {
      if (!kernel.continuous && (kernel.mask & bits) != 0) advance_kernel(kernel, false);
    }
  }

  bool had_hit(RateIndex rate) const {
    const auto& hits = clockwork_->hit_rates();
    return std::find(hits.begin(), hits.end(), rate) != hits.end();
  }

  void advance_kernels(bool left) {
    if (program_.kernels.empty()) return;
    KernelFrame kernels = frame_.kernel_frame(left);
    frame_.arena[program_.time] = t_;
    execute(program_.advance_list, frame_.arena, &kernels);
    for (const Program::KernelState& kernel : program_.kernels) {
      if (kernel.continuous) advance_kernel(kernel, left);
    }
  }

  // The accepted step from `before` to `after`, or the part of it until an event: some points inside it for kernels
  // with a history, which interpolate between them, then its end.
  void advance_kernels_through(double before, double after) {
    constexpr int parts = 4;
    const double now = t_;
    if (program_.history_count > 0) {
      for (int i = 1; i < parts; ++i) {
        t_ = before + (after - before) * i / parts;
        put_states_of(t_);
        KernelFrame kernels = frame_.kernel_frame(true);
        execute(program_.advance_list, frame_.arena, &kernels);
        for (const Program::KernelState& kernel : program_.kernels) {
          if (kernel.continuous && kernel.kernel->histories() > 0) advance_kernel(kernel, true);
        }
      }
      put_states_of(after);
    }
    t_ = after;
    advance_kernels(true);
    t_ = now;
  }

  KernelCall call_of(const Program::KernelState& kernel) {
    double* in = frame_.scratch.data();
    for (std::size_t i = 0; i < kernel.advance_inputs.size(); ++i) in[i] = frame_.arena[kernel.advance_inputs[i]];
    KernelCall call;
    call.time = t_;
    call.in = in;
    call.state = frame_.kernel_states.data() + kernel.first_state;
    call.scratch = in + kernel.advance_inputs.size();
    call.history = frame_.histories.data() + kernel.first_history;
    return call;
  }

  void advance_kernel(const Program::KernelState& kernel, bool left) {
    KernelCall call = call_of(kernel);
    call.left = left;
    kernel.kernel->advance(call);
  }

  // The next instant at which a continuous kernel's output jumps.
  double next_kernel_jump() {
    double next = std::numeric_limits<double>::infinity();
    for (const Program::KernelState& kernel : program_.kernels) {
      if (kernel.continuous) next = std::min(next, kernel.kernel->next_jump(call_of(kernel)));
    }
    return next;
  }
  bool kernel_jumps_by(double t) {
    const double jump = next_kernel_jump();
    return jump <= t || is_same_instant(jump, t);
  }

  double longest_step() {
    double longest = std::numeric_limits<double>::infinity();
    for (const Program::KernelState& kernel : program_.kernels) {
      double* in = frame_.scratch.data();
      for (std::size_t i = 0; i < kernel.advance_inputs.size(); ++i) in[i] = frame_.arena[kernel.advance_inputs[i]];
      if (kernel.continuous) longest = std::min(longest, kernel.kernel->longest_step(in));
    }
    return longest;
  }

  // --- rows -------------------------------------------------------------------------------------------------------

  void evaluate_row(double t, bool left) {
    if (!row_is_finite(t, left)) throw_blame(t);
  }

  bool row_is_finite(double t, bool left) {
    frame_.arena[program_.time] = t;
    if (!program_.watch_list.empty()) {
      KernelFrame kernels = frame_.kernel_frame(left);
      execute(program_.watch_list, frame_.arena, &kernels);
    }
    const SlotIndex* const slots = program_.watch_list.roots.data();
    const std::size_t n = row_.size();
    bool finite = true;
    for (std::size_t i = 0; i < n; ++i) {
      row_[i] = frame_.arena[slots[i]];
      finite = finite && std::isfinite(row_[i]);
    }
    return finite;
  }

  [[noreturn]] void throw_blame(double t) {
    const auto bad = std::find_if(row_.begin(), row_.end(), [](double v) { return !std::isfinite(v); });
    const auto column = static_cast<std::size_t>(bad - row_.begin());
    const std::string& name = recording_.columns[column].name;
    throw not_finite(frame_, program_.resolved->watches[column],
                     fmt::format("'{}' became {}", name, number_in_words(row_[column])), t);
  }

  void append(double t, std::int8_t side) {
    if (static_cast<std::int64_t>(recording_.rows()) >= options_.max_rows) {
      throw LimitError(
          fmt::format("at time {} s the result has {} rows, the limit (simulation: max_rows)", t, options_.max_rows),
          t);
    }
    if (recording_.rows() > most_rows_in_memory_) {
      throw LimitError(
          fmt::format("at time {} s the result takes {:.1f} GB of memory, the limit", t, options_.max_memory / 1e9), t);
    }
    recording_.append(t, side, row_);
  }

  // --- samples ----------------------------------------------------------------------------------------------------

  void take_sample_times() {
    std::vector<double> times = options_.sample_times;
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    recording_.samples.clear();
    for (const double t : times) {
      if (t >= options_.start && t <= options_.stop) recording_.samples.push_back({t, {}, {}});
    }
  }

  double next_sample() const {
    return next_sample_ < recording_.samples.size() ? recording_.samples[next_sample_].time
                                                    : std::numeric_limits<double>::infinity();
  }

  // The samples inside a step; the states are then anywhere between.
  void sample_between(double before, double after) {
    while (next_sample() <= before || sampled_with(before)) ++next_sample_;
    for (; next_sample() < after && !sampled_with(after); ++next_sample_) {
      put_states_of(next_sample());
      evaluate_row(next_sample(), true);
      recording_.samples[next_sample_].left = recording_.samples[next_sample_].right = row_;
    }
  }

  // A sample this near to an event or stop is taken there, on both sides.
  bool sampled_with(double t) const { return std::fabs(next_sample() - t) <= event_tolerance(t, options_.event_tol); }

  // The row just evaluated is that of t: before anything happens there, or after everything has.
  void sample_at(bool left) {
    Recording::Sample& sample = recording_.samples[next_sample_];
    if (left || sample.left.empty()) sample.left = row_;
    sample.right = row_;
  }

  // Rows inside an accepted step: the output grid, or as many as keep the gaps small.
  void log_between(double before, double after) {
    const bool on_grid = options_.output_interval > 0;
    const bool fills_gap = !on_grid && options_.step <= 0 && frame_.state_count() > 0 && after - before > gap_;
    const bool grid_inside = on_grid && grid_time(next_grid_) < after;
    if (!fills_gap && !grid_inside && next_sample() >= after) return;
    std::copy(frame_.states(), frame_.states() + frame_.state_count(), saved_states_.begin());
    if (fills_gap) {
      const double n = std::ceil((after - before) / gap_ * (1 - 1e-9));
      for (double i = 1; i < n; ++i) row_inside(before + (after - before) * i / n);
    }
    for (; on_grid && grid_time(next_grid_) < after; ++next_grid_) row_inside(grid_time(next_grid_));
    sample_between(before, after);
    std::copy(saved_states_.begin(), saved_states_.end(), frame_.states());
    frame_.arena[program_.time] = after;
  }

  void row_inside(double t) {
    put_states_of(t);
    evaluate_row(t, true);
    append(t, 0);
  }

  double grid_time(std::int64_t k) const { return output_grid_.at(k); }

  // The row at the end of a step: the left one, should something jump here.
  void log_at(double t, bool at_event = false) {
    const bool sampled = sampled_with(t);
    // On a grid the value after a jump counts, so a grid time that is a stop or an event is logged by log_right.
    const bool wanted = options_.output_interval > 0 ? grid_time(next_grid_) <= t && t < clockwork_->next() && !at_event
                                                     : recording_.rows() == 0 || recording_.time().back() < t;
    if (!wanted && !sampled) return;
    if (!row_is_finite(t, true) || (at_event && a_jump_fired())) {
      // At an event the state is beyond the crossing by rounding. What was selected until now need not exist there, as
      // sqrt(-1e-17), and a limit must not be passed: the left row shows what is just before.
      if (!at_event) throw_blame(t);
      put_states_of(before_event_);
      evaluate_row(before_event_, true);
      put_states_of(t);
    }
    if (sampled) sample_at(true);
    if (!wanted) return;
    append(t, 0);
    if (options_.output_interval > 0) ++next_grid_;
  }

  // The row after everything at t_ has settled; it takes the place of the left one unless a continuous column jumped.
  void log_right(Mask bits) {
    const bool on_grid = options_.output_interval > 0;
    const bool sampled = sampled_with(t_);
    const bool wanted = !on_grid || grid_time(next_grid_) <= t_;
    if (!wanted && !sampled) return;
    evaluate_row(t_, false);
    if (sampled) sample_at(false);
    if (!wanted) return;
    const std::size_t last = recording_.rows();
    if (!on_grid && last > 0 && recording_.time().back() == t_) {
      bool jumped = false;
      for (std::size_t i = 0; i < row_.size(); ++i) {
        jumped = jumped || (recording_.columns[i].rate == 0 && row_[i] != recording_.at(last - 1, i));
      }
      if (jumped) {
        recording_.set_side(last - 1, -1);
      } else {
        recording_.remove_last_row();
      }
      append(t_, static_cast<std::int8_t>(jumped ? 1 : 0));
    } else {
      append(t_, 0);
      if (on_grid) ++next_grid_;
    }
    for (const RateIndex rate : clockwork_->hit_rates()) {
      if ((rate_bit(rate) & bits) != 0) recording_.mark_hit(rate);
    }
  }

  // --- limits -----------------------------------------------------------------------------------------------------

  void watch_limits() {
    if (statistics_.solver.steps >= options_.max_steps) {
      throw LimitError(fmt::format("at time {} s the run has taken {} steps, the limit (simulation: max_steps)", t_,
                                   options_.max_steps),
                       t_);
    }
    if (control_.cancel != nullptr && control_.cancel->load(std::memory_order_relaxed)) {
      throw LimitError(fmt::format("the run was stopped at time {} s", t_), t_);
    }
    if ((control_.time_limit > 0 || control_.progress) && (++ticks_ & 255) == 0) look_at_the_clock();
  }

  void look_at_the_clock() {
    const auto now = std::chrono::steady_clock::now();
    const double elapsed = std::chrono::duration<double>(now - began_).count();
    if (control_.time_limit > 0 && elapsed > control_.time_limit) {
      throw LimitError(fmt::format("at time {} s the run has taken {:g} s, the time limit", t_, control_.time_limit),
                       t_);
    }
    if (control_.progress && std::chrono::duration<double>(now - reported_).count() > 0.1) {
      reported_ = now;
      control_.progress((t_ - options_.start) / (options_.stop - options_.start));
    }
  }

  double take_step(double stop) {
    try {
      return integrator_->step(stop);
    } catch (const StateError& e) {
      if (const auto after = step_following_modes(stop)) return *after;
      // The solver knows states by number; say which one, and where its value came from.
      const auto place = static_cast<std::size_t>(std::max(e.state(), 0));
      const std::string& name = program_.state_names[place];
      const std::uint32_t derivative = program_.resolved->derivatives[program_.state_at[place]];
      throw solver_failed(frame_, derivative, e, name);
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
      integrator_->restart(t_);
      after = integrator_->step(stop);
      integrator_->interpolate(*after, frame_.states());  // what it needs for others is evaluated now
    } catch (const StateError&) {
      after.reset();
    }
    system_->follows_modes = false;
    for (std::size_t m = 0; m < modes.size(); ++m) frame_.arena[program_.modes[m]] = modes[m];
    KernelFrame kernels = frame_.kernel_frame(true);
    execute(program_.held_list, frame_.arena, &kernels, event_bit);
    return after;
  }

  void finish() {
    statistics_.rows = static_cast<std::int64_t>(recording_.rows());
    if (!integrator_) return;
    const SolverStatistics& s = integrator_->statistics();
    statistics_.solver.rejected = s.rejected;
    statistics_.solver.evaluations = s.evaluations + steps_by_list_ * stages_of(options_.solver);
    statistics_.solver.jacobians = s.jacobians;
  }

  Frame& frame_;
  const Program& program_;
  const SimulationOptions& options_;
  Recording& recording_;
  const RunControl& control_;
  double gap_;
  double t_ = 0;
  std::vector<double> row_;
  std::size_t most_rows_in_memory_;
  std::vector<double> saved_states_, held_before_, guard_values_;
  TimeGrid output_grid_;
  TimeGrid step_grid_;  // of a diagram without states
  std::int64_t next_step_ = 1;
  std::optional<Clockwork> clockwork_;
  std::optional<ProgramSystem> system_;
  std::unique_ptr<Integrator> integrator_;
  RootFinder roots_;
  std::vector<int> fired_;
  double before_event_ = 0;  // s; none of fired_ has crossed there
  bool restart_ = true;
  bool has_continuous_ = true;
  double retried_at_ = std::numeric_limits<double>::quiet_NaN();
  double last_event_ = -std::numeric_limits<double>::infinity();
  int events_in_a_row_ = 0;
  std::int64_t next_grid_ = 0;
  std::int64_t steps_by_list_ = 0;
  std::size_t next_sample_ = 0;
  unsigned ticks_ = 0;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point reported_ = began_;
  RunStatistics statistics_;
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
