// The ends of the axes: from the limits the user gives and the data that are seen.

#include <algorithm>
#include <cmath>

#include "render/layout/plan.h"

namespace plantloop {
namespace {

struct Range {
  double lower = 1, upper = -1;  // empty
  void add(double v) {
    if (!(lower <= upper)) lower = upper = v;
    lower = std::min(lower, v);
    upper = std::max(upper, v);
  }
};

bool shown(double v, Scale scale) { return std::isfinite(v) && (scale != Scale::log || v > 0); }

bool counts(const Series& s) { return s.look.ink != Ink::grid && s.look.ink != Ink::reference; }

void add_x(Range& range, const Panel& panel, Scale scale) {
  for (const auto* list : {&panel.series, &panel.right_series})
    for (const Series& s : *list) {
      if (!counts(s)) continue;
      for (const double x : s.x)
        if (shown(x, scale)) range.add(x);
      for (const Area& area : s.areas)
        for (const double x : area.x)
          if (shown(x, scale)) range.add(x);
    }
  for (const Callout& c : panel.callouts)
    if (!c.quiet && shown(c.x, scale)) range.add(c.x);
}

// Values of y whose x is seen.
void add_y(Range& range, const Panel& panel, bool right, const Ruler& x, Scale scale) {
  const double lower = std::min(x.lower, x.upper), upper = std::max(x.lower, x.upper);
  const auto add = [&](double at, double y) {
    if (at >= lower && at <= upper && shown(y, scale)) range.add(y);
  };
  for (const Series& s : right ? panel.right_series : panel.series) {
    if (!counts(s)) continue;
    for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
      add(s.x[i], s.y[i]);
      if (s.kind == Series::Kind::band && i < s.lower.size()) add(s.x[i], s.lower[i]);
    }
    for (const Area& area : s.areas)
      for (std::size_t i = 0; i < std::min(area.x.size(), area.y.size()); ++i) add(area.x[i], area.y[i]);
  }
  for (const Callout& c : panel.callouts)
    if (!c.quiet && c.right == right) add(c.x, c.y);
}

// A reference line belongs into view when it is near the data.
void add_references(Range& range, const Panel& panel, Scale scale) {
  Range wider = range;
  const auto add = [&](double v) {
    if (!shown(v, scale)) return;
    const double span = range.upper - range.lower;
    const bool far = range.lower <= range.upper && span > 0 && (v > range.upper + span || v < range.lower - span);
    if (!far) wider.add(v);
  };
  for (const ReferenceLine& line : panel.lines)
    if (line.axis == ReferenceLine::y) add(line.at);
  for (const ReferenceBand& band : panel.bands) {
    if (band.lower) add(*band.lower);
    if (band.upper) add(*band.upper);
  }
  range = wider;
}

bool in_degrees(const std::string& label) {
  return label.ends_with("[°]") || label.ends_with("[deg]") || label.ends_with("(°)");
}

RulerWish wish_for(const Axis& axis, const Range& range, double length, double spacing, double gap) {
  return {.scale = axis.scale,
          .limits = axis.limits,
          .data_lower = range.lower,
          .data_upper = range.upper,
          .length = length,
          .spacing = spacing,
          .gap = gap,
          .degrees = in_degrees(axis.label),
          .threshold = axis.threshold,
          .named = axis.ticks.empty() ? nullptr : &axis.ticks};
}

// Low panels have their numbers closer together.
double upright_spacing(const PanelPlan& panel, double unit) {
  const double length = panel.box.height();
  return length / (2 + length / (105 * unit));
}

std::vector<Label> set_all(const Ruler& ruler, const LabelStyle& style) {
  std::vector<Label> labels;
  for (const Tick& tick : ruler.ticks) labels.push_back(set_label(tick.label, style));
  return labels;
}

// The x axis with as many labels as find room beside each other.
Ruler horizontal(const Plan& plan, RulerWish wish, const LabelStyle& style) {
  for (int attempt = 0;; ++attempt) {
    Ruler ruler = make_ruler(wish);
    const std::vector<Label> labels = set_all(ruler, style);
    bool fits = true;
    for (std::size_t i = 0; i + 1 < labels.size(); ++i) {
      const double gap =
          (position(ruler, ruler.ticks[i + 1].value) - position(ruler, ruler.ticks[i].value)) * wish.length;
      if ((labels[i].width + labels[i + 1].width) / 2 + 10 * plan.unit > gap) fits = false;
    }
    if (fits || attempt == 6 + 20 * (wish.named != nullptr)) return ruler;
    wish.spacing *= 1.35;
    wish.every = std::max(wish.every + 1, static_cast<int>(1.4 * wish.every));
  }
}

void widen(Ruler& ruler, double factor, double target) {
  const double middle = ruler.lower + (ruler.upper - ruler.lower) / 2, half = (ruler.upper - ruler.lower) / 2 * factor;
  ruler.lower = middle - half;
  ruler.upper = middle + half;
  set_ticks(ruler, target, false);
}

void make_equal(PanelPlan& panel, double unit) {
  if (panel.x.scale != Scale::linear || panel.y.scale != Scale::linear) return;
  const double x_unit = panel.box.width() / (panel.x.upper - panel.x.lower);
  const double y_unit = panel.box.height() / (panel.y.upper - panel.y.lower);
  const double x_target = std::clamp(panel.box.width() / (110 * unit), 3.0, 9.0);
  const double y_target = std::clamp(2 + panel.box.height() / (90 * unit), 3.0, 9.0);
  if (x_unit > y_unit)
    widen(panel.x, x_unit / y_unit, x_target);
  else
    widen(panel.y, y_unit / x_unit, y_target);
}

// The grid lines of the left axis serve the right one as well when they begin and end at the panel's edges.
void share_intervals(const Ruler& left, RulerWish& wish) {
  if (left.scale != Scale::linear || left.ticks.size() < 2) return;
  const double slack = 1e-9 * (left.upper - left.lower);
  if (std::abs(left.ticks.front().value - left.lower) > slack || std::abs(left.ticks.back().value - left.upper) > slack)
    return;
  wish.intervals = static_cast<int>(left.ticks.size()) - 1;
  for (const Tick& tick : left.ticks)
    if (tick.value < 0) ++wish.intervals_below_zero;
  if (left.lower >= 0 || left.upper <= 0) wish.intervals_below_zero = 0;
}

// The axes of one panel but for a shared x.
void set_panel_rulers(const Plan& plan, PanelPlan& p, const Range& left) {
  const double u = plan.unit;
  const LabelStyle style = plan.tick_style();
  p.y = make_ruler(wish_for(p.panel->y, left, p.box.height(), upright_spacing(p, u), 20 * u));
  if (p.panel->equal) make_equal(p, u);
  p.right_ticks.clear();
  if (p.twin) {
    Range right;
    add_y(right, *p.panel, true, p.x, p.panel->right.scale);
    RulerWish wish = wish_for(p.panel->right, right, p.box.height(), upright_spacing(p, u), 20 * u);
    if (!wish.limits.lower && !wish.limits.upper && wish.scale == Scale::linear) share_intervals(p.y, wish);
    p.right = make_ruler(wish);
    p.right_ticks = set_all(p.right, style);
    p.right_note = p.right.note.empty() ? Label{} : set_label(p.right.note, style);
  }
  p.x_ticks = set_all(p.x, style);
  p.y_ticks = set_all(p.y, style);
  p.y_note = p.y.note.empty() || !p.shows_y ? Label{} : set_label(p.y.note, style);
  p.x_note = p.x.note.empty() ? Label{} : set_label(p.x.note, style);
}

Range left_range(const PanelPlan& p) {
  Range left;
  add_y(left, *p.panel, false, p.x, p.panel->y.scale);
  add_references(left, *p.panel, p.panel->y.scale);
  return left;
}

}  // namespace

