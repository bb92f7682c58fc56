// Which line is which: end labels where they fit, else a legend in the emptiest corner, else one outside the panel.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/layout/occupancy.h"
#include "render/layout/plan.h"

namespace plantloop {
namespace {

// Without the unit.
std::string quantity(const std::string& label) {
  const std::size_t bracket = label.rfind(" [");
  return bracket == std::string::npos ? label : label.substr(0, bracket);
}

// The series that need an explanation.
std::vector<std::size_t> labelled(const PanelPlan& panel) {
  std::vector<std::size_t> result;
  std::size_t left = 0, right = 0;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const SeriesPlan& s = panel.series[i];
    ++(s.right ? right : left);
    const Axis& axis = s.right ? panel.panel->right : panel.panel->y;
    const std::string& label = s.series->look.label;
    const bool said_by_axis = (label == axis.label || label == quantity(axis.label)) && !label.empty();
    if (!label.empty() && !s.is_guide() && !(said_by_axis && panel.series.size() == 1)) result.push_back(i);
  }
  // The colours of the two axes' labels say it already.
  const bool axes_say_it =
      panel.twin && left == 1 && right == 1 && !panel.panel->y.label.empty() && !panel.panel->right.label.empty();
  return axes_say_it ? std::vector<std::size_t>{} : result;
}

// Moves the wanted heights apart until neighbours have `row` between them, as little as possible.
std::vector<double> spread(const std::vector<double>& wanted, double row) {
  struct Cluster {
    double sum = 0;
    std::size_t count = 0;
    double start(double distance) const {
      return sum / static_cast<double>(count) - distance * static_cast<double>(count - 1) / 2;
    }
  };
  std::vector<std::size_t> order(wanted.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return wanted[a] < wanted[b]; });
  std::vector<Cluster> clusters;
  for (const std::size_t i : order) {
    clusters.push_back({wanted[i], 1});
    while (clusters.size() >= 2) {
      const Cluster& above = clusters[clusters.size() - 2];
      const Cluster& last = clusters.back();
      if (above.start(row) + row * static_cast<double>(above.count) <= last.start(row)) break;
      const Cluster joined{above.sum + last.sum, above.count + last.count};
      clusters.pop_back();
      clusters.back() = joined;
    }
  }
  std::vector<double> result(wanted.size());
  std::size_t next = 0;
  for (const Cluster& c : clusters)
    for (std::size_t k = 0; k < c.count; ++k) result[order[next++]] = c.start(row) + row * static_cast<double>(k);
  return result;
}

// The height at which a line leaves the panel on the right; NaN when it does not reach that side.
double end_height(const PanelPlan& panel, const SeriesPlan& series) {
  double height = std::numeric_limits<double>::quiet_NaN();
  for (const Curve& line : series.lines)
    for (const Spot s : line)
      if (s.x >= panel.box.right - 0.02 * panel.box.width() && s.x <= panel.box.right + 0.5) height = s.y;
  const bool inside = height >= panel.box.top - 1 && height <= panel.box.bottom + 1;
  return inside ? height : std::numeric_limits<double>::quiet_NaN();
}

struct Sizes {
  double row, sample, gap, between;
};

Sizes sizes(const Plan& plan) {
  const double size = plan.theme->text_size * plan.unit;
  return {1.5 * size, 2.0 * size, 0.55 * size, 1.5 * size};
}

void set_key_labels(const Plan& plan, PanelPlan& panel, double width) {
  std::vector<std::string> texts;
  for (const std::size_t i : panel.key.entries) {
    const SeriesPlan& s = panel.series[i];
    texts.push_back(s.series->look.label + (s.right ? " (right)" : ""));
  }
  const auto set_all = [&] {
    panel.key.labels.clear();
    for (const std::string& text : texts)
      panel.key.labels.push_back(set_label_shortened(text, plan.text_style(), width));
  };
  set_all();
  // Where shortened names are the same though whole they are not, what they have in common is left out first.
  const auto different = [](auto list) {
    std::sort(list.begin(), list.end());
    return std::unique(list.begin(), list.end()) - list.begin();
  };
  std::vector<std::string> shown;
  for (const Label& label : panel.key.labels) shown.push_back(label.source);
  if (different(shown) == different(texts)) return;
  texts = distinct_parts(texts);
  set_all();
}

void add_rest(const Plan& plan, KeyPlan& key) {
  key.labels.push_back(set_label(fmt::format("and {} more", key.hidden), plan.text_style()));
}

// Leaves out the last entries when there are more than there is room for, and says how many.
void cut_key(const Plan& plan, KeyPlan& key, std::size_t most) {
  if (key.entries.size() <= most) return;
  const std::size_t kept = most - 1;
  key.hidden = key.entries.size() - kept;
  key.entries.resize(kept);
  key.labels.resize(kept);
  add_rest(plan, key);
}

double widest(const std::vector<Label>& labels) {
  double result = 0;
  for (const Label& label : labels) result = std::max(result, label.width);
  return result;
}

// The box in the corner that was asked for.
Box corner(const PanelPlan& panel, double width, double height, double margin) {
  const Legend wish = panel.panel->legend;
  const Box& b = panel.box;
  const double left =
      wish == Legend::top_left || wish == Legend::bottom_left ? b.left + margin : b.right - margin - width;
  const double top =
      wish == Legend::top_left || wish == Legend::top_right ? b.top + margin : b.bottom - margin - height;
  return {left, top, left + width, top + height};
}

}  // namespace

double end_label_width(const PanelPlan& panel) {
  return panel.key.kind == KeyKind::end_labels ? widest(panel.key.labels) : 0;
}

