// Declaration and recording to figure: every expression of the section was recorded or evaluated in the run already.

#include "app/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>

#include "app/figures/parts.h"
#include "render/error.h"
#include "render/plots/plot.h"

namespace plantloop {
namespace {

struct Columns {
  std::size_t first = 0, count = 0;
};

bool is_time(const ExpressionPtr& signal) {
  return signal && signal->kind == Expression::Kind::name && to_string(*signal) == "time";
}

ExpressionPtr signal_of(const FigureBlock& block, std::string_view name) {
  const FigureEntry* entry = block.find(name);
  return entry ? entry->signal : nullptr;
}

// What a plot shows along its x axis, when it is a signal.
ExpressionPtr along(const FigureBlock& plot) {
  const ExpressionPtr x = signal_of(plot, "x");
  return x ? x : signal_of(plot, "t");
}

class Maker {
 public:
  Maker(const DiagramRun& run, const Model& model)
      : run_(run),
        recording_(run.recording),
        model_(model),
        number_([this](const ExpressionPtr& e) { return number(e); }) {}

  Figure figure(const FigureDecl& declared) const {
    Figure figure;
    set_figure(figure, declared.says, number_);
    const std::vector<FigureBlock>& panels = declared.says.parts("panels");
    const bool timed = std::any_of(panels.begin(), panels.end(), over_time);
    if (timed && figure.x.label.empty()) {
      figure.x.label = "time [s]";
      if (figure.x.time_unit.empty()) figure.x.time_unit = "auto";
    }
    // What a plot shows is not over time, unless it says so; one that stands alone has the figure's axis.
    const bool shares = panels.size() == 1;
    for (const FigureBlock& says : panels) {
      figure.add_panel(panel(says, figure.x));
      if (!shares && !says.find("y") && !over_time(says) && !figure.panels.back().x)
        figure.panels.back().x = Axis{.tight = true};
      const std::size_t at = figure.panels.size() - 1;
      draw_plots(figure, says, at, std::nullopt);
      for (const FigureBlock& inset : says.parts("insets")) {
        // An inset shows a part of what its panel shows, on axes of its own.
        Panel small = panel(inset, Axis{});
        if (!small.x) small.x = Axis{};
        figure.panels[at].insets.push_back(std::move(small));
        draw_plots(figure, inset, at, figure.panels[at].insets.size() - 1);
      }
    }
    return figure;
  }

 private:
  const DiagramRun& run_;
  const Recording& recording_;
  const Model& model_;
  const NumberOf number_;

  // Whether the panel lies over the figure's own x axis because that is time.
  static bool over_time(const FigureBlock& panel) {
    if (panel.find("y")) return !panel.find("x");
    return std::any_of(panel.entries.begin(), panel.entries.end(), [](const FigureEntry& entry) {
      return entry.word->kind == FigureWord::Kind::plot &&
             std::any_of(entry.parts.begin(), entry.parts.end(),
                         [](const FigureBlock& plot) { return is_time(along(plot)); });
    });
  }

  std::optional<double> number(const ExpressionPtr& expression) const {
    if (!expression) return std::nullopt;
    const auto found = run_.numbers.find(expression.get());
    if (found != run_.numbers.end()) return found->second;
    return plain_number(expression);
  }

  Columns columns(const ExpressionPtr& signal) const {
    const auto found = run_.shown.find(signal.get());
    return found == run_.shown.end() ? Columns{} : Columns{found->second.first, found->second.count};
  }

  Panel panel(const FigureBlock& says, const Axis& shared) const {
    Panel panel;
    const std::vector<FigureBlock>&y = says.parts("y"), &right = says.parts("right");
    const bool alone = right.empty() && y.size() == 1;
    panel.y.label = common_label(y);
    panel.right.label = common_label(right);
    std::optional<std::size_t> x;
    if (const std::vector<FigureBlock>& over = says.parts("x"); !over.empty()) {
      const Columns shown = columns(signal_of(over[0], "signal"));
      if (shown.count > 0) x = shown.first;
      panel.x = Axis{.label = x ? label_of(recording_.columns[*x]) : ""};
    }
    set_panel(panel, says, shared, number_);
    if (panel.y.scale == Scale::linear && panel.y.ticks.empty()) panel.y.ticks = state_ticks(y);
    if (panel.right.scale == Scale::linear && panel.right.ticks.empty()) panel.right.ticks = state_ticks(right);
    const FigureEntry* labels = says.find("labels");
    for (std::size_t i = 0; i < y.size(); ++i)
      add(y[i], labels && i < labels->texts.size() ? labels->texts[i] : "", x, alone, panel.series);
    for (const FigureBlock& curve : right) add(curve, "", x, false, panel.right_series);
    return panel;
  }

