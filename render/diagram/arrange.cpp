// Sheet -> arrangement: the steps of the layout, one after the other.

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "render/diagram/web.h"
#include "render/text/label.h"

namespace plantloop {
namespace {

using Shape = SheetBlock::Shape;

double width_of(const std::string& text, double size) {
  return text.empty() ? 0 : set_label(text, {.size = size}).width;
}

class Arranger {
 public:
  Arranger(const Sheet& sheet, const std::vector<SheetHint>& hints, bool is_framed) : sheet_(sheet), hints_(hints) {
    web_.is_framed = is_framed;
  }

  Arrangement run() {
    make_web();
    find_feedback(web_);
    add_results();
    split_circles(web_);
    choose_sides();
    give_columns(web_);
    if (web_.is_framed) move_ports_to_edges();
    give_sizes();
    // Four beginnings, and the simplest end.
    const Web start = web_;
    double least = 0;
    for (const int beginning : {0, 1, 2, 3}) {
      web_ = start;
      web_.branches_first = beginning % 2 != 0;
      if (beginning < 2) turn_sides_by_height();
      if (beginning >= 2) improve_columns();
      improve_sides();
      improve_columns();
      Arrangement candidate = arranged();
      const double price = cost(candidate);
      if (beginning > 0 && price >= least) continue;
      least = price;
      result_ = std::move(candidate);
      best_ = web_;
    }
    web_ = std::move(best_);
    move_to_origin();
    return std::move(result_);
  }

 private:
  const SheetBlock& block(const Element& e) const { return sheet_.blocks[static_cast<std::size_t>(e.block)]; }

  // Elements in the order of their paths, nets in the order of where they come from.
  void make_web() {
    std::vector<int> order(sheet_.blocks.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      return sheet_.blocks[static_cast<std::size_t>(a)].path < sheet_.blocks[static_cast<std::size_t>(b)].path;
    });
    std::vector<int> element_of(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      const SheetBlock& b = sheet_.blocks[static_cast<std::size_t>(order[i])];
      element_of[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
      Element e;
      e.key = b.path;
      e.block = order[i];
      e.shape = b.shape;
      e.has_state = b.has_state;
      e.in.assign(b.inputs.size(), -1);
      e.out.assign(b.outputs.size(), -1);
      e.in_text = b.inputs;
      for (const SheetHint& h : hints_) {
        if (h.path != sheet_.path + b.path) continue;
        (h.where == SheetHint::Where::forward ? e.forced_forward : e.forced_feedback) = true;
      }
      web_.elements.push_back(std::move(e));
    }
    for (std::size_t w = 0; w < sheet_.wires.size(); ++w) {
      const SheetWire& wire = sheet_.wires[w];
      if (wire.to.empty() && !wire.is_shown) continue;
      Net net;
      net.wire = static_cast<int>(w);
      net.element = element_of[static_cast<std::size_t>(wire.from.block)];
      net.port = wire.from.port;
      net.is_shown = wire.is_shown;
      for (const SheetPort& to : wire.to)
        net.sinks.push_back({element_of[static_cast<std::size_t>(to.block)], to.port, false});
      std::sort(net.sinks.begin(), net.sinks.end(), [](const Sink& a, const Sink& b) {
        return std::pair(a.element, a.port) < std::pair(b.element, b.port);
      });
      web_.nets.push_back(std::move(net));
    }
    std::sort(web_.nets.begin(), web_.nets.end(),
              [](const Net& a, const Net& b) { return std::pair(a.element, a.port) < std::pair(b.element, b.port); });
    for (std::size_t n = 0; n < web_.nets.size(); ++n) {
      const Net& net = web_.nets[n];
      web_.elements[static_cast<std::size_t>(net.element)].out[static_cast<std::size_t>(net.port)] =
          static_cast<int>(n);
      for (const Sink& s : net.sinks)
        web_.elements[static_cast<std::size_t>(s.element)].in[static_cast<std::size_t>(s.port)] = static_cast<int>(n);
    }
  }

  Plan planned() const {
    Plan plan = make_plan(web_);
    order_columns(web_, plan);
    give_heights(web_, plan);
    return plan;
  }

