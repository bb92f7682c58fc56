// Strokes, fills and glyphs to triangles.

#include "render/geometry/triangles.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "render/text/font.h"

namespace plantloop {
namespace {

struct Vec {
  double x = 0, y = 0;  // in 1/256 pixel
  friend Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y}; }
  friend Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y}; }
  friend Vec operator*(double s, Vec a) { return {s * a.x, s * a.y}; }
};
double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y; }
double cross(Vec a, Vec b) { return a.x * b.y - a.y * b.x; }
Vec unit(Vec a) { return (1 / std::sqrt(dot(a, a))) * a; }
Point rounded(Vec a) { return {static_cast<Fixed>(std::lround(a.x)), static_cast<Fixed>(std::lround(a.y))}; }

// Winding numbers are kept in 8 bits: no more rings than this in one pass.
constexpr std::size_t rings_in_a_pass = 120;
constexpr std::int32_t corners_in_a_part = 192;

class Maker {
 public:
  Triangles made;

  void group(const Group& g, std::optional<Rect> clip) {
    if (g.clip)
      clip = clip ? Rect{std::max(clip->left, g.clip->left), std::max(clip->top, g.clip->top),
                         std::min(clip->right, g.clip->right), std::min(clip->bottom, g.clip->bottom)}
                  : *g.clip;
    clip_ = clip;
    for (const SceneNode& node : g.children) {
      if (const auto* inner = std::get_if<Group>(&node.item)) {
        group(*inner, clip);
        clip_ = clip;
      } else if (const auto* f = std::get_if<Fill>(&node.item)) {
        fill(*f);
      } else if (const auto* s = std::get_if<Stroke>(&node.item)) {
        stroke(*s);
      } else {
        text(std::get<TextRun>(node.item));
      }
    }
  }

 private:
  std::optional<Rect> clip_;
  std::size_t rings_ = 0;
  bool new_cover_ = false;

  // Continues the last batch when nothing differs.
  void begin(Batch::Kind kind, Color color, bool may_join) {
    if (may_join && !made.batches.empty()) {
      const Batch& last = made.batches.back();
      const bool full = kind == Batch::Kind::winding && rings_ >= rings_in_a_pass;
      if (last.kind == kind && last.color == color && last.clip == clip_ && !full) return;
    }
    made.batches.push_back({kind, color, clip_});
    rings_ = 0;
  }

  void triangle(Point a, Point b, Point c) {
    Batch& batch = made.batches.back();
    const Fixed top = std::min({a.y, b.y, c.y}), bottom = std::max({a.y, b.y, c.y});
    if (batch.covers.empty() || new_cover_) batch.covers.push_back({a.x, top, a.x, bottom});
    new_cover_ = false;
    Rect& cover = batch.covers.back();
    cover.left = std::min({cover.left, a.x, b.x, c.x});
    cover.right = std::max({cover.right, a.x, b.x, c.x});
    cover.top = std::min(cover.top, top);
    cover.bottom = std::max(cover.bottom, bottom);
    if (batch.parts.empty() || batch.parts.back().count >= corners_in_a_part)
      batch.parts.push_back({static_cast<std::int32_t>(made.corners.size()), 0, top, bottom});
    Batch::Part& part = batch.parts.back();
    part.count += 3;
    part.top = std::min(part.top, top);
    part.bottom = std::max(part.bottom, bottom);
    made.corners.insert(made.corners.end(), {a, b, c});
  }

  void ring(const Polyline& points) {
    ++rings_;
    if (points.size() >= 3) halve(points, 0, points.size() - 1);
  }

  // Any triangles whose edges cancel but for the ring's give its winding numbers. Halving keeps nearly all of them
  // small, where a fan about one point would be made of slivers across the whole picture.
  void halve(const Polyline& points, std::size_t first, std::size_t last) {
    if (last - first < 2) return;
    const std::size_t middle = (first + last) / 2;
    triangle(points[first], points[middle], points[last]);
    halve(points, first, middle);
    halve(points, middle, last);
  }

