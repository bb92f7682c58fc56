// A panel in three dimensions: parallel projection of surfaces, curves and points.
//
// A surface is z over a grid, so its facets have an exact order from back to front: row by row of cells, the far ones
// first, whatever the heights are. Curves are cut into pieces; a piece is hidden when it lies below its own cell's
// facet, or when a facet that is drawn after it covers its middle; all others are drawn on top. So no depth buffer is
// needed and all stays a drawing of lines and areas. The eye is never below the floor.

#include "render/space.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/layout/plan.h"

namespace plantloop {
namespace {

struct Vec3 {
  double x = 0, y = 0, z = 0;
};

struct Range {
  double lower = std::numeric_limits<double>::infinity(), upper = -lower;
  void add(double v) {
    if (!std::isfinite(v)) return;
    lower = std::min(lower, v);
    upper = std::max(upper, v);
  }
};

// The ends of an axis: given, or rounded outwards where `loose`; else only to a tick that is near.
Ruler ruler_of(const SpaceAxis& axis, const Range& range, double length, double unit, bool loose) {
  RulerWish wish{.limits = {axis.lower, axis.upper},
                 .data_lower = range.lower,
                 .data_upper = range.upper,
                 .length = length,
                 .spacing = 85 * unit,
                 .gap = 30 * unit,
                 .tight = !loose};
  const Ruler ruler = make_ruler(wish);
  if (loose || ruler.ticks.size() < 2) return ruler;
  const double step = ruler.ticks[1].value - ruler.ticks[0].value, near = 0.05 * (ruler.upper - ruler.lower);
  const double below = ruler.ticks.front().value - step, above = ruler.ticks.back().value + step;
  if (!axis.lower && ruler.lower - below <= near) wish.data_lower = below;
  if (!axis.upper && above - ruler.upper <= near) wish.data_upper = above;
  return make_ruler(wish);
}

class View {
 public:
  View(Group& group, const Plan& plan, const PanelPlan& panel, std::string role)
      : group_(group),
        plan_(plan),
        theme_(*plan.theme),
        panel_(panel),
        space_(*panel.panel->space),
        role_(std::move(role)) {}

  void draw() {
    set_axes();
    set_eye();
    walls();
    contents();
    numbers();
    names();
    if (panel_.bar) draw_bar(group_, plan_, panel_, panel_.box.right, role_);
  }

 private:
  Group& group_;
  const Plan& plan_;
  const Theme& theme_;
  const PanelPlan& panel_;
  const Space& space_;
  const std::string role_;
  const double u_ = plan_.unit;
  Ruler x_, y_, z_;
  double cos_a_ = 1, sin_a_ = 0, cos_e_ = 1, sin_e_ = 0, high_ = 0.7, scale_ = 1;
  Spot middle_;
  std::vector<Box> taken_;  // by numbers and labels
  std::vector<std::pair<std::size_t, Spot>> ends_;
  // Of each axis the end that is far from the eye, -1 or 1.
  double far_x_ = 1, far_y_ = 1;

  void set_axes() {
    Range x, y, z;
    for (const Surface& s : space_.surfaces) {
      for (const double v : s.x) x.add(v);
      for (const double v : s.y) y.add(v);
      for (const double v : s.z) z.add(v);
    }
    for (const SpaceCurve& c : space_.curves) {
      for (const double v : c.x) x.add(v);
      for (const double v : c.y) y.add(v);
      for (const double v : c.z) z.add(v);
    }
    const double side = 0.6 * std::min(panel_.box.width(), panel_.box.height());
    // Heights of a surface end at round numbers; all else fills its room.
    x_ = ruler_of(space_.x, x, side, u_, false);
    y_ = ruler_of(space_.y, y, side, u_, false);
    z_ = ruler_of(space_.z, z, side, u_, !space_.surfaces.empty());
  }