  Arrangement arranged() const {
    Plan plan = planned();
    reserve_labels(plan);
    Arrangement result;
    route(web_, plan, result);
    place_blocks(plan, result);
    return result;
  }

  // How hard the drawing is to follow: bends, those of winding ways more, and crossings.
  static double cost(const Arrangement& a) {
    double sum = 0;
    for (const PlacedNet& net : a.nets)
      for (const int bends : net.bends) sum += bends + 20 * std::max(0, bends - 4);
    return sum + 1.5 * crossings(a);
  }

  static int crossings(const Arrangement& a) {
    struct Part {
      double from, until, at;
      std::size_t net;
    };
    std::vector<Part> level, upright;
    for (std::size_t n = 0; n < a.nets.size(); ++n)
      for (const Curve& line : a.nets[n].lines)
        for (std::size_t i = 0; i + 1 < line.size(); ++i) {
          const Spot p = line[i], q = line[i + 1];
          if (p.y == q.y) {
            level.push_back({std::min(p.x, q.x), std::max(p.x, q.x), p.y, n});
          } else {
            upright.push_back({std::min(p.y, q.y), std::max(p.y, q.y), p.x, n});
          }
        }
    int count = 0;
    for (const Part& h : level)
      for (const Part& v : upright)
        if (h.net != v.net && h.from < v.at && v.at < h.until && v.from < h.at && h.at < v.until) ++count;
    return count;
  }

  void turn_sides_by_height() {
    for (int round = 0; round < 4; ++round)
      if (!turn_sides(planned())) return;
  }

  // How many attempts a sheet is worth: each takes longer the larger it is.
  int budget() const { return std::clamp(4000 / static_cast<int>(web_.elements.size() + 1), 8, 150); }

  // Tries every circle's wires on the other side, as long as that makes the drawing simpler and there are not too many.
  void improve_sides() {
    int tries = budget();
    double best = cost(arranged());
    for (bool better = true; better && tries > 0;) {
      better = false;
      for (std::size_t i = 0; i < web_.elements.size() && tries > 0; ++i) {
        if (web_.elements[i].shape != Shape::circle) continue;
        for (std::size_t p = 0; p < web_.elements[i].in.size(); ++p) {
          if (!can_turn(web_.elements[i], p)) continue;
          const Web before = web_;
          turn(web_.elements[i], p);
          --tries;
          if (const double now = cost(arranged()); now < best - 1e-9) {
            best = now;
            better = true;
          } else {
            web_ = before;
          }
        }
      }
    }
  }

  // Whether a source stands above or below it.
  bool has_company(const Element& e) const {
    for (std::size_t p = 0; p < e.in.size(); ++p)
      if (const Element* from = source_of(e, p); from != nullptr && from->is_beside()) return true;
    return false;
  }

  // Tries what leads back, and what stands beside the main path, in other columns.
  void improve_columns() {
    int tries = budget() / 3;
    double best = cost(arranged());
    for (Element& e : web_.elements) {
      if (e.is_beside() || e.first_column == e.last_column || has_company(e)) continue;
      for (const int column : {e.column - 1, e.column + 1, e.column - 2, e.column + 2}) {
        if (column < e.first_column || column > e.last_column || --tries < 0) continue;
        const int before = std::exchange(e.column, column);
        if (const double now = cost(arranged()); now < best - 1e-9) {
          best = now;
          break;
        }
        e.column = before;
      }
    }
  }

  static Side opposite(Side side) { return side == Side::top ? Side::bottom : Side::top; }

  const Element* source_of(const Element& e, std::size_t p) const {
    return e.in[p] < 0 ? nullptr
                       : &web_.elements[static_cast<std::size_t>(web_.nets[static_cast<std::size_t>(e.in[p])].element)];
  }

  // A wire from above or below, not from what leads back, may come from the other side, if nothing that leads back is
  // there.
  bool can_turn(const Element& e, std::size_t p) const {
    if (e.in_side[p] != Side::top && e.in_side[p] != Side::bottom) return false;
    const Element* from = source_of(e, p);
    if (from == nullptr || from->is_beside()) return false;
    if (e.is_feedback) return true;
    if (from->is_feedback) return false;
    for (std::size_t q = 0; q < e.in.size(); ++q) {
      if (e.in_side[q] != opposite(e.in_side[p])) continue;
      const Element* other = source_of(e, q);
      if (other == nullptr || other->is_feedback) return false;
    }
    return true;
  }

