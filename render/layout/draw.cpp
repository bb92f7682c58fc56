// Writes a finished plan down as a scene.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/layout/plan.h"
#include "render/text/font.h"

namespace plantloop {
namespace {

Polyline straight(double x0, double y0, double x1, double y1) { return {to_point({x0, y0}), to_point({x1, y1})}; }

std::vector<Fixed> dashes(LineStyle style, double width, double unit) {
  if (style == LineStyle::dashed) return {to_fixed(3.5 * width), to_fixed(2.5 * width)};
  if (style == LineStyle::dashdot)
    return {to_fixed(5 * width), to_fixed(2.2 * width), to_fixed(1.2 * width), to_fixed(2.2 * width)};
  if (style == LineStyle::dotted) return {to_fixed(std::max(width, unit)), to_fixed(1.8 * width)};
  return {};
}

const char* scale_name(const Ruler& ruler) {
  if (ruler.named) return "names";
  return ruler.scale == Scale::log && ruler.offset == 0 ? "log" : ruler.scale != Scale::linear ? "symlog" : "linear";
}

class Drawing {
 public:
  explicit Drawing(const Plan& plan) : plan_(plan), theme_(*plan.theme), u_(plan.unit) {}

  Scene scene() {
    Scene scene;
    scene.selectable_text = plan_.figure->selectable_text;
    scene.title = plan_.figure->title;
    scene.width = plan_.width;
    scene.height = plan_.height;
    scene.dpi = plan_.figure->dpi;
    scene.background = theme_.background;
    scene.fonts = scene_fonts();
    if (!plan_.title.empty()) {
      Group& group = scene.root.group("title");
      double y = plan_.title_y + cap_height * theme_.title_size * u_;
      for (const Label& line : plan_.title) {
        group.add({text(line, plan_.title_x, y, 0, theme_.text)});
        y += 1.25 * theme_.title_size * u_;
      }
    }
    for (std::size_t i = 0; i < plan_.panels.size(); ++i)
      panel(scene.root.group(fmt::format("panel/{}", i)), plan_.panels[i], fmt::format("panel/{}", i));
    return scene;
  }

 private:
  const Plan& plan_;
  const Theme& theme_;
  const double u_;

  TextRun text(const Label& label, double x, double y, int turns, Color color) {
    return place(label, x, y, turns, color, theme_.background);
  }

  double x_of(const PanelPlan& p, double v) { return p.box.left + position(p.x, v) * p.box.width(); }
  double y_of(const PanelPlan& p, const Ruler& r, double v) { return p.box.bottom - position(r, v) * p.box.height(); }

  void panel(Group& group, const PanelPlan& p, const std::string& role) {
    if (p.panel->space) {
      words(group, p, role);
      draw_space(group, plan_, p, role);
      return;
    }
    reference_bands(group, p, role);
    if (!p.panel->bare) grid(group, p, role);
    guides(group, p, role);
    areas(group, p, role);
    reference_lines(group, p, role);
    if (!p.panel->bare) axes(group, p, role);
    lines(group, p, role);
    if (!p.panel->bare) numbers(group, p, role);
    words(group, p, role);
    placed_labels(group, p, role);
    if (p.bar) draw_bar(group, plan_, p, p.box.right + right_of_box(p), role);
    key(group, p, role);
    for (std::size_t i = 0; i < p.insets.size(); ++i) inset(group, p.insets[i], fmt::format("{}/inset/{}", role, i));
  }

  // Where the colour bar's room begins.
  double right_of_box(const PanelPlan& p) const {
    if (p.key.kind == KeyKind::end_labels) return end_label_width(p) + 8 * u_ + 10 * u_;
    if (!p.twin) return 0;
    double widest = 0;
    for (const Label& l : p.right_ticks) widest = std::max(widest, l.width);
    return 18 * u_ + widest + static_cast<double>(p.right_label.size()) * 1.25 * theme_.label_size * u_;
  }

