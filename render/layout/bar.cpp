// The colour bar beside a panel.

#include <algorithm>
#include <cmath>

#include "render/layout/plan.h"

namespace plantloop {
namespace {

constexpr double away = 20, thick = 15, gap = 8;  // in sixths of a millimetre
constexpr int steps = 64;

// In three dimensions the bar stands apart from the drawing and is shorter.
double length_of(const PanelPlan& panel) { return (panel.panel->space ? 0.5 : 1.0) * panel.box.height(); }

double numbers_width(const ColorBar& bar) {
  double widest = 0;
  for (const Label& label : bar.ticks) widest = std::max(widest, label.width);
  return widest;
}

}  // namespace

void set_bar(const Plan& plan, PanelPlan& panel) {
  panel.bar.reset();
  const std::optional<ColorScale>& scale = panel.panel->colors;
  if (!scale || !scale->bar || !(scale->lower < scale->upper)) return;
  ColorBar bar;
  bar.scale = &*scale;
  const double length = length_of(panel);
  bar.ruler = make_ruler({.limits = {scale->lower, scale->upper},
                          .data_lower = scale->lower,
                          .data_upper = scale->upper,
                          .length = length,
                          .spacing = length / (2 + length / (150 * plan.unit)),
                          .gap = 20 * plan.unit,
                          .tight = true});
  for (const Tick& tick : bar.ruler.ticks) bar.ticks.push_back(set_label(tick.label, plan.tick_style()));
  if (!bar.ruler.note.empty()) bar.note = set_label(bar.ruler.note, plan.tick_style());
  bar.label = set_lines(scale->label, plan.label_style(), std::max(1.05 * length, 20.0), 2);
  panel.bar = std::move(bar);
}

double bar_width(const Plan& plan, const PanelPlan& panel) {
  const ColorBar& bar = *panel.bar;
  const double u = plan.unit;
  const double label = static_cast<double>(bar.label.size()) * 1.25 * plan.theme->label_size * u;
  return (away + thick + gap) * u + std::max(numbers_width(bar), bar.note.width - thick * u) +
         (bar.label.empty() ? 0 : gap * u + label) + 18 * u;
}

void draw_bar(Group& group, const Plan& plan, const PanelPlan& panel, double left, const std::string& role) {
  const ColorBar& bar = *panel.bar;
  const Theme& theme = *plan.theme;
  const double u = plan.unit, x = std::floor(left + away * u), width = std::floor(thick * u);
  const double top = panel.box.top, height = length_of(panel), bottom = std::floor(top + height);
  Group& own = group.group(role + "/bar");
  for (int i = 0; i < steps; ++i) {
    const auto edge = [&](int k) { return std::round(bottom - height * k / steps); };
    own.add({box_fill({x, edge(i + 1), x + width, edge(i)}, map_color(theme, bar.scale->map, (i + 0.5) / steps))});
  }
  const double half = 0.5 * cap_height * theme.text_size * u, numbers = x + width + gap * u;
  Group& ticks = group.group(role + "/bar/ticks", "linear");
  for (std::size_t i = 0; i < bar.ticks.size(); ++i) {
    const double y = bottom - position(bar.ruler, bar.ruler.ticks[i].value) * height;
    ticks.add({place(bar.ticks[i], numbers, y + half, 0, theme.muted, theme.background)});
  }
  if (!bar.note.empty())
    group.group(role + "/bar/note").add({place(bar.note, x, top - 12 * u, 0, theme.muted, theme.background)});
  const double size = theme.label_size * u;
  double at = numbers + numbers_width(bar) + gap * u + cap_height * size;
  for (const Label& line : bar.label) {
    const double y = std::clamp((top + bottom + line.width) / 2, line.width + 4 * u, plan.height - 4 * u);
    group.group(role + "/bar/label").add({place(line, at, y, 1, theme.text, theme.background)});
    at += 1.25 * size;
  }
}

}  // namespace plantloop