  void turn(Element& e, std::size_t p) {
    const Side old = e.in_side[p], now = opposite(old);
    for (std::size_t q = 0; q < e.in.size(); ++q) {
      if (e.in_side[q] != now) continue;
      e.in_side[q] = old;
      Element& source = web_.elements[static_cast<std::size_t>(web_.nets[static_cast<std::size_t>(e.in[q])].element)];
      if (!source.is_beside()) continue;
      std::swap(source.is_above, source.is_below);
      source.above = source.below = source.half_height;
      if (source.block >= 0) add_captions(source, block(source));
    }
    e.in_side[p] = now;
  }

  // A wire that reaches a circle from above but comes from below, or the other way round, changes sides.
  bool turn_sides(const Plan& plan) {
    bool turned = false;
    for (std::size_t i = 0; i < web_.elements.size(); ++i) {
      Element& e = web_.elements[i];
      if (e.shape != Shape::circle) continue;
      for (std::size_t p = 0; p < e.in.size(); ++p) {
        const Side side = e.in_side[p];
        if (e.in[p] < 0 || (side != Side::top && side != Side::bottom)) continue;
        const double above = height_before(plan, static_cast<int>(i), e.in[p]) - plan.items[i].y;
        const Side better = above < 0 ? Side::top : Side::bottom;
        if (better == side || std::abs(above) < 1 || !can_turn(e, p)) continue;
        turn(e, p);
        turned = true;
      }
    }
    return turned;
  }

  // The height at which a net arrives at the channel of the circle's corner; the circle's own when it is not known.
  double height_before(const Plan& plan, int circle, int net) const {
    for (const std::vector<End>& ends : plan.channels)
      for (const End& corner : ends) {
        const Item& it = plan.items[static_cast<std::size_t>(corner.item)];
        if (it.kind != Item::Kind::corner || it.element != circle || it.net != net) continue;
        for (const End& other : ends)
          if (other.flow == corner.flow && other.from_left != corner.from_left)
            return plan.items[static_cast<std::size_t>(other.item)].y + other.offset;
      }
    return plan.items[static_cast<std::size_t>(circle)].y;
  }

  // A result that only goes back, or nowhere, leaves the sheet on the right.
  void add_results() {
    for (std::size_t n = 0; n < web_.nets.size(); ++n) {
      const Net& net = web_.nets[n];
      if (!net.is_shown || web_.elements[static_cast<std::size_t>(net.element)].is_feedback) continue;
      const bool goes_on = std::any_of(net.sinks.begin(), net.sinks.end(), [&](const Sink& s) {
        return !s.is_back && !web_.elements[static_cast<std::size_t>(s.element)].is_feedback;
      });
      if (goes_on) continue;
      Element result;
      result.key = web_.elements[static_cast<std::size_t>(net.element)].key + ">";
      result.block = -1 - net.wire;
      result.shape = Shape::output;
      result.in = {static_cast<int>(n)};
      result.in_text = {""};
      web_.nets[n].sinks.push_back({static_cast<int>(web_.elements.size()), 0, false});
      web_.elements.push_back(std::move(result));
    }
  }

  void choose_sides() {
    for (Element& e : web_.elements)
      if (e.in_side.size() != e.in.size()) e.in_side.assign(e.in.size(), e.is_feedback ? Side::right : Side::left);
    for (Element& e : web_.elements)
      if (const int top = top_input(e); top >= 0) e.in_side[static_cast<std::size_t>(top)] = Side::top;
  }

  int top_input(const Element& e) const { return e.block >= 0 && e.shape == Shape::box ? block(e).top_input : -1; }

  void move_ports_to_edges() {
    int last = 0;
    for (const Element& e : web_.elements) last = std::max(last, e.column);
    for (Element& e : web_.elements) {
      if (e.block < 0 || e.is_feedback) continue;
      if (e.shape == Shape::input) e.column = 0;
      if (e.shape == Shape::output) e.column = last;
    }
  }

