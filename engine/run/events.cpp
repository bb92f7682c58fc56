// Events are located on the dense output of an accepted step; then jumps and modes settle by passes.

#include "engine/run/events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/error.h"
#include "engine/program/resolve.h"

namespace plantloop {

namespace {

constexpr int most_passes = 100;            // of event iteration
constexpr int most_events_in_a_row = 1000;  // of one function, closer together than 1000 event tolerances
constexpr int most_events_beyond = 100;     // the limit of a series
constexpr double near_of_run = 0.05;        // of the search gap, that is 1e-4 of the run
constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<Direction> directions_of_guards(const Program& program) {
  std::vector<Direction> directions;
  for (const Program::Guard& guard : program.guards) directions.push_back(static_cast<Direction>(guard.direction));
  return directions;
}

std::vector<std::int8_t> signs_at_zero(const Program& program) {
  std::vector<std::int8_t> signs;
  for (const Program::Guard& guard : program.guards) signs.push_back(static_cast<std::int8_t>(guard.at_zero));
  return signs;
}

}  // namespace

Events::Events(RunState& run, KernelAdvance& kernels, Rows& rows)
    : run_(run),
      frame_(run.frame),
      program_(run.program),
      options_(run.options),
      kernels_(kernels),
      rows_(rows),
      roots_(directions_of_guards(run.program), run.options.event_tol, signs_at_zero(run.program)),
      guard_values_(run.program.guards.size()),
      was_open_(run.program.guards.size(), 1),
      last_event_(run.program.guards.size(), -infinity),
      quiet_until_(run.program.guards.size(), -infinity),
      in_a_row_(run.program.guards.size(), 0),
      sign_when_muted_(run.program.guards.size(), 0),
      woken_at_(run.program.guards.size(), -infinity),
      told_(run.program.guards.size(), 0),
      left_true_(run.program.guards.size(), no),
      left_since_(run.program.guards.size(), -infinity),
      left_value_(run.program.guards.size(), 0),
      accumulations_(run.program.guards.size()) {}

void Events::forget_steps() {
  wanted_stop_ = -infinity;
  retried_at_ = std::numeric_limits<double>::quiet_NaN();
  std::fill(accumulations_.begin(), accumulations_.end(), Accumulation{});
  std::fill(woken_at_.begin(), woken_at_.end(), -infinity);
  for (std::size_t i = 0; i < left_true_.size(); ++i) {
    if (left_true_[i] == is_turned) left_true_[i] = yes;
    left_since_[i] = run_.t;
  }
}

double Events::wanted_stop() const {
  double stop = wanted_stop_;
  for (std::size_t i = 0; any_muted_ && i < quiet_until_.size(); ++i) {
    if (quiet_until_[i] > run_.t && quiet_until_[i] < infinity && !(stop > run_.t && stop < quiet_until_[i])) {
      stop = quiet_until_[i];
    }
  }
  return stop;
}

void Events::guards_at(double t, double* values) {
  run_.put_states_of(t);
  KernelFrame kernels = frame_.kernel_frame(true);
  execute(program_.guard_list, frame_.arena, &kernels);
  for (std::size_t i = 0; i < program_.guards.size(); ++i) values[i] = frame_.arena[program_.guard_list.roots[i]];
  for (std::size_t i = 0; any_muted_ && i < program_.guards.size(); ++i) {
    if (is_muted(i)) values[i] = std::numeric_limits<double>::quiet_NaN();  // it fires no more, its sign is kept
  }
}

bool Events::crossing_between(double before, double after) {
  if (any_muted_) wake();
  const double parts = std::max(1.0, std::ceil((after - before) / run_.search_gap * (1 - 1e-9)));
  double from = before;
  seen_.clear();
  if (any_left_true_ && ends_zeno_after(before, after)) return true;
  auto seen = seen_.cbegin();
  for (double i = 1; i <= parts;) {
    double to = i < parts ? before + (after - before) * i / parts : after;
    while (seen != seen_.cend() && *seen <= from) ++seen;
    if (seen != seen_.cend() && *seen < to) {
      to = *seen;
    } else {
      ++i;
    }
    const auto found = roots_.first(from, to, [this](double t, double* values) { guards_at(t, values); });
    if (found) {
      const double at = found->time;
      before_event_ = found->before;
      fired_.assign(found->fired.begin(), found->fired.end());
      if (step_again(before, at)) return true;
      rows_.log_between(before, at);
      if (!kernels_.none()) kernels_.through(before, at);
      run_.put_states_of(at);
      run_.t = at;
      run_.restart = false;  // until something that happens here says so
      watch_for_zeno(at);
      event(true);
      return true;
    }
    if (from == before || to == after) {
      run_.put_states_of(to);
      if (in_wrong_mode(before, to)) return true;
    }
    roots_.remember(roots_.values());
    from = to;
  }
  return false;
}

// Beyond the instant at which a kernel's output is not smooth the step used what held before, so that its dense output
// is bent. The step is taken again, up to there.
bool Events::step_again(double before, double at) {
  if (!only_kernels_fired(fired_) || before < wanted_stop_) return false;  // once for each such instant
  if (at - before < 1e3 * event_tolerance(at, options_.event_tol)) return false;
  wanted_stop_ = at;
  run_.put_states_of(before);
  run_.t = before;
  run_.restart = true;
  return true;
}

// A function that was zero at the start of a step has no sign to change. When the end of the step shows another mode
// than the one that was used, the step is taken again in that mode.
bool Events::in_wrong_mode(double before, double after) {
  if (program_.modes.empty() || !modes_differ()) return false;
  if (retried_at_ == before) {  // it turns either way: go on from the end with what holds there
    rows_.log_between(before, after);
    run_.t = before_event_ = after;
    if (!kernels_.none()) kernels_.through(before, after);
    fired_.clear();
    event(true);
    return true;
  }
  retried_at_ = before;
  if (!program_.holds.empty()) {  // what was active at `before` only keeps the value from there
    run_.t = before;
    run_.put_states_of(before);
    take_holds(before);
    run_.put_states_of(after);
    modes_differ();
  }
  take_modes();
  run_.put_states_of(before);
  KernelFrame kernels = frame_.kernel_frame(false);
  execute(program_.held_list, frame_.arena, &kernels, event_bit);
  run_.t = before;
  run_.restart = true;
  ++run_.statistics.mode_changes;
  return true;
}

void Events::watch_for_zeno(double at) {
  const double close = 1e3 * event_tolerance(at, options_.event_tol);
  if (!run_.still.empty() || any_muted_) release();
  for (const int g : fired_) {
    const auto i = static_cast<std::size_t>(g);
    run_.watch.fired(i, at);
    in_a_row_[i] = at - last_event_[i] < close ? in_a_row_[i] + 1 : 0;
    last_event_[i] = at;
    accumulations_[i].add(at, std::max(close, near_of_run * run_.search_gap));
    if (in_a_row_[i] > most_events_in_a_row || accumulations_[i].beyond() > most_events_beyond)
      end_zeno(i, at, roots_.signs()[i]);
  }
}

void Accumulation::add(double t, double most) {
  times_[count_++ % times_.size()] = t;
  if (const double left = remaining(); left < most) {
    limit_ = t + left;
    width_ = std::max(width_, left);
  } else if (t <= limit_ + 2 * width_) {
    if (limit_ < infinity) ++beyond_;
  } else {
    limit_ = infinity;
    width_ = 0;
    beyond_ = 0;
  }
}

double Accumulation::remaining() const {
  if (count_ < 5) return infinity;
  // The sums of m intervals are a geometric series when the intervals are; what only happens to be a burst is none.
  const std::size_t m = std::min(count_ - 1, times_.size() - 1) / 3;
  const double late = back(0) - back(m);
  const double early = back(m) - back(2 * m);
  const double before = back(2 * m) - back(3 * m);
  const bool is_geometric = late * before < 3 * early * early && early * early < 3 * late * before;
  if (!is_geometric || !(late < 0.95 * early)) return infinity;
  return late * late / (early - late);
}

// Of the functions whose conditions held still after their actions at t: those that the action turned back, that is,
// they head for where they do not hold. Found along the tangent, so that one which turns again at once counts.
std::vector<std::uint8_t> Events::turned_back(double t, double tolerance) {
  std::vector<std::uint8_t> turned(left_true_.size(), 0);
  const std::size_t n = frame_.state_count();
  if (n == 0) return turned;
  run_.put_states_of(t);
  KernelFrame kernels = frame_.kernel_frame(true);
  execute(program_.derivative_list, frame_.arena, &kernels);
  const double* const roots = frame_.arena + program_.derivative_list.roots.front();
  std::vector<double> slopes(roots, roots + n);
  for (const auto place : run_.still) slopes[place] = 0;
  const std::vector<double> states(frame_.states(), frame_.states() + n);
  std::array<std::vector<double>, 4> values;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double s = tolerance * static_cast<double>(k);
    for (std::size_t i = 0; i < n; ++i) frame_.states()[i] = states[i] + s * slopes[i];
    frame_.arena[program_.time] = t + s;
    execute(program_.guard_list, frame_.arena, &kernels);
    for (const auto root : program_.guard_list.roots) values[k].push_back(frame_.arena[root]);
  }
  for (std::size_t i = 0; i < turned.size(); ++i) {
    const auto change = [&](std::size_t k) { return (values[k][i] - values[0][i]) * program_.guards[i].direction; };
    // What is only rounding is not three times as much three times as far away.
    turned[i] = left_true_[i] != no && change(3) < 0 && std::fabs(change(3) - 3 * change(1)) <= -0.1 * change(3) &&
                std::fabs(change(3) - 1.5 * change(2)) <= -0.1 * change(3);
  }
  return turned;
}

