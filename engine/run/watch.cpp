// What is noticed during a run. Thresholds are such that a run which is only lively says nothing.

#include "engine/run/watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "engine/program/resolve.h"
#include "engine/program/status_kernel.h"
#include "engine/run/stiffness.h"

namespace plantloop {

namespace {

constexpr double close = 1e-6;             // of the run's length: between events, and the length of a step
constexpr int chatter_events = 100;        // in a row
constexpr int collapsed_steps = 1000;      // in a row
constexpr std::int64_t many_events = 200;  // below that restarts cost nothing
constexpr double many_of_steps = 0.1;

}  // namespace

RunWatch::RunWatch(const Frame& frame, const SimulationOptions& options)
    : frame_(frame),
      program_(*frame.program),
      options_(options),
      modes_since_(options.start),
      hit_since_(options.start),
      mode_time_(program_.modes.size()),
      limit_time_(program_.limits.size()),
      at_limit_(program_.limits.size()),
      events_(program_.guards.size()),
      last_event_(program_.guards.size(), -std::numeric_limits<double>::infinity()),
      streak_start_(program_.guards.size()),
      streak_(program_.guards.size()),
      chatters_(program_.guards.size()),
      active_(program_.jumps.size()) {
  for (const KernelStep& step : program_.held_list.kernels) {
    const auto* const kernel = dynamic_cast<const StatusKernel*>(program_.kernels[step.kernel].kernel.get());
    if (kernel == nullptr) continue;
    std::vector<std::string> words = kernel->status_words();
    std::vector<std::int64_t> counts(words.size());
    statuses_.push_back(
        {step.kernel, step.out + static_cast<SlotIndex>(kernel->status_output()), std::move(words), std::move(counts)});
  }
}

void RunWatch::limits_until(double t) {
  if (t <= hit_since_) return;
  for (std::size_t i = 0; i < at_limit_.size(); ++i) {
    if (at_limit_[i] != 0) limit_time_[i] += t - hit_since_;
  }
  hit_since_ = t;
}

void RunWatch::hit(double t, Mask bits) {
  limits_until(t);
  for (std::size_t i = 0; i < at_limit_.size(); ++i) {
    const Program::Limit& limit = program_.limits[i];
    at_limit_[i] = frame_.arena[limit.value] == frame_.arena[limit.limit];
  }
  for (Status& status : statuses_) {
    const Program::KernelState& kernel = program_.kernels[status.kernel];
    if ((kernel.mask & bits) == 0 || (kernel.gate != no_gate && frame_.arena[kernel.gate] == 0)) continue;
    const auto said = static_cast<std::size_t>(frame_.arena[status.slot]);
    if (said < status.counts.size()) ++status.counts[said];
  }
}

// One line for each controller that was not always as it should be.
void RunWatch::tell_statuses() {
  for (const Status& status : statuses_) {
    std::int64_t all = 0;
    for (const std::int64_t count : status.counts) all += count;
    if (all == status.counts.front()) continue;
    std::string text;
    for (std::size_t i = 0; i < status.counts.size(); ++i) {
      if (status.counts[i] == 0) continue;
      text += fmt::format("{}{} at {:.3g} % ({})", text.empty() ? "" : "; ", status.words[i],
                          100.0 * static_cast<double>(status.counts[i]) / static_cast<double>(all), status.counts[i]);
    }
    const std::uint32_t site = program_.kernels[status.kernel].site;
    findings_.push_back(
        {"control-status", fmt::format("'{}' at {} samples: {}", program_.sites[site].path, all, text), site});
  }
}

std::string RunWatch::name_of(std::size_t g) const {
  if (guard(g).is_jump) return program_.jumps[guard(g).index].name;
  return program_.sites[site_of(g)].path;
}

std::uint32_t RunWatch::site_of(std::size_t g) const {
  return guard(g).is_jump ? program_.jumps[guard(g).index].site : program_.resolved->graph.modes[guard(g).index].site;
}

void RunWatch::fired(std::size_t g, double t) {
  if (guard(g).is_jump && program_.jumps[guard(g).index].of_kernel) return;
  ++events_[g];
  if (guard(g).is_jump) active_[guard(g).index] = 1;
  const bool is_close = t - last_event_[g] < close * (options_.stop - options_.start);
  if (!is_close) streak_start_[g] = t;
  streak_[g] = is_close ? streak_[g] + 1 : 0;
  last_event_[g] = t;
  if (streak_[g] < chatter_events || chatters_[g] != 0) return;
  for (std::size_t other = 0; other < chatters_.size(); ++other)  // of one block one is enough
    if (program_.sites[site_of(other)].path == program_.sites[site_of(g)].path) chatters_[other] = 1;
  findings_.push_back({"chatter",
                       fmt::format("'{}' chatters: {} events within {:.3g} s from time {:g} s on; a wider hysteresis "
                                   "would end it",
                                   name_of(g), streak_[g], t - streak_start_[g], streak_start_[g]),
                       site_of(g)});
}

void RunWatch::modes_until(double t) {
  if (t > modes_since_) {
    for (std::size_t m = 0; m < mode_time_.size(); ++m) {
      if (frame_.arena[program_.modes[m]] != 0) mode_time_[m] += t - modes_since_;
    }
  }
  modes_since_ = t;
}

void RunWatch::before_step(std::size_t states) {
  const double* x = frame_.arena + program_.states;
  if (first_states_.empty()) first_states_.assign(x, x + states);
  if (short_steps_ != collapsed_steps - 1 || collapsed_) return;
  states_before_.assign(x, x + states);
}

void RunWatch::after_step(double before, double after, std::size_t states) {
  const bool is_short = after - before < close * (options_.stop - options_.start);
  short_steps_ = is_short ? short_steps_ + 1 : 0;
  if (short_steps_ != collapsed_steps || collapsed_ || states_before_.size() != states) return;
  collapsed_ = true;
  explain_short_steps(after, after - before);
}

// The fastest state is the one that changes most in the last step, measured by itself. Steps that are as long as the
// method is stable are a stiff equation's; shorter ones follow what moves.
void RunWatch::explain_short_steps(double t, double h) {
  std::size_t fastest = 0;
  double most = -1;
  for (std::size_t i = 0; i < states_before_.size(); ++i) {
    const double now = frame_.arena[program_.states + i];
    const double change = std::fabs(now - states_before_[i]) / (std::fabs(now) + options_.atol);
    if (change > most) most = change, fastest = i;
  }
  const std::string& name = program_.state_names[fastest];
  const bool moves = most > 0 && h / most < 1e-3 * (options_.stop - options_.start);  // else it is at rest
  const std::string in = moves ? fmt::format(", which changes by its own size within {:.2g} s", h / most) : "";
  const bool implicit = options_.solver == "bdf" || options_.solver == "ida";
  const double border = options_.solver == "dopri5" ? 2 : options_.solver == "adams" ? 0.5 : 1.5;
  const double eigenvalue = implicit ? 0 : fastest_eigenvalue(frame_, options_.rtol, options_.atol);
  if (!implicit && h * eigenvalue < border) {
    const bool driven = h * eigenvalue < 1e-3;
    why_short_ = fmt::format("steps are {:.2g} s at time {:g} s; the fastest state is '{}'{}{}", h, t, name, in,
                             driven ? ": what drives it is that fast" : "");
    return;
  }
  findings_.push_back({"step-size",
                       fmt::format("at time {:g} s the steps have collapsed to {:.2g} s; the fastest state is '{}'{}{}",
                                   t, h, name, in, implicit ? "" : "; solver: bdf is made for stiff equations"),
                       program_.state_sites[fastest]});
}

std::string RunWatch::hint() const {
  constexpr double much = 1e9;
  const double* const x = frame_.arena + program_.states;
  std::size_t most = 0;
  const auto growth = [&](std::size_t i) { return std::fabs(x[i]) / std::max(1.0, std::fabs(first_states_[i])); };
  for (std::size_t i = 1; i < first_states_.size(); ++i) {
    if (growth(i) > growth(most)) most = i;
  }
  if (!first_states_.empty() && growth(most) > much) {
    return fmt::format("\n  state '{}' has grown to {:.3g}: the equations may diverge", program_.state_names[most],
                       x[most]);
  }
  return why_short_.empty() ? "" : "\n  " + why_short_;
}

void RunWatch::finish(double t, bool whole, RunStatistics& statistics) {
  modes_until(t);
  limits_until(t);
  const double length = t - options_.start;
  const auto tell_limit = [&](double time, std::uint32_t site) {
    if (length > 0 && !program_.sites[site].method.starts_with("wire"))
      statistics.limits.push_back({time / length, site});
  };
  const std::vector<Mode>& modes = program_.resolved->graph.modes;
  for (std::size_t m = 0; m < modes.size(); ++m) {
    if (modes[m].of_limit && !modes[m].of_loop) tell_limit(mode_time_[m], modes[m].site);
  }
  for (std::size_t i = 0; i < limit_time_.size(); ++i) tell_limit(limit_time_[i], program_.limits[i].site);

  std::int64_t all = 0;
  std::map<std::string, std::pair<std::int64_t, std::uint32_t>> by_name;
  for (std::size_t g = 0; g < events_.size(); ++g) {
    if (events_[g] == 0) continue;
    all += events_[g];
    auto& [count, site] = by_name[name_of(g)];
    count += events_[g];
    site = site_of(g);
  }
  if (all >= many_events && static_cast<double>(all) > many_of_steps * static_cast<double>(statistics.solver.steps) &&
      frame_.state_count() > 0) {
    const auto most = std::max_element(by_name.begin(), by_name.end(),
                                       [](const auto& a, const auto& b) { return a.second.first < b.second.first; });
    findings_.push_back({"restarts",
                         fmt::format("the solver started anew at {} events in {} steps; {} of them are of '{}'", all,
                                     statistics.solver.steps, most->second.first, most->first),
                         most->second.second});
  }

  std::map<std::string, std::pair<bool, std::uint32_t>> ran;  // by the conditional part's path: whether it did
  for (std::size_t j = 0; whole && length > 0 && j < program_.jumps.size(); ++j) {
    const Program::Jump& jump = program_.jumps[j];
    const Site& site = program_.sites[jump.site];
    if (site.method != "enable" && site.method != "trigger") continue;
    const std::string& name = jump.name;
    const std::size_t end = name.rfind(site.method == "enable" ? ".enable" : ".trigger");
    auto& [did, where] = ran[name.substr(0, end)];
    did = did || active_[j] != 0;
    where = jump.site;
  }
  for (const auto& [path, what] : ran) {
    if (what.first) continue;
    const bool triggered = program_.sites[what.second].method == "trigger";
    findings_.push_back({"never-enabled",
                         triggered
                             ? fmt::format("'{}' was not triggered once in the run", path)
                             : fmt::format("'{}' was never active: its condition did not hold once in the run", path),
                         what.second});
  }
  tell_statuses();
  statistics.findings = std::move(findings_);
}

}  // namespace plantloop