  void inset(Group& group, const PanelPlan& p, const std::string& role) {
    if (p.inset_frame) {
      const Box& f = *p.inset_frame;
      Stroke frame{{}, to_fixed(theme_.reference_width * u_), {}, Stroke::Cap::butt, theme_.reference};
      frame.lines.push_back({to_point({f.left, f.top}), to_point({f.right, f.top}), to_point({f.right, f.bottom}),
                             to_point({f.left, f.bottom}), to_point({f.left, f.top})});
      group.group(role + "/frame").add({std::move(frame)});
    }
    Group& own = group.group(role);
    own.add({box_fill(whole_inset(plan_, p), theme_.background)});
    panel(own, p, role);
  }

  // Grids and lines of reference that are curves.
  void guides(Group& group, const PanelPlan& p, const std::string& role) {
    for (std::size_t i = 0; i < p.series.size(); ++i) {
      const SeriesPlan& s = p.series[i];
      if (!s.is_guide()) continue;
      Group& own = group.group(fmt::format("{}/guides/{}", role, i));
      own.clip = to_rect(p.box);
      shapes(own, s);
      Stroke stroke{{}, to_fixed(s.width), dashes(s.style, 1.6 * s.width, u_), Stroke::Cap::butt, s.color};
      for (const Curve& line : s.lines) stroke.lines.push_back(to_polyline(line));
      if (!stroke.lines.empty()) own.add({std::move(stroke)});
      markers(own, s, p);
    }
  }

  // Neighbours of one colour together.
  void shapes(Group& own, const SeriesPlan& s) {
    Fill fill;
    for (const Patch& shape : s.shapes) {
      if (!fill.rings.empty() && !(fill.color == shape.color)) own.add({std::exchange(fill, {})});
      fill.color = shape.color;
      fill.rings.push_back(to_polyline(shape.ring));
    }
    if (!fill.rings.empty()) own.add({std::move(fill)});
  }

  void reference_bands(Group& group, const PanelPlan& p, const std::string& role) {
    const Box& b = p.box;
    Group* bands = nullptr;
    for (const ReferenceBand& band : p.panel->bands) {
      const auto y = [&](double v) { return to_pixels(p, p.x.lower, v, false).y; };
      const auto x = [&](double v) { return to_pixels(p, v, p.y.lower, false).x; };
      Box area{band.from ? x(*band.from) : b.left, band.upper ? y(*band.upper) : b.top,
               band.until ? x(*band.until) : b.right, band.lower ? y(*band.lower) : b.bottom};
      if (area.left > area.right) std::swap(area.left, area.right);
      if (area.top > area.bottom) std::swap(area.top, area.bottom);
      area = {std::max(area.left, b.left), std::max(area.top, b.top), std::min(area.right, b.right),
              std::min(area.bottom, b.bottom)};
      if (!(area.width() > 0) || !(area.height() > 0)) continue;
      if (!bands) bands = &group.group(role + "/bands");
      const Color color = band.color.value_or(theme_.reference);
      bands->add({box_fill(area, with_alpha(color, 34))});
    }
  }

  void grid(Group& group, const PanelPlan& p, const std::string& role) {
    const Box& b = p.box;
    const auto crisp = [](double v) { return std::floor(v) + 0.5; };
    Stroke minor{{}, to_fixed(theme_.grid_width * u_), {}, Stroke::Cap::butt, theme_.minor_grid};
    Stroke major{{}, to_fixed(theme_.grid_width * u_), {}, Stroke::Cap::butt, theme_.grid};
    for (const double v : p.x.minor)
      minor.lines.push_back(straight(crisp(x_of(p, v)), b.top, crisp(x_of(p, v)), b.bottom));
    for (const double v : p.y.minor)
      minor.lines.push_back(straight(b.left, crisp(y_of(p, p.y, v)), b.right, crisp(y_of(p, p.y, v))));
    if (!p.x.named)
      for (const Tick& t : p.x.ticks)
        major.lines.push_back(straight(crisp(x_of(p, t.value)), b.top, crisp(x_of(p, t.value)), b.bottom));
    for (const Tick& t : p.y.ticks)
      major.lines.push_back(straight(b.left, crisp(y_of(p, p.y, t.value)), b.right, crisp(y_of(p, p.y, t.value))));
    Group& lines = group.group(role + "/grid");
    if (!minor.lines.empty()) lines.add({std::move(minor)});
    if (!major.lines.empty()) lines.add({std::move(major)});
  }

