// Every connection as pieces between neighbouring columns, and the order of what stands in a column.

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "render/diagram/web.h"

namespace plantloop {
namespace {

class Pieces {
 public:
  explicit Pieces(const Web& web) : web_(web) {
    plan_.columns.resize(static_cast<std::size_t>(web.columns));
    plan_.channels.resize(static_cast<std::size_t>(web.columns) + 1);
  }

  Plan run() {
    for (std::size_t e = 0; e < web_.elements.size(); ++e) {
      const Element& element = web_.elements[e];
      add({.kind = Item::Kind::element,
           .element = static_cast<int>(e),
           .is_lane = element.is_feedback,
           .column = element.column,
           .above = element.above,
           .below = element.below});
    }
    for (std::size_t n = 0; n < web_.nets.size(); ++n)
      for (const Sink& sink : web_.nets[n].sinks) connect(static_cast<int>(n), sink);
    return std::move(plan_);
  }

 private:
  int add(Item item) {
    const int index = static_cast<int>(plan_.items.size());
    plan_.columns[static_cast<std::size_t>(item.column)].push_back(index);
    plan_.items.push_back(item);
    return index;
  }

  void connect(int n, const Sink& sink) {
    const Net& net = web_.nets[static_cast<std::size_t>(n)];
    const Element &u = web_.elements[static_cast<std::size_t>(net.element)],
                  &v = web_.elements[static_cast<std::size_t>(sink.element)];
    if (u.is_beside()) return;  // a straight line down or up
    const bool lane = sink.is_back || u.is_feedback || v.is_feedback;
    const int start = u.column + (u.is_feedback ? 0 : 1);
    const Side side = v.in_side[static_cast<std::size_t>(sink.port)];
    End last{.net = n, .port = sink.port};
    int end = 0;
    if (side == Side::left || side == Side::right) {
      last.item = sink.element;
      last.offset = v.in_offset[static_cast<std::size_t>(sink.port)];
      last.from_left = side == Side::right;
      end = v.column + (last.from_left ? 1 : 0);
    } else {
      last.item = add({.kind = Item::Kind::corner,
                       .element = sink.element,
                       .net = n,
                       .is_lane = lane,
                       .from_above = side == Side::top,
                       .column = v.column});
      last.port = -1;
      last.from_left = start > v.column;
      end = v.column + (last.from_left ? 1 : 0);
    }
    put(start, lane,
        {.net = n,
         .item = net.element,
         .offset = u.out_offset[static_cast<std::size_t>(net.port)],
         .from_left = !u.is_feedback,
         .is_source = true});
    for (int c = start; c < end; ++c) {
      const int pass = pass_of(n, lane, c);
      put(c, lane, {.net = n, .item = pass});
      put(c + 1, lane, {.net = n, .item = pass, .from_left = true});
    }
    for (int c = start - 1; c >= end; --c) {
      const int pass = pass_of(n, lane, c);
      put(c + 1, lane, {.net = n, .item = pass, .from_left = true});
      put(c, lane, {.net = n, .item = pass});
    }
    put(end, lane, last);
  }

  int pass_of(int net, bool lane, int column) {
    const auto [it, is_new] = passes_.try_emplace(std::tuple(net, lane, column), 0);
    if (is_new) it->second = add({.kind = Item::Kind::pass, .net = net, .is_lane = lane, .column = column});
    return it->second;
  }

  // Where a net begins, all of its ways are connected.
  void put(int channel, bool lane, End end) {
    const Net& net = web_.nets[static_cast<std::size_t>(end.net)];
    const Element& u = web_.elements[static_cast<std::size_t>(net.element)];
    const bool at_source = channel == u.column + (u.is_feedback ? 0 : 1);
    end.flow = 2 * end.net + (lane && !at_source ? 1 : 0);
    std::vector<End>& ends = plan_.channels[static_cast<std::size_t>(channel)];
    const bool known = std::any_of(ends.begin(), ends.end(), [&](const End& e) {
      return e.flow == end.flow && e.item == end.item && e.port == end.port && e.from_left == end.from_left &&
             e.is_source == end.is_source;
    });
    if (!known) ends.push_back(end);
  }