// The steps after an event whose action left its condition true. A condition that ceases to hold for a short time is
// found there (`seen_`), however long the step. One that does not get to cease has events that follow each other
// without end, too close to be seen: its action turned it back and it turned again at once, or its events accumulate
// inside the step. Then the run stands at `before` again, and the policy of `zeno` has been applied: true.
bool Events::ends_zeno_after(double before, double after) {
  any_left_true_ = false;
  const double tolerance = event_tolerance(before, options_.event_tol);
  const double close = 1e3 * tolerance;
  const auto holds = [&](std::size_t i, double value) {
    const Program::Guard& guard = program_.guards[i];
    return value * guard.direction > 0 || (value == 0 && guard.at_zero == guard.direction);
  };
  std::vector<std::uint8_t> suspects(left_true_.size(), 0);
  std::vector<std::uint8_t> ends(left_true_.size(), 0);
  std::vector<std::uint8_t> waits(left_true_.size(), 0);  // for the limit of its events
  std::vector<std::uint8_t> ceases(left_true_.size(), no);
  const std::vector<std::uint8_t> turned = turned_back(before, close / 3);
  bool any = false;
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    if (left_true_[i] == no || is_muted(i)) continue;
    const double limit = std::max(accumulations_[i].limit(), left_since_[i] + close);
    const bool accumulates = last_event_[i] == left_since_[i] && limit < infinity;
    ends[i] = accumulates && limit <= after;
    waits[i] = accumulates && ends[i] == 0;
    if (left_true_[i] == yes && turned[i] != 0) left_true_[i] = is_turned;
    suspects[i] = accumulates || left_true_[i] != yes;
    any = any || suspects[i] != 0;
  }
  std::vector<double> values(suspects.size());
  if (any) guards_at(before, values.data());
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    if (suspects[i] != 0 && left_since_[i] == before) left_value_[i] = std::fabs(values[i]);
  }
  bool last = !any;
  for (double s = tolerance / 8; !last; s *= 2) {
    last = before + s >= after;
    guards_at(last ? after : before + s, values.data());
    for (std::size_t i = 0; i < suspects.size(); ++i) {
      if (suspects[i] == 0) continue;
      if (!holds(i, values[i])) {
        if (!last && (seen_.empty() || seen_.back() < before + s)) seen_.push_back(before + s);
        suspects[i] = ends[i] = 0;
        ceases[i] = std::exchange(left_true_[i], std::uint8_t{no});
        continue;
      }
      const bool is_grown = before + s - left_since_[i] <= close && std::fabs(values[i]) > left_value_[i];
      if (left_true_[i] == is_turned && is_grown) ends[i] = 1;
    }
  }
  any = false;
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    if (suspects[i] != 0 && after - left_since_[i] > close && left_true_[i] == by_zeno) ends[i] = 1;
    if (suspects[i] == 0 || ends[i] != 0 || (after - left_since_[i] > close && waits[i] == 0)) {
      left_true_[i] = no;
    } else {
      any_left_true_ = true;  // too early to tell
    }
    if (ends[i] == 0) continue;
    if (!any) {
      run_.put_states_of(before);
      run_.t = before;
      run_.restart = any = true;
    }
    end_zeno(i, before, static_cast<std::int8_t>(-program_.guards[i].direction));
  }
  // The step is taken again: what it showed is to be seen then.
  for (std::size_t i = 0; any && i < ceases.size(); ++i) {
    if (ceases[i] == no) continue;
    left_true_[i] = ceases[i];
    any_left_true_ = true;
  }
  return any;
}

