// Rows are evaluated by the list of watched values, at accepted steps and at instants inside them.

#include "engine/run/rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/error.h"
#include "engine/program/resolve.h"
#include "engine/run/blame.h"
#include "engine/solve/root.h"

namespace plantloop {

Rows::Rows(RunState& run, Recording& recording)
    : run_(run),
      frame_(run.frame),
      program_(run.program),
      options_(run.options),
      recording_(recording),
      row_(recording.columns.size()),
      states_after_(run.frame.state_count()),
      most_rows_in_memory_(
          static_cast<std::size_t>(run.options.max_memory / static_cast<double>((row_.size() + 1) * sizeof(double)))),
      grid_(run.options.start, run.options.output_interval) {}

void Rows::begin() {
  take_sample_times();
  double rows = RunState::gaps;
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

void Rows::resume() {
  begin();
  const double t = run_.t;
  while (options_.output_interval > 0 && grid_.at(next_grid_) <= t) ++next_grid_;
  while (next_sample() <= t || sampled_with(t)) ++next_sample_;
  evaluate_row(t, false);
  append(t, 0);
}

void Rows::log_step(double t) {
  evaluate_row(t, true);
  append(t, 0);
}

void Rows::evaluate_row(double t, bool left) {
  if (!row_is_finite(t, left)) throw_blame(t);
}

bool Rows::row_is_finite(double t, bool left) {
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

void Rows::throw_blame(double t) {
  const auto bad = std::find_if(row_.begin(), row_.end(), [](double v) { return !std::isfinite(v); });
  const auto column = static_cast<std::size_t>(bad - row_.begin());
  const std::string& name = recording_.columns[column].name;
  throw not_finite(frame_, program_.resolved->watches[column],
                   fmt::format("'{}' became {}", name, number_in_words(row_[column])), t);
}

void Rows::append(double t, std::int8_t side) {
  if (static_cast<std::int64_t>(recording_.rows()) >= options_.max_rows) {
    throw LimitError(
        fmt::format(
            "at time {} s the result has {} rows, the limit (simulation: max_rows); an output_interval makes fewer{}",
            t, options_.max_rows, run_.watch.hint()),
        t);
  }
  if (recording_.rows() > most_rows_in_memory_) {
    throw LimitError(
        fmt::format(
            "at time {} s the result takes {:.1f} GB of memory, the limit; an output_interval makes fewer rows{}", t,
            options_.max_memory / 1e9, run_.watch.hint()),
        t);
  }
  recording_.append(t, side, row_);
}

void Rows::take_sample_times() {
  std::vector<double> times = options_.sample_times;
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  recording_.samples.clear();
  for (const double t : times) {
    if (t >= options_.start && t <= options_.stop) recording_.samples.push_back({t, {}, {}});
  }
}

double Rows::next_sample() const {
  return next_sample_ < recording_.samples.size() ? recording_.samples[next_sample_].time
                                                  : std::numeric_limits<double>::infinity();
}

// The samples inside a step; the states are then anywhere between.
void Rows::sample_between(double before, double after) {
  while (next_sample() <= before || sampled_with(before)) ++next_sample_;
  for (; next_sample() < after && !sampled_with(after); ++next_sample_) {
    run_.put_states_of(next_sample());
    evaluate_row(next_sample(), true);
    recording_.samples[next_sample_].left = recording_.samples[next_sample_].right = row_;
  }
}

// A sample this near to an event or stop is taken there, on both sides.
bool Rows::sampled_with(double t) const {
  return std::fabs(next_sample() - t) <= event_tolerance(t, options_.event_tol);
}

// The row just evaluated is that of t: before anything happens there, or after everything has.
void Rows::sample_at(bool left) {
  Recording::Sample& sample = recording_.samples[next_sample_];
  if (left || sample.left.empty()) sample.left = row_;
  sample.right = row_;
}

void Rows::log_between(double before, double after) {
  const bool on_grid = options_.output_interval > 0;
  const bool fills_gap = !on_grid && options_.step <= 0 && frame_.state_count() > 0 && after - before > run_.gap;
  const bool grid_inside = on_grid && grid_.at(next_grid_) < after;
  if (!fills_gap && !grid_inside && next_sample() >= after) return;
  std::copy(frame_.states(), frame_.states() + frame_.state_count(), states_after_.begin());
  if (fills_gap) {
    const double n = std::ceil((after - before) / run_.gap * (1 - 1e-9));
    for (double i = 1; i < n; ++i) row_inside(before + (after - before) * i / n);
  }
  for (; on_grid && grid_.at(next_grid_) < after; ++next_grid_) row_inside(grid_.at(next_grid_));
  sample_between(before, after);
  std::copy(states_after_.begin(), states_after_.end(), frame_.states());
  frame_.arena[program_.time] = after;
}

void Rows::row_inside(double t) {
  run_.put_states_of(t);
  evaluate_row(t, true);
  append(t, 0);
}

void Rows::log_left(double t, bool is_stop) {
  const bool sampled = sampled_with(t);
  // On a grid the value after a jump counts, so a grid time that is a stop is logged by log_right.
  const bool wanted = options_.output_interval > 0 ? grid_.at(next_grid_) <= t && !is_stop
                                                   : recording_.rows() == 0 || recording_.time().back() < t;
  if (!wanted && !sampled) return;
  evaluate_row(t, true);
  if (sampled) sample_at(true);
  if (!wanted) return;
  append(t, 0);
  if (options_.output_interval > 0) ++next_grid_;
}

void Rows::log_left_of_event(double t, double before, bool jumps) {
  const bool sampled = sampled_with(t);
  const bool wanted =
      options_.output_interval <= 0 && (recording_.rows() == 0 || recording_.time().back() < t);  // else as in log_left
  if (!wanted && !sampled) return;
  if (!row_is_finite(t, true) || jumps) {
    // The state is beyond the crossing by rounding. What was selected until now need not exist there, as sqrt(-1e-17),
    // and a limit must not be passed: the left row shows what is just before.
    run_.put_states_of(before);
    evaluate_row(before, true);
    run_.put_states_of(t);
  }
  if (sampled) sample_at(true);
  if (wanted) append(t, 0);
}

void Rows::log_right(Mask bits) {
  const bool on_grid = options_.output_interval > 0;
  const bool sampled = sampled_with(run_.t);
  const bool wanted = !on_grid || grid_.at(next_grid_) <= run_.t;
  if (!wanted && !sampled) return;
  evaluate_row(run_.t, false);
  if (sampled) sample_at(false);
  if (!wanted) return;
  const std::size_t last = recording_.rows();
  if (!on_grid && last > 0 && recording_.time().back() == run_.t) {
    bool jumped = false;
    for (std::size_t i = 0; i < row_.size(); ++i) {
      jumped = jumped || (recording_.columns[i].rate == 0 && row_[i] != recording_.at(last - 1, i));
    }
    if (jumped) {
      recording_.set_side(last - 1, -1);
    } else {
      recording_.remove_last_row();
    }
    append(run_.t, static_cast<std::int8_t>(jumped ? 1 : 0));
  } else {
    append(run_.t, 0);
    if (on_grid) ++next_grid_;
  }
  for (const RateIndex rate : run_.clockwork->hit_rates()) {
    if ((rate_bit(rate) & bits) != 0) recording_.mark_hit(rate);
  }
}

}  // namespace plantloop
