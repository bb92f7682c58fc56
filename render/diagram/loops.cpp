// Loops are opened where a control engineer would: at the sum that compares, whose other input comes from outside.

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <string_view>

#include "render/diagram/web.h"

namespace plantloop {
namespace {

struct Connection {
  int from = 0, to = 0;
  Sink* sink = nullptr;
  const Net* net = nullptr;
};

std::vector<std::vector<Connection>> leaving(Web& web) {
  std::vector<std::vector<Connection>> result(web.elements.size());
  for (Net& net : web.nets)
    for (Sink& sink : net.sinks)
      result[static_cast<std::size_t>(net.element)].push_back({net.element, sink.element, &sink, &net});
  return result;
}

// Strongly connected components (Tarjan, 1972) of the elements with `inside[e] == part`, by connections that do not
// close a loop; on a stack of our own, so that long chains do no harm.
std::vector<std::vector<int>> components(const std::vector<std::vector<Connection>>& out,
                                         const std::vector<int>& inside, const std::vector<int>& members, int part) {
  std::vector<int> number(out.size(), -1), low(out.size(), 0), stack;
  std::vector<char> on_stack(out.size(), 0);
  std::vector<std::vector<int>> result;
  struct Call {
    int at;
    std::size_t next;
  };
  int count = 0;
  for (const int root : members) {
    if (number[static_cast<std::size_t>(root)] >= 0) continue;
    std::vector<Call> calls{{root, 0}};
    while (!calls.empty()) {
      Call& call = calls.back();
      const auto at = static_cast<std::size_t>(call.at);
      if (call.next == 0) {
        number[at] = low[at] = count++;
        stack.push_back(call.at);
        on_stack[at] = 1;
      }
      bool called = false;
      while (call.next < out[at].size()) {
        const Connection& c = out[at][call.next++];
        const auto to = static_cast<std::size_t>(c.to);
        if (c.sink->is_back || inside[to] != part) continue;
        if (number[to] < 0) {
          calls.push_back({c.to, 0});
          called = true;
          break;
        }
        if (on_stack[to]) low[at] = std::min(low[at], number[to]);
      }
      if (called) continue;
      if (call.next == 0) call.next = 1;  // an element without connections
      if (low[at] == number[at]) {
        std::vector<int> component;
        for (int top = -1; top != call.at;) {
          top = stack.back();
          stack.pop_back();
          on_stack[static_cast<std::size_t>(top)] = 0;
          component.push_back(top);
        }
        std::sort(component.begin(), component.end());
        result.push_back(std::move(component));
      }
      const int done = call.at;
      calls.pop_back();
      if (!calls.empty()) {
        const auto parent = static_cast<std::size_t>(calls.back().at);
        low[parent] = std::min(low[parent], low[static_cast<std::size_t>(done)]);
      }
    }
  }
  return result;
}

bool is_minus(const Element& e, int port) {
  return e.shape == SheetBlock::Shape::circle && e.in_text[static_cast<std::size_t>(port)] == "−";
}

class LoopCutter {
 public:
  explicit LoopCutter(Web& web) : web_(web), out_(leaving(web)), inside_(web.elements.size(), 0) {}

  void run() {
    std::vector<int> all;
    for (std::size_t i = 0; i < web_.elements.size(); ++i) all.push_back(static_cast<int>(i));
    cut(all, 0);
  }

 private:
  void cut(const std::vector<int>& members, int part) {
    for (const std::vector<int>& loop : components(out_, inside_, members, part)) {
      const int own = ++parts_;
      for (const int e : loop) inside_[static_cast<std::size_t>(e)] = own;
      const int entry = best_entry(loop, own);
      if (cut_into(entry, loop)) cut(loop, own);
    }
  }

  // What a sum subtracts is what comes back; only when it subtracts nothing of its loop, all that comes from there is.
  bool cut_into(int entry, const std::vector<int>& loop) {
    bool any = false;
    for (const bool minus_only : {true, false}) {
      for (const int e : loop)
        for (const Connection& c : out_[static_cast<std::size_t>(e)]) {
          if (c.to != entry || c.sink->is_back) continue;
          if (minus_only && !is_minus(web_.elements[static_cast<std::size_t>(entry)], c.sink->port)) continue;
          c.sink->is_back = any = true;
        }
      if (any) break;
    }
    return any;
  }

  // Where signals from outside enter, best at a sum that subtracts what comes back from them.
  int best_entry(const std::vector<int>& loop, int part) const {
    std::vector<int> score(web_.elements.size(), 0);
    for (const Net& net : web_.nets) {
      const bool from_inside = inside_[static_cast<std::size_t>(net.element)] == part;
      for (const Sink& sink : net.sinks) {
        if (inside_[static_cast<std::size_t>(sink.element)] != part) continue;
        if (sink.is_back) {
          score[static_cast<std::size_t>(sink.element)] |= 64;
          continue;
        }
        const Element& e = web_.elements[static_cast<std::size_t>(sink.element)];
        const bool minus = is_minus(e, sink.port);
        int& s = score[static_cast<std::size_t>(sink.element)];
        if (from_inside) {
          s |= (minus ? 8 : 32) | (minus && net.is_shown ? 2 : 0);
        } else {
          s |= 4 | (minus ? 0 : 16);
        }
      }
    }
    const auto value = [&](int e) {
      const int s = score[static_cast<std::size_t>(e)];
      const bool compares = (s & 16) && (s & 8);
      const bool is_circle = web_.elements[static_cast<std::size_t>(e)].shape == SheetBlock::Shape::circle;
      // Where branches only meet, with a plus, is no good place to begin.
      const bool adds = is_circle && web_.elements[static_cast<std::size_t>(e)].in_text[0] != "×";
      const bool joins = adds && (s & 32) && !(s & 8) && (s & 4);
      return (compares ? 32 : 0) + ((s & 4) ? 8 : 0) + ((s & 8) ? 4 : 0) + ((s & 2) ? 2 : 0) + (is_circle ? 1 : 0) +
             ((s & 64) ? 6 : 0) - (joins ? 3 : 0);
    };
    int best = loop.front();
    for (const int e : loop)
      if (value(e) > value(best)) best = e;
    return best;
  }