  void give_sizes() {
    for (Element& e : web_.elements) {
      if (e.block < 0) {
        size_result(e);
      } else {
        const SheetBlock& b = block(e);
        if (b.inside) {
          size_frame(e, b);
        } else {
          size_block(e, b);
        }
        if (e.shape != Shape::circle && e.shape != Shape::bar) add_captions(e, b);
      }
    }
  }

  static void size_result(Element& e) {
    e.half_width = e.half_height = 0;
    e.left = 0;
    e.right = 10;
    e.above = e.below = 12;
    e.in_offset = {0};
  }

  void size_block(Element& e, const SheetBlock& b) {
    const SheetStyle& s = sheet_style;
    const FormulaSize face = b.curves.empty() ? measure(b.formula, s.text) : FormulaSize{46, 18, 18};
    switch (e.shape) {
      case Shape::circle:
        e.half_width = e.half_height = s.circle;
        break;
      case Shape::bar:
        e.half_width = 3.5;
        e.half_height = std::max(18.0, static_cast<double>(std::max<std::size_t>(2, e.in.size())) * s.port_gap / 2 - 3);
        break;
      case Shape::value:
      case Shape::input:
      case Shape::output:
        e.half_width = face.width / 2 + 5;
        e.half_height = std::max(12.0, face.height() / 2 + 3);
        break;
      case Shape::gain:
        // The formula lies in the wide half of the triangle.
        e.half_height = std::max(26.0, face.height() / 2 + 14 + face.width * 0.16);
        e.half_width = std::max(29.0, face.width * 0.82 + 10);
        break;
      case Shape::box: {
        const std::size_t left = e.in.size() - (b.top_input >= 0 ? 1 : 0);
        const std::size_t ports = std::max({std::size_t{1}, left, e.out.size()});
        double names_left = 0, names_right = 0;
        if (left > 1)
          for (std::size_t i = 0; i < e.in.size(); ++i)
            if (static_cast<int>(i) != b.top_input)
              names_left = std::max(names_left, width_of(e.in_text[i], s.caption) + 8);
        if (e.out.size() > 1)
          for (const std::string& text : b.outputs) names_right = std::max(names_right, width_of(text, s.caption) + 8);
        const double names = names_left > 0 || names_right > 0 ? 2 * std::max(names_left, names_right) : 0;
        e.half_width = std::max(s.box_width / 2, (face.width + names) / 2 + s.padding);
        e.half_height = std::max({s.box_height / 2, face.height() / 2 + s.padding - 3,
                                  static_cast<double>(ports) * s.port_gap / 2 + (ports > 1 ? 7 : 0)});
        if (b.top_input >= 0) {
          // The name of what comes from above stands inside, above the face.
          e.half_height += s.top_name / 2;
          e.half_width = std::max(
              e.half_width, width_of(e.in_text[static_cast<std::size_t>(b.top_input)], s.caption) / 2 + s.padding);
        }
        if (b.copies > 1) {
          e.half_width += s.stack;
          e.half_height += s.stack;
        }
        break;
      }
    }
    e.left = e.right = e.half_width;
    e.above = e.below = e.half_height;
    e.out_offset = spread(e.out.size());
    if (b.top_input >= 0 && e.shape == Shape::box) {
      e.in_offset = spread(e.in.size() - 1);
      e.in_offset.insert(e.in_offset.begin() + b.top_input, 0);
    } else {
      e.in_offset = spread(e.in.size());
    }
    for (std::size_t i = 0; i < e.in.size(); ++i)
      if (e.in_side[i] == Side::top || e.in_side[i] == Side::bottom || e.shape == Shape::circle) e.in_offset[i] = 0;
  }

  static std::vector<double> spread(std::size_t count) {
    std::vector<double> result;
    for (std::size_t i = 0; i < count; ++i)
      result.push_back((static_cast<double>(i) - (static_cast<double>(count) - 1) / 2) * sheet_style.port_gap);
    return result;
  }