void Events::note_left_true(const std::vector<int>& fired) {
  for (const int g : fired) {
    const auto i = static_cast<std::size_t>(g);
    const Program::Guard& guard = program_.guards[i];
    if (!guard.is_jump || guard.direction == 0 || program_.jumps[guard.index].targets.empty()) continue;
    if (roots_.signs()[i] != guard.direction) continue;
    left_true_[i] = woken_at_[i] <= run_.t && is_near(woken_at_[i], run_.t) ? by_zeno : yes;
    left_since_[i] = run_.t;
    any_left_true_ = true;
  }
}

// A function whose events follow each other without end: the policy of `zeno`.
// `sign`: the one that counts as the function's last when it is looked at again after a time.
void Events::end_zeno(std::size_t i, double at, std::int8_t sign) {
  const Program::Guard& function = program_.guards[i];
  const std::string name = name_of(function);
  const std::string what = fmt::format("at time {} s events follow each other without end: {}", at, name);
  if (options_.zeno == "error") {
    throw RunError(what +
                       "\n  a hysteresis, or a restitution that ends, makes them end; or go on with simulation: {zeno: "
                       "hold} or {zeno: ignore}",
                   at);
  }
  in_a_row_[i] = 0;
  any_muted_ = true;
  sign_when_muted_[i] = sign;
  const bool tell = std::exchange(told_[i], 1) == 0;
  if (options_.zeno == "ignore") {
    quiet_until_[i] = at + run_.search_gap;
    if (tell) {
      run_.statistics.warnings.push_back(
          fmt::format("{}; it is not looked at for {:g} s (zeno: ignore)", what, run_.search_gap));
    }
    return;
  }
  quiet_until_[i] = infinity;
  if (function.is_jump) {
    take_limit(program_.jumps[function.index]);
    for (const auto& target : program_.jumps[function.index].targets) {
      if (!target.discrete) run_.still.push_back(target.slot - program_.states);
    }
  }
  if (!tell) return;
  run_.statistics.warnings.push_back(fmt::format("{}; {} until the next event of something else (zeno: hold)", what,
                                                 function.is_jump ? "what it sets stands still" : "its mode is held"));
}

