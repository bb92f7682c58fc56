// The series of a panel, from data to pixels.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "render/layout/plan.h"

namespace plantloop {
namespace {

// Lines are followed this far beyond the panel's edge, so that ends and joins out there are not seen.
constexpr double beyond = 40;
// Pixels from the edge at which a far value is held, so that arithmetic stays finite.
constexpr double horizon = 1e12;

// A curve of more samples than this that does not run from left to right is thinned more.
constexpr std::size_t many = 50000;

struct Samples {
  std::vector<double> x, y;
};

// A held signal as a line: across, then up or down. The last value is held to the end of the panel's data.
Samples held(const Series& s, double end) {
  Samples result;
  const std::size_t n = std::min(s.x.size(), s.y.size());
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0 && std::isfinite(s.y[i - 1])) {
      result.x.push_back(s.x[i]);
      result.y.push_back(s.y[i - 1]);
    }
    result.x.push_back(s.x[i]);
    result.y.push_back(s.y[i]);
  }
  if (n > 0 && std::isfinite(s.y[n - 1]) && s.x[n - 1] < end) {
    result.x.push_back(end);
    result.y.push_back(s.y[n - 1]);
  }
  return result;
}

double last_x(const PanelPlan& panel) {
  double last = panel.x.lower;
  for (const SeriesPlan& plan : panel.series)
    for (const double x : plan.series->x)
      if (std::isfinite(x)) last = std::max(last, x);
  return std::min(last, panel.x.upper);
}

// Unbroken parts in pixels.
std::vector<Curve> to_curves(const PanelPlan& panel, const std::vector<double>& x, const std::vector<double>& y,
                             bool right) {
  std::vector<Curve> result;
  bool open = false;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    const bool finite = std::isfinite(x[i]) && std::isfinite(y[i]);
    const Spot spot = finite ? to_pixels(panel, x[i], y[i], right) : Spot{};
    if (!finite || !std::isfinite(spot.x) || !std::isfinite(spot.y)) {
      open = false;
      continue;
    }
    if (!open) result.emplace_back();
    open = true;
    result.back().push_back(spot);
  }
  return result;
}

bool rising(const Curve& curve) {
  return std::is_sorted(curve.begin(), curve.end(), [](Spot a, Spot b) { return a.x < b.x; });
}

// Columns are as wide as a stroke of this width hides.
Curve decimated(const Curve& curve, double stroke) {
  return rising(curve) ? decimate_columns(curve, std::max(0.5, 0.32 * stroke)) : decimate_distance(curve, 0.35);
}

void add_lines(const PanelPlan& panel, SeriesPlan& plan, const Samples& samples) {
  for (const Curve& curve : to_curves(panel, samples.x, samples.y, plan.right)) {
    const bool endless = curve.size() > many && plan.style == LineStyle::solid && !rising(curve);
    const Box reach = panel.box.grown(beyond);
    const std::vector<Curve> parts = endless ? without_repeats(decimate_distance(curve, 1.5), reach)
                                             : std::vector<Curve>{decimated(curve, plan.width)};
    for (const Curve& part : parts)
      for (Curve& seen : clip_line(part, reach)) plan.lines.push_back(std::move(seen));
  }
}

void add_area(const PanelPlan& panel, SeriesPlan& plan) {
  const Series& s = *plan.series;
  const std::size_t n = std::min({s.x.size(), s.y.size(), s.lower.size()});
  for (std::size_t begin = 0; begin < n;) {
    Curve upper, lower;
    std::size_t i = begin;
    for (; i < n; ++i) {
      if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i]) || !std::isfinite(s.lower[i])) break;
      const Spot a = to_pixels(panel, s.x[i], s.y[i], plan.right);
      Spot b = to_pixels(panel, s.x[i], s.lower[i], plan.right);
      // On a logarithmic axis an area that reaches zero goes down to the edge.
      if (std::isnan(b.y) && !std::isnan(a.y)) b.y = panel.box.bottom + beyond;
      if (!std::isfinite(a.x) || !std::isfinite(a.y) || !std::isfinite(b.y)) break;
      upper.push_back(a);
      lower.push_back(b);
    }
    if (upper.size() >= 2) {
      Curve ring = decimated(upper, 0);
      const Curve back = decimated(lower, 0);
      ring.insert(ring.end(), back.rbegin(), back.rend());
      Curve seen = clip_area(std::move(ring), panel.box.grown(beyond));
      if (seen.size() >= 3) plan.areas.push_back(std::move(seen));
    }
    begin = i + 1;
  }
}

// Polygons, each with its series' colour or that of its value.
void add_shapes(const Plan& plan, const PanelPlan& panel, SeriesPlan& series) {
  const std::optional<ColorScale>& colors = panel.panel->colors;
  for (const Area& area : series.series->areas) {
    Curve ring;
    for (std::size_t i = 0; i < std::min(area.x.size(), area.y.size()); ++i) {
      const Spot spot = to_pixels(panel, area.x[i], area.y[i], series.right);
      // On a logarithmic axis what reaches zero goes to the edge.
      ring.push_back({std::isnan(spot.x) && !std::isnan(area.x[i]) ? panel.box.left - beyond : spot.x,
                      std::isnan(spot.y) && !std::isnan(area.y[i]) ? panel.box.bottom + beyond : spot.y});
    }
    const bool finite =
        std::all_of(ring.begin(), ring.end(), [](Spot s) { return std::isfinite(s.x) && std::isfinite(s.y); });
    if (ring.size() < 3 || !finite) continue;
    if (series.series->crisp)
      for (Spot& spot : ring) spot = {std::floor(spot.x + 0.5), std::floor(spot.y + 0.5)};
    ring = clip_area(std::move(ring), panel.box.grown(beyond));
    if (to_polyline(ring).size() < 3) continue;
    Color color = series.color;
    if (area.value && colors) {
      if (std::isnan(*area.value)) continue;
      const double part = (*area.value - colors->lower) / (colors->upper - colors->lower);
      color = with_alpha(map_color(*plan.theme, colors->map, part), series.color.a);
    }
    series.shapes.push_back({std::move(ring), color});
  }
}