  // A line along the edge is seen in its full width; but an inset's curves go on behind its edges.
  Rect clip_of(const PanelPlan& p) const { return to_rect(p.box.grown(p.is_inset ? 0.5 : 2 * u_)); }

  void areas(Group& group, const PanelPlan& p, const std::string& role) {
    for (std::size_t i = 0; i < p.series.size(); ++i) {
      const SeriesPlan& s = p.series[i];
      if (s.series->kind == Series::Kind::areas && !s.is_guide()) {
        Group& own = group.group(fmt::format("{}/series/{}", role, i), s.series->look.label);
        own.clip = to_rect(p.box.grown(0.5));
        shapes(own, s);
      }
      if (s.series->kind != Series::Kind::band) continue;
      Group& own = group.group(fmt::format("{}/series/{}", role, i), s.series->look.label);
      own.clip = to_rect(p.box);
      const Color color = with_alpha(s.color, band_alpha(s));
      for (const Curve& area : s.areas)
        if (Polyline ring = to_polyline(area); ring.size() >= 3) own.add({Fill{{std::move(ring)}, color}});
    }
  }

  std::uint8_t band_alpha(const SeriesPlan& s) const { return s.color.a < 255 ? s.color.a : theme_.band_alpha; }

  void lines(Group& group, const PanelPlan& p, const std::string& role) {
    for (std::size_t i = 0; i < p.series.size(); ++i) {
      const SeriesPlan& s = p.series[i];
      if (s.series->kind == Series::Kind::band || s.series->kind == Series::Kind::areas || s.is_guide()) continue;
      Group& own = group.group(fmt::format("{}/series/{}", role, i), s.series->look.label);
      own.clip = clip_of(p);
      Stroke stroke{{}, to_fixed(s.width), dashes(s.style, s.width, u_), Stroke::Cap::butt, s.color};
      if (s.style == LineStyle::solid) stroke.cap = Stroke::Cap::round;
      for (const Curve& line : s.lines) stroke.lines.push_back(to_polyline(line));
      if (!stroke.lines.empty()) own.add({std::move(stroke)});
      shapes(own, s);
      markers(own, s, p);
    }
  }

  void markers(Group& own, const SeriesPlan& s, const PanelPlan& p) const {
    const Marker marker = s.series->look.marker == Marker::none ? Marker::dot : s.series->look.marker;
    const double radius = s.mark_radius;
    // Arrows at the edge are whole, as markers are.
    const double arrow = s.series->kind == Series::Kind::arrows ? 0.5 * arrow_length(plan_, s) : 0;
    own.clip = s.marks.empty() && arrow == 0 ? clip_of(p) : to_rect(p.box.grown(std::max(1.5 * radius, arrow)));
    Fill filled{{}, s.color};
    Stroke drawn{{}, to_fixed(s.width), {}, Stroke::Cap::butt, s.color};
    for (const Spot at : s.marks) add_marker(filled, drawn, marker, at, radius);
    // What is translucent shows how many lie on top of each other.
    if (s.color.a < 255)
      for (Polyline& ring : std::exchange(filled.rings, {})) own.add({Fill{{std::move(ring)}, s.color}});
    if (!filled.rings.empty()) own.add({std::move(filled)});
    if (!drawn.lines.empty()) own.add({std::move(drawn)});
  }

  void reference_lines(Group& group, const PanelPlan& p, const std::string& role) {
    const Box& b = p.box;
    const double width = theme_.reference_width * u_;
    Group* lines = nullptr;
    for (const ReferenceLine& line : p.panel->lines) {
      const bool across = line.axis == ReferenceLine::y;
      const Spot at = to_pixels(p, across ? p.x.lower : line.at, across ? line.at : p.y.lower, false);
      if (std::isnan(at.x) || std::isnan(at.y)) continue;
      if (!b.grown(0.5).contains(across ? Spot{b.left, at.y} : Spot{at.x, b.top})) continue;
      if (!lines) lines = &group.group(role + "/lines");
      const double level = std::floor(across ? at.y : at.x) + 0.5;
      Stroke stroke{{across ? straight(b.left, level, b.right, level) : straight(level, b.bottom, level, b.top)},
                    to_fixed(width),
                    {},
                    Stroke::Cap::butt,
                    line.color.value_or(theme_.reference)};
      if (line.style == LineStyle::dashed) stroke.dashes = {to_fixed(7 * u_), to_fixed(5 * u_)};
      if (line.style == LineStyle::dotted) stroke.dashes = {to_fixed(2 * u_), to_fixed(3 * u_)};
      if (line.style != LineStyle::none) lines->add({std::move(stroke)});
    }
  }

