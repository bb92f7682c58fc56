// Lays a figure out: measures labels, gives every panel its box, then places what belongs into it.

#include "render/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/error.h"
#include "render/layout/plan.h"

namespace plantloop {
namespace {

double default_height(const Figure& figure) {
  if (figure.panels.size() <= 1) {
    const bool square = !figure.panels.empty() && figure.panels[0].equal;
    return (square ? 0.8 : 2.0 / 3) * figure.width;
  }
  // Many panels are lower than few.
  const double low = figure.panels.size() == 2 ? 0.32 : figure.panels.size() == 3 ? 0.27 : 0.23;
  double sum = 0.13;
  for (const Panel& panel : figure.panels) sum += (panel.x ? 0.5 : low) * std::clamp(panel.height, 0.2, 5.0);
  return sum * figure.width;
}

Plan begin(const Figure& figure) {
  Plan plan;
  plan.figure = &figure;
  plan.theme = find_theme(figure.theme);
  if (!plan.theme)
    throw RenderError(
        fmt::format("there is no theme '{}'; there are: {}", figure.theme, fmt::join(theme_names(), ", ")));
  const double height = figure.height > 0 ? figure.height : default_height(figure);
  if (!(figure.width >= 20 && height >= 20))
    throw RenderError(
        fmt::format("a figure of {:g} mm by {:g} mm is too small: at least 20 mm each way", figure.width, height));
  const double per_mm = figure.dpi / 25.4;
  plan.unit = figure.dpi / 152.4;
  const double width_pixels = std::round(figure.width * per_mm), height_pixels = std::round(height * per_mm);
  if (!(width_pixels >= 50 && height_pixels >= 50 && width_pixels <= 16384 && height_pixels <= 16384))
    throw RenderError(fmt::format("a figure of {:g} by {:g} pixels cannot be drawn: 50 to 16384 each way", width_pixels,
                                  height_pixels));
  plan.width = static_cast<int>(width_pixels);
  plan.height = static_cast<int>(height_pixels);
  return plan;
}

SeriesPlan plan_series(const Plan& plan, const Series& series, bool right, const SeriesStyle& style) {
  SeriesPlan result;
  result.series = &series;
  result.right = right;
  result.color = series.look.color.value_or(style.color);
  result.text_color = readable_on(plan.theme->background, result.color, 4.5);
  const double given = series.look.width * (152.4 / 72);  // points to sixths of a millimetre
  const double widen = series.look.color ? 1.0 : style.widen;
  result.width = plan.unit * (given > 0 ? given : plan.theme->line_width * widen);
  result.style = series.look.style;
  if (result.style == LineStyle::solid && !series.look.color && style.round % 3 != 0)
    result.style = style.round % 3 == 1 ? LineStyle::dashed : LineStyle::dotted;
  return result;
}

// Every series takes the next place in the palette, except those that are given a colour or share another's.
void add_series(const Plan& plan, PanelPlan& p) {
  std::vector<std::pair<const Series*, bool>> all;
  for (const Series& s : p.panel->series) all.emplace_back(&s, false);
  for (const Series& s : p.panel->right_series) all.emplace_back(&s, true);
  const auto borrows = [&](const SeriesLook& look) {
    return !look.color && look.color_of && *look.color_of < all.size();
  };
  std::vector<SeriesStyle> styles;
  std::size_t next = 0;
  for (const auto& [series, right] : all) {
    const bool own = !series->look.color && !borrows(series->look);
    styles.push_back(series_style(*plan.theme, own ? next++ : 0));
    if (series->look.color) styles.back().color = *series->look.color;
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto [series, right] = all[i];
    p.series.push_back(plan_series(plan, *series, right, styles[borrows(series->look) ? *series->look.color_of : i]));
  }
}

void add_panels(Plan& plan) {
  static const Panel nothing{};
  const Figure& figure = *plan.figure;
  const auto add = [&](const Panel& panel) {
    PanelPlan p;
    p.panel = &panel;
    p.x_axis = panel.x ? &*panel.x : &figure.x;
    p.twin = !panel.right_series.empty();
    add_series(plan, p);
    if (p.twin && panel.series.size() == 1) p.left_color = p.series.front().text_color;
    if (p.twin && panel.right_series.size() == 1) p.right_color = p.series.back().text_color;
    plan.panels.push_back(std::move(p));
  };
  for (const Panel& panel : figure.panels) add(panel);
  if (figure.panels.empty()) add(nothing);
  // Of the panels that share an axis only the lowest shows its numbers.
  bool seen = false;
  for (auto p = plan.panels.rbegin(); p != plan.panels.rend(); ++p) {
    if (p->panel->x) continue;
    p->shows_x = !seen;
    seen = true;
  }
}

double widest(const std::vector<Label>& labels) {
  double result = 0;
  for (const Label& label : labels) result = std::max(result, label.width);
  return result;
}

struct Measures {
  double pad, gap, line, tick_row, label_row;
};

Measures measures(const Plan& plan) {
  const double u = plan.unit;
  return {18 * u, 9 * u, 1.25, 1.45 * plan.theme->text_size * u, 1.5 * plan.theme->label_size * u};
}

// How much room an axis needs at its side: numbers, then its label standing upright.
double side_width(const Plan& plan, const std::vector<Label>& ticks, const std::vector<Label>& label) {
  const Measures m = measures(plan);
  const double words = static_cast<double>(label.size()) * m.line * plan.theme->label_size * plan.unit;
  return m.gap + widest(ticks) + (label.empty() ? 0 : 0.9 * m.gap + words);
}

void set_words(Plan& plan) {
  const Theme& theme = *plan.theme;
  const double u = plan.unit;
  const LabelStyle title{theme.title_size * u, true, false}, panel_title{theme.panel_title_size * u, true, false};
  plan.title = set_lines(plan.figure->title, title, plan.width - plan.title_x - 24 * u, 3);
  for (PanelPlan& p : plan.panels) {
    const Panel& panel = *p.panel;
    const double tall = p.box.height() > 0 ? 1.05 * p.box.height() : 300 * u;
    p.title = set_lines(panel.title, panel_title, p.box.width(), 2);
    p.y_label = set_lines(panel.y.label, plan.label_style(), tall, 2);
    p.right_label = p.twin ? set_lines(panel.right.label, plan.label_style(), tall, 2) : std::vector<Label>{};
    const double note = p.x_note.empty() ? 0 : 2 * (p.x_note.width + 12 * u);
    p.x_label =
        p.shows_x ? set_lines(p.x_axis->label, plan.label_style(), p.box.width() - note, 2) : std::vector<Label>{};
  }
}

double height_above(const Plan& plan, const PanelPlan& p) {
  const Measures m = measures(plan);
  double height = 0;
  if (!p.title.empty())
    height += static_cast<double>(p.title.size()) * m.line * plan.theme->panel_title_size * plan.unit + 0.8 * m.gap;
  if (!p.y_note.empty() || !p.right_note.empty()) height += m.tick_row;
  if (p.key.kind == KeyKind::above)
    height += std::ceil(static_cast<double>(p.key.labels.size()) / p.key.columns) * p.key.row + 0.5 * m.gap;
  return height;
}

double height_below(const Plan& plan, const PanelPlan& p) {
  const Measures m = measures(plan);
  if (!p.shows_x) return 0;
  const double label = static_cast<double>(p.x_label.size()) * m.line * plan.theme->label_size * plan.unit;
  return 0.4 * m.gap + m.tick_row + (label > 0 ? label + 0.4 * m.gap : p.x_note.empty() ? 0 : m.tick_row);
}

void set_boxes(Plan& plan) {
  const Measures m = measures(plan);
  const double u = plan.unit;
  double left = 0, right = 0;
  for (const PanelPlan& p : plan.panels) {
    left = std::max(left, m.pad + side_width(plan, p.y_ticks, p.y_label));
    double side = 24 * u;
    if (p.shows_x && !p.x_ticks.empty()) {
      const double at = position(p.x, p.x.ticks.back().value);
      side = std::max(side, p.x_ticks.back().width / 2 + 10 * u - (1 - at) * std::max(p.box.width(), 1.0));
      const double first = position(p.x, p.x.ticks.front().value);
      left = std::max(left, p.x_ticks.front().width / 2 + 10 * u - first * std::max(p.box.width(), 1.0));
    }
    if (p.twin) side = std::max(side, m.pad + side_width(plan, p.right_ticks, p.right_label));
    if (p.key.kind == KeyKind::end_labels) side = std::max(side, end_label_width(p) + 8 * u + m.pad);
    if (p.key.kind == KeyKind::beside) {
      const double beside = p.key.columns * p.key.column + (p.key.columns - 1) * 1.5 * plan.theme->text_size * u +
                            2.6 * plan.theme->text_size * u;
      side = (p.twin ? side : 0) + std::max(24 * u, beside);
    }
    right = std::max(right, side);
  }
  // Keep at least a third of the width for the data.
  const double most = 2.0 / 3 * plan.width;
  if (left + right > most) {
    right = std::min(right, most / 2);
    left = std::min(left, most - right);
  }
  plan.title_x = left;
  plan.title_y = m.pad;

  double top = plan.title.empty()
                   ? m.pad
                   : m.pad + static_cast<double>(plan.title.size()) * m.line * plan.theme->title_size * u + 0.7 * m.gap;
  double fixed_height = top + 0.8 * m.pad, weights = 0;
  const double between = 26 * u;
  for (std::size_t i = 0; i < plan.panels.size(); ++i) {
    fixed_height += height_above(plan, plan.panels[i]) + height_below(plan, plan.panels[i]) + (i > 0 ? between : 0);
    weights += std::clamp(plan.panels[i].panel->height, 0.2, 5.0) *
               (plan.panels[i].panel->x && plan.panels.size() > 1 ? 1.5 : 1);
  }
  const double room = std::max(plan.height - fixed_height, 20 * u * static_cast<double>(plan.panels.size()));
  for (std::size_t i = 0; i < plan.panels.size(); ++i) {
    PanelPlan& p = plan.panels[i];
    top += height_above(plan, p) + (i > 0 ? between : 0);
    const double weight = std::clamp(p.panel->height, 0.2, 5.0) * (p.panel->x && plan.panels.size() > 1 ? 1.5 : 1);
    const double height = room * weight / weights;
    // Edges lie in the middle of pixels, where the axis lines are crisp.
    const auto snap = [](double v) { return std::floor(v) + 0.5; };
    p.box = {snap(left), snap(top), snap(plan.width - right), snap(top + height)};
    top += height + height_below(plan, p);
  }
}

}  // namespace

Scene layout(const Figure& figure) {
  Plan plan = begin(figure);
  add_panels(plan);
  // Boxes need the widths of the numbers, numbers need the sizes of the boxes: twice round is enough.
  for (PanelPlan& p : plan.panels)
    p.box = {0, 0, 0.85 * plan.width, 0.8 * plan.height / static_cast<double>(plan.panels.size())};
  const auto settle = [&] {
    for (int round = 0; round < 2; ++round) {
      set_rulers(plan);
      set_words(plan);
      set_boxes(plan);
    }
  };
  settle();
  for (PanelPlan& p : plan.panels) {
    set_curves(plan, p);
    choose_end_labels(plan, p);
  }
  settle();
  bool moved = false;
  for (PanelPlan& p : plan.panels) {
    set_curves(plan, p);
    place_labels(plan, p);
    choose_legend(plan, p);
    moved = moved || p.key.kind == KeyKind::above || p.key.kind == KeyKind::beside;
  }
  if (moved) settle();
  for (PanelPlan& p : plan.panels) {
    if (moved) {
      set_curves(plan, p);
      place_labels(plan, p);
    }
    place_key(plan, p);
  }
  return draw(plan);
}

}  // namespace plantloop