  const Web& web_;
  Plan plan_;
  std::map<std::tuple<int, bool, int>, int> passes_;
};

// A circle with its corners and the source above it, or any other item: what keeps together in a column.
struct Unit {
  std::vector<int> items;
  double place = 0;
  int tie = 0;
};

class Order {
 public:
  Order(const Web& web, Plan& plan) : web_(web), plan_(plan), place_(plan.items.size(), 0) {}

  void run() {
    find_path_numbers();
    make_units();
    std::vector<std::vector<Unit>> best = units_;
    write();
    int least = crossings();
    for (int sweep = 0; sweep < 12 && least > 0; ++sweep) {
      const int n = static_cast<int>(units_.size());
      if (sweep % 2 == 0) {
        for (int c = 1; c < n; ++c) sort_column(c, true);
      } else {
        for (int c = n - 2; c >= 0; --c) sort_column(c, false);
      }
      write();
      if (const int count = crossings(); count < least) {
        least = count;
        best = units_;
      }
    }
    units_ = std::move(best);
    write();
    add_lanes();
  }

 private:
  const Item& item(int i) const { return plan_.items[static_cast<std::size_t>(i)]; }

  // The main path is 0; every further element takes the number of the way by which it is found from there.
  void find_path_numbers() {
    const std::size_t n = web_.elements.size();
    path_.assign(n, -1);
    std::vector<int> queue;
    for (const int e : web_.main_path) {
      path_[static_cast<std::size_t>(e)] = 0;
      queue.push_back(e);
    }
    int next = 1;
    for (std::size_t done = 0, start = 0; done < n;) {
      for (; done < queue.size(); ++done) {
        const Element& e = web_.elements[static_cast<std::size_t>(queue[done])];
        const auto visit = [&](int other) {
          if (path_[static_cast<std::size_t>(other)] >= 0) return;
          path_[static_cast<std::size_t>(other)] = next++;
          queue.push_back(other);
        };
        for (const int net : e.in)
          if (net >= 0) visit(web_.nets[static_cast<std::size_t>(net)].element);
        for (const int net : e.out)
          if (net >= 0)
            for (const Sink& s : web_.nets[static_cast<std::size_t>(net)].sinks) visit(s.element);
      }
      while (start < n && path_[start] >= 0) ++start;
      if (start == n) break;
      path_[start] = next++;
      queue.push_back(static_cast<int>(start));
    }
  }

  int tie_of(int i) const {
    const Item& it = item(i);
    if (it.kind == Item::Kind::element) return path_[static_cast<std::size_t>(it.element)];
    int least = 1 << 20;
    for (const Sink& s : web_.nets[static_cast<std::size_t>(it.net)].sinks)
      least = std::min(least, path_[static_cast<std::size_t>(s.element)]);
    return std::max(least, path_[static_cast<std::size_t>(web_.nets[static_cast<std::size_t>(it.net)].element)]);
  }

  void make_units() {
    units_.resize(plan_.columns.size());
    for (std::size_t c = 0; c < plan_.columns.size(); ++c) {
      std::vector<int> above, below, plain;
      for (const int i : plan_.columns[c]) {
        const Item& it = item(i);
        if (it.kind == Item::Kind::corner) {
          const bool attached = !web_.elements[static_cast<std::size_t>(it.element)].is_feedback;
          if (attached) continue;  // comes with its circle
          continue;
        }
        if (it.kind == Item::Kind::element && web_.elements[static_cast<std::size_t>(it.element)].is_beside()) continue;
        if (it.is_lane) continue;
        plain.push_back(i);
      }
      for (const int i : plain) units_[c].push_back({with_company(i), 0, tie_of(i)});
      std::stable_sort(units_[c].begin(), units_[c].end(), [this](const Unit& a, const Unit& b) {
        return web_.branches_first ? a.tie > b.tie : a.tie < b.tie;
      });
    }
  }

