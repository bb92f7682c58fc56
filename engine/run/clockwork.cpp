// Hits are counted, never accumulated: hit k of a rate is at offset + k period, rounded once.

#include "engine/run/clockwork.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/error.h"

namespace plantloop {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double most_ticks = 9007199254740992.0;  // 2^53

// Whether a hit or an edge has passed at time t, or is at t but for rounding.
bool has_come(double time, double t) { return time <= t || is_same_instant(t, time); }

}  // namespace

Clockwork::Clockwork(Frame& frame, double start, double stop) : frame_(frame), stop_(stop) {
  const Program& program = *frame.program;
  for (std::size_t r = 1; r < program.rates.size(); ++r) {
    const RecordedRate& rate = program.rates[r];
    if (rate.triggered) {
      frame_.next_hit[r] = 0;
      frame_.arena[program.hits[r]] = -1;  // no hit yet
      continue;
    }
    const double period = rate.period.to_double();
    if (std::max(std::fabs(start), std::fabs(stop)) / period > most_ticks) {
      throw RunError(fmt::format("the period {} s is too short to count its hits exactly up to {} s",
                                 rate.period.to_string(), stop));
    }
    auto k = static_cast<std::int64_t>(std::ceil((start - rate.offset.to_double()) / period)) - 1;
    // An offset beyond the period delays the first hit; a run from before time 0 has hits all along.
    if (start >= 0) k = std::max<std::int64_t>(k, 0);
    frame_.next_hit[r] = k;
    while (hit_time(r) < start) ++frame_.next_hit[r];
  }
  instants_.resize(program.schedules.size());
  for (const Program::Schedule& schedule : program.schedules) {
    grids_.emplace_back(frame_.arena[schedule.first], frame_.arena[schedule.period]);
  }
  for (std::size_t s = 0; s < program.schedules.size(); ++s) {
    const Program::Schedule& schedule = program.schedules[s];
    const std::string& path = program.sites[schedule.site].path;
    if (schedule.periodic) {
      if (!(frame_.arena[schedule.period] > 0)) {
        throw RunError(
            fmt::format("block '{}': its period must be greater than 0, it is {}", path, frame_.arena[schedule.period]),
            start, path);
      }
      const double first = frame_.arena[schedule.first];
      const double passed = std::floor((start - first) / frame_.arena[schedule.period]);
      if (!std::isfinite(first)) {
        throw RunError(fmt::format("block '{}': its first edge is at {} s", path, first), start, path);
      }
      // Instants are told apart only as far as doubles are.
      if (!(std::max({std::fabs(start - first), std::fabs(stop - first)}) / frame_.arena[schedule.period] <
            most_ticks)) {
        throw RunError(fmt::format("block '{}': its period of {:g} s is too short to count its edges up to {:g} s",
                                   path, frame_.arena[schedule.period], stop),
                       start, path);
      }
      frame_.next_instant[s] = std::max<std::int64_t>(0, static_cast<std::int64_t>(passed) - 1);
      while (has_come(instant(s), start)) ++frame_.next_instant[s];
    } else {
      for (const auto slot : schedule.times) instants_[s].push_back(frame_.arena[slot]);
      if (!std::is_sorted(instants_[s].begin(), instants_[s].end())) {
        throw RunError(fmt::format("block '{}': its times must ascend", path), start, path);
      }
      frame_.next_instant[s] = 0;
      while (has_come(instant(s), start)) ++frame_.next_instant[s];
    }
    frame_.arena[program.segments[s]] = static_cast<double>(frame_.next_instant[s]);
  }
  hit_times_.assign(program.rates.size(), never);
  for (std::size_t r = 1; r < hit_times_.size(); ++r) {
    hit_times_[r] = hit_time(r);
  }
  for (std::size_t s = 0; s < instants_.size(); ++s) instant_times_.push_back(instant(s));
  find_next();
}

void Clockwork::resume() {
  for (std::size_t r = 1; r < hit_times_.size(); ++r) hit_times_[r] = hit_time(r);
  for (std::size_t s = 0; s < instant_times_.size(); ++s) instant_times_[s] = instant(s);
  hit_rates_.clear();
  find_next();
}

double Clockwork::hit_time(std::size_t rate) const {
  const RecordedRate& r = frame_.program->rates[rate];
  if (r.triggered) return never;  // its hits are events
  const std::int64_t k = frame_.next_hit[rate];
  if (r.offset.is_zero()) return r.period.at(k);
  // offset + k period as one rational, rounded once; should it not fit, the parts are rounded.
  const auto factor = Rational::make(k);
  if (factor) {
    if (const auto product = multiply(r.period, *factor)) {
      if (const auto sum = add(*product, r.offset)) return sum->to_double();
    }
  }
  return r.offset.to_double() + r.period.at(k);
}

double Clockwork::instant(std::size_t s) const {
  const Program::Schedule& schedule = frame_.program->schedules[s];
  const std::int64_t k = frame_.next_instant[s];
  if (schedule.periodic) return grids_[s].at(k);
  return k < static_cast<std::int64_t>(instants_[s].size()) ? instants_[s][static_cast<std::size_t>(k)] : never;
}

// A source's edge within rounding of a hit is at that hit: 0.15 + 0.3 is not 0.45, but means it.
void Clockwork::find_next() {
  double hit = never, edge = never;
  for (std::size_t r = 1; r < hit_times_.size(); ++r) hit = std::min(hit, hit_times_[r]);
  for (const double t : instant_times_) edge = std::min(edge, t);
  if (edge < stop_ && is_same_instant(edge, stop_)) edge = stop_;
  next_ = is_same_instant(edge, hit) ? hit : std::min(hit, edge);
}

void Clockwork::trigger(RateIndex rate) {
  if (std::find(hit_rates_.begin(), hit_rates_.end(), rate) != hit_rates_.end()) return;
  frame_.arena[frame_.program->hits[rate]] = static_cast<double>(frame_.next_hit[rate]++);
  hit_rates_.push_back(rate);
}

Mask Clockwork::advance(double t) {
  Mask bits = 0;
  hit_rates_.clear();
  if (!has_come(next_, t)) return bits;
  const Program& program = *frame_.program;
  for (std::size_t r = 1; r < hit_times_.size(); ++r) {
    if (!has_come(hit_times_[r], t)) continue;
    frame_.arena[program.hits[r]] = static_cast<double>(frame_.next_hit[r]);
    ++frame_.next_hit[r];
    hit_times_[r] = hit_time(r);
    hit_rates_.push_back(static_cast<RateIndex>(r));
    bits |= rate_bit(static_cast<RateIndex>(r));
  }
  for (std::size_t s = 0; s < instant_times_.size(); ++s) {
    if (!has_come(instant_times_[s], t)) continue;
    while (has_come(instant_times_[s], t)) {
      ++frame_.next_instant[s];
      instant_times_[s] = instant(s);
    }
    frame_.arena[program.segments[s]] = static_cast<double>(frame_.next_instant[s]);
    bits |= event_bit;
  }
  find_next();
  return bits;
}

}  // namespace plantloop
