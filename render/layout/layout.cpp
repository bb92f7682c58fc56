// Lays a figure out: measures labels, gives every panel its box, then places what belongs into it.

#include "render/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/error.h"
#include "render/layout/plan.h"

namespace plantloop {
namespace {

double default_height(const Figure& figure) {
  if (figure.panels.size() <= 1) {
    const bool square = !figure.panels.empty() && (figure.panels[0].equal || figure.panels[0].space);
    return (square ? 0.8 : 2.0 / 3) * figure.width;
  }
  const std::size_t columns = static_cast<std::size_t>(std::max(1, figure.columns));
  const std::size_t rows = (figure.panels.size() + columns - 1) / columns;
  // Many panels are lower than few; beside each other they are about as high as wide.
  const double low = columns > 1 ? 0.7 / static_cast<double>(columns) : rows == 2 ? 0.32 : rows == 3 ? 0.27 : 0.23;
  double sum = 0.13;
  for (std::size_t i = 0; i < figure.panels.size(); i += columns) {
    double highest = 0;
    for (std::size_t k = i; k < std::min(i + columns, figure.panels.size()); ++k) {
      const Panel& panel = figure.panels[k];
      const double own = columns > 1 || (!panel.x && !panel.space) ? low : 0.5;
      highest = std::max(highest, own * std::clamp(panel.height, 0.2, 5.0));
    }
    sum += highest;
  }
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

void add_panels(Plan& plan) {
  static const Panel nothing{};
  const Figure& figure = *plan.figure;
  for (const Panel& panel : figure.panels) plan.panels.push_back(plan_panel(plan, panel));
  if (figure.panels.empty()) plan.panels.push_back(plan_panel(plan, nothing));
  const int count = static_cast<int>(plan.panels.size());
  plan.columns = std::clamp(figure.columns, 1, count);
  plan.rows = (count + plan.columns - 1) / plan.columns;
  for (int i = 0; i < count; ++i) {
    PanelPlan& p = plan.panels[static_cast<std::size_t>(i)];
    p.row = i / plan.columns;
    p.column = i % plan.columns;
    if (figure.share_y && p.column > 0) p.shows_y = false;
  }
  // Of the panels of a column that share an axis only the lowest shows its numbers.
  for (int column = 0; column < plan.columns; ++column) {
    bool seen = false;
    for (auto p = plan.panels.rbegin(); p != plan.panels.rend(); ++p) {
      if (p->panel->x || p->panel->space || p->panel->bare || p->column != column) continue;
      p->shows_x = !seen;
      seen = true;
    }
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
    p.y_label = p.shows_y ? set_lines(panel.y.label, plan.label_style(), tall, 2) : std::vector<Label>{};
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

double weight_of(const Plan& plan, const PanelPlan& p) {
  const bool alone = p.panel->x && plan.columns == 1 && plan.panels.size() > 1;
  return std::clamp(p.panel->height, 0.2, 5.0) * (alone ? 1.5 : 1);
}

// The room that a panel needs on its left.
double left_of(const Plan& plan, const PanelPlan& p) {
  const Measures m = measures(plan);
  const double u = plan.unit;
  double left = (p.column == 0 ? m.pad : 0.8 * m.pad) + (p.shows_y ? side_width(plan, p.y_ticks, p.y_label) : 0);
  if (p.shows_x && !p.x_ticks.empty()) {
    const double first = position(p.x, p.x.ticks.front().value);
    left = std::max(left, p.x_ticks.front().width / 2 + 10 * u - first * std::max(p.box.width(), 1.0));
  }
  return left;
}

// ... and on its right.
double right_of(const Plan& plan, const PanelPlan& p) {
  const Measures m = measures(plan);
  const double u = plan.unit;
  double side = p.column + 1 == plan.columns ? 24 * u : 0.6 * m.pad;
  if (p.shows_x && !p.x_ticks.empty()) {
    const double at = position(p.x, p.x.ticks.back().value);
    side = std::max(side, p.x_ticks.back().width / 2 + 10 * u - (1 - at) * std::max(p.box.width(), 1.0));
  }
  if (p.twin) side = std::max(side, m.pad + side_width(plan, p.right_ticks, p.right_label));
  if (p.key.kind == KeyKind::end_labels) side = std::max(side, end_label_width(p) + 8 * u + m.pad);
  if (p.key.kind == KeyKind::beside) {
    const double beside = p.key.columns * p.key.column + (p.key.columns - 1) * 1.5 * plan.theme->text_size * u +
                          2.6 * plan.theme->text_size * u;
    side = (p.twin ? side : 0) + std::max(24 * u, beside);
  }
  if (p.bar) side = (p.twin || p.key.kind == KeyKind::end_labels ? side : 0) + bar_width(plan, p);
  return side;
}

void set_boxes(Plan& plan) {
  const Measures m = measures(plan);
  const double u = plan.unit;
  const auto count = [](int n) { return static_cast<std::size_t>(n); };
  std::vector<double> lefts(count(plan.columns)), rights(count(plan.columns)), above(count(plan.rows)),
      below(count(plan.rows)), weights(count(plan.rows));
  for (const PanelPlan& p : plan.panels) {
    lefts[count(p.column)] = std::max(lefts[count(p.column)], left_of(plan, p));
    rights[count(p.column)] = std::max(rights[count(p.column)], right_of(plan, p));
    above[count(p.row)] = std::max(above[count(p.row)], height_above(plan, p));
    below[count(p.row)] = std::max(below[count(p.row)], height_below(plan, p));
    weights[count(p.row)] = std::max(weights[count(p.row)], weight_of(plan, p));
  }
  // Keep at least a third of the width for the data.
  const double most = 2.0 / 3 * plan.width;
  const double sum_left = std::accumulate(lefts.begin(), lefts.end(), 0.0);
  const double sum_right = std::accumulate(rights.begin(), rights.end(), 0.0);
  if (sum_left + sum_right > most) {
    const double right = std::min(sum_right, most / 2), left = std::min(sum_left, most - right);
    for (double& side : lefts) side *= left / sum_left;
    for (double& side : rights) side *= right / sum_right;
  }
  const double wide = (plan.width - std::accumulate(lefts.begin(), lefts.end(), 0.0) -
                       std::accumulate(rights.begin(), rights.end(), 0.0)) /
                      plan.columns;
  plan.title_x = plan.panels.front().panel->space ? m.pad + 9 * u : lefts.front();
  plan.title_y = m.pad;

  double top = plan.title.empty()
                   ? m.pad
                   : m.pad + static_cast<double>(plan.title.size()) * m.line * plan.theme->title_size * u + 1.1 * m.gap;
  const double between = 26 * u;
  const double fixed_height = top + 0.8 * m.pad + std::accumulate(above.begin(), above.end(), 0.0) +
                              std::accumulate(below.begin(), below.end(), 0.0) + (plan.rows - 1) * between;
  const double room = std::max(plan.height - fixed_height, 20 * u * plan.rows);
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0);
  // Edges lie in the middle of pixels, where the axis lines are crisp.
  const auto snap = [](double v) { return std::floor(v) + 0.5; };
  for (std::size_t row = 0; row < above.size(); ++row) {
    top += above[row] + (row > 0 ? between : 0);
    const double height = room * weights[row] / all;
    double x = 0;
    for (std::size_t column = 0; column < lefts.size(); ++column) {
      x += lefts[column];
      const std::size_t i = row * lefts.size() + column;
      if (i < plan.panels.size()) plan.panels[i].box = {snap(x), snap(top), snap(x + wide), snap(top + height)};
      x += wide + rights[column];
    }
    top += height + below[row];
  }
}

}  // namespace

Scene layout(const Figure& given) {
  const std::optional<Figure> converted = in_units(given);
  const Figure& figure = converted ? *converted : given;
  Plan plan = begin(figure);
  add_panels(plan);
  // Boxes need the widths of the numbers, numbers need the sizes of the boxes: twice round is enough.
  for (PanelPlan& p : plan.panels) p.box = {0, 0, 0.85 * plan.width / plan.columns, 0.8 * plan.height / plan.rows};
  const auto settle = [&] {
    for (int round = 0; round < 2; ++round) {
      set_rulers(plan);
      for (PanelPlan& p : plan.panels) set_bar(plan, p);
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
    place_insets(plan, p);
  }
  return draw(plan);
}

}  // namespace plantloop