  void axes(Group& group, const PanelPlan& p, const std::string& role) {
    const Box& b = p.box;
    Stroke lines{{{to_point({b.left, b.top}), to_point({b.left, b.bottom}), to_point({b.right, b.bottom})}},
                 to_fixed(1.1 * u_),
                 {},
                 Stroke::Cap::butt,
                 theme_.axis};
    group.group(role + "/axes").add({std::move(lines)});
  }

  void numbers(Group& group, const PanelPlan& p, const std::string& role) {
    const Box& b = p.box;
    const double half = 0.5 * cap_height * theme_.text_size * u_;
    const double gap = 9 * u_;
    if (p.shows_x) {
      Group& ticks = group.group(role + "/x/ticks", scale_name(p.x));
      const double y = b.bottom + 0.4 * gap + 0.25 * theme_.text_size * u_ + 2 * half + 0.1 * theme_.text_size * u_;
      for (std::size_t i = 0; i < p.x_ticks.size(); ++i) {
        const double x = x_of(p, p.x.ticks[i].value);
        if (p.x_turned)
          ticks.add({text(p.x_ticks[i], x + half, b.bottom + gap + p.x_ticks[i].width, 1, theme_.muted)});
        else
          ticks.add(
              {text(p.x_ticks[i], beside_right(p, x - p.x_ticks[i].width / 2, p.x_ticks[i]), y, 0, theme_.muted)});
      }
      if (!p.x_note.empty()) {
        const double below = y + (p.x_label.empty() ? 1.45 * theme_.text_size * u_ : 1.5 * theme_.label_size * u_);
        group.group(role + "/x/note").add({text(p.x_note, b.right - p.x_note.width, below, 0, theme_.muted)});
      }
    }
    if (p.shows_y) left_numbers(group, p, role);
    right_numbers(group, p, role);
  }

  // An exponent rises to the height of the right axis' lowest number: it stays to the left of that.
  double beside_right(const PanelPlan& p, double x, const Label& label) const {
    if (!p.twin || p.right_ticks.empty() || -label.top < 0.8 * label.size) return x;
    return std::min(x, p.box.right + 3 * u_ - label.width);
  }

  void left_numbers(Group& group, const PanelPlan& p, const std::string& role) {
    const Box& b = p.box;
    const double half = 0.5 * cap_height * theme_.text_size * u_, gap = 9 * u_;
    Group& left = group.group(role + "/y/ticks", scale_name(p.y));
    const Color left_color = p.left_color.value_or(theme_.muted);
    for (std::size_t i = 0; i < p.y_ticks.size(); ++i)
      left.add({text(p.y_ticks[i], b.left - gap - p.y_ticks[i].width, y_of(p, p.y, p.y.ticks[i].value) + half, 0,
                     left_color)});
    if (!p.y_note.empty()) group.group(role + "/y/note").add({text(p.y_note, b.left, b.top - gap, 0, left_color)});
  }

  void right_numbers(Group& group, const PanelPlan& p, const std::string& role) {
    if (!p.twin) return;
    const Box& b = p.box;
    const double half = 0.5 * cap_height * theme_.text_size * u_, gap = 9 * u_;
    const Color right_color = p.right_color.value_or(theme_.muted);
    Group& right = group.group(role + "/right/ticks", scale_name(p.right));
    for (std::size_t i = 0; i < p.right_ticks.size(); ++i)
      right.add(
          {text(p.right_ticks[i], b.right + gap, y_of(p, p.right, p.right.ticks[i].value) + half, 0, right_color)});
    if (!p.right_note.empty())
      group.group(role + "/right/note")
          .add({text(p.right_note, b.right - p.right_note.width, b.top - gap, 0, right_color)});
  }