  void set_eye() {
    const double degree = 3.14159265358979323846 / 180;
    const double azimuth = std::isfinite(space_.azimuth) ? space_.azimuth : -50;
    const double elevation = std::isfinite(space_.elevation) ? std::clamp(space_.elevation, 5.0, 85.0) : 28;
    cos_a_ = std::cos(azimuth * degree);
    sin_a_ = std::sin(azimuth * degree);
    cos_e_ = std::cos(elevation * degree);
    sin_e_ = std::sin(elevation * degree);
    far_x_ = sin_a_ > 0 ? -1 : 1;
    far_y_ = -cos_a_ > 0 ? -1 : 1;
    const Box& b = panel_.box;
    const Box room{b.left + 58 * u_, b.top + 8 * u_, b.right - 30 * u_, b.bottom - 52 * u_};
    const double across = 2 * (std::abs(cos_a_) + std::abs(sin_a_));
    const double floor = sin_e_ * across;
    // As high as the room allows, but neither a plate nor a tower.
    const double wanted = across * std::max(room.height(), 10.0) / std::max(room.width(), 10.0);
    high_ = std::clamp((wanted - floor) / (2 * cos_e_), 0.45, 1.1);
    scale_ =
        std::min(std::max(room.width(), 10.0) / across, std::max(room.height(), 10.0) / (floor + 2 * high_ * cos_e_));
    middle_ = {(room.left + room.right) / 2, (room.top + room.bottom) / 2};
  }

  // From the cube between -1 and 1 to the picture.
  Spot project(Vec3 p) const {
    const double toward = p.x * sin_a_ - p.y * cos_a_;
    return {middle_.x + scale_ * (p.x * cos_a_ + p.y * sin_a_),
            middle_.y - scale_ * (high_ * p.z * cos_e_ - toward * sin_e_)};
  }

  static double part(const Ruler& r, double v) { return 2 * position(r, v) - 1; }
  Vec3 cube(double x, double y, double z) const { return {part(x_, x), part(y_, y), part(z_, z)}; }

  void line(Stroke& stroke, Vec3 a, Vec3 b) const {
    stroke.lines.push_back({to_point(project(a)), to_point(project(b))});
  }

  void walls() {
    Stroke grid{{}, to_fixed(theme_.grid_width * u_), {}, Stroke::Cap::butt, theme_.grid};
    for (const Tick& t : x_.ticks) {
      const double v = part(x_, t.value);
      line(grid, {v, -1, -1}, {v, 1, -1});
      line(grid, {v, far_y_, -1}, {v, far_y_, 1});
    }
    for (const Tick& t : y_.ticks) {
      const double v = part(y_, t.value);
      line(grid, {-1, v, -1}, {1, v, -1});
      line(grid, {far_x_, v, -1}, {far_x_, v, 1});
    }
    for (const Tick& t : z_.ticks) {
      const double v = part(z_, t.value);
      line(grid, {far_x_, -1, v}, {far_x_, 1, v});
      line(grid, {-1, far_y_, v}, {1, far_y_, v});
    }
    if (!grid.lines.empty()) group_.group(role_ + "/grid").add({std::move(grid)});
    Stroke axes{{}, to_fixed(1.1 * u_), {}, Stroke::Cap::butt, theme_.axis};
    line(axes, {-1, -far_y_, -1}, {1, -far_y_, -1});
    line(axes, {-far_x_, -1, -1}, {-far_x_, 1, -1});
    const auto [x, y] = upright();
    line(axes, {x, y, -1}, {x, y, 1});
    group_.group(role_ + "/axes").add({std::move(axes)});
  }

  // The vertical edge at the left of the picture.
  std::pair<double, double> upright() const {
    const Spot one = project({far_x_, -far_y_, 0}), other = project({-far_x_, far_y_, 0});
    return one.x < other.x ? std::pair{far_x_, -far_y_} : std::pair{-far_x_, far_y_};
  }

