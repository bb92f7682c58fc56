// Declaration and recording to figure: every expression of the section was recorded or evaluated in the run already.

#include "app/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/theme.h"

namespace plantloop {
namespace {

struct Columns {
  std::size_t first = 0, count = 0;
};

class Maker {
 public:
  explicit Maker(const DiagramRun& run) : run_(run), recording_(run.recording) {}

  Figure figure(const FigureDecl& declared) const {
    Figure figure;
    figure.title = declared.title;
    if (find_theme(declared.theme) != nullptr) figure.theme = declared.theme;
    if (const auto width = number(declared.width)) figure.width = *width;
    figure.x.label = declared.x_label.empty() ? "time [s]" : declared.x_label;
    figure.x.limits = {number(declared.x_lower), number(declared.x_upper)};
    for (const FigurePanel& panel : declared.panels) figure.add_panel(this->panel(panel, figure.x));
    return figure;
  }

 private:
  std::optional<double> number(const ExpressionPtr& expression) const {
    if (!expression) return std::nullopt;
    const auto found = run_.numbers.find(expression.get());
    if (found != run_.numbers.end()) return found->second;
    if (expression->kind == Expression::Kind::number) return expression->number;
    return std::nullopt;
  }

  Columns columns(const FigureSignal& signal) const {
    const auto found = run_.shown.find(signal.signal.get());
    return found == run_.shown.end() ? Columns{} : Columns{found->second.first, found->second.count};
  }

  Panel panel(const FigurePanel& declared, const Axis& time) const {
    Panel panel;
    panel.equal = declared.equal;
    panel.y.scale = declared.scale == "log" ? Scale::log : Scale::linear;
    panel.y.limits = {number(declared.lower_limit), number(declared.upper_limit)};
    const bool alone = declared.right.empty() && declared.y.size() == 1;
    panel.y.label = declared.label.empty() ? common_label(declared.y) : declared.label;
    panel.right.label = declared.right_label.empty() ? common_label(declared.right) : declared.right_label;
    std::optional<std::size_t> x;
    if (declared.x.signal) {
      const Columns shown = columns(declared.x);
      if (shown.count > 0) x = shown.first;
      panel.x = Axis{.label = x ? label_of(recording_.columns[*x]) : ""};
      if (!declared.x_label.empty()) panel.x->label = declared.x_label;
    } else if (!declared.x_label.empty()) {
      panel.x = time;
      panel.x->label = declared.x_label;
    }
    for (const FigureSignal& signal : declared.y) add(signal, x, alone, panel.series);
    for (const FigureSignal& signal : declared.right) add(signal, x, false, panel.right_series);
    add_references(declared, panel);
    return panel;
  }

  // The curves of a signal: one for each element of a vector. The only curve of a panel has its name on the axis.
  void add(const FigureSignal& signal, std::optional<std::size_t> x, bool alone, std::vector<Series>& into) const {
    const Columns shown = columns(signal);
    for (std::size_t i = 0; i < shown.count; ++i) {
      const RecordedColumn& column = recording_.columns[shown.first + i];
      SeriesLook look;
      look.label = signal.label.empty() ? (alone && shown.count == 1 ? "" : column.name) : signal.label;
      if (!signal.label.empty() && shown.count > 1) look.label += fmt::format(" {}", i + 1);
      Series series = x ? line_series(recording_.column(*x), recording_.column(shown.first + i), look)
                        : series_of(recording_, shown.first + i, look);
      apply_style(signal.style, series.look, series.kind);
      into.push_back(std::move(series));
    }
  }

  std::string common_label(const std::vector<FigureSignal>& signals) const {
    std::vector<const RecordedColumn*> all;
    for (const FigureSignal& signal : signals) {
      const Columns shown = columns(signal);
      for (std::size_t i = 0; i < shown.count; ++i) all.push_back(&recording_.columns[shown.first + i]);
    }
    if (all.empty()) return {};
    if (all.size() == 1) return label_of(*all.front());
    const std::string& unit = all.front()->unit;
    const bool same = std::all_of(all.begin(), all.end(), [&](const RecordedColumn* c) { return c->unit == unit; });
    return same && !unit.empty() ? fmt::format("[{}]", unit) : "";
  }

  void add_references(const FigurePanel& declared, Panel& panel) const {
    for (const FigureLine& line : declared.lines) {
      const auto at = number(line.x ? line.x : line.y);
      if (at)
        panel.lines.push_back({.axis = line.x ? ReferenceLine::x : ReferenceLine::y, .at = *at, .label = line.label});
    }
    for (const FigureBand& band : declared.bands) {
      panel.bands.push_back({.lower = number(band.lower),
                             .upper = number(band.upper),
                             .from = number(band.from),
                             .until = number(band.until),
                             .label = band.label});
    }
  }

  const DiagramRun& run_;
  const Recording& recording_;
};

}  // namespace

Figure make_figure(const FigureDecl& declared, const DiagramRun& run, const Model&) {
  return Maker(run).figure(declared);
}

Series series_of(const Recording& recording, std::size_t column, SeriesLook look) {
  const auto rate = static_cast<std::size_t>(recording.columns[column].rate);
  if (rate == 0) return line_series(recording.time(), recording.column(column), std::move(look));
  std::vector<double> x;
  std::vector<double> y;
  for (const std::size_t row : recording.hits[rate]) {
    x.push_back(recording.time()[row]);
    y.push_back(recording.at(row, column));
  }
  // The last value is held until the run's end.
  if (!x.empty() && recording.time().back() > x.back()) {
    x.push_back(recording.time().back());
    y.push_back(y.back());
  }
  return stairs_series(std::move(x), std::move(y), std::move(look));
}

std::string label_of(const RecordedColumn& column) {
  return column.unit.empty() ? column.name : fmt::format("{} [{}]", column.name, column.unit);
}

bool apply_style(std::string_view style, SeriesLook& look, Series::Kind& kind) {
  if (style.empty() || style == "solid") return true;
  if (style == "dashed") {
    look.style = LineStyle::dashed;
  } else if (style == "dashdot") {
    look.style = LineStyle::dashdot;
  } else if (style == "dotted") {
    look.style = LineStyle::dotted;
  } else if (style == "none" || style == "points") {
    look.style = LineStyle::none;
    if (style == "points") look.marker = Marker::dot;
  } else if (style == "line_points") {
    look.marker = Marker::dot;
  } else if (style == "steps") {
    kind = Series::Kind::stairs;
  } else {
    return false;
  }
  return true;
}

}  // namespace plantloop
