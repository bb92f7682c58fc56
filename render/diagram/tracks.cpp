// Every vertical line gets a track of its own in its channel; then the pieces of each net are joined to lines.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "render/diagram/web.h"

namespace plantloop {
namespace {

constexpr double same = 0.5;  // heights closer than this are one

// What of one net is connected in one channel.
struct Flow {
  std::vector<const End*> ends;
  double top = 0, bottom = 0;
  bool is_straight = false;
  int level = 0;
  double x = 0;
  // An end that another flow keeps from being reached straight: it is reached from a second track.
  struct Detour {
    const End* end = nullptr;
    int level = 0;
    double x = 0;
  };
  std::vector<Detour> detours;
};

struct Piece {
  Spot a, b;  // a.x <= b.x, a.y <= b.y
};

class Router {
 public:
  Router(const Web& web, Plan& plan, Arrangement& result) : web_(web), plan_(plan), result_(result) {}

  void run() {
    find_flows();
    give_x();
    pieces_.resize(web_.nets.size());
    for (std::size_t c = 0; c < flows_.size(); ++c)
      for (const Flow& flow : flows_[c]) cross_channel(flow, c);
    cross_columns();
    for (std::size_t n = 0; n < web_.nets.size(); ++n) result_.nets.push_back(join(static_cast<int>(n)));
  }

 private:
  const Item& item(int i) const { return plan_.items[static_cast<std::size_t>(i)]; }
  double height(const End& e) const { return item(e.item).y + e.offset; }

  void find_flows() {
    flows_.resize(plan_.channels.size());
    for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
      std::map<int, Flow> by_number;
      for (const End& e : plan_.channels[c]) by_number[e.flow].ends.push_back(&e);
      for (auto& [number, flow] : by_number) {
        flow.top = flow.bottom = height(*flow.ends[0]);
        for (const End* e : flow.ends) {
          flow.top = std::min(flow.top, height(*e));
          flow.bottom = std::max(flow.bottom, height(*e));
        }
        flow.is_straight = flow.bottom - flow.top < same;
        flows_[c].push_back(std::move(flow));
      }
      give_levels(flows_[c]);
    }
  }

  // Must `a` stand left of `b`, so that their horizontal parts do not lie on each other?
  bool must_precede(const Flow& a, const Flow& b) const {
    for (const End* l : a.ends)
      for (const End* r : b.ends)
        if (l->from_left && !r->from_left && std::abs(height(*l) - height(*r)) < 8) return true;
    return false;
  }

  // How many crossings it costs to have `a` left of `b`.
  int cost(const Flow& a, const Flow& b) const {
    int count = 0;
    for (const End* e : b.ends)
      if (e->from_left && height(*e) > a.top && height(*e) < a.bottom) ++count;
    for (const End* e : a.ends)
      if (!e->from_left && height(*e) > b.top && height(*e) < b.bottom) ++count;
    return count;
  }

  void give_levels(std::vector<Flow>& flows) {
    std::vector<Flow*> open, placed;
    for (Flow& f : flows)
      if (!f.is_straight) open.push_back(&f);
    while (!open.empty()) {
      // The one that costs the least to stand left of all others.
      std::size_t best = 0;
      long least = std::numeric_limits<long>::max();
      for (std::size_t i = 0; i < open.size(); ++i) {
        long sum = 0;
        for (std::size_t j = 0; j < open.size(); ++j) {
          if (i == j) continue;
          if (must_precede(*open[j], *open[i])) sum += 1000;
          sum += cost(*open[i], *open[j]) - cost(*open[j], *open[i]);
        }
        if (sum < least) {
          least = sum;
          best = i;
        }
      }
      Flow* f = open[best];
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(best));
      for (const Flow* before : placed) {
        const bool meet = before->top < f->bottom + 10 && f->top < before->bottom + 10;
        if (meet || must_precede(*before, *f)) f->level = std::max(f->level, before->level + 1);
      }
      placed.push_back(f);
    }
    // Where two flows would each have to stand left of the other, the left one goes round the right one.
    for (std::size_t i = 0; i < placed.size(); ++i)
      for (std::size_t j = i + 1; j < placed.size(); ++j)
        for (const End* r : placed[i]->ends)
          for (const End* l : placed[j]->ends) {
            if (r->from_left || !l->from_left || std::abs(height(*r) - height(*l)) >= 8) continue;
            int level = 0;
            for (const Flow* f : placed) {
              level = std::max(level, f->level + 1);
              for (const Flow::Detour& d : f->detours) level = std::max(level, d.level + 1);
            }
            placed[i]->detours.push_back({r, level, 0});
          }
  }