  void numbers() {
    const double size = theme_.text_size * u_, half = 0.5 * cap_height * size;
    const auto along = [&](const Ruler& ruler, const SpaceAxis& axis, const char* name, auto&& place_of) {
      Group& ticks = group_.group(fmt::format("{}/{}/numbers", role_, name));
      const Spot begin = project(place_of(-1)), end = project(place_of(1)), center = project({0, 0, -1});
      // Outwards, at right angles to the edge.
      Spot out{end.y - begin.y, begin.x - end.x};
      const double length = std::max(std::hypot(out.x, out.y), 1e-9);
      const double sign =
          out.x * ((begin.x + end.x) / 2 - center.x) + out.y * ((begin.y + end.y) / 2 - center.y) < 0 ? -1 : 1;
      out = {sign * out.x / length, sign * out.y / length};
      double widest = 0;
      for (const Tick& tick : ruler.ticks) {
        const Spot at = project(place_of(part(ruler, tick.value)));
        const Label label = set_label(tick.label, plan_.tick_style());
        widest = std::max(widest, label.width);
        // Left axes have their numbers end, right ones begin at the tick, so that at the corner both find room.
        const double x = at.x + (out.x > 0 ? 4 * u_ : -4 * u_ - label.width);
        const double y = at.y + (8 * u_ + half) * std::max(out.y, 0.3) + half;
        const Box box{x, y - size, x + label.width, y + 0.2 * size};
        // Numbers of two axes side by side would read as one.
        const Box apart{box.left - 0.8 * size, box.top - 3 * u_, box.right + 0.8 * size, box.bottom + 3 * u_};
        if (std::any_of(taken_.begin(), taken_.end(), [&](const Box& o) { return o.meets(apart); })) continue;
        taken_.push_back(box);
        ticks.add({place(label, x, y, 0, theme_.muted, theme_.background)});
      }
      std::string words = axis.label;
      if (!ruler.note.empty()) words += (words.empty() ? "" : "  ") + ruler.note;
      if (words.empty()) return;
      const Spot at{(begin.x + end.x) / 2, (begin.y + end.y) / 2};
      const Label label = set_label_within(words, plan_.label_style(), 0.45 * panel_.box.width());
      const double reach =
          16 * u_ + std::abs(out.x) * (widest + 0.5 * label.width) + std::abs(out.y) * (1.1 * size + half);
      const double x = std::clamp(at.x + reach * out.x - label.width / 2, 6 * u_,
                                  std::max(plan_.width - 6 * u_ - label.width, 6 * u_));
      const double y = std::min(at.y + reach * out.y + half, plan_.height - 8 * u_);
      const Box box{x, y - size, x + label.width, y + 0.25 * size};
      const bool hit = std::any_of(taken_.begin(), taken_.end(), [&](const Box& o) { return o.meets(box); });
      if (hit) return;
      taken_.push_back(box);
      group_.group(fmt::format("{}/{}/label", role_, name))
          .add({place(label, x, y, 0, theme_.text, theme_.background)});
    };
    along(x_, space_.x, "x", [&](double v) { return Vec3{v, -far_y_, -1}; });
    along(y_, space_.y, "y", [&](double v) { return Vec3{-far_x_, v, -1}; });
    upright_numbers(half);
  }

  void upright_numbers(double half) {
    const auto [ex, ey] = upright();
    Group& ticks = group_.group(role_ + "/z/numbers");
    double top = 1e9, left = 1e9;
    const double lowest = project({ex, ey, -1}).y;
    for (const Tick& tick : z_.ticks) {
      const Spot at = project({ex, ey, part(z_, tick.value)});
      const Label label = set_label(tick.label, plan_.tick_style());
      // The foot of the edge belongs to the numbers of the floor.
      if (at.y > lowest - 1.2 * theme_.text_size * u_) continue;
      const double x = at.x - 9 * u_ - label.width, y = at.y + half;
      taken_.push_back({x, y + label.top, x + label.width, y + label.bottom});
      ticks.add({place(label, x, y, 0, theme_.muted, theme_.background)});
      top = std::min(top, at.y);
      left = std::min(left, at.x - 9 * u_ - label.width);
    }
    std::string words = space_.z.label;
    if (!z_.note.empty()) words += (words.empty() ? "" : "  ") + z_.note;
    if (words.empty()) return;
    const Label label = set_label_within(words, plan_.label_style(), 0.9 * panel_.box.height());
    const Spot from = project({ex, ey, -1}), to = project({ex, ey, 1});
    const double y = std::clamp((from.y + to.y + label.width) / 2, label.width + 4 * u_,
                                std::max(plan_.height - 4 * u_, label.width + 4 * u_));
    const double x = std::max((left < 1e8 ? left : from.x) - 10 * u_, 4 * u_ + cap_height * label.size);
    group_.group(role_ + "/z/label").add({place(label, x, y, 1, theme_.text, theme_.background)});
  }

