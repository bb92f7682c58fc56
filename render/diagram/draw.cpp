// Blocks with rounded corners, faces and captions; wires with arrows and dots.

#include "render/diagram/draw.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/error.h"
#include "render/text/font.h"
#include "render/text/label.h"
#include "render/theme.h"

namespace plantloop {
namespace {

using Shape = SheetBlock::Shape;

constexpr double margin = 30, title_room = 46;
constexpr double line_width = 1.6, curve_width = 2.0;
constexpr int largest = 16384;

// A quarter of a circle from `from` by the cosines and sines of multiples of 15 degrees.
constexpr double cosines[] = {
    1, 0.96592582628906829, 0.86602540378443865, 0.70710678118654752, 0.5, 0.25881904510252076, 0};

Curve rounded(const Box& b, double r) {
  Curve ring;
  const auto corner = [&](double cx, double cy, double sx, double sy, bool from_x) {
    for (int i = 0; i <= 6; ++i) {
      const double c = cosines[i], s = cosines[6 - i];
      ring.push_back(from_x ? Spot{cx + sx * r * c, cy + sy * r * s} : Spot{cx + sx * r * s, cy + sy * r * c});
    }
  };
  corner(b.right - r, b.top + r, 1, -1, false);
  corner(b.right - r, b.bottom - r, 1, 1, true);
  corner(b.left + r, b.bottom - r, -1, 1, false);
  corner(b.left + r, b.top + r, -1, -1, true);
  return ring;
}

class Drawer {
 public:
  Drawer(const Theme& theme, Scene& scene) : theme_(theme), scene_(scene) {
    face_ = over(with_alpha(theme.text, 8), theme.background);
    signal_ = readable_on(over(with_alpha(theme.text, 20), theme.background), theme.palette[1], 4.6);
    curve_ = readable_on(face_, theme.palette[0], 3.2);
  }

  void run(const Sheet& sheet, const Arrangement& a) {
    double top = margin, width = a.width;
    if (!sheet.title.empty()) {
      const Label title = set_label(sheet.title, {.size = theme_.title_size, .strong = true});
      scene_.root.group("title").add({plantloop::place(title, margin, margin + 16, 0, theme_.text, theme_.background)});
      width = std::max(width, title.width);
      top += title_room;
    }
    set_size(width + 2 * margin, top + a.height + margin);
    draw_sheet(scene_.root, "", sheet, a, {margin, top}, theme_.background);
  }

 private:
  void set_size(double width, double height) {
    const double w = std::ceil(width), h = std::ceil(height);
    if (w > largest || h > largest) {
      throw RenderError(
          fmt::format("the drawing needs {:.0f} by {:.0f} pixels, and {} is the most; draw the subsystems one by one",
                      w, h, largest));
    }
    scene_.width = static_cast<int>(w);
    scene_.height = static_cast<int>(h);
  }

  void draw_sheet(Group& into, const std::string& path, const Sheet& sheet, const Arrangement& a, Spot origin,
                  Color paper) {
    for (const PlacedFrame& f : a.frames) {
      const PlacedBlock& b = a.blocks[static_cast<std::size_t>(f.block)];
      const SheetBlock& block = sheet.blocks[static_cast<std::size_t>(b.block)];
      Group& group = into.group("frame/" + path + block.path);
      outline(group, rounded(moved(b.box, origin), 6), frame_fill(paper), theme_.axis, 1.2, {7, 5});
      caption(group, block, moved(b.box, origin), false, paper);
      top_name(group, block, b, moved(b.box, origin), frame_fill(paper));
      const bool outside = std::exchange(is_in_frame_, true);
      draw_sheet(group, path + block.path + ".", *block.inside, f.inside,
                 {origin.x + f.origin.x, origin.y + f.origin.y}, frame_fill(paper));
      is_in_frame_ = outside;
      join_ports(group, *block.inside, b, f, origin);
    }
    for (const PlacedNet& net : a.nets) draw_net(into, path, sheet, a, net, origin, paper);
    for (const PlacedBlock& b : a.blocks) {
      if (b.block < 0) {
        draw_result(into, path, sheet, b, origin, paper);
      } else if (!sheet.blocks[static_cast<std::size_t>(b.block)].inside) {
        draw_block(into, path, sheet.blocks[static_cast<std::size_t>(b.block)], b, origin, paper);
      }
    }
  }

