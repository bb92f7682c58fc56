// Heights: what can stand on one line does, the main path first; the rest lies as near to its neighbours as there is
// room.
//
// The method of linear segments (G. Sander, 1996): items of neighbouring columns whose connection shall be straight are
// joined to lines, in falling importance, as long as the order in every column allows it. Then every line gets one
// height.

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/diagram/web.h"

namespace plantloop {
namespace {

constexpr double below_main = 60;  // what leads back stands so far below the main path where nothing else keeps it down

struct Joint {
  int left = 0, right = 0;  // items
  double shift = 0;         // height of `right` above that of `left` when the connection is straight
  int weight = 0;
};

class Rows {
 public:
  Rows(const Web& web, Plan& plan) : web_(web), plan_(plan) {}

  void run() {
    if (plan_.items.empty()) return;
    start_lines();
    find_joints();
    for (const Joint& j : joints_) join(j);
    set_heights();
    for (std::size_t i = 0; i < plan_.items.size(); ++i)
      plan_.items[i].y = height_[static_cast<std::size_t>(line_[i])] + shift_[i];
    branch_from_passes();
    straighten_corners();
  }

 private:
  Item& item(int i) { return plan_.items[static_cast<std::size_t>(i)]; }

  void start_lines() {
    const std::size_t n = plan_.items.size();
    line_.resize(n);
    shift_.assign(n, 0);
    members_.resize(n);
    next_.assign(n, -1);
    for (std::size_t i = 0; i < n; ++i) {
      line_[i] = static_cast<int>(i);
      members_[i] = {static_cast<int>(i)};
    }
    for (const std::vector<int>& column : plan_.columns)
      for (std::size_t i = 0; i + 1 < column.size(); ++i) next_[static_cast<std::size_t>(column[i])] = column[i + 1];
    previous_.assign(n, -1);
    for (std::size_t i = 0; i < n; ++i)
      if (next_[i] >= 0) previous_[static_cast<std::size_t>(next_[i])] = static_cast<int>(i);
  }

  // A corner whose wire also passes through its column branches off there, when no element stands between.
  void branch_from_passes() {
    for (const std::vector<int>& column : plan_.columns)
      for (std::size_t c = 0; c < column.size(); ++c) {
        Item& corner = item(column[c]);
        if (corner.kind != Item::Kind::corner) continue;
        const int step = corner.from_above ? -1 : 1;
        for (int at = static_cast<int>(c) + step; at >= 0 && at < static_cast<int>(column.size()); at += step) {
          const Item& other = item(column[static_cast<std::size_t>(at)]);
          if (other.kind == Item::Kind::element) break;
          if (other.kind != Item::Kind::pass || other.net != corner.net || other.is_lane != corner.is_lane) continue;
          corner.y = other.y;
          break;
        }
      }
  }

  // A corner moves to the height at which its wire arrives, when nothing but wires is passed on the way.
  void straighten_corners() {
    for (const std::vector<End>& ends : plan_.channels)
      for (const End& mine : ends) {
        Item& corner = item(mine.item);
        if (corner.kind != Item::Kind::corner) continue;
        for (const End& other : ends) {
          if (other.flow != mine.flow || other.from_left == mine.from_left) continue;
          const double y = item(other.item).y + other.offset, circle = item(corner.element).y;
          const double distance = corner.from_above ? circle - y : y - circle;
          const double half = web_.elements[static_cast<std::size_t>(corner.element)].half_height;
          if (distance < half + sheet_style.stub || std::abs(y - corner.y) < 0.1) continue;
          if (!is_free_way(corner, y, circle)) continue;
          corner.y = y;
          break;
        }
      }
  }

  // Whether a wire may stand at this height of the corner's column, and reach the circle from there.
  bool is_free_way(const Item& corner, double y, double circle) {
    for (const int i : plan_.columns[static_cast<std::size_t>(corner.column)]) {
      const Item& other = item(i);
      if (&other == &corner || (other.kind == Item::Kind::element && other.element == corner.element)) continue;
      const double room = other.kind == Item::Kind::element ? 10 : 0.7 * sheet_style.lane_gap;
      if (y > other.y - other.above - room && y < other.y + other.below + room) return false;
      const bool between = (other.y - y) * (other.y - circle) < 0;
      if (between && other.kind == Item::Kind::element) return false;
      // Another corner of this circle on the same side cannot be; of another one it would be crossed.
      if (between && other.kind == Item::Kind::corner) return false;
    }
    return true;
  }

  int path_place(int e) const {
    const auto it = std::find(web_.main_path.begin(), web_.main_path.end(), e);
    return it == web_.main_path.end() ? -1 : static_cast<int>(it - web_.main_path.begin());
  }

  void find_joints() {
    for (const std::vector<End>& ends : plan_.channels)
      for (const End& l : ends)
        for (const End& r : ends)
          if (l.from_left && !r.from_left && l.flow == r.flow)
            joints_.push_back({l.item, r.item, l.offset - r.offset, weight(l, r)});
    std::stable_sort(joints_.begin(), joints_.end(),
                     [](const Joint& a, const Joint& b) { return a.weight > b.weight; });
  }