  void words(Group& group, const PanelPlan& p, const std::string& role) {
    const Box& b = p.box;
    const double size = theme_.label_size * u_, line = 1.25 * size;
    if (!p.title.empty()) {
      Group& title = group.group(role + "/title");
      double y = b.top - 0.8 * 9 * u_ - 0.1 * theme_.panel_title_size * u_ -
                 static_cast<double>(p.title.size() - 1) * 1.25 * theme_.panel_title_size * u_;
      if (!p.y_note.empty() || !p.right_note.empty()) y -= 1.45 * theme_.text_size * u_;
      if (p.key.kind == KeyKind::above)
        y = p.key.box.top - 0.4 * 9 * u_ -
            static_cast<double>(p.title.size() - 1) * 1.25 * theme_.panel_title_size * u_;
      for (const Label& l : p.title) {
        title.add({text(l, b.left, y, 0, theme_.text)});
        y += 1.25 * theme_.panel_title_size * u_;
      }
    }
    if (!p.x_label.empty()) {
      Group& label = group.group(role + "/x/label");
      double upright = 0;
      if (p.x_turned)
        for (const Label& l : p.x_ticks) upright = std::max(upright, l.width + 0.6 * 9 * u_);
      const double numbers = p.x_turned ? upright : 1.45 * theme_.text_size * u_;
      double y = b.bottom + 0.8 * 9 * u_ + numbers + cap_height * size + 0.12 * size;
      for (const Label& l : p.x_label) {
        label.add({text(l, (b.left + b.right - l.width) / 2, y, 0, theme_.text)});
        y += line;
      }
    }
    if (!p.y_label.empty()) {
      Group& label = group.group(role + "/y/label");
      // The first column's labels stand in one line at the picture's edge.
      double widest = 0;
      for (const Label& l : p.y_ticks) widest = std::max(widest, l.width);
      double x = p.column == 0 ? 18 * u_ + cap_height * size
                               : b.left - 1.9 * 9 * u_ - widest - 0.25 * size -
                                     (static_cast<double>(p.y_label.size()) - 1) * line;
      for (const Label& l : p.y_label) {
        label.add({text(l, x, upright_y(p, l), 1, p.left_color.value_or(theme_.text))});
        x += line;
      }
    }
    if (!p.right_label.empty()) {
      Group& label = group.group(role + "/right/label");
      double widest = 0;
      for (const Label& l : p.right_ticks) widest = std::max(widest, l.width);
      double x = b.right + 9 * u_ + widest + 0.9 * 9 * u_ + cap_height * size;
      for (const Label& l : p.right_label) {
        label.add({text(l, x, upright_y(p, l), 1, p.right_color.value_or(theme_.text))});
        x += line;
      }
    }
  }

  // Centred on the panel, but inside the picture.
  double upright_y(const PanelPlan& p, const Label& l) const {
    const double y = (p.box.top + p.box.bottom + l.width) / 2;
    return std::clamp(y, l.width + 4 * u_, std::max(plan_.height - 4 * u_, l.width + 4 * u_));
  }

  void placed_labels(Group& group, const PanelPlan& p, const std::string& role) {
    if (!p.callouts.empty()) {
      Group& marks = group.group(role + "/callouts");
      for (const PlacedMark& m : p.callouts) {
        Fill halo{{}, theme_.background}, filled{{}, m.color};
        Stroke around{{}, to_fixed(3.5 * u_), {}, Stroke::Cap::butt, theme_.background};
        Stroke drawn{{}, to_fixed(2 * u_), {}, Stroke::Cap::butt, m.color};
        add_marker(halo, around, m.marker, m.at, 6.2 * u_);
        add_marker(filled, drawn, m.marker, m.at, 4.6 * u_);
        if (!halo.rings.empty()) marks.add({std::move(halo)});
        if (!filled.rings.empty()) marks.add({std::move(filled)});
        if (!drawn.lines.empty()) marks.add({std::move(drawn)});
      }
    }
    if (p.labels.empty()) return;
    Group& labels = group.group(role + "/labels");
    for (const PlacedLabel& l : p.labels) {
      if (l.leader)
        labels.add({Stroke{{{to_point(l.leader->first), to_point(l.leader->second)}},
                           to_fixed(theme_.grid_width * u_),
                           {},
                           Stroke::Cap::butt,
                           l.color}});
      if (l.veil) labels.add({box_fill(l.box().grown(2 * u_), with_alpha(theme_.background, 215))});
      labels.add({text(l.label, l.x, l.y, 0, l.color)});
    }
  }

