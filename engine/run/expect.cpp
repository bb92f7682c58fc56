// Each entry is one number measured on the recording and one statement about it.

#include "engine/run/expect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/base/csv.h"
#include "engine/base/files.h"
#include "engine/run/measures.h"

namespace plantloop {

namespace {

Baseline read_baseline(const Model& model, const std::string& name) {
  Baseline baseline;
  const FileResult path = resolve_path(model.project, model.path, name);
  const FileResult text = path.ok() ? read_file(path.value) : path;
  if (!text.ok()) {
    baseline.error = fmt::format("cannot read '{}': {}", name, text.error);
    return baseline;
  }
  CsvResult file = read_csv(text.value);
  if (!file.ok()) {
    baseline.error = fmt::format("{}:{}: {}", name, file.line, file.error);
    return baseline;
  }
  const int time = file.table.find("time");
  if (time < 0) {
    baseline.error = fmt::format("{} has no column 'time'", name);
    return baseline;
  }
  baseline.time_column = static_cast<std::size_t>(time);
  const auto& times = file.table.columns[baseline.time_column];
  if (!std::is_sorted(times.begin(), times.end())) {
    baseline.error = fmt::format("in {} the times do not ascend", name);
    return baseline;
  }
  baseline.table = std::move(file.table);
  return baseline;
}

class Judge {
 public:
  Judge(const DiagramRun& run, const Baselines& baselines) : run_(run), baselines_(baselines) {}

  Verdict operator()(const ExpectDecl& entry) const {
    Verdict verdict;
    verdict.text = entry.text;
    verdict.mark = entry.mark;
    verdict.entry = &entry;
    if (!entry.event.empty()) {
      compare(entry, events(entry.event), verdict);
      return verdict;
    }
    if (!entry.signal && entry.measure == "baseline") {
      judge_whole_baseline(entry, verdict);
      return verdict;
    }
    const auto shown = run_.shown.find(entry.signal.get());
    if (shown == run_.shown.end() || shown->second.count == 0) {
      verdict.measured = "the signal was not recorded";
      return verdict;
    }
    // Of a vector every element must keep what is said.
    verdict.met = true;
    for (std::uint32_t i = 0; i < shown->second.count; ++i) {
      Verdict element = verdict;
      judge_column(entry, shown->second.first + i, element);
      if (verdict.measured.empty() || (verdict.met && !element.met)) {
        verdict.measured = element.measured;
        verdict.column = shown->second.first + i;
      }
      verdict.met = verdict.met && element.met;
    }
    return verdict;
  }

 private:
  std::optional<double> number(const ExpressionPtr& expression) const {
    if (!expression) return std::nullopt;
    const auto found = run_.numbers.find(expression.get());
    return found == run_.numbers.end() ? std::nullopt : std::optional(found->second);
  }

  double events(const std::string& name) const {
    const auto found = run_.recording.events.find(name);
    return found == run_.recording.events.end() ? 0 : static_cast<double>(found->second.size());
  }

  void judge_column(const ExpectDecl& entry, std::size_t column, Verdict& verdict) const {
    if (entry.measure == "baseline") return judge_baseline(entry, column, verdict);
    if (entry.measure == "at") {
      const double at = number(entry.at).value_or(NAN);
      compare(entry, run_.recording.sampled(column, at, entry.side == "left"), verdict);
      if (!(at >= run_.options.start && at <= run_.options.stop)) {
        verdict.measured =
            fmt::format("not measured: the run went from {:g} s to {:g} s", run_.options.start, run_.options.stop);
      } else if (std::isnan(run_.recording.sampled(column, at)) && !run_.statistics.ended_by.empty()) {
        verdict.measured = fmt::format("not measured: '{}' ended the run before", run_.statistics.ended_by);
      }
      return;
    }
    MeasureOptions options;
    if (const auto from = number(entry.from)) options.from = *from;
    if (const auto until = number(entry.until)) options.until = *until;
    if (const auto band = number(entry.band)) options.band = *band;
    options.step = {number(entry.step_at), number(entry.step_until), number(entry.step_from), number(entry.step_to)};
    compare(entry, measure(run_.recording, column, entry.measure, options), verdict);
  }