  int weight(const End& l, const End& r) {
    const Item &a = item(l.item), &b = item(r.item);
    if (a.kind == Item::Kind::element && b.kind == Item::Kind::element) {
      const int p = path_place(a.element), q = path_place(b.element);
      if (p >= 0 && q == p + 1) return 1000;
      return a.is_lane || b.is_lane ? 80 : 70;
    }
    const auto on_main = [&](const Item& it) {
      if (it.kind == Item::Kind::element) return path_place(it.element) >= 0;
      const Net& net = web_.nets[static_cast<std::size_t>(it.net)];
      if (it.is_lane || it.kind != Item::Kind::pass || path_place(net.element) < 0) return false;
      return std::any_of(net.sinks.begin(), net.sinks.end(), [&](const Sink& s) {
        return path_place(s.element) == path_place(net.element) + 1 && !s.is_back;
      });
    };
    if (on_main(a) && on_main(b)) return 900;
    if (a.kind == Item::Kind::corner || b.kind == Item::Kind::corner) return 60;
    if (a.kind == Item::Kind::pass && b.kind == Item::Kind::pass) return 100;
    return a.is_lane || b.is_lane ? 85 : 65;
  }

  // Whether line `from` must lie above line `to`, directly or through others.
  bool lies_above(int from, int to) const {
    std::vector<int> open{from};
    std::vector<char> seen(members_.size(), 0);
    seen[static_cast<std::size_t>(from)] = 1;
    while (!open.empty()) {
      const int line = open.back();
      open.pop_back();
      for (const int i : members_[static_cast<std::size_t>(line)]) {
        const int below = next_[static_cast<std::size_t>(i)];
        if (below < 0) continue;
        const int other = line_[static_cast<std::size_t>(below)];
        if (other == to) return true;
        if (seen[static_cast<std::size_t>(other)]) continue;
        seen[static_cast<std::size_t>(other)] = 1;
        open.push_back(other);
      }
    }
    return false;
  }

  void join(const Joint& j) {
    const int a = line_[static_cast<std::size_t>(j.left)], b = line_[static_cast<std::size_t>(j.right)];
    if (a == b) return;
    for (const int x : members_[static_cast<std::size_t>(a)])
      for (const int y : members_[static_cast<std::size_t>(b)])
        if (item(x).column == item(y).column) return;
    if (lies_above(a, b) || lies_above(b, a)) return;
    const double move = shift_[static_cast<std::size_t>(j.left)] + j.shift - shift_[static_cast<std::size_t>(j.right)];
    for (const int y : members_[static_cast<std::size_t>(b)]) {
      line_[static_cast<std::size_t>(y)] = a;
      shift_[static_cast<std::size_t>(y)] += move;
      members_[static_cast<std::size_t>(a)].push_back(y);
    }
    members_[static_cast<std::size_t>(b)].clear();
  }

  double gap(const Item& a, const Item& b) const {
    const auto company = [](const Item& corner, const Item& circle) {
      return corner.kind == Item::Kind::corner && circle.kind == Item::Kind::element &&
             circle.element == corner.element;
    };
    if (company(a, b) || company(b, a)) return sheet_style.stub + 2;
    const bool wire_a = a.kind != Item::Kind::element, wire_b = b.kind != Item::Kind::element;
    if (wire_a && wire_b) return sheet_style.lane_gap;
    const auto is_result = [&](const Item& i) {
      return i.kind == Item::Kind::element && web_.elements[static_cast<std::size_t>(i.element)].block < 0;
    };
    if (is_result(a) && is_result(b)) return sheet_style.port_gap - 24;
    if (is_result(a) || is_result(b)) return 14;
    return wire_a || wire_b ? 20 : sheet_style.row_gap;
  }

  // Least distance of the heights of two lines' items.
  double distance(int above, int below) {
    const Item &a = item(above), &b = item(below);
    return a.below + b.above + gap(a, b);
  }

  std::vector<int> sorted_lines() {
    std::vector<int> waiting(members_.size(), 0), order;
    for (std::size_t i = 0; i < next_.size(); ++i)
      if (next_[i] >= 0 && line_[i] != line_[static_cast<std::size_t>(next_[i])])
        ++waiting[static_cast<std::size_t>(line_[static_cast<std::size_t>(next_[i])])];
    for (std::size_t l = 0; l < members_.size(); ++l)
      if (!members_[l].empty() && waiting[l] == 0) order.push_back(static_cast<int>(l));
    for (std::size_t k = 0; k < order.size(); ++k)
      for (const int i : members_[static_cast<std::size_t>(order[k])]) {
        const int below = next_[static_cast<std::size_t>(i)];
        if (below >= 0 && --waiting[static_cast<std::size_t>(line_[static_cast<std::size_t>(below)])] == 0)
          order.push_back(line_[static_cast<std::size_t>(below)]);
      }
    return order;
  }

