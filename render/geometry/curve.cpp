// Decimation and clipping of curves.

#include "render/geometry/curve.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace plantloop {

Fixed to_fixed(double pixels) { return static_cast<Fixed>(std::lround(pixels * 256)); }
Point to_point(Spot spot) { return {to_fixed(spot.x), to_fixed(spot.y)}; }
Rect to_rect(const Box& box) {
  return {to_fixed(box.left), to_fixed(box.top), to_fixed(box.right), to_fixed(box.bottom)};
}

Curve decimate_columns(const Curve& curve, double width) {
  Curve result;
  const auto column_of = [width](Spot s) { return std::floor(s.x / width); };
  double left = -std::numeric_limits<double>::infinity();  // the column before
  for (std::size_t begin = 0; begin < curve.size();) {
    const double column = column_of(curve[begin]);
    std::size_t end = begin, low = begin, high = begin;
    while (end < curve.size() && column_of(curve[end]) == column) {
      if (curve[end].y < curve[low].y) low = end;
      if (curve[end].y > curve[high].y) high = end;
      ++end;
    }
    const bool far_before = column > left + 1, far_behind = end == curve.size() || column_of(curve[end]) > column + 1;
    const auto [one, other] = std::minmax(low, high);
    if (far_before && begin != one) result.push_back(curve[begin]);
    result.push_back(curve[one]);
    if (other != one) result.push_back(curve[other]);
    if (far_behind && end - 1 != other) result.push_back(curve[end - 1]);
    left = column;
    begin = end;
  }
  return result;
}

Curve decimate_distance(const Curve& curve, double reach) {
  Curve result;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const bool end = i == 0 || i + 1 == curve.size();
    if (end || std::abs(curve[i].x - result.back().x) + std::abs(curve[i].y - result.back().y) >= reach)
      result.push_back(curve[i]);
  }
  return result;
}

std::vector<Curve> without_repeats(const Curve& curve, const Box& box) {
  const auto columns = static_cast<std::size_t>(box.width()) + 2, rows = static_cast<std::size_t>(box.height()) + 2;
  std::vector<bool> inked(columns * rows);
  // Inks the pixel and tells whether it was blank.
  const auto ink = [&](double x, double y) {
    if (!box.contains({x, y})) return false;
    auto pixel = inked[static_cast<std::size_t>(y - box.top) * columns + static_cast<std::size_t>(x - box.left)];
    const bool blank = !pixel;
    pixel = true;
    return blank;
  };
  std::vector<Curve> result;
  bool open = false;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const Spot a = curve[i], b = curve[i + 1];
    const int steps = 1 + static_cast<int>(std::min(std::max(std::abs(b.x - a.x), std::abs(b.y - a.y)), 1e5));
    bool fresh = false;
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      if (ink(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y))) fresh = true;
    }
    if (fresh && !open) result.push_back({a});
    if (fresh) result.back().push_back(b);
    open = fresh;
  }
  return result;
}

std::vector<Curve> clip_line(const Curve& curve, const Box& box) {
  std::vector<Curve> result;
  bool open = false;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const Spot a = curve[i], b = curve[i + 1];
    double enter = 0, leave = 1;
    const auto cut = [&](double speed, double room) {  // speed t <= room
      if (speed == 0) return room >= 0;
      const double t = room / speed;
      if (speed > 0)
        leave = std::min(leave, t);
      else
        enter = std::max(enter, t);
      return enter <= leave;
    };
    const double dx = b.x - a.x, dy = b.y - a.y;
    const bool seen =
        cut(dx, box.right - a.x) && cut(-dx, a.x - box.left) && cut(dy, box.bottom - a.y) && cut(-dy, a.y - box.top);
    if (!seen) {
      open = false;
      continue;
    }
    const auto along = [&](double t) {
      const Spot s = t <= 0 ? a : t >= 1 ? b : Spot{a.x + t * dx, a.y + t * dy};
      return Spot{std::clamp(s.x, box.left, box.right), std::clamp(s.y, box.top, box.bottom)};
    };
    if (!open || enter > 0) result.push_back({along(enter)});
    result.back().push_back(along(leave));
    open = leave >= 1;
  }
  if (curve.size() == 1 && box.contains(curve[0])) result.push_back(curve);
  return result;
}

Curve clip_area(Curve ring, const Box& box) {
  const auto against = [&](auto inside, auto crossing) {
    Curve kept;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Spot a = ring[i], b = ring[(i + 1) % ring.size()];
      if (inside(a)) kept.push_back(a);
      if (inside(a) != inside(b)) kept.push_back(crossing(a, b));
    }
    ring = std::move(kept);
  };
  const auto at_x = [](double x) {
    return [x](Spot a, Spot b) { return Spot{x, a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x))}; };
  };
  const auto at_y = [](double y) {
    return [y](Spot a, Spot b) { return Spot{a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)), y}; };
  };
  against([&](Spot s) { return s.x >= box.left; }, at_x(box.left));
  against([&](Spot s) { return s.x <= box.right; }, at_x(box.right));
  against([&](Spot s) { return s.y >= box.top; }, at_y(box.top));
  against([&](Spot s) { return s.y <= box.bottom; }, at_y(box.bottom));
  return ring;
}

Polyline to_polyline(const Curve& curve) {
  Polyline result;
  for (const Spot spot : curve) {
    const Point p = to_point(spot);
    if (!result.empty() && result.back() == p) continue;
    if (result.size() >= 2) {
      const Point a = result[result.size() - 2], b = result.back();
      const std::int64_t ux = b.x - a.x, uy = b.y - a.y, vx = p.x - b.x, vy = p.y - b.y;
      if (ux * vy == uy * vx && ux * vx + uy * vy > 0) result.pop_back();
    }
    result.push_back(p);
  }
  return result;
}

}  // namespace plantloop