  Web& web_;
  std::vector<std::vector<Connection>> out_;
  std::vector<int> inside_;
  int parts_ = 0;
};

// Elements from which a result can be reached without going back; the others lead back.
class Direction {
 public:
  explicit Direction(Web& web) : web_(web), out_(leaving(web)), live_(web.elements.size(), 0) {}

  void run() {
    for (std::size_t i = 0; i < live_.size(); ++i) {
      const bool ends = out_[i].empty() && web_.elements[i].shape != SheetBlock::Shape::input;
      if (ends || web_.elements[i].forced_forward) reach(static_cast<int>(i));
    }
    for (const Net& net : web_.nets)
      if (net.is_shown && !net.sinks.empty()) reach(net.element);
    // A loop that nothing leaves still has a forward path: up to the last state of its plant.
    const std::vector<int> depth = forward_depths(web_);
    for (;;) {
      int last = -1;
      const auto better = [&](int a, int b) {
        if (b < 0) return true;
        const Element &x = web_.elements[static_cast<std::size_t>(a)], &y = web_.elements[static_cast<std::size_t>(b)];
        if (x.has_state != y.has_state) return x.has_state;
        return depth[static_cast<std::size_t>(a)] > depth[static_cast<std::size_t>(b)];
      };
      for (const Net& net : web_.nets)
        for (const Sink& sink : net.sinks)
          if (sink.is_back && !live_[static_cast<std::size_t>(sink.element)]) consider(net.element, better, last);
      if (last < 0) break;
      reach(last);
    }
    for (std::size_t i = 0; i < live_.size(); ++i)
      web_.elements[i].is_feedback =
          (!live_[i] || web_.elements[i].forced_feedback) && !web_.elements[i].forced_forward && !out_[i].empty();
  }

 private:
  template <typename Better>
  void consider(int tail, Better better, int& best) {
    // The tail and what stands before it on the way from the loop's entry.
    std::vector<int> open{tail};
    std::vector<char> seen(live_.size(), 0);
    seen[static_cast<std::size_t>(tail)] = 1;
    while (!open.empty()) {
      const int e = open.back();
      open.pop_back();
      if (live_[static_cast<std::size_t>(e)]) continue;
      if (better(e, best)) best = e;
      for (const int net : web_.elements[static_cast<std::size_t>(e)].in) {
        if (net < 0) continue;
        const int from = web_.nets[static_cast<std::size_t>(net)].element;
        if (seen[static_cast<std::size_t>(from)]) continue;
        bool forward = false;
        for (const Sink& s : web_.nets[static_cast<std::size_t>(net)].sinks)
          if (s.element == e && !s.is_back) forward = true;
        if (!forward) continue;
        seen[static_cast<std::size_t>(from)] = 1;
        open.push_back(from);
      }
    }
  }

  void reach(int element) {
    std::vector<int> open{element};
    while (!open.empty()) {
      const int e = open.back();
      open.pop_back();
      if (live_[static_cast<std::size_t>(e)]) continue;
      live_[static_cast<std::size_t>(e)] = 1;
      for (const int n : web_.elements[static_cast<std::size_t>(e)].in) {
        if (n < 0) continue;
        const Net& net = web_.nets[static_cast<std::size_t>(n)];
        for (const Sink& s : net.sinks)
          if (s.element == e && !s.is_back) open.push_back(net.element);
      }
    }
  }

  Web& web_;
  std::vector<std::vector<Connection>> out_;
  std::vector<char> live_;
};

}  // namespace

std::vector<int> forward_depths(const Web& web) {
  const std::size_t n = web.elements.size();
  std::vector<int> depth(n, 0), waiting(n, 0);
  for (const Net& net : web.nets)
    for (const Sink& s : net.sinks)
      if (!s.is_back) ++waiting[static_cast<std::size_t>(s.element)];
  std::vector<std::vector<int>> nets(n);
  for (std::size_t i = 0; i < web.nets.size(); ++i)
    nets[static_cast<std::size_t>(web.nets[i].element)].push_back(static_cast<int>(i));
  std::vector<int> open;
  for (std::size_t i = 0; i < n; ++i)
    if (waiting[i] == 0) open.push_back(static_cast<int>(i));
  while (!open.empty()) {
    const auto e = static_cast<std::size_t>(open.back());
    open.pop_back();
    for (const int i : nets[e])
      for (const Sink& s : web.nets[static_cast<std::size_t>(i)].sinks) {
        if (s.is_back) continue;
        const auto to = static_cast<std::size_t>(s.element);
        depth[to] = std::max(depth[to], depth[e] + 1);
        if (--waiting[to] == 0) open.push_back(s.element);
      }
  }
  return depth;
}

void find_feedback(Web& web) {
  LoopCutter(web).run();
  Direction(web).run();
}

}  // namespace plantloop