  // The item with everything that stands straight above and below it.
  std::vector<int> with_company(int i) const {
    const Item& it = item(i);
    std::vector<int> above, below;
    if (it.kind == Item::Kind::element)
      for (int other = 0; other < static_cast<int>(plan_.items.size()); ++other) {
        const Item& o = item(other);
        if (o.column != it.column) continue;
        if (o.kind == Item::Kind::corner && o.element == it.element) (o.from_above ? above : below).push_back(other);
        if (o.kind == Item::Kind::element && web_.elements[static_cast<std::size_t>(o.element)].is_beside()) {
          const Element& source = web_.elements[static_cast<std::size_t>(o.element)];
          if (web_.nets[static_cast<std::size_t>(source.out[0])].sinks[0].element == it.element)
            (source.is_above ? above : below).push_back(other);
        }
      }
    std::vector<int> all = above;
    all.push_back(i);
    all.insert(all.end(), below.begin(), below.end());
    return all;
  }

  void write() {
    for (std::size_t c = 0; c < units_.size(); ++c) {
      plan_.columns[c].clear();
      for (const Unit& unit : units_[c])
        for (const int i : unit.items) {
          place_[static_cast<std::size_t>(i)] = static_cast<double>(plan_.columns[c].size());
          plan_.columns[c].push_back(i);
        }
    }
  }

  // Ports of an element follow each other within its place.
  double place_of(const End& end) const { return place_[static_cast<std::size_t>(end.item)] + end.offset / 2000; }
  bool is_lane(const End& end) const { return item(end.item).is_lane; }

  void sort_column(int c, bool from_left) {
    const std::vector<End>& ends = plan_.channels[static_cast<std::size_t>(from_left ? c : c + 1)];
    for (Unit& unit : units_[static_cast<std::size_t>(c)]) {
      double sum = 0;
      int count = 0;
      for (const End& mine : ends) {
        if (mine.from_left == from_left ||
            std::find(unit.items.begin(), unit.items.end(), mine.item) == unit.items.end() || is_lane(mine))
          continue;
        for (const End& other : ends)
          if (other.flow == mine.flow && other.from_left == from_left && !is_lane(other)) {
            // A way into the circle's side counts more than one from above or below.
            const int weight = item(mine.item).kind == Item::Kind::corner ? 1 : 2;
            sum += weight * (place_of(other) - mine.offset / 2000);
            count += weight;
          }
      }
      unit.place = count > 0 ? sum / count : place_[static_cast<std::size_t>(unit.items.front())];
    }
    std::stable_sort(units_[static_cast<std::size_t>(c)].begin(), units_[static_cast<std::size_t>(c)].end(),
                     [](const Unit& a, const Unit& b) {
                       return std::abs(a.place - b.place) > 1e-9 ? a.place < b.place : a.tie < b.tie;
                     });
    plan_.columns[static_cast<std::size_t>(c)].clear();
    for (const Unit& unit : units_[static_cast<std::size_t>(c)])
      for (const int i : unit.items) {
        place_[static_cast<std::size_t>(i)] = static_cast<double>(plan_.columns[static_cast<std::size_t>(c)].size());
        plan_.columns[static_cast<std::size_t>(c)].push_back(i);
      }
  }

  int crossings() const {
    int count = 0;
    for (const std::vector<End>& ends : plan_.channels) {
      std::vector<std::tuple<double, double, int>> lines;
      for (const End& l : ends)
        for (const End& r : ends)
          if (l.from_left && !r.from_left && l.flow == r.flow && !is_lane(l) && !is_lane(r))
            lines.emplace_back(place_of(l), place_of(r), l.net);
      for (std::size_t i = 0; i < lines.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
          const auto& [a, b, m] = lines[i];
          const auto& [x, y, n] = lines[j];
          if (m != n && (a - x) * (b - y) < 0) ++count;
        }
    }
    return count;
  }

