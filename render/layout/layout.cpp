// Lays a figure out: measures labels, gives every panel its box, then places what belongs into it.

#include "render/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "render/error.h"
#include "render/layout/plan.h"

namespace plantloop {
namespace {

double default_height(const Figure& figure) {
  if (figure.panels.size() <= 1 && (figure.panels.empty() || figure.panels[0].below.empty())) {
    const bool square = !figure.panels.empty() && (figure.panels[0].equal || figure.panels[0].space);
    return (square ? 0.8 : 2.0 / 3) * figure.width;
  }
  const std::size_t columns =
      static_cast<std::size_t>(std::clamp<int>(figure.columns, 1, static_cast<int>(figure.panels.size())));
  std::size_t rows = (figure.panels.size() + columns - 1) / columns;
  if (columns == 1)
    for (const Panel& panel : figure.panels) rows += panel.below.size();
  // Many panels are lower than few; beside each other they are about as high as wide.
  const double low = columns > 1 ? 0.7 / static_cast<double>(columns) : rows == 2 ? 0.32 : rows == 3 ? 0.27 : 0.23;
  double sum = 0.13;
  for (std::size_t i = 0; i < figure.panels.size(); i += columns) {
    double highest = 0;
    for (std::size_t k = i; k < std::min(i + columns, figure.panels.size()); ++k) {
      const Panel& panel = figure.panels[k];
      const auto own = [&](const Panel& part, bool stands_alone) {
        return (columns > 1 || !stands_alone ? low : 0.5) * std::clamp(part.height, 0.2, 5.0);
      };
      double height = own(panel, panel.below.empty() && (panel.x || panel.space));
      // What stands under a panel beside others shares its place, which is then somewhat higher.
      for (const Panel& part : panel.below) height += (columns > 1 ? 0.5 : 1.0) * own(part, part.x.has_value());
      highest = std::max(highest, height);
    }
    sum += highest;
  }
  return sum * figure.width;
}

// The only panel's own axis takes what the user says of the figure's x, but for time, which it does not show.
std::optional<Figure> with_own_axis(const Figure& figure) {
  if (figure.panels.size() != 1 || !figure.panels[0].x || !figure.panels[0].x->own) return std::nullopt;
  Figure made = figure;
  Axis& axis = *made.panels[0].x;
  const bool time = !figure.x.time_unit.empty() || figure.x.label.starts_with("time");
  if (axis.label.empty() || (!time && !figure.x.label.empty())) {
    axis.label = figure.x.label;
    axis.time_unit = figure.x.time_unit;
  }
  if (figure.x.limits.lower) axis.limits.lower = figure.x.limits.lower;
  if (figure.x.limits.upper) axis.limits.upper = figure.x.limits.upper;
  if (figure.x.scale != Scale::linear) axis.scale = figure.x.scale;
  if (figure.x.threshold != 0) axis.threshold = figure.x.threshold;
  if (!figure.x.ticks.empty()) axis.ticks = figure.x.ticks;
  return made;
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
  const int count = std::max(static_cast<int>(figure.panels.size()), 1);
  plan.columns = std::clamp(figure.columns, 1, count);
  const auto add = [&](const Panel& panel, std::size_t owner, int row, int column) {
    plan.panels.push_back(plan_panel(plan, panel));
    PanelPlan& p = plan.panels.back();
    p.owner = panel.x ? plan.panels.size() - 1 : owner;
    if (p.owner != shared_axis) p.x_axis = &*plan.panels[p.owner].panel->x;
    p.row = row;
    p.column = column;
    if (figure.share_y && column > 0) p.shows_y = false;
  };
  int row = 0;
  for (int i = 0; i < count; ++i) {
    const Panel& head = figure.panels.empty() ? nothing : figure.panels[static_cast<std::size_t>(i)];
    const int column = i % plan.columns;
    if (i > 0 && column == 0) ++row;
    add(head, shared_axis, row, column);
    const std::size_t owner = plan.panels.back().owner;
    for (const Panel& panel : head.below) {
      // In one column what stands under a panel is a row of its own, beside others a part of its panel's place.
      if (plan.columns == 1) ++row;
      add(panel, owner, row, column);
      plan.panels.back().under = plan.columns > 1;
    }
  }
  plan.rows = row + 1;
}

// Of the panels of a column that share an axis only the lowest shows its numbers.
void show_axes(Plan& plan) {
  std::set<std::pair<int, std::size_t>> seen;
  for (auto p = plan.panels.rbegin(); p != plan.panels.rend(); ++p)
    if (!p->panel->space && !p->panel->bare) p->shows_x = seen.insert({p->column, p->owner}).second;
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

// Of the row of numbers or names below a panel.
double numbers_height(const Plan& plan, const PanelPlan& p) {
  return p.x_turned ? widest(p.x_ticks) + 0.6 * measures(plan).gap : measures(plan).tick_row;
}

double height_below(const Plan& plan, const PanelPlan& p) {
  const Measures m = measures(plan);
  if (!p.shows_x) return 0;
  const double label = static_cast<double>(p.x_label.size()) * m.line * plan.theme->label_size * plan.unit;
  return 0.4 * m.gap + numbers_height(plan, p) + (label > 0 ? label + 0.4 * m.gap : p.x_note.empty() ? 0 : m.tick_row);
}

double weight_of(const Plan& plan, const PanelPlan& p) {
  const bool alone = p.panel->x && p.panel->below.empty() && plan.columns == 1 && plan.panels.size() > 1;
  return std::clamp(p.panel->height, 0.2, 5.0) * (alone ? 1.5 : 1);
}

double across(const PanelPlan& p, const Label& tick) { return p.x_turned ? tick.size : tick.width; }

// The room that a panel needs on its left.
double left_of(const Plan& plan, const PanelPlan& p) {
  const Measures m = measures(plan);
  const double u = plan.unit;
  double left = (p.column == 0 ? m.pad : 0.8 * m.pad) + (p.shows_y ? side_width(plan, p.y_ticks, p.y_label) : 0);
  if (p.shows_x && !p.x_ticks.empty()) {
    const double first = position(p.x, p.x.ticks.front().value);
    left = std::max(left, across(p, p.x_ticks.front()) / 2 + 10 * u - first * std::max(p.box.width(), 1.0));
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
    side = std::max(side, across(p, p.x_ticks.back()) / 2 + 10 * u - (1 - at) * std::max(p.box.width(), 1.0));
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

// Panels that stand in one place of the rows and columns, one under the other.
struct Place {
  std::size_t first = 0, last = 0;
  double weight = 0, weight_sum = 0;
  double between = 0;  // the height that no panel has
};

constexpr double row_gap = 26;  // in units

double height_between(const Plan& plan, const PanelPlan& upper, const PanelPlan& lower) {
  return height_below(plan, upper) + 0.7 * row_gap * plan.unit + height_above(plan, lower);
}

std::vector<Place> places_of(const Plan& plan) {
  std::vector<Place> places;
  for (std::size_t i = 0; i < plan.panels.size(); ++i) {
    const double weight = weight_of(plan, plan.panels[i]);
    if (!plan.panels[i].under) {
      places.push_back({i, i, weight, weight, 0});
      continue;
    }
    Place& place = places.back();
    place.last = i;
    place.weight += 0.5 * weight;
    place.weight_sum += weight;
    place.between += height_between(plan, plan.panels[i - 1], plan.panels[i]);
  }
  return places;
}

void set_boxes(Plan& plan) {
  const Measures m = measures(plan);
  const double u = plan.unit;
  const auto count = [](int n) { return static_cast<std::size_t>(n); };
  std::vector<double> lefts(count(plan.columns)), rights(count(plan.columns)), above(count(plan.rows)),
      below(count(plan.rows)), weights(count(plan.rows));
  const std::vector<Place> places = places_of(plan);
  for (const PanelPlan& p : plan.panels) {
    lefts[count(p.column)] = std::max(lefts[count(p.column)], left_of(plan, p));
    rights[count(p.column)] = std::max(rights[count(p.column)], right_of(plan, p));
  }
  for (const Place& place : places) {
    const PanelPlan &first = plan.panels[place.first], &last = plan.panels[place.last];
    above[count(first.row)] = std::max(above[count(first.row)], height_above(plan, first));
    below[count(first.row)] = std::max(below[count(first.row)], height_below(plan, last));
    weights[count(first.row)] = std::max(weights[count(first.row)], place.weight);
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
  const double between = row_gap * u;
  const double fixed_height = top + 0.8 * m.pad + std::accumulate(above.begin(), above.end(), 0.0) +
                              std::accumulate(below.begin(), below.end(), 0.0) + (plan.rows - 1) * between;
  const double room = std::max(plan.height - fixed_height, 20 * u * plan.rows);
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0);
  // Edges lie in the middle of pixels, where the axis lines are crisp.
  const auto snap = [](double v) { return std::floor(v) + 0.5; };
  for (std::size_t row = 0; row < above.size(); ++row) {
    top += above[row] + (row > 0 ? between : 0);
    const double height = room * weights[row] / all;
    for (const Place& place : places) {
      if (count(plan.panels[place.first].row) != row) continue;
      const std::size_t column = count(plan.panels[place.first].column);
      double x = column * wide + lefts[0];
      for (std::size_t k = 0; k < column; ++k) x += rights[k] + lefts[k + 1];
      const double own = std::max(height - place.between, 10 * u * static_cast<double>(place.last - place.first + 1));
      double y = top;
      for (std::size_t i = place.first; i <= place.last; ++i) {
        PanelPlan& p = plan.panels[i];
        if (i > place.first) y += height_between(plan, plan.panels[i - 1], p);
        const double part = own * weight_of(plan, p) / place.weight_sum;
        p.box = {snap(x), snap(y), snap(x + wide), snap(y + part)};
        y += part;
      }
    }
    top += height + below[row];
  }
}

}  // namespace

Scene layout(const Figure& given) {
  const std::optional<Figure> single = with_own_axis(given);
  const std::optional<Figure> converted = in_units(single ? *single : given);
  const Figure& figure = converted ? *converted : single ? *single : given;
  Plan plan = begin(figure);
  add_panels(plan);
  part_axes(plan);
  show_axes(plan);
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
    const auto covered = [&](const PlacedLabel& label) {
      return std::any_of(p.insets.begin(), p.insets.end(),
                         [&](const PanelPlan& inset) { return whole_inset(plan, inset).meets(label.box()); });
    };
    if (std::any_of(p.labels.begin(), p.labels.end(), covered)) place_labels(plan, p);
  }
  return draw(plan);
}

}  // namespace plantloop