  void key(Group& group, const PanelPlan& p, const std::string& role) {
    const KeyPlan& k = p.key;
    if (k.kind == KeyKind::none) return;
    const double size = theme_.text_size * u_, half = 0.5 * cap_height * size;
    Group& legend = group.group(role + (k.kind == KeyKind::end_labels ? "/ends" : "/legend"));
    if (k.kind == KeyKind::end_labels) {
      for (std::size_t i = 0; i < k.entries.size(); ++i) {
        const SeriesPlan& s = p.series[k.entries[i]];
        legend.group(fmt::format("{}/ends/{}", role, k.entries[i]))
            .add({text(k.labels[i], p.box.right + 8 * u_, p.end_label_y[i] + 0.75 * half + 0.1 * half, 0,
                       s.text_color)});
      }
      return;
    }
    const double pad = k.kind == KeyKind::inside ? 0.5 * size : 0, sample = 2 * size;
    if (k.kind == KeyKind::inside) legend.add({box_fill(k.box, theme_.background)});
    const int rows = static_cast<int>(std::ceil(static_cast<double>(k.labels.size()) / k.columns));
    for (std::size_t i = 0; i < k.labels.size(); ++i) {
      const int n = static_cast<int>(i);
      const int column = k.kind == KeyKind::above ? n % k.columns : n / rows,
                row = k.kind == KeyKind::above ? n / k.columns : n % rows;
      const double x = k.box.left + pad + column * (k.column + 1.5 * size), y = k.box.top + pad + (row + 0.5) * k.row;
      if (i < k.entries.size()) {
        const SeriesPlan& s = p.series[k.entries[i]];
        Group& entry = legend.group(fmt::format("{}/legend/{}", role, k.entries[i]), s.series->look.label);
        sample_of(entry, s, x, y, sample);
        entry.add({text(k.labels[i], x + sample + 0.55 * size, y + half, 0, theme_.text)});
      } else {
        legend.group(role + "/legend/more")
            .add({text(k.labels[i], x + sample + 0.55 * size, y + half, 0, theme_.muted)});
      }
    }
  }

  void sample_of(Group& entry, const SeriesPlan& s, double x, double y, double length) {
    if (s.series->kind == Series::Kind::band || s.series->kind == Series::Kind::areas) {
      const double half = 0.33 * theme_.text_size * u_;
      const std::uint8_t alpha = s.series->kind == Series::Kind::band ? band_alpha(s) : s.color.a;
      entry.add({box_fill({x, y - half, x + length, y + half}, with_alpha(s.color, alpha))});
      return;
    }
    if (s.style != LineStyle::none)
      entry.add({Stroke{{straight(x, y, x + length, y)},
                        to_fixed(s.width),
                        dashes(s.style, s.width, u_),
                        Stroke::Cap::butt,
                        s.color}});
    if (s.series->look.marker == Marker::none) return;
    Fill filled{{}, s.color};
    Stroke drawn{{}, to_fixed(s.width), {}, Stroke::Cap::butt, s.color};
    add_marker(filled, drawn, s.series->look.marker, {x + length / 2, y}, std::clamp(s.mark_radius, 2.4 * u_, 5 * u_));
    if (!filled.rings.empty()) entry.add({std::move(filled)});
    if (!drawn.lines.empty()) entry.add({std::move(drawn)});
  }
};

}  // namespace

Scene draw(const Plan& plan) { return Drawing(plan).scene(); }

}  // namespace plantloop
