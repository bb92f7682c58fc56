// A column for every element: as far left as its inputs allow, sources beside their readers, what leads back in the
// middle of its way.

#include <algorithm>
#include <limits>
#include <numeric>

#include "render/diagram/web.h"

namespace plantloop {
namespace {

using Shape = SheetBlock::Shape;

class Columns {
 public:
  explicit Columns(Web& web) : web_(web), after_(web.elements.size()), before_(web.elements.size()) {}

  void run() {
    find_sources_beside();
    constrain_forward();
    constrain_feedback();
    pack_left();
    find_main_path();
    pull_sources();
    centre_feedback();
    for (const int e : order_) {
      Element& x = element(e);
      if (x.is_feedback || on_main_path(e) || after_[static_cast<std::size_t>(e)].empty()) continue;
      if (web_.is_framed && x.shape == Shape::input) continue;
      x.first_column = x.column;
      x.last_column = highest(e);
    }
    for (Element& e : web_.elements)
      if (e.is_beside()) e.column = element(reader_of(e)).column;
    web_.columns = 0;
    for (const Element& e : web_.elements) web_.columns = std::max(web_.columns, e.column + 1);
  }

 private:
  struct Constraint {
    int other = 0;
    int least = 0;  // columns between
  };

  Element& element(int e) { return web_.elements[static_cast<std::size_t>(e)]; }
  int reader_of(const Element& source) const {
    return web_.nets[static_cast<std::size_t>(source.out[0])].sinks[0].element;
  }

  // A source that only feeds the top or bottom of a circle stands straight above or below it.
  void find_sources_beside() {
    for (Element& e : web_.elements) {
      const bool is_source = std::all_of(e.in.begin(), e.in.end(), [](int n) { return n < 0; });
      if (!is_source || e.out.size() != 1 || e.out[0] < 0 || e.is_feedback || e.shape == Shape::circle) continue;
      if (web_.is_framed && e.shape == Shape::input) continue;
      const Net& net = web_.nets[static_cast<std::size_t>(e.out[0])];
      if (net.sinks.size() != 1) continue;
      const Element& to = element(net.sinks[0].element);
      if (to.is_feedback) continue;
      const Side side = to.in_side[static_cast<std::size_t>(net.sinks[0].port)];
      e.is_above = side == Side::top;
      e.is_below = side == Side::bottom;
    }
  }

  void add(int left, int right, int least) {
    after_[static_cast<std::size_t>(left)].push_back({right, least});
    before_[static_cast<std::size_t>(right)].push_back({left, least});
  }

  bool reaches(int from, int to) const {
    std::vector<int> open{from};
    std::vector<char> seen(after_.size(), 0);
    while (!open.empty()) {
      const int e = open.back();
      open.pop_back();
      if (e == to) return true;
      if (seen[static_cast<std::size_t>(e)]) continue;
      seen[static_cast<std::size_t>(e)] = 1;
      for (const Constraint& c : after_[static_cast<std::size_t>(e)]) open.push_back(c.other);
    }
    return false;
  }

  void add_if_possible(int left, int right, int least) {
    if (left != right && !reaches(right, left)) add(left, right, least);
  }

  void constrain_forward() {
    for (const Net& net : web_.nets)
      for (const Sink& s : net.sinks) {
        const Element &u = element(net.element), &v = element(s.element);
        if (!s.is_back && !u.is_feedback && !v.is_feedback && !u.is_beside()) add(net.element, s.element, 1);
      }
  }

  void constrain_feedback() {
    for (const Net& net : web_.nets)
      for (const Sink& s : net.sinks) {
        const Element &u = element(net.element), &v = element(s.element);
        if (u.is_feedback && v.is_feedback && !s.is_back) add_if_possible(s.element, net.element, 1);
      }
    for (const Net& net : web_.nets)
      for (const Sink& s : net.sinks) {
        const Element &u = element(net.element), &v = element(s.element);
        if (u.is_feedback && !v.is_feedback) add_if_possible(s.element, net.element, v.shape == Shape::circle ? 1 : 0);
      }
    for (const Net& net : web_.nets)
      for (const Sink& s : net.sinks) {
        const Element &u = element(net.element), &v = element(s.element);
        if (!u.is_feedback && v.is_feedback) add_if_possible(s.element, net.element, 0);
      }
  }

  // Elements so that every one stands behind those that it needs.
  std::vector<int> sorted() const {
    std::vector<int> waiting(after_.size(), 0), order;
    for (std::size_t e = 0; e < after_.size(); ++e) waiting[e] = static_cast<int>(before_[e].size());
    for (std::size_t e = 0; e < after_.size(); ++e)
      if (waiting[e] == 0) order.push_back(static_cast<int>(e));
    for (std::size_t i = 0; i < order.size(); ++i)
      for (const Constraint& c : after_[static_cast<std::size_t>(order[i])])
        if (--waiting[static_cast<std::size_t>(c.other)] == 0) order.push_back(c.other);
    return order;
  }