  // From the edge of a frame to the ports inside.
  void join_ports(Group& into, const Sheet& inside, const PlacedBlock& frame, const PlacedFrame& f, Spot origin) {
    Stroke stroke = line(theme_.text, line_width);
    std::size_t in = 0, out = 0;
    for (std::size_t i = 0; i < inside.blocks.size(); ++i) {
      const Shape shape = inside.blocks[i].shape;
      if (shape != Shape::input && shape != Shape::output) continue;
      const std::vector<PlacedPort>& ports = shape == Shape::input ? frame.inputs : frame.outputs;
      const std::size_t at = shape == Shape::input ? in++ : out++;
      if (at >= ports.size()) continue;
      for (const PlacedBlock& p : f.inside.blocks) {
        if (p.block != static_cast<int>(i)) continue;
        const PlacedPort& port = ports[at];
        const double x = port.side == Side::left ? p.box.left : p.box.right;
        stroke.lines.push_back({to_point({origin.x + port.at.x, origin.y + port.at.y}),
                                to_point({origin.x + f.origin.x + x, origin.y + port.at.y})});
      }
    }
    if (!stroke.lines.empty()) into.add({std::move(stroke)});
  }

  static Box moved(const Box& b, Spot by) { return {b.left + by.x, b.top + by.y, b.right + by.x, b.bottom + by.y}; }

  Color frame_fill(Color paper) const { return over(with_alpha(theme_.text, 5), paper); }

  static Stroke line(Color color, double width) {
    Stroke stroke;
    stroke.width = to_fixed(width);
    stroke.color = color;
    return stroke;
  }

  void outline(Group& into, Curve ring, Color fill, Color edge, double width,
               const std::vector<double>& dashes = {}) const {
    into.add({Fill{{to_polyline(ring)}, fill}});
    ring.push_back(ring.front());
    Stroke stroke = line(edge, width);
    for (const double d : dashes) stroke.dashes.push_back(to_fixed(d));
    stroke.lines = {to_polyline(ring)};
    into.add({std::move(stroke)});
  }

  void text(Group& into, const std::string& words, double size, double x, double base, double align, Color color,
            Color paper) const {
    const Label label = set_label(words, {.size = size});
    if (!label.empty()) into.add({plantloop::place(label, x - align * label.width, base, 0, color, paper)});
  }

  void draw_result(Group& into, const std::string& path, const Sheet& sheet, const PlacedBlock& b, Spot origin,
                   Color paper) {
    const SheetWire& wire = sheet.wires[static_cast<std::size_t>(-1 - b.block)];
    Group& group = into.group("result/" + path + sheet.blocks[static_cast<std::size_t>(wire.from.block)].path);
    text(group, wire.result, sheet_style.text, origin.x + b.box.right + 8,
         origin.y + b.box.top + 0.36 * sheet_style.text, 0, signal_, paper);
  }

  void draw_block(Group& into, const std::string& path, const SheetBlock& block, const PlacedBlock& placed, Spot origin,
                  Color paper) {
    Group& group = into.group("block/" + path + block.path, spoken(block.formula));
    const Box box = moved(placed.box, origin);
    const Spot centre{(box.left + box.right) / 2, (box.top + box.bottom) / 2};
    switch (placed.shape) {
      case Shape::circle:
        draw_circle(group, placed, centre, origin);
        return;
      case Shape::bar:
        group.add({Fill{
            {to_polyline({{box.left, box.top}, {box.right, box.top}, {box.right, box.bottom}, {box.left, box.bottom}})},
            theme_.text}});
        return;
      case Shape::value:
        formula(group, block.formula, centre, theme_.text, paper);
        break;
      case Shape::input:
      case Shape::output:
        formula(group, block.formula, centre, signal_, paper);
        break;
      case Shape::gain:
        draw_gain(group, block, placed, box, centre);
        break;
      case Shape::box:
        draw_box(group, block, placed, box, origin);
        break;
    }
    caption(group, block, box, placed.caption_above, paper);
  }