  // What leads back, below everything else: the shorter its way the higher.
  void add_lanes() {
    std::vector<int> group(plan_.items.size());
    std::iota(group.begin(), group.end(), 0);
    const auto find = [&](int i) {
      while (group[static_cast<std::size_t>(i)] != i) i = group[static_cast<std::size_t>(i)];
      return i;
    };
    const auto join = [&](int i, int j) {
      const int a = find(i), b = find(j);
      group[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    };
    const auto is_free = [&](int i) {
      return item(i).is_lane && !(item(i).kind == Item::Kind::corner && !in_lanes(i));
    };
    for (const std::vector<End>& ends : plan_.channels)
      for (const End& a : ends)
        for (const End& b : ends)
          if (a.flow == b.flow && is_free(a.item) && is_free(b.item)) join(a.item, b.item);
    for (std::size_t i = 0; i < plan_.items.size(); ++i) {
      const Item& it = plan_.items[i];
      if (it.kind != Item::Kind::corner || !in_lanes(static_cast<int>(i))) continue;
      join(static_cast<int>(i), it.element);
    }
    std::map<int, std::pair<int, int>> span;
    for (std::size_t i = 0; i < plan_.items.size(); ++i) {
      if (!is_free(static_cast<int>(i))) continue;
      const int c = item(static_cast<int>(i)).column;
      const auto [it, is_new] = span.try_emplace(find(static_cast<int>(i)), c, c);
      it->second = {std::min(it->second.first, c), std::max(it->second.second, c)};
    }
    // Groups in rising order of their spans; each lies below what its loop is made of, and below the groups before it
    // that it meets.
    std::map<std::tuple<int, int>, std::vector<int>> groups;
    for (std::size_t i = 0; i < plan_.items.size(); ++i) {
      const int lane = static_cast<int>(i);
      if (!is_free(lane) || item(lane).kind == Item::Kind::corner) continue;
      const auto [from, until] = span.at(find(lane));
      groups[{until - from, find(lane)}].push_back(lane);
    }
    std::vector<PlacedLanes> placed;
    for (auto& [key, lanes] : groups) {
      placed.push_back({{}, lanes});
      std::vector<char> loop(plan_.items.size(), 0);
      mark_loops(placed, loop);
      std::sort(lanes.begin(), lanes.end(), [&](int a, int b) {
        return std::tuple(lane_length(item(a)), item(a).kind != Item::Kind::element, a) <
               std::tuple(lane_length(item(b)), item(b).kind != Item::Kind::element, b);
      });
      for (const int lane : lanes) {
        std::vector<int>& column = plan_.columns[static_cast<std::size_t>(item(lane).column)];
        auto at = column.end();
        while (at != column.begin() && !loop[static_cast<std::size_t>(*(at - 1))]) --at;
        if (at == column.begin()) at = column.end();
        const std::vector<int> company = with_company(lane);
        for (const int i : company) loop[static_cast<std::size_t>(i)] = 1;
        placed.back().items.insert(placed.back().items.end(), company.begin(), company.end());
        column.insert(at, company.begin(), company.end());
      }
    }
  }

  // A group of lanes, with the elements that they connect to.
  struct PlacedLanes {
    std::vector<int> ends;   // elements of the forward paths
    std::vector<int> lanes;  // passes and elements
    std::vector<int> items;  // the lanes with corners
  };

  // The items on the ways from where the last group of lanes leads to where it comes from, and the groups inside.
  void mark_loops(std::vector<PlacedLanes>& groups, std::vector<char>& loop) const {
    std::vector<int> heads, tails;
    const auto look_at = [&](const Net& net) {
      if (!web_.elements[static_cast<std::size_t>(net.element)].is_feedback) tails.push_back(net.element);
      for (const Sink& s : net.sinks)
        if ((s.is_back || web_.elements[static_cast<std::size_t>(net.element)].is_feedback) &&
            !web_.elements[static_cast<std::size_t>(s.element)].is_feedback)
          heads.push_back(s.element);
    };
    for (const int i : groups.back().lanes) {
      const Item& it = item(i);
      if (it.net >= 0) look_at(web_.nets[static_cast<std::size_t>(it.net)]);
      if (it.kind != Item::Kind::element) continue;
      const Element& e = web_.elements[static_cast<std::size_t>(it.element)];
      for (const auto* ports : {&e.in, &e.out})
        for (const int net : *ports)
          if (net >= 0) look_at(web_.nets[static_cast<std::size_t>(net)]);
    }
    groups.back().ends = heads;
    groups.back().ends.insert(groups.back().ends.end(), tails.begin(), tails.end());
    const std::vector<char> down = reach(heads, true), up = reach(tails, false);
    const auto in_loop = [&](int e) { return down[static_cast<std::size_t>(e)] && up[static_cast<std::size_t>(e)]; };
    for (std::size_t i = 0; i < plan_.items.size(); ++i) {
      const Item& it = plan_.items[i];
      if (it.kind == Item::Kind::pass) {
        if (it.is_lane) continue;
        const Net& net = web_.nets[static_cast<std::size_t>(it.net)];
        if (in_loop(net.element) && std::any_of(net.sinks.begin(), net.sinks.end(),
                                                [&](const Sink& s) { return !s.is_back && in_loop(s.element); }))
          loop[i] = 1;
      } else if (in_loop(it.element)) {
        loop[i] = 1;
      }
    }
    for (const PlacedLanes& group : groups)
      if (std::any_of(group.ends.begin(), group.ends.end(), in_loop))
        for (const int i : group.items) loop[static_cast<std::size_t>(i)] = 1;
  }

  // Forward elements that are reached from these without going back, down or up the signals.
  std::vector<char> reach(std::vector<int> open, bool down) const {
    std::vector<char> seen(web_.elements.size(), 0);
    while (!open.empty()) {
      const int e = open.back();
      open.pop_back();
      if (seen[static_cast<std::size_t>(e)] || web_.elements[static_cast<std::size_t>(e)].is_feedback) continue;
      seen[static_cast<std::size_t>(e)] = 1;
      const Element& element = web_.elements[static_cast<std::size_t>(e)];
      for (const int n : down ? element.out : element.in) {
        if (n < 0) continue;
        const Net& net = web_.nets[static_cast<std::size_t>(n)];
        for (const Sink& s : net.sinks) {
          if (s.is_back || (!down && s.element != e)) continue;
          open.push_back(down ? s.element : net.element);
        }
      }
    }
    return seen;
  }

  // A corner of a circle that itself leads back.
  bool in_lanes(int corner) const { return web_.elements[static_cast<std::size_t>(item(corner).element)].is_feedback; }

  // How far a net, or what an element gives, goes back.
  int lane_length(const Item& it) const {
    const int n = it.net >= 0 ? it.net : web_.elements[static_cast<std::size_t>(it.element)].out[0];
    if (n < 0) return 0;
    const Net& net = web_.nets[static_cast<std::size_t>(n)];
    int length = 0;
    for (const Sink& s : net.sinks)
      length = std::max(length, std::abs(web_.elements[static_cast<std::size_t>(net.element)].column -
                                         web_.elements[static_cast<std::size_t>(s.element)].column));
    return length;
  }

  const Web& web_;
  Plan& plan_;
  std::vector<double> place_;
  std::vector<int> path_;
  std::vector<std::vector<Unit>> units_;
};

}  // namespace

Plan make_plan(const Web& web) { return Pieces(web).run(); }

void order_columns(const Web& web, Plan& plan) { Order(web, plan).run(); }

}  // namespace plantloop