  // A point, or a piece of a curve.
  struct Piece {
    std::size_t curve = 0;
    Spot from, to;  // equal for a point
    Vec3 at;        // its middle
    double depth = 0;
    bool hidden = false;
    Spot middle() const { return {(from.x + to.x) / 2, (from.y + to.y) / 2}; }
  };

  Color curve_color(std::size_t i) const {
    const std::size_t taken = space_.surfaces.empty() ? 0 : 1;
    return series_style(theme_, i + taken).color;
  }

  void add(Group& group, const Piece& piece) const {
    // Of a line what is far away is paler.
    const Color full = curve_color(piece.curve);
    const double far = space_.curves[piece.curve].line ? std::clamp(0.5 - 0.4 * piece.depth, 0.0, 1.0) * 0.5 : 0;
    const Color color = over(with_alpha(theme_.background, static_cast<std::uint8_t>(std::lround(255 * far))), full);
    if (space_.curves[piece.curve].line) {
      group.add({Stroke{{{to_point(piece.from), to_point(piece.to)}},
                        to_fixed(curve_width(piece.curve)),
                        {},
                        Stroke::Cap::round,
                        color}});
      return;
    }
    Fill halo{{}, theme_.background}, dot{{}, color};
    Stroke none;
    add_marker(halo, none, Marker::dot, piece.from, 4.6 * u_);
    add_marker(dot, none, Marker::dot, piece.from, 3.4 * u_);
    group.add({std::move(halo)});
    group.add({std::move(dot)});
  }

  // Long curves run close to themselves.
  double curve_width(std::size_t i) const {
    return (space_.curves[i].x.size() > 2000 ? 0.6 : 1.0) * theme_.line_width * u_;
  }

  // As fine as the eye sees; coarser, and at last only some of the samples, where they are more than the picture holds.
  std::vector<Piece> pieces() const {
    constexpr std::size_t most = 30000;
    std::vector<Piece> all = pieces(1.5, 1);
    for (double step = 3; all.size() > most && step < 10; step *= 1.5) all = pieces(step, 1);
    for (std::size_t every = 2; all.size() > most; every *= 2) all = pieces(10, every);
    return all;
  }