  void draw_box(Group& group, const SheetBlock& block, const PlacedBlock& placed, const Box& box, Spot origin) const {
    // Of a stack the front is where the inputs arrive, the back where the output leaves.
    Box front = box;
    if (block.copies > 1) {
      const double step = sheet_style.stack;
      for (const double k : {2.0, 1.0, 0.0}) {
        const double x = k * step;
        front = {box.left + x, box.top + 2 * step - x, box.right - 2 * step + x, box.bottom - x};
        if (placed.is_flipped) front = {box.left + 2 * step - x, front.top, box.right - x, front.bottom};
        if (k > 0) outline(group, rounded(front, 4), face_, theme_.text, 1.1);
      }
    }
    outline(group, rounded(front, 4), face_, theme_.text, line_width);
    if (block.is_subsystem) {
      Stroke inner = line(theme_.axis, 1.0);
      Curve ring = rounded({front.left + 4, front.top + 4, front.right - 4, front.bottom - 4}, 2);
      ring.push_back(ring.front());
      inner.lines = {to_polyline(ring)};
      group.add({std::move(inner)});
    }
    Spot centre{(front.left + front.right) / 2, (front.top + front.bottom) / 2};
    top_name(group, block, placed, front, face_);
    if (block.top_input >= 0) centre.y += sheet_style.top_name / 2;
    if (block.curves.empty()) {
      formula(group, block.formula, {centre.x + port_shift(placed), centre.y}, theme_.text, face_);
    } else {
      draw_curves(group, block, centre);
    }
    port_names(group, placed, origin);
  }

  void top_name(Group& group, const SheetBlock& block, const PlacedBlock& placed, const Box& box, Color paper) const {
    if (block.top_input < 0) return;
    const double size = sheet_style.caption;
    text(group, placed.inputs[static_cast<std::size_t>(block.top_input)].text, size, (box.left + box.right) / 2,
         box.top + size + 3, 0.5, theme_.muted, paper);
  }

  // A face moves away from the names of ports on one side only.
  static double port_shift(const PlacedBlock& placed) {
    const auto widest = [&](const std::vector<PlacedPort>& ports) {
      double w = 0;
      if (beside(ports) > 1)
        for (const PlacedPort& p : ports)
          if (!p.text.empty() && is_beside(p)) w = std::max(w, set_label(p.text, {.size = sheet_style.caption}).width);
      return w;
    };
    const double shift = (widest(placed.inputs) - widest(placed.outputs)) / 2;
    return placed.is_flipped ? -shift : shift;
  }

  void formula(Group& into, const Formula& f, Spot centre, Color color, Color paper) const {
    const FormulaSize size = measure(f, sheet_style.text);
    set_formula(into, f, sheet_style.text, centre.x - size.width / 2, centre.y + (size.above - size.below) / 2, color,
                paper);
  }

  void draw_gain(Group& into, const SheetBlock& block, const PlacedBlock& placed, const Box& box, Spot centre) {
    const double back = placed.is_flipped ? box.right : box.left, tip = placed.is_flipped ? box.left : box.right;
    outline(into, {{back, box.top}, {tip, centre.y}, {back, box.bottom}}, face_, theme_.text, line_width);
    const double inward = (tip - back) * 0.36;
    formula(into, block.formula, {back + inward, centre.y}, theme_.text, face_);
  }

  void draw_circle(Group& into, const PlacedBlock& placed, Spot centre, Spot origin) {
    const double r = sheet_style.circle;
    outline(into, rounded({centre.x - r, centre.y - r, centre.x + r, centre.y + r}, r), face_, theme_.text, line_width);
    // Each sign lies inside, at its wire; drawn as lines, so that it is centred and of one weight. A circle that only
    // multiplies has one sign in its middle.
    Stroke signs = line(theme_.text, 1.4);
    const auto cross = [&](Spot at, double h) {
      signs.lines.push_back({to_point({at.x - h, at.y - h}), to_point({at.x + h, at.y + h})});
      signs.lines.push_back({to_point({at.x - h, at.y + h}), to_point({at.x + h, at.y - h})});
    };
    const auto has = [&](std::string_view sign) {
      return std::any_of(placed.inputs.begin(), placed.inputs.end(),
                         [&](const PlacedPort& p) { return p.text == sign; });
    };
    const bool divides = has("÷");
    for (const PlacedPort& port : placed.inputs) {
      const Spot at{origin.x + port.at.x, origin.y + port.at.y};
      const Spot middle{centre.x + (at.x - centre.x) * 0.56, centre.y + (at.y - centre.y) * 0.56};
      const double h = 3.2;
      if (port.text == "+" || port.text == "−") {
        signs.lines.push_back({to_point({middle.x - h, middle.y}), to_point({middle.x + h, middle.y})});
        if (port.text == "+")
          signs.lines.push_back({to_point({middle.x, middle.y - h}), to_point({middle.x, middle.y + h})});
      } else if (port.text == "÷") {
        signs.lines.push_back({to_point({middle.x - h, middle.y}), to_point({middle.x + h, middle.y})});
        for (const double dy : {-3.0, 3.0})
          signs.lines.push_back({to_point({middle.x - 0.8, middle.y + dy}), to_point({middle.x + 0.8, middle.y + dy})});
      } else if (port.text == "×" && divides) {
        cross(middle, 2.6);
      }
    }
    if (has("×") && !divides) cross(centre, 4.6);
    if (!signs.lines.empty()) into.add({std::move(signs)});
  }