  // Every corner turns the same way, once around: true of triangles and of the facets of most surfaces.
  static bool is_convex_quad(const Polyline& points) {
    if (points.size() < 3 || points.size() > 4) return false;
    int turns = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto at = [&](std::size_t k) {
        const Point p = points[(i + k) % points.size()];
        return Vec{static_cast<double>(p.x), static_cast<double>(p.y)};
      };
      const double turn = cross(at(1) - at(0), at(2) - at(1));
      turns += turn > 0 ? 1 : turn < 0 ? -1 : 0;
    }
    return std::abs(turns) == static_cast<int>(points.size());
  }

  void fill(const Fill& f) {
    // Opaque facets need no counting of windings.
    if (f.color.a == 255 && f.rings.size() == 1 && is_convex_quad(f.rings[0])) {
      const Polyline& p = f.rings[0];
      begin(Batch::Kind::direct, f.color, true);
      triangle(p[0], p[1], p[2]);
      if (p.size() == 4) triangle(p[0], p[2], p[3]);
      return;
    }
    begin(Batch::Kind::winding, f.color, false);
    for (const Polyline& points : f.rings) {
      // Opaque markers may lie on top of each other in any number.
      if (f.color.a == 255) begin(Batch::Kind::winding, f.color, true);
      new_cover_ = true;
      ring(points);
    }
  }

  void text(const TextRun& t) {
    begin(Batch::Kind::winding, t.color, true);
    new_cover_ = true;
    for (const GlyphRun& run : t.runs) {
      const double scale = static_cast<double>(run.size) / units_per_em(run.font);
      for (const GlyphRun::Glyph& glyph : run.glyphs) {
        begin(Batch::Kind::winding, t.color, true);
        outline_rings(
            outline(run.font, glyph.id),
            [&](double x, double y) {
              const Vec local{run.at.x + scale * (glyph.x + x), run.at.y - scale * (glyph.y + y)};
              const Vec turned = t.turns == 0   ? local
                                 : t.turns == 1 ? Vec{local.y, -local.x}
                                 : t.turns == 2 ? Vec{-local.x, -local.y}
                                                : Vec{-local.y, local.x};
              return rounded(Vec{static_cast<double>(t.origin.x), static_cast<double>(t.origin.y)} + turned);
            },
            run.size);
      }
    }
  }

  // Curves become a fixed number of chords, more for large letters.
  template <typename Place>
  void outline_rings(const Outline& shape, Place place, Fixed size) {
    const int chords = size > 40 * 256 ? 10 : 5;
    Polyline points;
    double x = 0, y = 0;
    const auto close = [&] {
      if (points.size() >= 3) ring(points);
      points.clear();
    };
    for (const OutlineStep& s : shape.steps) {
      if (s.kind == OutlineStep::move) close();
      if (s.kind == OutlineStep::quadratic || s.kind == OutlineStep::cubic) {
        for (int i = 1; i < chords; ++i) {
          const double t = static_cast<double>(i) / chords, r = 1 - t;
          if (s.kind == OutlineStep::quadratic)
            points.push_back(
                place(r * r * x + 2 * r * t * s.x1 + t * t * s.x, r * r * y + 2 * r * t * s.y1 + t * t * s.y));
          else
            points.push_back(place(r * r * r * x + 3 * r * r * t * s.x1 + 3 * r * t * t * s.x2 + t * t * t * s.x,
                                   r * r * r * y + 3 * r * r * t * s.y1 + 3 * r * t * t * s.y2 + t * t * t * s.y));
        }
      }
      points.push_back(place(s.x, s.y));
      x = s.x;
      y = s.y;
    }
    close();
  }

  void stroke(const Stroke& s) {
    begin(s.color.a == 255 ? Batch::Kind::direct : Batch::Kind::mask, s.color, s.color.a == 255);
    for (const Polyline& line : s.lines) {
      if (s.dashes.empty())
        solid(line, s);
      else
        dashed(line, s);
    }
  }

  void dashed(const Polyline& line, const Stroke& s) {
    double period = 0;
    for (const Fixed d : s.dashes) period += d;
    if (!(period > 0) || s.dashes.size() % 2 != 0) return solid(line, s);
    std::size_t dash = 0;
    double left = s.dashes[0];
    std::vector<Vec> piece;
    const auto flush = [&] {
      if (piece.size() >= 2) thick(piece, s.width / 2.0, s.cap);
      piece.clear();
    };
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Vec a{static_cast<double>(line[i].x), static_cast<double>(line[i].y)};
      const Vec b{static_cast<double>(line[i + 1].x), static_cast<double>(line[i + 1].y)};
      const double length = std::sqrt(dot(b - a, b - a));
      if (dash % 2 == 0 && piece.empty()) piece.push_back(a);
      double at = 0;
      while (length - at > left) {
        at += left;
        const Vec p = a + (at / length) * (b - a);
        if (dash % 2 == 0) {
          piece.push_back(p);
          flush();
        } else {
          piece.assign(1, p);
        }
        dash = (dash + 1) % s.dashes.size();
        left = s.dashes[dash];
      }
      left -= length - at;
      if (dash % 2 == 0) piece.push_back(b);
    }
    flush();
  }

  void solid(const Polyline& line, const Stroke& s) {
    std::vector<Vec> points;
    for (const Point p : line) points.push_back({static_cast<double>(p.x), static_cast<double>(p.y)});
    thick(points, s.width / 2.0, s.cap);
  }

  // A fan about p from p + from to p + to, turning the short way; halved until the error is below 1/12 pixel.
  void wedge(Vec p, Vec from, Vec to, Vec ahead, int depth) {
    const double radius2 = dot(from, from);
    const Vec sum = from + to;
    const double length2 = dot(sum, sum);
    // The chord's distance from the arc is r - |sum| / 2.
    const double error = std::sqrt(radius2) - std::sqrt(length2) / 2;
    if (error < 21 || depth == 0) {
      triangle(rounded(p), rounded(p + from), rounded(p + to));
      return;
    }
    const Vec middle = length2 > 1e-6 * radius2 ? std::sqrt(radius2) * unit(sum) : std::sqrt(radius2) * ahead;
    wedge(p, from, middle, ahead, depth - 1);
    wedge(p, middle, to, ahead, depth - 1);
  }

  void thick(const std::vector<Vec>& given, double radius, Stroke::Cap cap) {
    std::vector<Vec> points;
    for (const Vec p : given)
      if (points.empty() || dot(p - points.back(), p - points.back()) > 0) points.push_back(p);
    if (points.size() < 2) return;
    const bool closed = points.size() > 3 && points.front().x == points.back().x && points.front().y == points.back().y;
    Vec before{};
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const Vec a = points[i], b = points[i + 1], along = unit(b - a);
      const Vec side = radius * Vec{-along.y, along.x};
      const Point a0 = rounded(a + side), a1 = rounded(a - side), b0 = rounded(b + side), b1 = rounded(b - side);
      triangle(a0, a1, b1);
      triangle(a0, b1, b0);
      if (i > 0)
        join(a, before, along, radius);
      else if (closed)
        join(a, unit(points.back() - points[points.size() - 2]), along, radius);
      else if (cap == Stroke::Cap::round)
        wedge(a, side, -1.0 * side, -1.0 * along, 6);
      if (i + 2 == points.size() && !closed && cap == Stroke::Cap::round) wedge(b, side, -1.0 * side, along, 6);
      before = along;
    }
  }

  // Fills the gap on the outer side of a corner.
  void join(Vec p, Vec in, Vec out, double radius) {
    const double turn = cross(in, out);
    if (turn == 0 && dot(in, out) > 0) return;
    const double outer = turn > 0 ? -radius : radius;
    wedge(p, outer * Vec{-in.y, in.x}, outer * Vec{-out.y, out.x}, in, 6);
  }
};

}  // namespace

Triangles triangulate(const Scene& scene) {
  Maker maker;
  maker.group(scene.root, std::nullopt);
  return std::move(maker.made);
}

}  // namespace plantloop