  void give_x() {
    const std::size_t columns = plan_.columns.size();
    std::vector<double> left(columns, 0), right(columns, 0);
    for (const Item& i : plan_.items) {
      if (i.kind != Item::Kind::element) continue;
      const Element& e = web_.elements[static_cast<std::size_t>(i.element)];
      const auto c = static_cast<std::size_t>(i.column);
      left[c] = std::max(left[c], e.left);
      right[c] = std::max(right[c], e.right);
    }
    plan_.column_x.assign(columns, 0);
    plan_.channel_left.assign(columns + 1, 0);
    plan_.channel_right.assign(columns + 1, 0);
    double x = 0;
    for (std::size_t c = 0; c <= columns; ++c) {
      int levels = 0;
      bool used = false;
      for (const Flow& f : flows_[c]) {
        used = true;
        if (!f.is_straight) levels = std::max(levels, f.level + 1);
        for (const Flow::Detour& d : f.detours) levels = std::max(levels, d.level + 1);
      }
      plan_.channel_left[c] = x;
      double width = 0;
      if (levels > 0) {
        width = plan_.label_room[c] + sheet_style.stub + (levels - 1) * sheet_style.track_gap +
                std::max(sheet_style.stub, plan_.label_room_right[c] + 8);
      } else if (used) {
        width =
            std::max(plan_.label_room[c] + plan_.label_room_right[c] + sheet_style.arrow + 4, 1.6 * sheet_style.stub);
      } else if (c > 0 && c < columns) {
        width = sheet_style.stub;
      }
      // Tracks stand to the right of the labels, arrows to the right of the tracks.
      for (Flow& f : flows_[c]) {
        const auto x_of = [&](int level) {
          return x + plan_.label_room[c] + sheet_style.stub + level * sheet_style.track_gap;
        };
        f.x = x_of(f.level);
        for (Flow::Detour& d : f.detours) d.x = x_of(d.level);
      }
      x += width;
      plan_.channel_right[c] = x;
      if (c < columns) {
        plan_.column_x[c] = x + left[c];
        x += left[c] + right[c];
      }
    }
    result_.width = x;
  }

  double edge_x(const End& e, std::size_t c) const {
    const Item& i = item(e.item);
    if (i.kind == Item::Kind::pass) return e.from_left ? plan_.channel_left[c] : plan_.channel_right[c];
    const double centre = plan_.column_x[static_cast<std::size_t>(i.column)];
    if (i.kind == Item::Kind::corner) return centre;
    const double half = web_.elements[static_cast<std::size_t>(i.element)].half_width;
    return e.from_left ? centre + half : centre - half;
  }

  void add(int net, Spot a, Spot b) {
    if (std::abs(a.x - b.x) < 1e-9 && std::abs(a.y - b.y) < 1e-9) return;
    if (a.x > b.x || a.y > b.y) std::swap(a, b);
    pieces_[static_cast<std::size_t>(net)].push_back({a, b});
  }