// What the states become when the action happens without end, if that has a limit: the speed of a ball comes to rest.
void Events::take_limit(const Program::Jump& jump) {
  constexpr int most = 5000;
  constexpr double contraction = 0.999;
  const std::size_t n = jump.targets.size();
  const auto state = [&](std::size_t i) -> double& { return frame_.arena[jump.targets[i].slot]; };
  std::vector<double> start(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (jump.targets[i].discrete) return;
    start[i] = state(i);
  }
  KernelFrame kernels = frame_.kernel_frame(true);
  double last = infinity;
  for (int k = 0; k < most; ++k) {
    execute(program_.jump_list, frame_.arena, &kernels);
    double change = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double next = frame_.arena[program_.jump_list.roots[jump.first_value + i]];
      change = std::max(change, std::fabs(next - state(i)));
    }
    if (change == 0) return;
    if (!(change <= contraction * last)) break;
    last = change;
    for (std::size_t i = 0; i < n; ++i) state(i) = frame_.arena[program_.jump_list.roots[jump.first_value + i]];
    if (k + 1 == most) return;
  }
  for (std::size_t i = 0; i < n; ++i) state(i) = start[i];
}

// Functions that are looked at again fire at once where they have crossed meanwhile.
void Events::wake() {
  any_muted_ = false;
  for (std::size_t i = 0; i < quiet_until_.size(); ++i) {
    if (quiet_until_[i] <= run_.t && quiet_until_[i] > -infinity) {
      quiet_until_[i] = -infinity;
      woken_at_[i] = run_.t;
      roots_.signs()[i] = sign_when_muted_[i];
    }
    any_muted_ = any_muted_ || quiet_until_[i] > run_.t;
  }
}