void choose_end_labels(const Plan& plan, PanelPlan& panel) {
  KeyPlan& key = panel.key;
  key = {};
  const Legend wish = panel.panel->legend;
  if (wish == Legend::none) return;
  key.entries = labelled(panel);
  if (key.entries.empty()) return;
  key.kind = KeyKind::inside;
  if (wish != Legend::automatic || panel.twin || key.entries.size() > 8) return;
  std::vector<double> heights;
  for (const std::size_t i : key.entries) heights.push_back(end_height(panel, panel.series[i]));
  if (std::any_of(heights.begin(), heights.end(), [](double h) { return std::isnan(h); })) return;
  const double row = 1.25 * plan.theme->text_size * plan.unit;
  panel.end_label_y = spread(heights, row);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (std::abs(heights[i] - panel.end_label_y[i]) > 0.8 * row) return;
    if (panel.end_label_y[i] < panel.box.top - row || panel.end_label_y[i] > panel.box.bottom + 0.3 * row) return;
  }
  set_key_labels(plan, panel, 1e9);
  if (widest(key.labels) > 0.2 * plan.width) return;
  key.kind = KeyKind::end_labels;
}

void choose_legend(const Plan& plan, PanelPlan& panel) {
  KeyPlan& key = panel.key;
  if (key.kind == KeyKind::none || key.kind == KeyKind::end_labels) return;
  const Sizes s = sizes(plan);
  const double before = s.sample + s.gap;
  const double count = static_cast<double>(key.entries.size());

  set_key_labels(plan, panel, 0.45 * panel.box.width());
  // Fractions are higher than a row of letters.
  double row = s.row;
  for (const Label& label : key.labels) row = std::max(row, 1.15 * (label.bottom - label.top));
  key.row = row;
  key.column = before + widest(key.labels);
  key.columns = 1;
  double height = count * row;
  if (height > 0.5 * panel.box.height() && count <= 12) {
    key.columns = 2;
    height = std::ceil(count / 2) * row;
  }
  const double width = key.columns * key.column + (key.columns - 1) * s.between;
  const Legend wish = panel.panel->legend;
  const bool outside = wish == Legend::above || wish == Legend::beside;
  if (!outside && height <= 0.6 * panel.box.height() && width <= 0.7 * panel.box.width()) {
    double cost = 0;
    const Occupancy map = map_of(panel);
    const double pad = 0.5 * plan.theme->text_size * plan.unit;
    key.box = emptiest(panel, map, width + 2 * pad, height + 2 * pad, 0.6 * plan.theme->text_size * plan.unit, cost);
    if (cost == 0 || wish != Legend::automatic) {
      key.kind = KeyKind::inside;
      return;
    }
  }

  // Rows between title and panel.
  set_key_labels(plan, panel, 0.6 * panel.box.width());
  key.column = before + widest(key.labels);
  const double room = panel.box.width() + s.between;
  key.columns = std::max(1, std::min(static_cast<int>(room / (key.column + s.between)), static_cast<int>(count)));
  const int rows = static_cast<int>(std::ceil(count / key.columns));
  const bool few = rows <= 3 && rows * row < 0.3 * panel.box.height();
  const int per_column = std::max(1, static_cast<int>(panel.box.height() / row));
  if (wish == Legend::above || (wish != Legend::beside && (few || panel.twin || per_column < 6))) {
    key.kind = KeyKind::above;
    const int most_rows = std::max(few ? rows : 1, static_cast<int>(0.4 * panel.box.height() / row));
    cut_key(plan, key, static_cast<std::size_t>(key.columns * most_rows));
    // As even as the number of rows allows.
    const double shown = static_cast<double>(key.labels.size());
    key.columns = static_cast<int>(std::ceil(shown / std::ceil(shown / key.columns)));
    return;
  }

  // Columns right of the panel.
  key.kind = KeyKind::beside;
  key.columns = std::clamp(static_cast<int>(std::ceil(count / per_column)), 1, 3);
  cut_key(plan, key, static_cast<std::size_t>(key.columns * per_column));
  const std::size_t hidden = key.hidden;
  set_key_labels(plan, panel, 0.4 * plan.width / key.columns - before - s.between);
  if (hidden > 0) add_rest(plan, key);
  key.column = before + widest(key.labels);
}

void place_key(const Plan& plan, PanelPlan& panel) {
  KeyPlan& key = panel.key;
  const Sizes s = sizes(plan);
  const Box& b = panel.box;
  if (key.kind == KeyKind::end_labels) {
    std::vector<double> heights;
    for (const std::size_t i : key.entries) heights.push_back(end_height(panel, panel.series[i]));
    for (double& h : heights)
      if (std::isnan(h)) h = (b.top + b.bottom) / 2;
    panel.end_label_y = spread(heights, 1.25 * plan.theme->text_size * plan.unit);
  } else if (key.kind == KeyKind::inside) {
    double cost = 0;
    const double margin = 0.6 * plan.theme->text_size * plan.unit;
    key.box = panel.panel->legend == Legend::automatic
                  ? emptiest(panel, map_of(panel), key.box.width(), key.box.height(), margin, cost)
                  : corner(panel, key.box.width(), key.box.height(), margin);
  } else if (key.kind == KeyKind::above) {
    const double rows = std::ceil(static_cast<double>(key.labels.size()) / key.columns);
    const double bottom = b.top - 0.5 * s.row - (panel.y_note.empty() && panel.right_note.empty() ? 0 : 0.8 * s.row);
    key.box = {b.left, bottom - rows * key.row, b.right, bottom};
  } else if (key.kind == KeyKind::beside) {
    const double left = plan.width - 1.2 * s.row - key.columns * key.column - (key.columns - 1) * s.between;
    key.box = {left, b.top, plan.width - 1.2 * s.row, b.bottom};
  }
}

}  // namespace plantloop
