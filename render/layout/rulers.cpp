// The ends of the axes: from the limits the user gives and the data that are seen.

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

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

// The x axis with as many numbers as find room beside each other.
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

// Names cannot be guessed from their neighbours, as numbers can: they are shortened and set upright before any is left
// out.
struct Names {
  std::vector<Label> labels;
  bool turned = false;
};

std::optional<Names> names_of(const Plan& plan, const Ruler& all, double length, const LabelStyle& style) {
  const auto is_number = [](const Tick& tick) {
    return std::all_of(tick.label.begin(), tick.label.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  if (all.ticks.empty() || std::all_of(all.ticks.begin(), all.ticks.end(), is_number)) return std::nullopt;
  double slot = length;
  for (std::size_t i = 0; i + 1 < all.ticks.size(); ++i)
    slot = std::min(slot, (position(all, all.ticks[i + 1].value) - position(all, all.ticks[i].value)) * length);
  double widest = 0;
  Names names;
  for (const Tick& tick : all.ticks) {
    const Label whole = set_label(tick.label, style);
    widest = std::max(widest, whole.width);
    names.labels.push_back(whole);
  }
  if (widest + 10 * plan.unit <= slot) return names;
  // Upright they need no more than a line each.
  if (slot < 1.05 * style.size) return std::nullopt;
  names.turned = true;
  for (std::size_t i = 0; i < names.labels.size(); ++i)
    names.labels[i] = set_label_shortened(all.ticks[i].label, style, 0.25 * plan.height);
  return names;
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

void part_axes(Plan& plan) {
  const Axis& axis = plan.figure->x;
  if (!axis.label.empty() || axis.limits.lower || axis.limits.upper || axis.scale != Scale::linear) return;
  struct Member {
    std::size_t panel;
    Range range;
  };
  std::vector<Member> members;
  for (std::size_t i = 0; i < plan.panels.size(); ++i) {
    const PanelPlan& p = plan.panels[i];
    Member member{i, {}};
    if (p.owner == shared_axis && !p.panel->space) add_x(member.range, *p.panel, axis.scale);
    if (member.range.lower <= member.range.upper) members.push_back(member);
  }
  std::stable_sort(members.begin(), members.end(),
                   [](const Member& a, const Member& b) { return a.range.lower < b.range.lower; });
  // Those whose ranges meet, one after the other.
  for (std::size_t begin = 0; begin < members.size();) {
    Range all = members[begin].range;
    std::size_t end = begin + 1;
    while (end < members.size() && members[end].range.lower <= all.upper) all.add(members[end++].range.upper);
    const auto is_tiny = [&](const Range& range) { return range.upper - range.lower < 0.1 * (all.upper - all.lower); };
    std::size_t owner = shared_axis;
    if (begin > 0 || end < members.size())
      for (std::size_t i = begin; i < end; ++i)
        if (!is_tiny(members[i].range)) owner = std::min(owner, members[i].panel);
    for (std::size_t i = begin; i < end; ++i)
      plan.panels[members[i].panel].owner = is_tiny(members[i].range) ? members[i].panel : owner;
    begin = end;
  }
}

void set_rulers(Plan& plan) {
  const double u = plan.unit;
  const LabelStyle style = plan.tick_style();
  struct Shared {
    Range range;
    double narrowest = 1e9;
    int panels = 0;
    const Axis* axis = nullptr;
  };
  std::map<std::size_t, Shared> axes;
  for (const PanelPlan& p : plan.panels) {
    if (p.panel->space) continue;
    Shared& shared = axes[p.owner];
    shared.axis = p.x_axis;
    ++shared.panels;
    add_x(shared.range, *p.panel, p.x_axis->scale);
    shared.narrowest = std::min(shared.narrowest, p.box.width());
  }
  std::map<std::size_t, Ruler> rulers;
  std::map<std::size_t, Names> names;
  for (const auto& [owner, shared] : axes) {
    RulerWish wish = wish_for(*shared.axis, shared.range, shared.narrowest, 110 * u, 45 * u);
    wish.tight = shared.axis == &plan.figure->x || shared.axis->tight || shared.panels > 1;
    Ruler& ruler = rulers[owner];
    if (wish.named) ruler = make_ruler(wish);
    const auto found = wish.named ? names_of(plan, ruler, wish.length, style) : std::nullopt;
    if (found)
      names[owner] = *found;
    else
      ruler = horizontal(plan, wish, style);
  }
  for (PanelPlan& p : plan.panels)
    if (!p.panel->space) p.x = rulers[p.owner];
  std::vector<Range> lefts;
  for (const PanelPlan& p : plan.panels) lefts.push_back(p.panel->space ? Range{} : left_range(p));
  if (plan.figure->share_y) {
    Range widest;
    for (const Range& range : lefts)
      if (range.lower <= range.upper) widest.add(range.lower), widest.add(range.upper);
    std::fill(lefts.begin(), lefts.end(), widest);
  }
  for (std::size_t i = 0; i < plan.panels.size(); ++i)
    if (PanelPlan& p = plan.panels[i]; !p.panel->space) {
      set_panel_rulers(plan, p, lefts[i]);
      const auto named = names.find(p.owner);
      p.x_turned = named != names.end() && named->second.turned;
      if (named != names.end()) p.x_ticks = named->second.labels;
    }
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