  // The curves of a signal: one for each element of a vector. The only curve of a panel has its name on the axis.
  void add(const FigureBlock& curve, const std::string& name, std::optional<std::size_t> x, bool alone,
           std::vector<Series>& into) const {
    const Columns shown = columns(signal_of(curve, "signal"));
    for (std::size_t i = 0; i < shown.count; ++i) {
      const RecordedColumn& column = recording_.columns[shown.first + i];
      Series::Kind kind = Series::Kind::line;
      SeriesLook look = look_of(curve, kind, number_);
      if (look.label.empty()) look.label = name;
      if (look.label.empty())
        look.label = alone && shown.count == 1 ? "" : column.name;
      else if (shown.count > 1)
        look.label += fmt::format(" {}", i + 1);
      Series series = x ? line_series(recording_.column(*x), recording_.column(shown.first + i), look)
                        : series_of(recording_, shown.first + i, look);
      if (kind == Series::Kind::stairs) series.kind = kind;
      into.push_back(std::move(series));
    }
  }

  std::string common_label(const std::vector<FigureBlock>& curves) const {
    std::vector<const RecordedColumn*> all;
    for (const FigureBlock& curve : curves) {
      const Columns shown = columns(signal_of(curve, "signal"));
      for (std::size_t i = 0; i < shown.count; ++i) all.push_back(&recording_.columns[shown.first + i]);
    }
    if (all.empty()) return {};
    if (all.size() == 1) return label_of(*all.front());
    const std::string& unit = all.front()->unit;
    const bool same = std::all_of(all.begin(), all.end(), [&](const RecordedColumn* c) { return c->unit == unit; });
    return same && !unit.empty() ? fmt::format("[{}]", unit) : "";
  }

  // Where all curves of an axis are the state of machines with the same states, their names stand at the axis.
  std::vector<AxisTick> state_ticks(const std::vector<FigureBlock>& curves) const {
    const std::vector<std::string>* names = nullptr;
    for (const FigureBlock& curve : curves) {
      const Columns shown = columns(signal_of(curve, "signal"));
      for (std::size_t i = 0; i < shown.count; ++i) {
        const RecordedColumn& column = recording_.columns[shown.first + i];
        if (column.names.empty() || (names && *names != column.names)) return {};
        names = &column.names;
      }
    }
    std::vector<AxisTick> ticks;
    for (std::size_t i = 0; names && i < names->size(); ++i) ticks.push_back({static_cast<double>(i + 1), (*names)[i]});
    return ticks;
  }

  void draw_plots(Figure& figure, const FigureBlock& says, std::size_t at, std::optional<std::size_t> inset) const {
    for (const FigureEntry& entry : says.entries) {
      if (entry.word->kind != FigureWord::Kind::plot) continue;
      for (const FigureBlock& plot : entry.parts) {
        name_axes(figure, inset ? figure.panels[at].insets[*inset] : figure.panels[at], plot);
        Canvas canvas = inset ? Canvas(figure, at, *inset) : Canvas(figure, at);
        use(*find_plot(entry.word->name), plot, canvas);
      }
    }
  }

  // Signals along the axes give them their names and units.
  void name_axes(Figure& figure, Panel& panel, const FigureBlock& plot) const {
    const auto name = [this](Axis& axis, const ExpressionPtr& signal) {
      const Columns shown = signal && !is_time(signal) ? columns(signal) : Columns{};
      if (axis.label.empty() && shown.count == 1) axis.label = label_of(recording_.columns[shown.first]);
    };
    name(panel.x ? *panel.x : figure.x, along(plot));
    name(plot.flag("right") ? panel.right : panel.y, signal_of(plot, "y"));
  }

