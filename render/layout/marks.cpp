// The shapes of markers, and boxes.

#include "render/layout/plan.h"

namespace plantloop {

Fill box_fill(const Box& box, Color color) {
  const Rect r = to_rect(box);
  return {{{{r.left, r.top}, {r.right, r.top}, {r.right, r.bottom}, {r.left, r.bottom}}}, color};
}

void add_marker(Fill& filled, Stroke& drawn, Marker marker, Spot at, double r) {
  const auto polygon = [&](std::initializer_list<Spot> corners) {
    Polyline ring;
    for (const Spot c : corners) ring.push_back(to_point({at.x + c.x * r, at.y + c.y * r}));
    return ring;
  };
  const auto circle = [&](double radius) {
    // Points of the unit circle by turning (1, 0) through 15 degrees; the constants are cos and sin.
    constexpr double c = 0.96592582628906829, s = 0.25881904510252076;
    Polyline ring;
    double x = radius, y = 0;
    for (int i = 0; i < 24; ++i) {
      ring.push_back(to_point({at.x + x, at.y + y}));
      const double turned = c * x - s * y;
      y = s * x + c * y;
      x = turned;
    }
    return ring;
  };
  switch (marker) {
    case Marker::none:
      break;
    case Marker::dot:
      filled.rings.push_back(circle(r));
      break;
    case Marker::square:
      filled.rings.push_back(polygon({{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}}));
      break;
    case Marker::diamond:
      filled.rings.push_back(polygon({{0, -1.25}, {1.25, 0}, {0, 1.25}, {-1.25, 0}}));
      break;
    case Marker::triangle:
      filled.rings.push_back(polygon({{0, -1.2}, {1.1, 0.8}, {-1.1, 0.8}}));
      break;
    case Marker::ring: {
      Polyline ring = circle(r);
      ring.push_back(ring.front());
      drawn.lines.push_back(std::move(ring));
      break;
    }
    case Marker::cross:
      drawn.lines.push_back(polygon({{-0.9, -0.9}, {0.9, 0.9}}));
      drawn.lines.push_back(polygon({{-0.9, 0.9}, {0.9, -0.9}}));
      break;
    case Marker::dash:
      drawn.lines.push_back(polygon({{-1.3, 0}, {1.3, 0}}));
      break;
    case Marker::tick:
      drawn.lines.push_back(polygon({{0, -1.3}, {0, 1.3}}));
      break;
    case Marker::plus:
      drawn.lines.push_back(polygon({{-1.1, 0}, {1.1, 0}}));
      drawn.lines.push_back(polygon({{0, -1.1}, {0, 1.1}}));
      break;
  }
}

}  // namespace plantloop