  void size_frame(Element& e, const SheetBlock& b) {
    const Arrangement& inside = insides_.emplace(e.block, arrange_inside(e)).first->second;
    const double m = sheet_style.frame_margin;
    e.half_width = inside.width / 2 + m;
    e.half_height = inside.height / 2 + m;
    e.left = e.right = e.half_width;
    e.above = e.below = e.half_height;
    e.in_offset.assign(e.in.size(), 0);
    e.out_offset.assign(e.out.size(), 0);
    std::size_t in = 0, out = 0;
    for (std::size_t i = 0; i < b.inside->blocks.size(); ++i) {
      const Shape shape = b.inside->blocks[i].shape;
      if (shape != Shape::input && shape != Shape::output) continue;
      std::vector<double>& offsets = shape == Shape::input ? e.in_offset : e.out_offset;
      std::size_t& next = shape == Shape::input ? in : out;
      for (const PlacedBlock& p : inside.blocks)
        if (p.block == static_cast<int>(i) && next < offsets.size())
          offsets[next] = (p.box.top + p.box.bottom) / 2 - inside.height / 2;
      ++next;
    }
  }

  Arrangement arrange_inside(const Element& e) const;

  void add_captions(Element& e, const SheetBlock& b) const {
    const SheetStyle& s = sheet_style;
    double room = 0, width = 0;
    if (!b.caption.empty()) {
      room += s.caption * 1.35;
      width = width_of(b.caption, s.caption);
    }
    if (!b.note.empty()) {
      room += s.note * 1.35;
      width = std::max(width, width_of(b.note, s.note));
    }
    if (room == 0) return;
    e.caption_above = e.is_above;
    (e.caption_above ? e.above : e.below) += room + 3;
    e.left = std::max(e.left, width / 2 + 4);
    e.right = std::max(e.right, width / 2 + 4);
  }

  // The room for the label of each wire, before the first track of its channel.
  void reserve_labels(Plan& plan) const {
    plan.label_room.assign(plan.channels.size(), 0);
    plan.label_room_right.assign(plan.channels.size(), 0);
    for (const Net& net : web_.nets) {
      if (net.wire < 0) continue;
      const SheetWire& wire = sheet_.wires[static_cast<std::size_t>(net.wire)];
      if (wire.label.empty() && wire.note.empty()) continue;
      const Element& e = web_.elements[static_cast<std::size_t>(net.element)];
      if (e.is_beside()) continue;
      double width = width_of(wire.label, sheet_style.text) + width_of(wire.note, sheet_style.note) + 12;
      width -= (e.is_feedback ? e.left : e.right) - e.half_width;  // what the caption keeps free anyway
      double& room = e.is_feedback ? plan.label_room_right[static_cast<std::size_t>(e.column)]
                                   : plan.label_room[static_cast<std::size_t>(e.column) + 1];
      room = std::max(room, width);
    }
  }

  void place_blocks(const Plan& plan, Arrangement& result) const {
    for (std::size_t i = 0; i < web_.elements.size(); ++i) {
      const Element& e = web_.elements[i];
      const double x = plan.column_x[static_cast<std::size_t>(e.column)], y = plan.items[i].y;
      PlacedBlock placed;
      placed.block = e.block;
      placed.shape = e.shape;
      placed.box = {x - e.half_width, y - e.half_height, x + e.half_width, y + e.half_height};
      placed.is_flipped = placed.is_feedback = e.is_feedback;
      placed.caption_above = e.caption_above;
      for (std::size_t p = 0; p < e.in.size(); ++p) {
        const Side side = e.in_side[p];
        Spot at{x, y + e.in_offset[p]};
        if (side == Side::left) at.x -= e.half_width;
        if (side == Side::right) at.x += e.half_width;
        if (side == Side::top) at.y = y - e.half_height;
        if (side == Side::bottom) at.y = y + e.half_height;
        placed.inputs.push_back({at, side, e.in_text[p]});
      }
      for (std::size_t p = 0; p < e.out.size(); ++p) {
        const Side side = e.is_above ? Side::bottom : e.is_below ? Side::top : e.is_feedback ? Side::left : Side::right;
        Spot at{side == Side::left ? x - e.half_width : x + e.half_width, y};
        if (e.is_beside()) {
          at = {x, side == Side::bottom ? y + e.half_height : y - e.half_height};
        } else {
          at.y += e.out_offset[p];
        }
        placed.outputs.push_back({at, side, e.block >= 0 && p < block(e).outputs.size() ? block(e).outputs[p] : ""});
      }
      result.blocks.push_back(std::move(placed));
      if (e.block >= 0 && block(e).inside) {
        const double m = sheet_style.frame_margin;
        result.frames.push_back(
            {static_cast<int>(i), {x - e.half_width + m, y - e.half_height + m}, insides_.at(e.block)});
      }
    }
    for (const int e : web_.main_path) result.main_path.push_back(e);
  }