void Events::release() {
  if (!any_muted_) return;
  wake();
  any_muted_ = false;
  for (std::size_t i = 0; i < quiet_until_.size(); ++i) {
    const Program::Guard& guard = program_.guards[i];
    if (quiet_until_[i] == infinity) {
      quiet_until_[i] = -infinity;
      if (guard.is_jump && guard.direction != 0 && roots_.signs()[i] == guard.direction) {
        left_true_[i] = by_zeno;
        left_since_[i] = run_.t;
        any_left_true_ = true;
      }
    }
    any_muted_ = any_muted_ || quiet_until_[i] > -infinity;
  }
  if (run_.still.empty()) return;
  run_.still.clear();
  run_.restart = true;
}

bool Events::is_frozen(std::size_t mode) const {
  for (std::size_t g = 0; any_muted_ && g < program_.guards.size(); ++g) {
    if (!program_.guards[g].is_jump && program_.guards[g].index == mode && is_muted(g)) return true;
  }
  return false;
}

bool Events::a_jump_fired() const {
  return std::any_of(fired_.begin(), fired_.end(), [this](int g) {
    const Program::Guard& guard = program_.guards[static_cast<std::size_t>(g)];
    return guard.is_jump && !program_.jumps[guard.index].of_kernel;
  });
}

bool Events::only_kernels_fired(const std::vector<int>& fired) const {
  return !fired.empty() && std::all_of(fired.begin(), fired.end(), [this](int g) {
    const Program::Guard& guard = program_.guards[static_cast<std::size_t>(g)];
    return guard.is_jump && program_.jumps[guard.index].of_kernel;
  });
}