// A shaft with its middle at the place, and a head; as long as the look says.
void add_arrows(const Plan& plan, const PanelPlan& panel, SeriesPlan& series) {
  const Series& s = *series.series;
  const double length = arrow_length(plan, series), head = 0.3 * length;
  for (std::size_t i = 0; i < std::min({s.x.size(), s.y.size(), s.toward_x.size(), s.toward_y.size()}); ++i) {
    const Spot at = to_pixels(panel, s.x[i], s.y[i], series.right);
    if (!panel.box.contains(at)) continue;
    // The direction as it looks in the picture: the axes' units differ.
    const double dx = s.toward_x[i] * panel.box.width() / (panel.x.upper - panel.x.lower);
    const double dy = -s.toward_y[i] * panel.box.height() / (panel.y.upper - panel.y.lower);
    const double size = std::hypot(dx, dy);
    if (!(size > 0) || !std::isfinite(size)) continue;
    const double ux = dx / size, uy = dy / size;
    const Spot tip{at.x + 0.5 * length * ux, at.y + 0.5 * length * uy};
    const Spot neck{tip.x - head * ux, tip.y - head * uy};
    series.lines.push_back({{at.x - 0.5 * length * ux, at.y - 0.5 * length * uy}, neck});
    series.shapes.push_back({{tip,
                              {neck.x - 0.45 * head * uy, neck.y + 0.45 * head * ux},
                              {neck.x + 0.45 * head * uy, neck.y - 0.45 * head * ux}},
                             series.color});
  }
}

// So many markers at most: where more lie on top of each other, no eye can count them.
constexpr std::size_t most_marks = 40000;

// Keeps in each square of this side the first few.
std::vector<Spot> thinned(const std::vector<Spot>& marks, const Box& box, double side, std::uint8_t kept) {
  const auto columns = static_cast<std::size_t>(box.width() / side) + 3;
  std::vector<std::uint8_t> counts(columns * (static_cast<std::size_t>(box.height() / side) + 3));
  std::vector<Spot> result;
  for (const Spot s : marks) {
    const auto column = static_cast<std::size_t>((s.x - box.left) / side + 1);
    const auto row = static_cast<std::size_t>((s.y - box.top) / side + 1);
    std::uint8_t& count = counts[std::min(row * columns + column, counts.size() - 1)];
    if (count < kept) {
      ++count;
      result.push_back(s);
    }
  }
  return result;
}

void add_marks(const PanelPlan& panel, SeriesPlan& plan) {
  const Series& s = *plan.series;
  for (const Curve& curve : to_curves(panel, s.x, s.y, plan.right))
    for (const Spot spot : curve) {
      if (!panel.box.grown(1).contains(spot)) continue;
      if (!plan.marks.empty() && std::abs(plan.marks.back().x - spot.x) + std::abs(plan.marks.back().y - spot.y) < 0.25)
        continue;
      plan.marks.push_back(spot);
    }
  for (double side = std::max(1.0, 0.5 * plan.mark_radius); plan.marks.size() > most_marks; side *= 1.4)
    plan.marks = thinned(plan.marks, panel.box.grown(1), side, plan.color.a < 255 ? 3 : 1);
}

// A line of one sample has no length: it is shown as a dot.
void show_lone_samples(SeriesPlan& plan) {
  for (const Curve& line : plan.lines) {
    const bool lone = std::all_of(line.begin(), line.end(),
                                  [&](Spot s) { return std::abs(s.x - line[0].x) + std::abs(s.y - line[0].y) < 0.01; });
    if (lone && !line.empty()) plan.marks.push_back(line[0]);
  }
  std::erase_if(plan.lines, [](const Curve& line) { return to_polyline(line).size() < 2; });
}

}  // namespace

Spot to_pixels(const PanelPlan& panel, double x, double y, bool right) {
  const Box& box = panel.box;
  const double px = box.left + position(panel.x, x) * box.width();
  const double py = box.bottom - position(right ? panel.right : panel.y, y) * box.height();
  if (std::isnan(px) || std::isnan(py)) return {px, py};
  return {std::clamp(px, -horizon, horizon), std::clamp(py, -horizon, horizon)};
}

double arrow_length(const Plan& plan, const SeriesPlan& series) {
  const double size = series.series->look.size;
  return plan.unit * (size > 0 ? size * 152.4 / 72 : 18);
}

void set_curves(const Plan& figure, PanelPlan& panel) {
  const double end = last_x(panel);
  for (SeriesPlan& plan : panel.series) {
    plan.lines.clear();
    plan.areas.clear();
    plan.marks.clear();
    plan.shapes.clear();
    const Series& s = *plan.series;
    if (s.kind == Series::Kind::areas) {
      add_shapes(figure, panel, plan);
      continue;
    }
    if (s.kind == Series::Kind::arrows) {
      add_arrows(figure, panel, plan);
      continue;
    }
    if (s.kind == Series::Kind::band) {
      add_area(panel, plan);
      continue;
    }
    if (plan.style != LineStyle::none) {
      add_lines(panel, plan, s.kind == Series::Kind::stairs ? held(s, end) : Samples{s.x, s.y});
      show_lone_samples(plan);
    }
    if (s.look.marker != Marker::none) add_marks(panel, plan);
  }
}

}  // namespace plantloop