  static bool is_beside(const PlacedPort& p) { return p.side == Side::left || p.side == Side::right; }
  static std::ptrdiff_t beside(const std::vector<PlacedPort>& ports) {
    return std::count_if(ports.begin(), ports.end(), is_beside);
  }

  void draw_curves(Group& into, const SheetBlock& block, Spot centre) const {
    const double w = 46, h = 30;
    const auto at = [&](Spot s) { return Spot{centre.x + (s.x - 0.5) * w, centre.y - (s.y - 0.5) * h}; };
    const auto add = [&](const std::vector<Curve>& curves, Color color, double width) {
      Stroke stroke = line(color, width);
      stroke.cap = Stroke::Cap::round;
      for (const Curve& curve : curves) {
        Curve placed;
        for (const Spot s : curve) placed.push_back(at(s));
        if (Polyline points = to_polyline(placed); points.size() > 1) stroke.lines.push_back(std::move(points));
      }
      if (!stroke.lines.empty()) into.add({std::move(stroke)});
    };
    add(block.axes, readable_on(face_, theme_.axis, 3.0), 0.9);
    add(block.curves, curve_, curve_width);
  }

  void port_names(Group& into, const PlacedBlock& placed, Spot origin) const {
    const double size = sheet_style.caption;
    for (const auto* ports : {&placed.inputs, &placed.outputs}) {
      if (beside(*ports) < 2) continue;
      for (const PlacedPort& p : *ports) {
        if (p.text.empty() || !is_beside(p)) continue;
        const bool left = p.side == Side::left;
        text(into, p.text, size, origin.x + p.at.x + (left ? 6 : -6), origin.y + p.at.y + 0.36 * size, left ? 0 : 1,
             theme_.muted, face_);
      }
    }
  }

  void caption(Group& into, const SheetBlock& block, const Box& box, bool above, Color paper) const {
    const double x = (box.left + box.right) / 2;
    const SheetStyle& s = sheet_style;
    if (above) {
      double base = box.top - 6;
      if (!block.note.empty()) {
        text(into, block.note, s.note, x, base, 0.5, theme_.muted, paper);
        base -= s.note * 1.35;
      }
      text(into, block.caption, s.caption, x, base, 0.5, theme_.muted, paper);
      return;
    }
    double base = box.bottom + 4 + s.caption;
    if (!block.caption.empty()) {
      text(into, block.caption, s.caption, x, base, 0.5, theme_.muted, paper);
      base += s.note * 1.35;
    }
    if (!block.note.empty()) text(into, block.note, s.note, x, base, 0.5, theme_.muted, paper);
  }

  void draw_net(Group& into, const std::string& path, const Sheet& sheet, const Arrangement& a, const PlacedNet& net,
                Spot origin, Color paper) {
    const auto at = [&](Spot s) { return Spot{origin.x + s.x, origin.y + s.y}; };
    std::string role = "wire";
    if (net.wire >= 0) {
      const SheetWire& wire = sheet.wires[static_cast<std::size_t>(net.wire)];
      role = fmt::format("wire/{}{}/{}", path, sheet.blocks[static_cast<std::size_t>(wire.from.block)].path,
                         wire.from.port);
    }
    Group& group = into.group(role);
    Stroke stroke = line(theme_.text, line_width);
    for (const Curve& points : net.lines) {
      Curve drawn;
      for (const Spot s : points) drawn.push_back(at(s));
      shorten(drawn.front(), drawn[1], net, a, origin);
      shorten(drawn.back(), drawn[drawn.size() - 2], net, a, origin);
      stroke.lines.push_back(to_polyline(drawn));
    }
    if (!stroke.lines.empty()) group.add({std::move(stroke)});
    Fill marks;
    marks.color = theme_.text;
    for (const Spot dot : net.dots) {
      const Spot s = at(dot);
      marks.rings.push_back(to_polyline(rounded({s.x - 3.4, s.y - 3.4, s.x + 3.4, s.y + 3.4}, 3.4)));
    }
    for (const PlacedArrow& arrow : net.arrows)
      if (has_head(a, arrow)) marks.rings.push_back(to_polyline(arrow_head(at(arrow.tip), arrow.side)));
    if (!marks.rings.empty()) group.add({std::move(marks)});
    if (net.wire >= 0) wire_label(group, sheet.wires[static_cast<std::size_t>(net.wire)], a, net, origin, paper);
  }

