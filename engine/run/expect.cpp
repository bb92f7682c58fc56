// Each entry is one number measured on the recording and one statement about it.

#include "engine/run/expect.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "engine/base/csv.h"
#include "engine/base/files.h"
#include "engine/run/measures.h"

namespace plantloop {

namespace {

class Judge {
 public:
  Judge(const Model& model, const DiagramRun& run) : model_(model), run_(run) {}

  Verdict operator()(const ExpectDecl& entry) const {
    Verdict verdict{entry.text, false, {}, entry.mark};
    if (!entry.event.empty()) {
      compare(entry, events(entry.event), verdict);
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
      if (verdict.measured.empty() || (verdict.met && !element.met)) verdict.measured = element.measured;
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

  // Every row of the file whose column has the signal's name.
  void judge_baseline(const ExpectDecl& entry, std::size_t column, Verdict& verdict) const {
    verdict.met = false;
    const std::string& name = run_.recording.columns[column].name;
    const FileResult path = resolve_path(model_.project, model_.path, entry.baseline);
    const FileResult text = path.ok() ? read_file(path.value) : path;
    if (!text.ok()) {
      verdict.measured = fmt::format("cannot read '{}': {}", entry.baseline, text.error);
      return;
    }
    const CsvResult file = read_csv(text.value);
    if (!file.ok()) {
      verdict.measured = fmt::format("{}:{}: {}", entry.baseline, file.line, file.error);
      return;
    }
    const int time_column = file.table.find("time");
    const int value_column = file.table.find(name);
    if (time_column < 0 || value_column < 0) {
      verdict.measured = fmt::format("{} has no column '{}'", entry.baseline, time_column < 0 ? "time" : name);
      return;
    }
    const auto& times = file.table.columns[static_cast<std::size_t>(time_column)];
    const auto& values = file.table.columns[static_cast<std::size_t>(value_column)];
    const double abs = number(entry.abs).value_or(0);
    const double rel = number(entry.rel).value_or(0);
    verdict.met = true;
    double worst = -1;
    for (std::size_t i = 0; i < times.size(); ++i) {
      const double t = times[i];
      const bool left = i + 1 < times.size() && times[i + 1] == t;
      const double excess = std::fabs(run_.recording.value(column, t, left) - values[i]) - rel * std::fabs(values[i]);
      if (excess > abs || std::isnan(excess)) verdict.met = false;
      if (excess > worst || std::isnan(excess)) {
        worst = excess;
        verdict.measured = fmt::format("differs most at {:g} s, by {:g}, wanted within {:g}", t, excess, abs);
      }
    }
  }

  const Model& model_;
  const DiagramRun& run_;
};

}  // namespace

std::vector<Verdict> judge(const Model& model, const DiagramRun& run) {
  std::vector<Verdict> verdicts;
  const Judge one(model, run);
  for (const ExpectDecl& entry : model.expect) verdicts.push_back(one(entry));
  return verdicts;
}

}  // namespace plantloop