  void pack_left() {
    order_ = sorted();
    for (const int e : order_)
      for (const Constraint& c : after_[static_cast<std::size_t>(e)])
        element(c.other).column = std::max(element(c.other).column, element(e).column + c.least);
  }

  // The way with the most elements, those of loops and with states counting more.
  void find_main_path() {
    const std::size_t n = web_.elements.size();
    std::vector<int> best(n, 0), from(n, -1);
    const auto weight = [&](int e) {
      const Element& x = element(e);
      return x.is_feedback || x.is_beside() ? 0 : 4 + (x.has_state ? 2 : 0) + (in_loop(e) ? 6 : 0);
    };
    std::vector<std::vector<int>> next(n);
    for (const Net& net : web_.nets)
      for (const Sink& s : net.sinks)
        if (!s.is_back && !element(net.element).is_feedback && !element(s.element).is_feedback)
          next[static_cast<std::size_t>(net.element)].push_back(s.element);
    int end = -1;
    for (const int e : order_) {
      const auto at = static_cast<std::size_t>(e);
      if (element(e).is_feedback || element(e).is_beside()) continue;
      best[at] += weight(e);
      if (end < 0 || best[at] > best[static_cast<std::size_t>(end)]) end = e;
      for (const int v : next[at])
        if (best[at] > best[static_cast<std::size_t>(v)]) {
          best[static_cast<std::size_t>(v)] = best[at];
          from[static_cast<std::size_t>(v)] = e;
        }
    }
    for (int e = end; e >= 0; e = from[static_cast<std::size_t>(e)]) web_.main_path.push_back(e);
    std::reverse(web_.main_path.begin(), web_.main_path.end());
  }

  // Between the two ends of a connection that leads back.
  bool in_loop(int e) {
    if (loop_.empty()) {
      loop_.assign(web_.elements.size(), 0);
      std::vector<std::vector<int>> next(web_.elements.size()), previous(web_.elements.size());
      std::vector<std::pair<int, int>> back;
      for (const Net& net : web_.nets)
        for (const Sink& s : net.sinks) {
          if (s.is_back) {
            back.emplace_back(s.element, net.element);
          } else {
            next[static_cast<std::size_t>(net.element)].push_back(s.element);
            previous[static_cast<std::size_t>(s.element)].push_back(net.element);
          }
        }
      const auto reach = [](int start, const std::vector<std::vector<int>>& edges) {
        std::vector<char> seen(edges.size(), 0);
        std::vector<int> open{start};
        while (!open.empty()) {
          const auto at = static_cast<std::size_t>(open.back());
          open.pop_back();
          if (seen[at]) continue;
          seen[at] = 1;
          open.insert(open.end(), edges[at].begin(), edges[at].end());
        }
        return seen;
      };
      for (const auto& [head, tail] : back) {
        const std::vector<char> down = reach(head, next), up = reach(tail, previous);
        for (std::size_t i = 0; i < down.size(); ++i)
          if (down[i] && up[i]) loop_[i] = 1;
      }
    }
    return loop_[static_cast<std::size_t>(e)] != 0;
  }

  bool on_main_path(int e) const {
    return std::find(web_.main_path.begin(), web_.main_path.end(), e) != web_.main_path.end();
  }

  // Sources, and what only follows from them, stand as near to their reader as they can.
  void pull_sources() {
    std::vector<char> movable(web_.elements.size(), 0);
    for (const int e : order_) {
      const Element& x = element(e);
      if (x.is_feedback || on_main_path(e) || (web_.is_framed && x.shape == Shape::input)) continue;
      movable[static_cast<std::size_t>(e)] = std::all_of(x.in.begin(), x.in.end(), [&](int n) {
        if (n < 0) return true;
        const Net& net = web_.nets[static_cast<std::size_t>(n)];
        return net.sinks.size() == 1 &&
               (movable[static_cast<std::size_t>(net.element)] || element(net.element).is_beside());
      });
    }
    for (auto it = order_.rbegin(); it != order_.rend(); ++it) {
      if (!movable[static_cast<std::size_t>(*it)] || after_[static_cast<std::size_t>(*it)].empty()) continue;
      element(*it).column = highest(*it);
    }
  }

  int highest(int e) {
    int column = std::numeric_limits<int>::max();
    for (const Constraint& c : after_[static_cast<std::size_t>(e)])
      column = std::min(column, element(c.other).column - c.least);
    return std::max(column, element(e).column);
  }

  void centre_feedback() {
    for (auto it = order_.rbegin(); it != order_.rend(); ++it) {
      Element& e = element(*it);
      if (!e.is_feedback || after_[static_cast<std::size_t>(*it)].empty()) continue;
      e.first_column = e.column;
      e.last_column = highest(*it);
      e.column += (e.last_column - e.column) / 2;
    }
  }

  Web& web_;
  std::vector<std::vector<Constraint>> after_, before_;
  std::vector<int> order_;
  std::vector<char> loop_;
};

}  // namespace

void give_columns(Web& web) { Columns(web).run(); }

}  // namespace plantloop