  // What is wrong with the numbers is only seen now: the message has the place in the diagram.
  void use(const Plot& plot, const FigureBlock& says, Canvas& canvas) const {
    try {
      Given given(plot);
      const std::vector<std::size_t> rows = rows_of(says);
      for (const FigureEntry& entry : says.entries) {
        const bool input = std::any_of(plot.inputs().begin(), plot.inputs().end(),
                                       [&](const PlotInput& i) { return i.name == entry.word->name; });
        if (input) given.set(entry.word->name, value_of(entry, rows));
      }
      Series::Kind kind{};
      given.look = look_of(says, kind, number_);
      given.right = says.flag("right");
      given.check();
      plot.draw(canvas, given);
    } catch (const RenderError& error) {
      const std::string path = says.mark.source ? says.mark.source->name : model_.path;
      throw RenderError(
          fmt::format("{}:{}:{}: {}: {}", path, says.mark.line, says.mark.column, plot.name(), error.what()));
    }
  }

  // A vector of parameters is its elements, a signal is its values over time.
  bool is_constant(const Expression& e) const {
    if (e.kind == Expression::Kind::name) {
      const std::vector<ParameterDecl>& all = model_.top->parameters;
      const bool own =
          std::any_of(all.begin(), all.end(), [&](const ParameterDecl& p) { return p.name == e.parts.front(); });
      return own || e.parts.front() == "pi" || e.parts.front() == "inf";
    }
    return std::all_of(e.arguments.begin(), e.arguments.end(),
                       [this](const ExpressionPtr& argument) { return is_constant(*argument); });
  }

  // The rows that a plot is given: the hits of its signals' rate when they have one, else all.
  std::vector<std::size_t> rows_of(const FigureBlock& says) const {
    std::optional<int> rate;
    for (const FigureEntry& entry : says.entries) {
      if (!entry.signal || is_time(entry.signal) || is_constant(*entry.signal)) continue;
      const Columns shown = columns(entry.signal);
      for (std::size_t i = 0; i < shown.count; ++i) {
        const int own = recording_.columns[shown.first + i].rate;
        rate = rate && *rate != own ? 0 : own;
      }
    }
    if (rate && *rate > 0) return recording_.hits[static_cast<std::size_t>(*rate)];
    std::vector<std::size_t> all(recording_.rows());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }

  PlotValue value_of(const FigureEntry& entry, const std::vector<std::size_t>& rows) const {
    using Kind = FigureWord::Kind;
    switch (entry.word->kind) {
      case Kind::number:
        return number(entry.numbers.empty() ? nullptr : entry.numbers[0]).value_or(0);
      case Kind::flag:
        return entry.flag;
      case Kind::texts:
        return entry.texts;
      case Kind::column:
        return column_of(entry, rows);
      case Kind::grid:
        return grid_of(entry, rows);
      default:
        return entry.text;
    }
  }

  std::vector<double> numbers_of(const FigureEntry& entry) const {
    std::vector<double> values;
    for (const ExpressionPtr& e : entry.numbers) values.push_back(number(e).value_or(0));
    return values;
  }

  std::vector<double> column_of(const FigureEntry& entry, const std::vector<std::size_t>& rows) const {
    if (!entry.signal) return numbers_of(entry);
    std::vector<double> values;
    if (is_time(entry.signal)) {
      for (const std::size_t row : rows) values.push_back(recording_.time()[row]);
      return values;
    }
    const Columns shown = columns(entry.signal);
    if (shown.count == 1 && !is_constant(*entry.signal))
      for (const std::size_t row : rows) values.push_back(recording_.at(row, shown.first));
    else if (!rows.empty())
      for (std::size_t i = 0; i < shown.count; ++i) values.push_back(recording_.at(rows.back(), shown.first + i));
    return values;
  }

  GridValues grid_of(const FigureEntry& entry, const std::vector<std::size_t>& rows) const {
    if (!entry.signal)
      return {entry.columns == 0 ? 0 : entry.numbers.size() / entry.columns, entry.columns, numbers_of(entry)};
    const Columns shown = columns(entry.signal);
    GridValues grid{rows.size(), shown.count, {}};
    for (const std::size_t row : rows)
      for (std::size_t i = 0; i < shown.count; ++i) grid.values.push_back(recording_.at(row, shown.first + i));
    return grid;
  }
};

}  // namespace

Figure make_figure(const FigureDecl& declared, const DiagramRun& run, const Model& model) {
  return Maker(run, model).figure(declared);
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

}  // namespace plantloop