  void cross_channel(const Flow& flow, std::size_t c) {
    const int net = flow.ends[0]->net;
    if (flow.is_straight) {
      double from = std::numeric_limits<double>::infinity(), until = -from;
      const double y = height(*flow.ends[0]);
      for (const End* e : flow.ends) {
        from = std::min(from, edge_x(*e, c));
        until = std::max(until, edge_x(*e, c));
      }
      add(net, {from, y}, {until, y});
      return;
    }
    for (const End* e : flow.ends) {
      const auto detour =
          std::find_if(flow.detours.begin(), flow.detours.end(), [&](const Flow::Detour& d) { return d.end == e; });
      const double y = height(*e);
      if (detour == flow.detours.end()) {
        add(net, {edge_x(*e, c), y}, {flow.x, y});
        continue;
      }
      const double beside = y + ((flow.top + flow.bottom) / 2 > y ? 11 : -11);
      add(net, {flow.x, beside}, {detour->x, beside});
      add(net, {detour->x, beside}, {detour->x, y});
      add(net, {detour->x, y}, {edge_x(*e, c), y});
    }
    double top = flow.bottom, bottom = flow.top;
    for (const End* e : flow.ends) {
      double y = height(*e);
      if (std::any_of(flow.detours.begin(), flow.detours.end(), [&](const Flow::Detour& d) { return d.end == e; }))
        y += (flow.top + flow.bottom) / 2 > y ? 11 : -11;
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
    add(net, {flow.x, top}, {flow.x, bottom});
  }

  void cross_columns() {
    for (const Item& i : plan_.items) {
      const auto c = static_cast<std::size_t>(i.column);
      if (i.kind == Item::Kind::pass) add(i.net, {plan_.channel_right[c], i.y}, {plan_.channel_left[c + 1], i.y});
      if (i.kind == Item::Kind::corner) {
        const double y = item(i.element).y, r = web_.elements[static_cast<std::size_t>(i.element)].half_height;
        add(i.net, {plan_.column_x[c], i.y}, {plan_.column_x[c], i.from_above ? y - r : y + r});
      }
      if (i.kind != Item::Kind::element) continue;
      const Element& e = web_.elements[static_cast<std::size_t>(i.element)];
      if (!e.is_beside()) continue;
      const Net& net = web_.nets[static_cast<std::size_t>(e.out[0])];
      const Element& to = web_.elements[static_cast<std::size_t>(net.sinks[0].element)];
      const double sign = e.is_above ? 1 : -1;
      add(e.out[0], {plan_.column_x[c], i.y + sign * e.half_height},
          {plan_.column_x[c], item(net.sinks[0].element).y - sign * to.half_height});
    }
  }

  Spot port_of(int element, Side side, double offset) const {
    const Element& e = web_.elements[static_cast<std::size_t>(element)];
    const double x = plan_.column_x[static_cast<std::size_t>(e.column)], y = item(element).y;
    switch (side) {
      case Side::left:
        return {x - e.half_width, y + offset};
      case Side::right:
        return {x + e.half_width, y + offset};
      case Side::top:
        return {x, y - e.half_height};
      default:
        return {x, y + e.half_height};
    }
  }

  // A point by its place in hundredths of a pixel, so that equal points are equal.
  using Key = std::pair<long, long>;
  static Key key_of(Spot s) { return {std::lround(s.x * 100), std::lround(s.y * 100)}; }

  struct Knot {
    Spot at;
    std::set<Key> next;
  };

  // The pieces of a net as a graph of points: overlapping pieces are merged, and cut wherever another one ends or
  // turns.
  std::map<Key, Knot> knots_of(int n) const {
    const std::vector<Piece>& pieces = pieces_[static_cast<std::size_t>(n)];
    std::vector<Spot> spots;
    for (const Piece& p : pieces) {
      spots.push_back(p.a);
      spots.push_back(p.b);
      for (const Piece& q : pieces)
        if (is_level(p) != is_level(q)) {
          const Piece &h = is_level(p) ? p : q, &v = is_level(p) ? q : p;
          if (h.a.x <= v.a.x && v.a.x <= h.b.x && v.a.y <= h.a.y && h.a.y <= v.b.y && touches(h, v))
            spots.push_back({v.a.x, h.a.y});
        }
    }
    std::map<Key, Knot> knots;
    for (const Piece& p : pieces) {
      std::map<Key, Spot> on;
      for (const Spot s : spots)
        if (s.x >= p.a.x - 1e-6 && s.x <= p.b.x + 1e-6 && s.y >= p.a.y - 1e-6 && s.y <= p.b.y + 1e-6)
          on.emplace(key_of(s), s);
      const std::pair<const Key, Spot>* before = nullptr;
      for (const auto& entry : on) {
        knots[entry.first].at = entry.second;
        if (before != nullptr) {
          knots[before->first].next.insert(entry.first);
          knots[entry.first].next.insert(before->first);
        }
        before = &entry;
      }
    }
    return knots;
  }

  static bool is_level(const Piece& p) { return std::abs(p.a.y - p.b.y) < 1e-9; }
  // Two pieces of one net that cross are joined only where one of them ends: the others are ways that cross themselves.
  static bool touches(const Piece& h, const Piece& v) {
    const auto near = [](double a, double b) { return std::abs(a - b) < 1e-6; };
    return near(v.a.x, h.a.x) || near(v.a.x, h.b.x) || near(h.a.y, v.a.y) || near(h.a.y, v.b.y);
  }

  PlacedNet join(int n) {
    const Net& net = web_.nets[static_cast<std::size_t>(n)];
    PlacedNet placed;
    placed.wire = net.wire;
    const std::map<Key, Knot> knots = knots_of(n);
    const auto is_through = [&](const Knot& k) { return k.next.size() == 2; };
    // Lines from knot to knot; on the way through simple points.
    std::set<std::pair<Key, Key>> done;
    for (const auto& [key, knot] : knots) {
      if (is_through(knot)) continue;
      if (knot.next.size() > 2) placed.dots.push_back(knot.at);
      for (const Key& first : knot.next) {
        if (done.contains({key, first})) continue;
        Curve line{knot.at};
        Key at = key, to = first;
        for (;;) {
          done.insert({at, to});
          done.insert({to, at});
          const Knot& next = knots.at(to);
          line.push_back(next.at);
          if (!is_through(next)) break;
          const Key onwards = *next.next.begin() == at ? *next.next.rbegin() : *next.next.begin();
          at = to;
          to = onwards;
        }
        placed.lines.push_back(simplified(line));
      }
    }
    const Element& from = web_.elements[static_cast<std::size_t>(net.element)];
    const Side out = from.is_above      ? Side::bottom
                     : from.is_below    ? Side::top
                     : from.is_feedback ? Side::left
                                        : Side::right;
    const Spot start =
        port_of(net.element, out, from.is_beside() ? 0 : from.out_offset[static_cast<std::size_t>(net.port)]);
    for (const Sink& s : net.sinks) {
      const Element& e = web_.elements[static_cast<std::size_t>(s.element)];
      const Side side = e.in_side[static_cast<std::size_t>(s.port)];
      const Spot tip = port_of(s.element, side, e.in_offset[static_cast<std::size_t>(s.port)]);
      placed.arrows.push_back({tip, side, s.element});
      placed.bends.push_back(bends(knots, key_of(start), key_of(tip)));
    }
    placed.label_leftwards = from.is_feedback;
    placed.label = {start.x + (from.is_feedback ? -6.0 : 6.0), start.y - 7};
    return placed;
  }

  static Curve simplified(const Curve& line) {
    Curve result{line.front()};
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
      const Spot a = result.back(), b = line[i], c = line[i + 1];
      const bool straight = (std::abs(a.x - b.x) < 1e-6 && std::abs(b.x - c.x) < 1e-6) ||
                            (std::abs(a.y - b.y) < 1e-6 && std::abs(b.y - c.y) < 1e-6);
      if (!straight) result.push_back(b);
    }
    result.push_back(line.back());
    return result;
  }

  // Of the way with the fewest points; -1 when there is none.
  static int bends(const std::map<Key, Knot>& knots, Key from, Key to) {
    if (!knots.contains(from) || !knots.contains(to)) return -1;
    std::map<Key, Key> before{{from, from}};
    std::vector<Key> open{from};
    for (std::size_t i = 0; i < open.size() && !before.contains(to); ++i)
      for (const Key& next : knots.at(open[i]).next)
        if (before.emplace(next, open[i]).second) open.push_back(next);
    if (!before.contains(to)) return -1;
    int count = 0;
    for (Key at = to; before.at(at) != at;) {
      const Key previous = before.at(at), earlier = before.at(previous);
      if (earlier != previous && (earlier.first == previous.first) != (previous.first == at.first)) ++count;
      at = previous;
    }
    return count;
  }

  const Web& web_;
  Plan& plan_;
  Arrangement& result_;
  std::vector<std::vector<Flow>> flows_;
  std::vector<std::vector<Piece>> pieces_;
};

}  // namespace

void route(const Web& web, Plan& plan, Arrangement& arrangement) { Router(web, plan, arrangement).run(); }

}  // namespace plantloop
