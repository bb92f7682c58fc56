// Words inside a panel: the labels of reference lines, bands and callouts, each where the least is below it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/layout/plan.h"

namespace plantloop {
namespace {

constexpr double cell = 4;  // pixels, of the map of free space

bool inside(const Box& box, const Box& panel) {
  return box.left >= panel.left && box.right <= panel.right && box.top >= panel.top && box.bottom <= panel.bottom;
}

bool is_taken(const PanelPlan& panel, const Box& box) {
  return std::any_of(panel.labels.begin(), panel.labels.end(),
                     [&](const PlacedLabel& other) { return other.box().grown(2).meets(box); });
}

void add(Occupancy& map, PanelPlan& panel, PlacedLabel label) {
  map.add_box(label.box().grown(3), 100);
  panel.labels.push_back(std::move(label));
}

Color color_of(const Plan& plan, const PanelPlan& panel, const Callout& callout) {
  if (callout.color) return *callout.color;
  if (callout.color_of && *callout.color_of < panel.series.size()) return panel.series[*callout.color_of].color;
  return callout.quiet ? plan.theme->muted : plan.theme->text;
}

void add_mark(const Plan& plan, PanelPlan& panel, const Callout& callout) {
  const Spot at = to_pixels(panel, callout.x, callout.y, callout.right);
  if (callout.quiet || callout.marker == Marker::none || !panel.box.grown(1).contains(at)) return;
  panel.callouts.push_back({at, callout.marker, color_of(plan, panel, callout)});
}

// On the point itself, as the number of a contour stands on its line.
void place_quietly(const Plan& plan, PanelPlan& panel, Occupancy& map, const Callout& callout) {
  const Spot at = to_pixels(panel, callout.x, callout.y, callout.right);
  if (callout.label.empty() || !panel.box.contains(at)) return;
  Label label = set_label(callout.label, {0.8 * plan.theme->text_size * plan.unit, false, true});
  const double x = at.x - label.width / 2, y = at.y + 0.5 * cap_height * label.size;
  const Color color = readable_on(plan.theme->background, color_of(plan, panel, callout), 4.5);
  PlacedLabel placed{std::move(label), x, y, color, true, {}};
  if (!inside(placed.box().grown(3), panel.box) || is_taken(panel, placed.box().grown(4))) return;
  add(map, panel, std::move(placed));
}

// Around the point, near before far.
void place_callout(const Plan& plan, PanelPlan& panel, Occupancy& map, const Callout& callout) {
  const Spot at = to_pixels(panel, callout.x, callout.y, callout.right);
  if (callout.label.empty() || !panel.box.grown(1).contains(at)) return;
  Label label = set_label_shortened(callout.label, plan.remark_style(), 0.6 * panel.box.width());
  const double u = plan.unit, capital = cap_height * label.size;
  constexpr Spot ways[] = {{1, -1}, {-1, -1}, {1, 1}, {-1, 1}, {1, 0}, {-1, 0}, {0, -1}, {0, 1}};
  double least = std::numeric_limits<double>::infinity();
  std::optional<PlacedLabel> best;
  for (const double reach : {8.0, 22.0, 40.0, 64.0, 96.0, 140.0})
    for (const Spot way : ways) {
      const bool slanted = way.x != 0 && way.y != 0;
      const double r = (slanted ? 0.75 : 1) * reach * u;
      const double x = at.x + way.x * r + (way.x > 0 ? 0 : way.x < 0 ? -label.width : -label.width / 2);
      const double y = at.y + way.y * r + (way.y > 0 ? capital : way.y < 0 ? 0 : capital / 2);
      PlacedLabel placed{label, x, y, {}, false, {}};
      const Box box = placed.box();
      if (!inside(box.grown(2), panel.box) || is_taken(panel, box)) continue;
      const double cost = map.covered(box.grown(2)) + 0.25 * (reach - 8);
      if (cost >= least) continue;
      least = cost;
      placed.veil = cost - 0.25 * (reach - 8) >= 8;
      if (reach > 20) {
        const Spot end{std::clamp(at.x, box.left - 3 * u, box.right + 3 * u),
                       std::clamp(at.y, box.top - 3 * u, box.bottom + 3 * u)};
        placed.leader = {at, end};
      }
      best = std::move(placed);
    }
  if (!best) return;
  best->color = readable_on(plan.theme->background, color_of(plan, panel, callout), 4.5);
  if (best->leader) map.add_line({best->leader->first, best->leader->second});
  add(map, panel, std::move(*best));
}

}  // namespace

Occupancy map_of(const PanelPlan& panel) {
  Occupancy map(panel.box, cell);
  for (const SeriesPlan& series : panel.series) {
    if (series.series->look.ink == Ink::grid) continue;
    for (const Patch& shape : series.shapes) map.add_area(shape.ring);
    for (const Curve& area : series.areas) map.add_area(area);
    for (const Curve& line : series.lines) map.add_line(line);
    for (const Spot mark : series.marks) map.add_box(Box{mark.x, mark.y, mark.x, mark.y}.grown(4), 8);
  }
  for (const ReferenceLine& line : panel.panel->lines) {
    const bool across = line.axis == ReferenceLine::y;
    const Spot at = to_pixels(panel, across ? panel.x.lower : line.at, across ? line.at : panel.y.lower, false);
    if (std::isnan(at.x) || std::isnan(at.y)) continue;
    if (across)
      map.add_line({{panel.box.left, at.y}, {panel.box.right, at.y}});
    else
      map.add_line({{at.x, panel.box.top}, {at.x, panel.box.bottom}});
  }
  for (const PlacedLabel& l : panel.labels) map.add_box(l.box().grown(3), 100);
  for (const PlacedMark& m : panel.callouts) map.add_box(Box{m.at.x, m.at.y, m.at.x, m.at.y}.grown(5), 8);
  for (const PanelPlan& inset : panel.insets)
    if (inset.box.width() > 0) map.add_box(inset.box.grown(30), 100);
  return map;
}

Box emptiest(const PanelPlan& panel, const Occupancy& map, double width, double height, double inset, double& cost) {
  const Box& b = panel.box;
  const double left = b.left + inset, right = b.right - inset - width, middle = (left + right) / 2;
  const double top = b.top + inset, bottom = b.bottom - inset - height, half = (top + bottom) / 2;
  const Spot candidates[] = {{right, top},  {left, top},      {right, bottom}, {left, bottom},
                             {middle, top}, {middle, bottom}, {right, half},   {left, half}};
  Box best;
  cost = std::numeric_limits<double>::infinity();
  for (const Spot c : candidates) {
    const Box box{c.x, c.y, c.x + width, c.y + height};
    const double here = map.covered(box.grown(3));
    if (here < cost) {
      cost = here;
      best = box;
    }
  }
  return best;
}

void place_labels(const Plan& plan, PanelPlan& panel) {
  panel.labels.clear();
  panel.callouts.clear();
  for (const Callout& callout : panel.panel->callouts) add_mark(plan, panel, callout);
  Occupancy map = map_of(panel);
  // Once insets have their places, the legend has, too.
  const bool settled = std::any_of(panel.insets.begin(), panel.insets.end(),
                                   [](const PanelPlan& inset) { return inset.box.width() > 0; });
  if (settled && panel.key.kind == KeyKind::inside) map.add_box(panel.key.box, 100);
  const Theme& theme = *plan.theme;
  const Box& b = panel.box;
  const double gap = 6 * plan.unit;
  const LabelStyle style = plan.remark_style();

  // The candidate with the least below it; those that come first are preferred.
  const auto settle = [&](Label label, const std::vector<Spot>& candidates, Color color) {
    const Spot* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const Spot& c : candidates) {
      const Box box = PlacedLabel{label, c.x, c.y}.box();
      if (!inside(box, b)) continue;
      const double cost = map.covered(box.grown(1.5));
      if (cost < least && cost < 1e4) {
        least = cost;
        best = &c;
      }
    }
    if (best && !is_taken(panel, PlacedLabel{label, best->x, best->y}.box()))
      add(map, panel, {std::move(label), best->x, best->y, color, least >= 8, {}});
  };
  const auto fit = [&](const std::string& text) { return set_label_shortened(text, style, 0.5 * b.width()); };
  const auto beside_level = [&](const Label& label, double y) {
    std::vector<Spot> spots;
    for (const double part : {1.0, 0.0, 0.75, 0.5, 0.25}) {
      const double x = b.left + gap + part * (b.width() - 2 * gap - label.width);
      spots.push_back({x, y - gap - label.bottom});
      spots.push_back({x, y + gap + cap_height * label.size});
    }
    return spots;
  };