  std::vector<Piece> pieces(double step, std::size_t every) const {
    std::vector<Piece> result;
    for (std::size_t c = 0; c < space_.curves.size(); ++c) {
      const SpaceCurve& curve = space_.curves[c];
      const std::size_t n = std::min({curve.x.size(), curve.y.size(), curve.z.size()});
      std::optional<Vec3> before;
      // Long curves are thinned to what the eye can tell apart.
      for (std::size_t i = 0; i < n; i += every) {
        if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i]) || !std::isfinite(curve.z[i])) {
          before.reset();
          continue;
        }
        const Vec3 at = cube(curve.x[i], curve.y[i], curve.z[i]);
        const auto outside = [](double v) { return !(std::abs(v) <= 1 + 1e-9); };
        if (outside(at.x) || outside(at.y) || outside(at.z)) {
          before.reset();
          continue;
        }
        const Spot here = project(at);
        if (!curve.line) {
          result.push_back({c, here, here, at, depth(at)});
          continue;
        }
        if (before) {
          const Spot there = project(*before);
          if (std::abs(here.x - there.x) + std::abs(here.y - there.y) < step && i + every < n) continue;
          const Vec3 middle{(at.x + before->x) / 2, (at.y + before->y) / 2, (at.z + before->z) / 2};
          result.push_back({c, there, here, middle, depth(middle)});
        }
        before = at;
      }
    }
    return result;
  }

  double depth(Vec3 p) const { return cos_e_ * (p.x * sin_a_ - p.y * cos_a_) + sin_e_ * high_ * p.z; }

  void contents() {
    Group& own = group_.group(role_ + "/space");
    std::vector<Piece> all = pieces();
    std::stable_sort(all.begin(), all.end(), [](const Piece& a, const Piece& b) { return a.depth < b.depth; });
    for (const Surface& s : space_.surfaces) draw_surface(own, s, all);
    for (const Piece& p : all)
      if (!p.hidden) add(own, p);
    find_ends(all);
  }

  // Where the last piece of each curve ends.
  void find_ends(const std::vector<Piece>& all) {
    for (std::size_t c = 0; c < space_.curves.size(); ++c) {
      if (space_.curves[c].label.empty()) continue;
      const auto last =
          std::find_if(all.rbegin(), all.rend(), [&](const Piece& p) { return p.curve == c && !p.hidden; });
      if (last != all.rend()) ends_.emplace_back(c, last->to);
    }
  }

  // Above the curve's end, else some rows further up or down; without a name where others stand all around.
  void names() {
    for (const auto& [curve, end] : ends_) {
      const Label label = set_label_within(space_.curves[curve].label, plan_.remark_style(), 0.3 * panel_.box.width());
      const double x = std::min(end.x + 8 * u_, plan_.width - 4 * u_ - label.width);
      for (const int rows : {0, -1, 1, -2, 2, -3, 3}) {
        const double y = end.y - 6 * u_ + 1.3 * rows * label.size;
        const Box box{x + label.left, y + label.top, x + label.right, y + label.bottom};
        if (box.top < 0 || box.bottom > plan_.height) continue;
        if (std::any_of(taken_.begin(), taken_.end(), [&](const Box& other) { return box.meets(other); })) continue;
        taken_.push_back(box);
        group_.group(role_ + "/labels")
            .add({place(label, x, y, 0, readable_on(theme_.background, curve_color(curve), 4.5), theme_.background)});
        break;
      }
    }
  }

  void draw_surface(Group& own, const Surface& s, std::vector<Piece>& loose) const {
    const std::size_t nx = s.x.size(), ny = s.y.size();
    if (nx < 2 || ny < 2 || s.z.size() < nx * ny) return;
    // Cell coordinates of the grid, thinned to at most 120 by 120 facets.
    const std::size_t step_x = (nx + 119) / 120, step_y = (ny + 119) / 120;
    const auto thinned = [](std::size_t n, std::size_t step) {
      std::vector<std::size_t> list;
      for (std::size_t i = 0; i < n; i += step) list.push_back(i);
      if (list.back() != n - 1) list.push_back(n - 1);
      return list;
    };
    const std::vector<std::size_t> columns = thinned(nx, step_x), rows = thinned(ny, step_y);
    const std::size_t cx = columns.size() - 1, cy = rows.size() - 1;
    const auto point = [&](std::size_t row, std::size_t column) {
      return cube(s.x[columns[column]], s.y[rows[row]], s.z[rows[row] * nx + columns[column]]);
    };
    std::vector<std::vector<Piece*>> over(cx * cy);
    const auto cell_of = [](const std::vector<double>& grid, const std::vector<std::size_t>& kept, const Ruler& r,
                            double at) {
      std::size_t cell = 0;
      const bool rising = grid.back() >= grid.front();
      while (cell + 2 < kept.size() &&
             (rising ? part(r, grid[kept[cell + 1]]) < at : part(r, grid[kept[cell + 1]]) > at))
        ++cell;
      return cell;
    };
    for (Piece& p : loose) {
      const std::size_t column = cell_of(s.x, columns, x_, p.at.x), row = cell_of(s.y, rows, y_, p.at.y);
      const double z =
          (point(row, column).z + point(row, column + 1).z + point(row + 1, column).z + point(row + 1, column + 1).z) /
          4;
      // On the surface counts as above it.
      p.hidden = p.hidden || p.at.z < z - 0.03;
      over[row * cx + column].push_back(&p);
    }
    std::vector<Piece*> behind;
    const bool x_up = part(x_, s.x.back()) > part(x_, s.x.front()) ? far_x_ < 0 : far_x_ > 0;
    const bool y_up = part(y_, s.y.back()) > part(y_, s.y.front()) ? far_y_ < 0 : far_y_ > 0;
    for (std::size_t i = 0; i < cy; ++i)
      for (std::size_t k = 0; k < cx; ++k) {
        const std::size_t row = y_up ? i : cy - 1 - i, column = x_up ? k : cx - 1 - k;
        const std::array<Vec3, 4> corners{point(row, column), point(row, column + 1), point(row + 1, column + 1),
                                          point(row + 1, column)};
        facet(own, s, corners);
        for (Piece* p : behind) p->hidden = p->hidden || covers(corners, p->middle());
        for (Piece* p : over[row * cx + column]) behind.push_back(p);
        std::erase_if(behind, [](const Piece* p) { return p->hidden; });
      }
  }

  bool covers(const std::array<Vec3, 4>& corners, Spot at) const {
    bool inside = false;
    for (std::size_t i = 0; i < 4; ++i) {
      const Spot a = project(corners[i]), b = project(corners[(i + 1) % 4]);
      if ((a.y > at.y) != (b.y > at.y) && at.x < a.x + (b.x - a.x) * ((at.y - a.y) / (b.y - a.y))) inside = !inside;
    }
    return inside;
  }

  void facet(Group& own, const Surface& s, const std::array<Vec3, 4>& corners) const {
    for (const Vec3& c : corners)
      if (!(std::abs(c.x) <= 1.001 && std::abs(c.y) <= 1.001 && std::abs(c.z) <= 1.001)) return;
    Polyline ring;
    double z = 0;
    for (const Vec3& c : corners) {
      ring.push_back(to_point(project(c)));
      z += c.z / 4;
    }
    const double value = z_.lower + (z + 1) / 2 * (z_.upper - z_.lower);
    const std::optional<ColorScale>& colors = panel_.panel->colors;
    const double level = colors ? (value - colors->lower) / (colors->upper - colors->lower) : (z + 1) / 2;
    const Color base = map_color(theme_, colors ? colors->map : "viridis", level);
    Polyline around = ring;
    around.push_back(ring.front());
    if (!s.filled) {
      own.add({Fill{{std::move(ring)}, theme_.background}});
      own.add({Stroke{
          {std::move(around)}, to_fixed(1.3 * u_), {}, Stroke::Cap::round, readable_on(theme_.background, base, 3.0)}});
      return;
    }
    const Color lit = shade(base, corners);
    own.add({Fill{{std::move(ring)}, lit}});
    own.add({Stroke{{std::move(around)}, to_fixed(0.7 * u_), {}, Stroke::Cap::round, over(Color{0, 0, 0, 56}, lit)}});
  }

  // Light from above and a little from the left of the eye.
  Color shade(Color base, const std::array<Vec3, 4>& c) const {
    const Vec3 a{c[2].x - c[0].x, c[2].y - c[0].y, high_ * (c[2].z - c[0].z)};
    const Vec3 b{c[3].x - c[1].x, c[3].y - c[1].y, high_ * (c[3].z - c[1].z)};
    Vec3 n{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    if (n.z < 0) n = {-n.x, -n.y, -n.z};
    const double size = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    if (!(size > 0)) return base;
    const Vec3 light{0.35 * sin_a_ - 0.45 * cos_a_, -0.35 * cos_a_ - 0.45 * sin_a_, 0.82};
    const double bright = (n.x * light.x + n.y * light.y + n.z * light.z) / size;
    const double dark = std::clamp(0.75 - bright, 0.0, 0.9) * 0.45, glow = std::clamp(bright - 0.9, 0.0, 0.1) * 0.6;
    const Color darker = over({0, 0, 0, static_cast<std::uint8_t>(std::lround(255 * dark))}, base);
    return over({255, 255, 255, static_cast<std::uint8_t>(std::lround(255 * glow))}, darker);
  }
};

}  // namespace

void draw_space(Group& group, const Plan& plan, const PanelPlan& panel, const std::string& role) {
  View(group, plan, panel, role).draw();
}

}  // namespace plantloop
