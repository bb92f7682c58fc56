// What can be said against `expect:` before anything has run.

#include "engine/run/check_expect.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/csv.h"
#include "engine/base/files.h"

namespace plantloop {
namespace {

class Checker {
 public:
  Checker(const Graph& graph, const Record& record, const SimulationOptions& options, Report& report)
      : graph_(graph), record_(record), options_(options), report_(report) {}

  void check(const ExpectDecl& entry) {
    if (!entry.event.empty()) check_event(entry);
    if (entry.measure == "baseline") check_baseline(entry);
    inside(entry.at, "at");
    inside(entry.from, "from");
    inside(entry.until, "until");
    inside(entry.step_at, "at");
    ascending(entry.from, entry.until, "'from' is {:g} s, which is not before 'until', {:g} s");
    ascending(entry.lower, entry.upper, "'between' goes from {:g} down to {:g}: the lower bound comes first");
  }

 private:
  std::optional<double> number(const ExpressionPtr& expression) const {
    if (!expression) return std::nullopt;
    return evaluate_scalar(graph_, *expression, "a number", report_);
  }

  void check_event(const ExpectDecl& entry) {
    std::vector<std::string> names;
    for (const RecordedJump& jump : record_.jumps) names.push_back(jump.name);
    if (std::find(names.begin(), names.end(), entry.event) != names.end()) return;
    Finding& finding = report_.error(entry.mark, "there is no event '{}'", entry.event);
    if (names.empty()) {
      finding.hint("this diagram has none: events come from reset: and from limits of integrators");
    } else {
      finding.suggest(entry.event, names);
    }
  }

  void check_baseline(const ExpectDecl& entry) {
    const FileResult path = resolve_path(graph_.model->project, graph_.model->path, entry.baseline);
    const FileResult text = path.ok() ? read_file(path.value) : path;
    if (!text.ok()) {
      report_.error(entry.mark, "cannot read '{}': {}", entry.baseline, text.error).named("file");
    } else if (const CsvResult file = read_csv(text.value); !file.ok()) {
      report_.error(entry.mark, "'{}', line {}: {}", entry.baseline, file.line, file.error).named("file");
    } else if (file.table.find("time") < 0) {
      report_.error(entry.mark, "'{}' has no column 'time'", entry.baseline).named("file");
    }
  }

  void inside(const ExpressionPtr& expression, std::string_view what) {
    const auto t = number(expression);
    if (!t || !graph_.model->simulation.stop || (*t >= options_.start && *t <= options_.stop)) return;
    report_.error(expression->mark, "'{}' is {:g} s, and the simulation goes from {:g} s to {:g} s", what, *t,
                  options_.start, options_.stop);
  }

  void ascending(const ExpressionPtr& first, const ExpressionPtr& second, fmt::format_string<double&, double&> text) {
    auto low = number(first);
    auto high = number(second);
    if (low && high && !(*low <= *high)) report_.error(second->mark, text, *low, *high);
  }

  const Graph& graph_;
  const Record& record_;
  const SimulationOptions& options_;
  Report& report_;
};

}  // namespace

void check_expect(const Graph& graph, const Record& record, const SimulationOptions& options, Report& report) {
  Checker checker(graph, record, options, report);
  for (const ExpectDecl& entry : graph.model->expect) checker.check(entry);
}

}  // namespace plantloop
