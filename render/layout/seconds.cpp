// Axes in seconds, written in the unit that suits: the data are divided before anything is laid out.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "render/layout/plan.h"

namespace plantloop {
namespace {

struct Unit {
  std::string_view name;
  double seconds;
  double from;  // the shortest axis, in s, for which it is chosen
};
constexpr Unit units[] = {
    {"d", 86400, 3 * 86400.0}, {"h", 3600, 3 * 3600.0}, {"min", 60, 20 * 60.0}, {"s", 1, 0.02}, {"ms", 1e-3, 0}};

struct Span {
  double lower = std::numeric_limits<double>::infinity(), upper = -lower;
  void add(double x) {
    if (!std::isfinite(x)) return;
    lower = std::min(lower, x);
    upper = std::max(upper, x);
  }
  void add(const Panel& panel) {
    for (const std::vector<Series>* list : {&panel.series, &panel.right_series})
      for (const Series& series : *list)
        for (const double x : series.x) add(x);
    for (const Panel& part : panel.below)
      if (!part.x) add(part);
  }
};

const Unit& unit_of(const Axis& axis, Span span) {
  for (const Unit& unit : units)
    if (unit.name == axis.time_unit) return unit;
  if (axis.limits.lower) span.lower = *axis.limits.lower;
  if (axis.limits.upper) span.upper = *axis.limits.upper;
  const double length = span.upper - span.lower;
  if (!(length > 0)) return units[3];
  return *std::find_if(std::begin(units), std::end(units) - 1, [&](const Unit& unit) { return length >= unit.from; });
}

// "time [s]" -> "time [h]"
void set_unit(std::string& label, std::string_view unit) {
  const std::size_t bracket = label.rfind(" [");
  if (bracket != std::string::npos && label.back() == ']') label.resize(bracket);
  label += label.empty() ? "[" : " [";
  label += unit;
  label += ']';
}

void divide(std::optional<double>& value, double by) {
  if (value) *value /= by;
}

void divide(Axis& axis, const Unit& unit) {
  divide(axis.limits.lower, unit.seconds);
  divide(axis.limits.upper, unit.seconds);
  axis.threshold /= unit.seconds;
  for (AxisTick& tick : axis.ticks) tick.at /= unit.seconds;
  if (!axis.label.empty()) set_unit(axis.label, unit.name);
  axis.time_unit.clear();
}

void divide(Panel& panel, double by) {
  const auto all = [by](std::vector<double>& values) {
    for (double& value : values) value /= by;
  };
  for (std::vector<Series>* list : {&panel.series, &panel.right_series})
    for (Series& series : *list) {
      all(series.x);
      all(series.toward_x);
      for (Area& area : series.areas) all(area.x);
    }
  for (ReferenceLine& line : panel.lines)
    if (line.axis == ReferenceLine::x) line.at /= by;
  for (ReferenceBand& band : panel.bands) {
    divide(band.from, by);
    divide(band.until, by);
  }
  for (Callout& callout : panel.callouts) callout.x /= by;
}

// A panel and its insets, whose axes follow it unless they have units of their own.
void convert(Panel& panel, const Unit& unit) {
  if (unit.seconds != 1) divide(panel, unit.seconds);
  for (Panel& inset : panel.insets) {
    if (unit.seconds != 1) divide(inset, unit.seconds);
    if (inset.x) divide(*inset.x, unit);
  }
  for (Panel& part : panel.below)
    if (!part.x) convert(part, unit);
}

}  // namespace

std::optional<Figure> in_units(const Figure& figure) {
  const bool own = std::any_of(figure.panels.begin(), figure.panels.end(),
                               [](const Panel& p) { return p.x && !p.x->time_unit.empty(); });
  if (figure.x.time_unit.empty() && !own) return std::nullopt;
  Figure made = figure;
  if (!figure.x.time_unit.empty()) {
    Span span;
    for (const Panel& panel : figure.panels)
      if (!panel.x) span.add(panel);
    const Unit& unit = unit_of(figure.x, span);
    divide(made.x, unit);
    for (Panel& panel : made.panels)
      if (!panel.x) convert(panel, unit);
  }
  for (Panel& panel : made.panels) {
    if (!panel.x || panel.x->time_unit.empty()) continue;
    Span span;
    span.add(panel);
    const Unit& unit = unit_of(*panel.x, span);
    divide(*panel.x, unit);
    convert(panel, unit);
  }
  return made;
}

}  // namespace plantloop