std::string Events::names_of_fired() const {
  std::string names;
  for (const int g : fired_) {
    const Program::Guard& guard = program_.guards[static_cast<std::size_t>(g)];
    const std::string name = name_of(guard);
    if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

std::string Events::name_of(const Program::Guard& guard) const {
  if (!guard.is_jump) return mode_name(guard.index);
  const Program::Jump& jump = program_.jumps[guard.index];
  return jump.of_kernel ? fmt::format("what comes out of '{}'", program_.sites[jump.site].path) : jump.name;
}

std::string Events::mode_name(std::size_t mode) const {
  return program_.sites[program_.resolved->graph.modes[mode].site].path;
}

bool Events::is_near(double a, double b) const {
  return std::fabs(a - b) <= 10 * event_tolerance(b, options_.event_tol);
}

void Events::event(bool located) {
  if (located) {
    ++run_.statistics.events;
    rows_.log_left_of_event(run_.t, before_event_, a_jump_fired());
  }
  run_.clockwork->no_hits();
  // Where only a kernel's output is not smooth, the kernel knows how much.
  const bool of_kernels = located && only_kernels_fired(fired_);
  kernels_.broken_by(run_.t);
  const std::int64_t mode_changes = run_.statistics.mode_changes;
  take_holds(before_event_);
  run_.restart = false;  // what an earlier event at this instant asked for makes no kinks now
  const Mask bits = settle_events(located ? fired_ : std::vector<int>{}, event_bit);
  run_.triggered = bits & ~event_bit;
  run_.accept_loops();
  rows_.log_right(bits);
  const bool kinks = !of_kernels || run_.restart || run_.statistics.mode_changes != mode_changes;
  kernels_.after_event(kinks ? 1 : Break::smooth);
  run_.restart = true;
  // Where the step was to end is this instant, but for rounding.
  if (is_near(wanted_stop_, run_.t)) wanted_stop_ = -infinity;
}

Mask Events::settle_events(std::vector<int> fired, Mask bits) {
  bool states_changed = false;
  std::vector<int> all = fired;
  for (int pass = 0;; ++pass) {
    if (pass == most_passes) {
      fired_ = fired;
      throw RunError(fmt::format("at time {} s events do not settle: {}", run_.t, names_of_fired()), run_.t);
    }
    // What comes out of a kernel at a located instant changes no state, and the kernel knows how smooth it is.
    const bool came_out = pass == 0 && only_kernels_fired(fired);
    states_changed = (jump(fired) && !came_out) || states_changed;
    settle(bits);
    if (program_.guards.empty()) break;
    if (const Mask triggered = trigger(fired); triggered != 0) {
      bits |= triggered;
      settle(bits);
    }
    const std::vector<int> before = std::move(fired);
    fired = guards_fired_by_now(before);
    if (fired.empty()) break;
    all.insert(all.end(), fired.begin(), fired.end());
  }
  note_left_true(all);
  run_.restart = run_.restart || states_changed;
  return bits;
}

// The rates of the triggers among the guards that count now.
Mask Events::trigger(const std::vector<int>& fired) {
  Mask bits = 0;
  for (const int g : fired) {
    const Program::Guard& guard = program_.guards[static_cast<std::size_t>(g)];
    if (!guard.is_jump || program_.jumps[guard.index].triggers == 0) continue;
    const Program::Jump& jump = program_.jumps[guard.index];
    if (!is_open(guard.gate) || !is_open(jump.enabled)) continue;
    run_.clockwork->trigger(jump.triggers);
    run_.watch.active(guard.index);
    rows_.recording().events[jump.name].push_back(run_.t);
    bits |= rate_bit(jump.triggers);
  }
  return bits;
}

void Events::take_holds(double before) {
  if (program_.holds.empty()) return;
  frame_.arena[program_.time] = run_.t;
  KernelFrame kernels = frame_.kernel_frame(true);
  execute(program_.hold_list, frame_.arena, &kernels);
  const auto condition = [&](std::size_t i) { return frame_.arena[program_.hold_list.roots[2 * i]]; };
  const auto value = [&](std::size_t i) { return frame_.arena[program_.hold_list.roots[2 * i + 1]]; };
  const auto take = [&] {
    for (std::size_t i = 0; i < program_.holds.size(); ++i) {
      if (condition(i) != 0 && std::isfinite(value(i))) frame_.arena[program_.holds[i]] = value(i);
    }
  };
  for (std::size_t i = 0; before < run_.t && i < program_.holds.size(); ++i) {
    if (condition(i) == 0 || std::isfinite(value(i))) continue;
    // The state is beyond the crossing by rounding, where the value need not exist: the one just before it holds.
    run_.put_states_of(before);
    execute(program_.hold_list, frame_.arena, &kernels);
    take();
    run_.put_states_of(run_.t);
    execute(program_.hold_list, frame_.arena, &kernels);
    break;
  }
  take();
}

// Applies the jumps among the guards; their values come from before any of them.
bool Events::jump(const std::vector<int>& fired) {
  bool any = false;
  for (const int g : fired) any = any || program_.guards[static_cast<std::size_t>(g)].is_jump;
  if (!any) return false;
  KernelFrame kernels = frame_.kernel_frame(true);
  execute(program_.jump_list, frame_.arena, &kernels);
  std::vector<std::pair<SlotIndex, double>> changes;
  for (const int g : fired) {
    const Program::Guard& guard = program_.guards[static_cast<std::size_t>(g)];
    if (!guard.is_jump || !is_open(guard.gate)) continue;
    const Program::Jump& jump = program_.jumps[guard.index];
    if (jump.triggers != 0 || jump.of_kernel) continue;
    run_.watch.active(guard.index);
    rows_.recording().events[jump.name].push_back(run_.t);
    for (std::size_t i = 0; i < jump.targets.size(); ++i) {
      changes.emplace_back(jump.targets[i].slot, frame_.arena[program_.jump_list.roots[jump.first_value + i]]);
    }
  }
  for (const auto& [slot, value] : changes) frame_.arena[slot] = value;
  return true;
}

// Which jumps fire because something changed discontinuously; takes all signs into memory.
std::vector<int> Events::guards_fired_by_now(const std::vector<int>& just_fired) {
  KernelFrame kernels = frame_.kernel_frame(false);
  execute(program_.guard_list, frame_.arena, &kernels);
  std::vector<int> fired;
  std::vector<double>& values = guard_values_;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = frame_.arena[program_.guard_list.roots[i]];
    const Program::Guard& guard = program_.guards[i];
    const bool new_one = std::find(just_fired.begin(), just_fired.end(), static_cast<int>(i)) == just_fired.end();
    // What begins to be watched now has not crossed: it had no sign before.
    const bool watched = was_open_[i] != 0 && is_open(guard.gate);
    was_open_[i] = is_open(guard.gate) ? 1 : 0;
    if (!guard.is_jump || !new_one || is_muted(i)) continue;
    if (watched ? roots_.fires(i, values[i]) : is_due(guard, values[i])) fired.push_back(static_cast<int>(i));
  }
  roots_.remember_fired(just_fired, values);
  // The memory of those that fired is not touched again.
  for (const int g : just_fired) values[static_cast<std::size_t>(g)] = std::numeric_limits<double>::quiet_NaN();
  roots_.remember(values);
  return fired;
}

bool Events::is_due(const Program::Guard& guard, double value) const {
  return guard.is_jump && program_.jumps[guard.index].level && is_open(guard.gate) && value > 0;
}

std::vector<int> Events::remember_guards() {
  std::vector<int> due;
  if (program_.guards.empty()) return due;
  KernelFrame kernels = frame_.kernel_frame(false);
  execute(program_.guard_list, frame_.arena, &kernels);
  for (std::size_t i = 0; i < guard_values_.size(); ++i) guard_values_[i] = frame_.arena[program_.guard_list.roots[i]];
  for (std::size_t i = 0; i < was_open_.size(); ++i) {
    was_open_[i] = is_open(program_.guards[i].gate) ? 1 : 0;
    if (program_.guards[i].is_jump && guard_values_[i] > 0) run_.watch.active(program_.guards[i].index);
    if (is_due(program_.guards[i], guard_values_[i])) due.push_back(static_cast<int>(i));
  }
  roots_.remember(guard_values_);
  return due;
}

void Events::save(Checkpoint& checkpoint) const {
  const RootFinder::Memory memory = roots_.memory();
  checkpoint.signs = memory.signs;
  checkpoint.at_zero = memory.at_zero;
  checkpoint.was_open = was_open_;
  checkpoint.last_event = last_event_;
  checkpoint.quiet_until = quiet_until_;
  checkpoint.in_a_row = in_a_row_;
  for (std::size_t i = 0; i < left_true_.size(); ++i) {  // below zero: left true, and odd or even by which
    if (left_true_[i] != no) checkpoint.in_a_row[i] = -2 * in_a_row_[i] - (left_true_[i] == by_zeno ? 2 : 1);
  }
  checkpoint.sign_when_muted = sign_when_muted_;
  checkpoint.still.assign(run_.still.begin(), run_.still.end());
}

void Events::restore(const Checkpoint& checkpoint) {
  roots_.set_memory({checkpoint.signs, checkpoint.at_zero});
  was_open_ = checkpoint.was_open;
  last_event_ = checkpoint.last_event;
  quiet_until_ = checkpoint.quiet_until;
  in_a_row_ = checkpoint.in_a_row;
  for (std::size_t i = 0; i < left_true_.size(); ++i) {
    if (in_a_row_[i] >= 0) continue;
    left_true_[i] = in_a_row_[i] % 2 != 0 ? yes : by_zeno;
    in_a_row_[i] = (-in_a_row_[i] - left_true_[i]) / 2;
    left_since_[i] = run_.t;
    any_left_true_ = true;
  }
  sign_when_muted_ = checkpoint.sign_when_muted;
  run_.still.assign(checkpoint.still.begin(), checkpoint.still.end());
  any_muted_ = std::any_of(quiet_until_.begin(), quiet_until_.end(), [](double until) { return until > -infinity; });
}

void Events::settle(Mask bits) {
  frame_.arena[program_.time] = run_.t;
  KernelFrame kernels = frame_.kernel_frame(false);
  execute(program_.held_list, frame_.arena, &kernels, bits);
  if (program_.modes.empty()) return;
  for (int pass = 0; modes_differ(); ++pass) {
    if (pass == most_passes) {
      throw RunError(fmt::format("at time {} s events do not settle: {}", run_.t, name_of_differing_mode()), run_.t);
    }
    take_modes();
    ++run_.statistics.mode_changes;
    execute(program_.held_list, frame_.arena, &kernels, bits | event_bit);
  }
}

bool Events::modes_differ() {
  KernelFrame kernels = frame_.kernel_frame(false);
  execute(program_.mode_list, frame_.arena, &kernels);
  for (std::size_t m = 0; m < program_.modes.size(); ++m) {
    const double now = frame_.arena[program_.mode_list.roots[m]];
    if (now != frame_.arena[program_.modes[m]] && !std::isnan(now) && !is_frozen(m)) return true;
  }
  return false;
}

std::string Events::name_of_differing_mode() const {
  for (std::size_t m = 0; m < program_.modes.size(); ++m) {
    if (frame_.arena[program_.mode_list.roots[m]] != frame_.arena[program_.modes[m]]) return mode_name(m);
  }
  return {};
}

void Events::take_modes() {
  run_.watch.modes_until(run_.t);
  for (std::size_t m = 0; m < program_.modes.size(); ++m) {
    if (!is_frozen(m)) frame_.arena[program_.modes[m]] = frame_.arena[program_.mode_list.roots[m]];
  }
}

}  // namespace plantloop