  void compare(const ExpectDecl& entry, double measured, Verdict& verdict) const {
    if (const auto value = number(entry.value)) {
      const double tolerance = number(entry.abs).value_or(0) + number(entry.rel).value_or(0) * std::fabs(*value);
      verdict.met = std::fabs(measured - *value) <= tolerance;
      verdict.measured = fmt::format("{:.9g}, wanted {:.9g} within {:g}", measured, *value, tolerance);
      return;
    }
    const auto lower = number(entry.lower), upper = number(entry.upper);
    verdict.met = !(lower && !(measured >= *lower)) && !(upper && !(measured <= *upper)) && !std::isnan(measured);
    if (lower && upper) {
      verdict.measured = fmt::format("{:.9g}, wanted between {:g} and {:g}", measured, *lower, *upper);
    } else if (upper) {
      verdict.measured = fmt::format("{:.9g}, wanted at most {:g}", measured, *upper);
    } else if (lower) {
      verdict.measured = fmt::format("{:.9g}, wanted at least {:g}", measured, *lower);
    }
  }

  // Every row of the file whose column has the signal's name, against the run at exactly that row's time.
  void judge_baseline(const ExpectDecl& entry, std::size_t column, Verdict& verdict) const {
    const Baseline& file = baselines_.at(&entry);
    const std::string& name = run_.recording.columns[column].name;
    verdict.met = false;
    if (!file.error.empty()) {
      verdict.measured = file.error;
      return;
    }
    const int at = file.table.find(name);
    if (at < 0) {
      verdict.measured = fmt::format("{} has no column '{}'", entry.baseline, name);
      return;
    }
    const Tolerance tolerance{number(entry.abs).value_or(0), number(entry.rel).value_or(0),
                              number(entry.shift).value_or(0)};
    const Deviation worst =
        worst_deviation(recorded_signal(run_.recording, column),
                        signal_of(file.table, static_cast<std::size_t>(at), file.time_column), tolerance);
    verdict.met = worst.met;
    if (worst.outside) {
      verdict.measured = fmt::format("{} goes to {:g} s, where the run has no value", entry.baseline, worst.time);
    } else {
      verdict.measured = fmt::format("differs most at {:g} s: {:.9g}, wanted {:.9g} within {:g}", worst.time,
                                     worst.found, worst.wanted, worst.allowed);
    }
  }

  // A baseline without a signal: every column of the file.
  void judge_whole_baseline(const ExpectDecl& entry, Verdict& verdict) const {
    const Baseline& file = baselines_.at(&entry);
    verdict.met = file.error.empty();
    verdict.measured = file.error;
    if (!verdict.met) return;
    for (const std::string& name : signal_names(file.table)) {
      const int column = run_.recording.find(name);
      Verdict one = verdict;
      if (column < 0) {
        one.met = false;
        one.measured = fmt::format("the run has no column '{}'", name);
      } else {
        one.column = static_cast<std::size_t>(column);
        judge_baseline(entry, one.column, one);
        one.measured = fmt::format("'{}' {}", name, one.measured);
      }
      if (verdict.measured.empty() || (verdict.met && !one.met)) {
        verdict.measured = one.measured;
        verdict.column = one.column;
      }
      verdict.met = verdict.met && one.met;
    }
  }

  const DiagramRun& run_;
  const Baselines& baselines_;
};

}  // namespace

Baselines read_baselines(const Model& model) {
  Baselines baselines;
  for (const ExpectDecl& entry : model.expect) {
    if (entry.measure == "baseline") baselines.emplace(&entry, read_baseline(model, entry.baseline));
  }
  return baselines;
}

SampledSignal recorded_signal(const Recording& recording, std::size_t column) {
  const SampledSignal rows = signal_of(recording, column);
  SampledSignal all;
  all.between = rows.between;
  std::size_t row = 0;
  const auto take = [&](double t, double v) {
    all.time.push_back(t);
    all.value.push_back(v);
  };
  for (const Recording::Sample& sample : recording.samples) {
    for (; row < rows.time.size() && rows.time[row] < sample.time; ++row) take(rows.time[row], rows.value[row]);
    if (sample.right.empty()) continue;
    for (; row < rows.time.size() && rows.time[row] == sample.time; ++row) {
    }  // the sample stands for them
    if (sample.left[column] != sample.right[column]) take(sample.time, sample.left[column]);
    take(sample.time, sample.right[column]);
  }
  for (; row < rows.time.size(); ++row) take(rows.time[row], rows.value[row]);
  return all;
}

std::vector<Verdict> judge(const Model& model, const DiagramRun& run, const Baselines& baselines) {
  std::vector<Verdict> verdicts;
  const Judge one(run, baselines);
  for (const ExpectDecl& entry : model.expect) verdicts.push_back(one(entry));
  return verdicts;
}

}  // namespace plantloop