  // A wire into a bar has no head, and none that goes on across the edge of a frame.
  bool has_head(const Arrangement& a, const PlacedArrow& arrow) const {
    const PlacedBlock& b = a.blocks[static_cast<std::size_t>(arrow.block)];
    if (b.shape == Shape::bar || (is_in_frame_ && b.shape == Shape::output)) return false;
    return std::none_of(a.frames.begin(), a.frames.end(), [&](const PlacedFrame& f) { return f.block == arrow.block; });
  }

  void shorten(Spot& end, Spot towards, const PlacedNet& net, const Arrangement& a, Spot origin) const {
    for (const PlacedArrow& arrow : net.arrows) {
      if (!has_head(a, arrow)) continue;
      if (std::abs(origin.x + arrow.tip.x - end.x) > 0.01 || std::abs(origin.y + arrow.tip.y - end.y) > 0.01) continue;
      const double by = sheet_style.arrow * 0.7;
      if (end.x != towards.x) end.x += end.x < towards.x ? by : -by;
      if (end.y != towards.y) end.y += end.y < towards.y ? by : -by;
      return;
    }
  }

  static Curve arrow_head(Spot tip, Side side) {
    const double l = sheet_style.arrow, w = l * 0.42, notch = l * 0.74;
    const auto point = [&](double back, double across) {
      switch (side) {
        case Side::left:
          return Spot{tip.x - back, tip.y + across};
        case Side::right:
          return Spot{tip.x + back, tip.y + across};
        case Side::top:
          return Spot{tip.x + across, tip.y - back};
        default:
          return Spot{tip.x + across, tip.y + back};
      }
    };
    return {point(0, 0), point(l, w), point(notch, 0), point(l, -w)};
  }

  void wire_label(Group& into, const SheetWire& wire, const Arrangement& a, const PlacedNet& net, Spot origin,
                  Color paper) const {
    // At the end of a result stands its name already.
    const bool is_named = std::any_of(net.arrows.begin(), net.arrows.end(), [&](const PlacedArrow& arrow) {
      return a.blocks[static_cast<std::size_t>(arrow.block)].block < 0;
    });
    double x = origin.x + net.label.x;
    const double y = origin.y + net.label.y;
    const Label label = set_label(is_named ? "" : wire.label, {.size = sheet_style.text});
    const Label note = set_label(wire.note, {.size = sheet_style.note});
    if (net.label_leftwards) x -= label.width + (note.empty() ? 0 : note.width + 6);
    if (!label.empty()) into.add({plantloop::place(label, x, y, 0, signal_, paper)});
    if (!note.empty())
      into.add({plantloop::place(note, x + (label.empty() ? 0 : label.width + 6), y, 0, theme_.muted, paper)});
  }

  const Theme& theme_;
  Scene& scene_;
  Color face_, signal_, curve_;
  bool is_in_frame_ = false;
};

}  // namespace

Scene draw(const Sheet& sheet, const Arrangement& arrangement, std::string_view theme_name) {
  const Theme* theme = find_theme(theme_name);
  if (theme == nullptr)
    throw RenderError(fmt::format("there is no theme '{}'; there are: {}", theme_name, fmt::join(theme_names(), ", ")));
  Scene scene;
  scene.title = sheet.title;
  scene.dpi = 152.4;
  scene.background = theme->background;
  scene.fonts = scene_fonts();
  scene.root.role = "diagram";
  Drawer(*theme, scene).run(sheet, arrangement);
  return scene;
}

}  // namespace plantloop