  // The highest and lowest place that the present neighbours leave.
  double upper_end(int line) {
    double y = -std::numeric_limits<double>::infinity();
    for (const int i : members_[static_cast<std::size_t>(line)]) {
      const int above = previous_[static_cast<std::size_t>(i)];
      if (above >= 0)
        y = std::max(y, height_[static_cast<std::size_t>(line_[static_cast<std::size_t>(above)])] +
                            shift_[static_cast<std::size_t>(above)] + distance(above, i) -
                            shift_[static_cast<std::size_t>(i)]);
    }
    return y;
  }
  double lower_end(int line) {
    double y = std::numeric_limits<double>::infinity();
    for (const int i : members_[static_cast<std::size_t>(line)]) {
      const int below = next_[static_cast<std::size_t>(i)];
      if (below >= 0)
        y = std::min(y, height_[static_cast<std::size_t>(line_[static_cast<std::size_t>(below)])] +
                            shift_[static_cast<std::size_t>(below)] - distance(i, below) -
                            shift_[static_cast<std::size_t>(i)]);
    }
    return y;
  }

  void set_heights() {
    height_.assign(members_.size(), 0);
    const std::vector<int> order = sorted_lines();
    const int main = web_.main_path.empty() ? order.front() : line_[static_cast<std::size_t>(web_.main_path.front())];
    std::vector<char> above(members_.size(), 0), below(members_.size(), 0);
    for (const int l : order) {
      if (l == main) continue;
      above[static_cast<std::size_t>(l)] = lies_above(l, main);
      below[static_cast<std::size_t>(l)] = lies_above(main, l);
    }
    // What must lie above hangs on what is below it, the rest stands on what is above it.
    for (auto it = order.rbegin(); it != order.rend(); ++it) {
      if (!above[static_cast<std::size_t>(*it)]) continue;
      double y = std::numeric_limits<double>::infinity();
      for (const int i : members_[static_cast<std::size_t>(*it)]) {
        const int under = next_[static_cast<std::size_t>(i)];
        if (under < 0) continue;
        const auto other = static_cast<std::size_t>(line_[static_cast<std::size_t>(under)]);
        if (other != static_cast<std::size_t>(main) && !above[other]) continue;
        y = std::min(y, height_[other] + shift_[static_cast<std::size_t>(under)] - distance(i, under) -
                            shift_[static_cast<std::size_t>(i)]);
      }
      height_[static_cast<std::size_t>(*it)] = y;
    }
    for (const int l : order) {
      if (l == main || above[static_cast<std::size_t>(l)]) continue;
      const double y = upper_end(l);
      height_[static_cast<std::size_t>(l)] = std::isfinite(y) ? y : 0;
    }
    for (int round = 0; round < 30; ++round) {
      bool moved = false;
      const auto settle = [&](int l) {
        if (l == main) return;
        const double want = wanted(l), most = lower_end(l);
        double least = upper_end(l);
        if (!std::isfinite(least) && !std::isfinite(want) && !above[static_cast<std::size_t>(l)])
          least = height_[static_cast<std::size_t>(main)] + below_main;
        const double y = std::max(least, std::min(want, most));
        if (!std::isfinite(y)) return;
        if (std::abs(y - height_[static_cast<std::size_t>(l)]) < 0.01) return;
        height_[static_cast<std::size_t>(l)] = y;
        moved = true;
      };
      if (round % 2 == 0) {
        std::for_each(order.rbegin(), order.rend(), settle);
      } else {
        std::for_each(order.begin(), order.end(), settle);
      }
      if (!moved) break;
    }
  }

  // Where most of the connections to other lines would be straight; of what leads back as high as there is room.
  double wanted(int line) {
    std::vector<double> places;
    bool lane = true;
    for (const int i : members_[static_cast<std::size_t>(line)]) lane = lane && item(i).is_lane;
    if (lane) return -std::numeric_limits<double>::infinity();
    const auto y_of = [&](int i) {
      return height_[static_cast<std::size_t>(line_[static_cast<std::size_t>(i)])] +
             shift_[static_cast<std::size_t>(i)];
    };
    for (const Joint& j : joints_) {
      const int a = line_[static_cast<std::size_t>(j.left)], b = line_[static_cast<std::size_t>(j.right)];
      if (a == b) continue;
      if (a == line) places.push_back(y_of(j.right) - j.shift - shift_[static_cast<std::size_t>(j.left)]);
      if (b == line) places.push_back(y_of(j.left) + j.shift - shift_[static_cast<std::size_t>(j.right)]);
    }
    if (places.empty()) return height_[static_cast<std::size_t>(line)];
    std::sort(places.begin(), places.end());
    return places[(places.size() - 1) / 2];
  }

  const Web& web_;
  Plan& plan_;
  std::vector<Joint> joints_;
  std::vector<int> line_, next_, previous_;
  std::vector<double> shift_, height_;
  std::vector<std::vector<int>> members_;
};

}  // namespace

void give_heights(const Web& web, Plan& plan) { Rows(web, plan).run(); }

}  // namespace plantloop
