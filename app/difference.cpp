// Above the curves, below them the difference: what is not met should be seen, not read from numbers.

#include "app/difference.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "app/figures.h"
#include "engine/run/expect.h"

namespace plantloop::app {

namespace {

std::optional<double> number(const DiagramRun& run, const ExpressionPtr& expression) {
  if (!expression) return std::nullopt;
  const auto found = run.numbers.find(expression.get());
  return found == run.numbers.end() ? std::nullopt : std::optional(found->second);
}

Series curve(const SampledSignal& s, SeriesLook look) {
  return s.between == SampledSignal::Between::held ? stairs_series(s.time, s.value, std::move(look))
                                                   : line_series(s.time, s.value, std::move(look));
}

Panel difference_panel(const ComparedSignal& s) {
  Panel panel;
  panel.y.label = "difference";
  std::vector<double> upper, lower, difference;
  for (const Deviation& d : deviations(s.found, s.wanted, s.tolerance)) {
    upper.push_back(d.allowed);
    lower.push_back(-d.allowed);
    difference.push_back(d.outside ? NAN : d.found - d.wanted);
  }
  if (s.tolerance.abs > 0 || s.tolerance.rel > 0) panel.band(s.wanted.time, lower, upper, {.label = "allowed"});
  panel.line(s.wanted.time, difference);
  panel.lines.push_back({.axis = ReferenceLine::x, .at = s.deviation.time, .label = "worst"});
  return panel;
}

Panel both_panel(const ComparedSignal& s, const std::string& found, const std::string& wanted) {
  Panel panel;
  panel.y.label = s.name;
  panel.series.push_back(curve(s.found, {.label = found}));
  panel.series.push_back(curve(s.wanted, {.label = wanted, .style = LineStyle::dashed}));
  return panel;
}

void add_baseline(const Verdict& verdict, const DiagramRun& run, const Model& model, Figure& figure) {
  const Baselines all = read_baselines(model);
  const auto found = all.find(verdict.entry);
  if (found == all.end() || !found->second.error.empty()) return;
  const CsvTable& table = found->second.table;
  ComparedSignal s;
  s.name = run.recording.columns[verdict.column].name;
  const int at = table.find(s.name);
  if (at < 0) return;
  s.found = recorded_signal(run.recording, verdict.column);
  s.wanted = signal_of(table, static_cast<std::size_t>(at), found->second.time_column);
  s.tolerance = {number(run, verdict.entry->abs).value_or(0), number(run, verdict.entry->rel).value_or(0),
                 number(run, verdict.entry->shift).value_or(0)};
  s.deviation = worst_deviation(s.found, s.wanted, s.tolerance);
  figure.panels.push_back(both_panel(s, "run", verdict.entry->baseline));
  figure.panels.push_back(difference_panel(s));
}

// Measures whose value is one of the signal itself, so that it can stand beside the curve.
bool is_level(const std::string& measure) {
  return measure == "max" || measure == "min" || measure == "max_abs" || measure == "final" || measure == "rms";
}

}  // namespace

Figure figure_of(const Verdict& verdict, const DiagramRun& run, const Model& model) {
  Figure figure;
  figure.title = verdict.text;
  figure.x.label = "time [s]";
  if (verdict.entry == nullptr || verdict.column >= run.recording.columns.size()) return figure;
  const ExpectDecl& entry = *verdict.entry;
  if (entry.measure == "baseline") {
    add_baseline(verdict, run, model, figure);
    return figure;
  }
  Panel panel;
  panel.y.label = label_of(run.recording.columns[verdict.column]);
  panel.series.push_back(
      series_of(run.recording, verdict.column, {.label = run.recording.columns[verdict.column].name}));
  const auto value = number(run, entry.value);
  const double allowed =
      number(run, entry.abs).value_or(0) + number(run, entry.rel).value_or(0) * std::fabs(value.value_or(0));
  const auto at = number(run, entry.at);
  if (at) panel.lines.push_back({.axis = ReferenceLine::x, .at = *at, .label = "at"});
  if (at || is_level(entry.measure)) {
    if (value) panel.lines.push_back({.axis = ReferenceLine::y, .at = *value, .label = "wanted"});
    if (value && allowed > 0) panel.bands.push_back({.lower = *value - allowed, .upper = *value + allowed});
    const auto lower = number(run, entry.lower), upper = number(run, entry.upper);
    if (lower) panel.lines.push_back({.axis = ReferenceLine::y, .at = *lower, .label = "at least"});
    if (upper) panel.lines.push_back({.axis = ReferenceLine::y, .at = *upper, .label = "at most"});
  } else if (entry.step_at) {
    const double from = number(run, entry.step_from).value_or(0), to = number(run, entry.step_to).value_or(0);
    const double band = number(run, entry.band).value_or(0.02) * std::fabs(to - from);
    panel.lines.push_back({.axis = ReferenceLine::x, .at = number(run, entry.step_at).value_or(0), .label = "step"});
    const auto limit = number(run, entry.upper);
    if (entry.measure == "overshoot" && limit)
      panel.lines.push_back({.axis = ReferenceLine::y, .at = to + (to - from) * *limit / 100, .label = "at most"});
    panel.bands.push_back({.lower = to - band, .upper = to + band, .label = "band"});
  }
  const auto from = number(run, entry.from), until = number(run, entry.until);
  if (from) panel.lines.push_back({.axis = ReferenceLine::x, .at = *from, .label = "from"});
  if (until) panel.lines.push_back({.axis = ReferenceLine::x, .at = *until, .label = "until"});
  figure.panels.push_back(std::move(panel));
  return figure;
}

Figure figure_of(const std::vector<ComparedSignal>& signals, const std::string& found, const std::string& wanted) {
  Figure figure;
  figure.x.label = "time [s]";
  for (const ComparedSignal& s : signals) {
    figure.panels.push_back(both_panel(s, found, wanted));
    figure.panels.push_back(difference_panel(s));
  }
  return figure;
}

Image difference_of(const Image& found, const Image& wanted) {
  Image image = wanted;
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    const bool same =
        found.rgb[i] == wanted.rgb[i] && found.rgb[i + 1] == wanted.rgb[i + 1] && found.rgb[i + 2] == wanted.rgb[i + 2];
    for (std::size_t c = 0; c < 3; ++c) {
      const int pale = 255 - (255 - wanted.rgb[i + c]) / 4;
      image.rgb[i + c] = static_cast<std::uint8_t>(same ? pale : c == 0 ? 220 : 30);
    }
  }
  return image;
}

}  // namespace plantloop::app
