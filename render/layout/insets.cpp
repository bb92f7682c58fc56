// Small panels inside a panel.

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/layout/plan.h"

namespace plantloop {
namespace {

// The room for numbers beside an inset's box.
constexpr double left_room = 52, right_room = 22, top_room = 14, bottom_room = 34;

// Where the least is covered: in the corners and the middles of the sides, else anywhere; smaller where that helps.
Box freest(const PanelPlan& panel, const Occupancy& map, double u) {
  const Box& b = panel.box;
  Box best;
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](const Box& box, double cost) {
    if (cost >= least) return;
    least = cost;
    best = box;
  };
  for (const double size : {1.0, 0.85, 0.7}) {
    const double width = 0.4 * size * b.width() + (left_room + right_room) * u;
    const double height = 0.38 * size * b.height() + (top_room + bottom_room) * u;
    double cost = 0;
    const Box corner = emptiest(panel, map, width, height, 0, cost);
    take(corner, cost);
    constexpr int steps = 16;
    for (int row = 1; row < steps && least > 0; ++row)
      for (int column = steps - 1; column > 0; --column) {
        const double left = b.left + (b.width() - width) * column / steps;
        const double top = b.top + (b.height() - height) * row / steps;
        const Box box{left, top, left + width, top + height};
        take(box, map.covered(box.grown(3)));
      }
    if (least == 0) break;
  }
  return best;
}

Box box_of(const Plan& plan, const PanelPlan& panel, const Panel& inset) {
  const Box& b = panel.box;
  const double u = plan.unit;
  const auto snap = [](double v) { return std::floor(v) + 0.5; };
  if (inset.place) {
    const Panel::Place& p = *inset.place;
    const double left = b.left + std::clamp(p.left, 0.0, 0.9) * b.width();
    const double bottom = b.bottom - std::clamp(p.bottom, 0.0, 0.9) * b.height();
    return {snap(left), snap(bottom - std::clamp(p.height, 0.1, 1.0) * b.height()),
            snap(left + std::clamp(p.width, 0.1, 1.0) * b.width()), snap(bottom)};
  }
  Occupancy map = map_of(panel);
  if (panel.key.kind == KeyKind::inside) map.add_box(panel.key.box, 100);
  const Box whole = freest(panel, map, u);
  return {snap(whole.left + left_room * u), snap(whole.top + top_room * u), snap(whole.right - right_room * u),
          snap(whole.bottom - bottom_room * u)};
}

}  // namespace

Box whole_inset(const Plan& plan, const PanelPlan& inset) {
  const Box& b = inset.box;
  const double u = plan.unit;
  double widest = 0;
  for (const Label& label : inset.y_ticks) widest = std::max(widest, label.width);
  return {b.left - widest - 16 * u, b.top - 12 * u, b.right + 12 * u, b.bottom + 30 * u};
}

void place_insets(const Plan& plan, PanelPlan& panel) {
  for (std::size_t i = 0; i < panel.insets.size(); ++i) {
    PanelPlan inset = panel.insets[i];
    inset.insets.clear();
    inset.key = {};
    PanelPlan before = panel;
    before.insets.resize(i);
    inset.box = box_of(plan, before, *inset.panel);
    set_inset_rulers(plan, inset);
    set_curves(plan, inset);
    place_labels(plan, inset);
    const Spot a = to_pixels(panel, inset.x.lower, inset.y.lower, false),
               b = to_pixels(panel, inset.x.upper, inset.y.upper, false);
    const Box seen{a.x, b.y, b.x, a.y};
    const Box frame{std::max(seen.left, panel.box.left), std::max(seen.top, panel.box.top),
                    std::min(seen.right, panel.box.right), std::min(seen.bottom, panel.box.bottom)};
    const bool limited = inset.panel->x && (inset.panel->x->limits.lower || inset.panel->x->limits.upper);
    if (limited && frame.width() > 3 && frame.height() > 3) inset.inset_frame = frame;
    panel.insets[i] = std::move(inset);
  }
}

}  // namespace plantloop