void set_rulers(Plan& plan) {
  const double u = plan.unit;
  const LabelStyle style = plan.tick_style();
  Range shared;
  double narrowest = 1e9;
  for (const PanelPlan& p : plan.panels)
    if (!p.panel->x && !p.panel->space) {
      add_x(shared, *p.panel, plan.figure->x.scale);
      narrowest = std::min(narrowest, p.box.width());
    }
  RulerWish time = wish_for(plan.figure->x, shared, narrowest, 110 * u, 45 * u);
  time.tight = true;
  const Ruler common = horizontal(plan, time, style);
  for (PanelPlan& p : plan.panels) {
    p.x = common;
    if (!p.panel->x || p.panel->space) continue;
    Range own;
    add_x(own, *p.panel, p.panel->x->scale);
    p.x = horizontal(plan, wish_for(*p.panel->x, own, p.box.width(), 110 * u, 45 * u), style);
  }
  std::vector<Range> lefts;
  for (const PanelPlan& p : plan.panels) lefts.push_back(p.panel->space ? Range{} : left_range(p));
  if (plan.figure->share_y) {
    Range widest;
    for (const Range& range : lefts)
      if (range.lower <= range.upper) widest.add(range.lower), widest.add(range.upper);
    std::fill(lefts.begin(), lefts.end(), widest);
  }
  for (std::size_t i = 0; i < plan.panels.size(); ++i)
    if (!plan.panels[i].panel->space) set_panel_rulers(plan, plan.panels[i], lefts[i]);
}

void set_inset_rulers(const Plan& plan, PanelPlan& inset) {
  const double u = plan.unit;
  Range own;
  add_x(own, *inset.panel, inset.x_axis->scale);
  RulerWish wish = wish_for(*inset.x_axis, own, inset.box.width(), 90 * u, 45 * u);
  if (inset.panel->x) wish.limits = inset.panel->x->limits;
  wish.tight = true;
  inset.x = horizontal(plan, wish, plan.tick_style());
  set_panel_rulers(plan, inset, left_range(inset));
}

}  // namespace plantloop