  for (const ReferenceLine& line : panel.panel->lines) {
    if (line.label.empty()) continue;
    const bool across = line.axis == ReferenceLine::y;
    const Spot at = to_pixels(panel, across ? panel.x.lower : line.at, across ? line.at : panel.y.lower, false);
    if (std::isnan(at.x) || std::isnan(at.y) || !b.grown(0.5).contains(across ? Spot{b.left, at.y} : Spot{at.x, b.top}))
      continue;
    const Color color = readable_on(theme.background, line.color.value_or(theme.reference), 4.5);
    Label label = fit(line.label);
    std::vector<Spot> spots;
    if (across) {
      spots = beside_level(label, at.y);
    } else {
      for (const double part : {0.0, 1.0, 0.25, 0.5, 0.75}) {
        const double y = b.top + gap + cap_height * label.size + part * (b.height() - 2 * gap - label.size);
        spots.push_back({at.x + gap, y});
        spots.push_back({at.x - gap - label.width, y});
      }
    }
    settle(std::move(label), spots, color);
  }
  for (const ReferenceBand& band : panel.panel->bands) {
    if (band.label.empty()) continue;
    const Color color = readable_on(theme.background, band.color.value_or(theme.reference), 4.5);
    Label label = fit(band.label);
    const double top = band.upper ? to_pixels(panel, panel.x.lower, *band.upper, false).y : b.top;
    const double bottom = band.lower ? to_pixels(panel, panel.x.lower, *band.lower, false).y : b.bottom;
    const double left = band.from ? to_pixels(panel, *band.from, panel.y.lower, false).x : b.left;
    const double right = band.until ? to_pixels(panel, *band.until, panel.y.lower, false).x : b.right;
    const Box area{std::max(left, b.left), std::max(top, b.top), std::min(right, b.right), std::min(bottom, b.bottom)};
    if (!(area.width() > 0) || !(area.height() > 0)) continue;
    std::vector<Spot> spots;
    const double capital = cap_height * label.size;
    if (area.height() > label.size + 2 * gap) {
      for (const double y :
           {area.top + gap + capital, area.bottom - gap - label.bottom, (area.top + area.bottom + capital) / 2})
        for (const double x :
             {area.left + gap, area.right - gap - label.width, (area.left + area.right - label.width) / 2})
          if (x + label.width <= area.right) spots.push_back({x, y});
    }
    for (const double y : {area.top - gap, area.bottom + gap + capital})
      for (const double x :
           {area.right - gap - label.width, area.left + gap, (area.left + area.right - label.width) / 2})
        spots.push_back({x, y});
    settle(std::move(label), spots, color);
  }
  for (const Callout& callout : panel.panel->callouts)
    if (!callout.quiet) place_callout(plan, panel, map, callout);
  for (const Callout& callout : panel.panel->callouts)
    if (callout.quiet) place_quietly(plan, panel, map, callout);
}

}  // namespace plantloop