  // The top left corner of everything becomes the origin.
  void move_to_origin() {
    double left = 0, top = 0, right = 1, bottom = 1;
    bool first = true;
    const auto cover = [&](Spot s) {
      left = first ? s.x : std::min(left, s.x);
      right = first ? s.x : std::max(right, s.x);
      top = first ? s.y : std::min(top, s.y);
      bottom = first ? s.y : std::max(bottom, s.y);
      first = false;
    };
    for (std::size_t i = 0; i < web_.elements.size(); ++i) {
      const Element& e = web_.elements[i];
      const Box& b = result_.blocks[i].box;
      const double x = (b.left + b.right) / 2, y = (b.top + b.bottom) / 2;
      double end = x + e.right;
      if (e.block < 0) {
        const SheetWire& wire = sheet_.wires[static_cast<std::size_t>(-1 - e.block)];
        end = x + 8 + width_of(wire.result, sheet_style.text);
      }
      cover({x - e.left, y - e.above});
      cover({end, y + e.below});
    }
    for (const PlacedNet& net : result_.nets)
      for (const Curve& line : net.lines)
        for (const Spot s : line) {
          cover({s.x - 3, s.y - 3});
          cover({s.x + 3, s.y + 3});
        }
    const auto move = [&](Spot& s) { s = {s.x - left, s.y - top}; };
    for (PlacedBlock& b : result_.blocks) {
      b.box = {b.box.left - left, b.box.top - top, b.box.right - left, b.box.bottom - top};
      for (PlacedPort& p : b.inputs) move(p.at);
      for (PlacedPort& p : b.outputs) move(p.at);
    }
    for (PlacedNet& net : result_.nets) {
      for (Curve& line : net.lines) std::for_each(line.begin(), line.end(), move);
      std::for_each(net.dots.begin(), net.dots.end(), move);
      for (PlacedArrow& a : net.arrows) move(a.tip);
      move(net.label);
    }
    for (PlacedFrame& f : result_.frames) move(f.origin);
    result_.width = right - left;
    result_.height = bottom - top;
  }

  const Sheet& sheet_;
  const std::vector<SheetHint>& hints_;
  Web web_, best_;
  std::map<int, Arrangement> insides_;  // by block of the sheet
  Arrangement result_;
};

// Left becomes right.
void mirror(Arrangement& a) {
  const auto turn = [&](Spot& s) { s.x = a.width - s.x; };
  const auto swap = [](Side side) {
    return side == Side::left ? Side::right : side == Side::right ? Side::left : side;
  };
  for (PlacedBlock& b : a.blocks) {
    b.box = {a.width - b.box.right, b.box.top, a.width - b.box.left, b.box.bottom};
    b.is_flipped = !b.is_flipped;
    for (auto* ports : {&b.inputs, &b.outputs})
      for (PlacedPort& p : *ports) {
        turn(p.at);
        p.side = swap(p.side);
      }
  }
  for (PlacedNet& net : a.nets) {
    for (Curve& line : net.lines) std::for_each(line.begin(), line.end(), turn);
    std::for_each(net.dots.begin(), net.dots.end(), turn);
    for (PlacedArrow& arrow : net.arrows) {
      turn(arrow.tip);
      arrow.side = swap(arrow.side);
    }
    turn(net.label);
    net.label_leftwards = !net.label_leftwards;
  }
  for (PlacedFrame& f : a.frames) {
    f.origin.x = a.width - f.origin.x - f.inside.width;
    mirror(f.inside);
  }
  std::reverse(a.main_path.begin(), a.main_path.end());
}

Arrangement Arranger::arrange_inside(const Element& e) const {
  Arrangement inside = Arranger(*block(e).inside, hints_, true).run();
  if (e.is_feedback) mirror(inside);
  return inside;
}

}  // namespace

Arrangement arrange(const Sheet& sheet, const std::vector<SheetHint>& hints) {
  return Arranger(sheet, hints, false).run();
}

}  // namespace plantloop
