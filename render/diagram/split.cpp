// Sums with room for everything: a circle is fed on its main side, from above and from below; what is more makes a row
// of circles, the outermost loop first.

#include <algorithm>

#include "render/diagram/web.h"

namespace plantloop {
namespace {

using Shape = SheetBlock::Shape;

struct Term {
  int port = 0;
  int depth = 0;         // of what feeds it
  bool is_lane = false;  // comes from below, from what leads back
  bool is_source = false;
};

class Splitter {
 public:
  explicit Splitter(Web& web) : web_(web), depth_(forward_depths(web)) {}

  void run() {
    const std::size_t count = web_.elements.size();
    for (std::size_t e = 0; e < count; ++e)
      if (web_.elements[e].shape == Shape::circle) split(static_cast<int>(e));
  }

 private:
  Element& element(int e) { return web_.elements[static_cast<std::size_t>(e)]; }

  std::vector<Term> terms_of(int e) {
    std::vector<Term> terms;
    const Element& circle = element(e);
    for (std::size_t p = 0; p < circle.in.size(); ++p) {
      Term term{static_cast<int>(p)};
      if (circle.in[p] >= 0) {
        const Net& net = web_.nets[static_cast<std::size_t>(circle.in[p])];
        const Element& from = element(net.element);
        bool back = false;
        for (const Sink& s : net.sinks)
          if (s.element == e && s.port == term.port) back = s.is_back;
        term.depth = depth_[static_cast<std::size_t>(net.element)];
        term.is_lane = circle.is_feedback ? back || !from.is_feedback : back || from.is_feedback;
        const bool alone = std::all_of(from.in.begin(), from.in.end(), [](int n) { return n < 0; });
        term.is_source = alone && net.sinks.size() == 1;
      }
      terms.push_back(term);
    }
    return terms;
  }

  void split(int e) {
    std::vector<Term> sides, lanes;
    for (const Term& term : terms_of(e)) (term.is_lane ? lanes : sides).push_back(term);
    Term main;
    std::stable_sort(lanes.begin(), lanes.end(), [](const Term& a, const Term& b) { return a.depth > b.depth; });
    if (sides.empty()) {
      // The innermost loop, or of what leads back itself the farthest.
      const auto at = element(e).is_feedback ? lanes.begin() : lanes.end() - 1;
      main = *at;
      lanes.erase(at);
    } else {
      auto best = sides.begin();
      for (auto it = sides.begin(); it != sides.end(); ++it)
        if (std::pair(it->depth, !it->is_source) > std::pair(best->depth, !best->is_source)) best = it;
      main = *best;
      sides.erase(best);
    }
    if (sides.size() + lanes.size() > 6) return make_box(e);
    const std::size_t circles = std::max({std::size_t{1}, lanes.size(), (sides.size() + lanes.size() + 1) / 2});
    std::vector<Slots> slots(circles);
    // The forward path lies above what leads back, and below what it receives.
    const bool is_flipped = element(e).is_feedback;
    for (std::size_t i = 0; i < lanes.size(); ++i) (is_flipped ? slots[i].top : slots[i].bottom) = lanes[i].port;
    for (const Term& side : sides) place(slots, side, main.port, is_flipped);
    write(e, main.port, slots);
  }

  struct Slots {
    int top = -1, bottom = -1;
  };

  // Sources and earlier terms above, later ones below, where there is room.
  static void place(std::vector<Slots>& slots, const Term& side, int main, bool is_flipped) {
    const bool above = !is_flipped && (side.is_source || side.port < main);
    for (const bool top : {above, !above})
      for (Slots& s : slots) {
        int& slot = top ? s.top : s.bottom;
        if (slot >= 0) continue;
        slot = side.port;
        return;
      }
  }

  void move_sink(int from, int port, int to, int new_port) {
    const int n = element(from).in[static_cast<std::size_t>(port)];
    if (n < 0) return;
    for (Sink& s : web_.nets[static_cast<std::size_t>(n)].sinks)
      if (s.element == from && s.port == port) {
        s.element = -1 - to;  // marked, so that a later move does not take it for an old one
        s.port = new_port;
      }
  }

  void write(int e, int main, const std::vector<Slots>& slots) {
    const Element old = element(e);
    const Side start = old.is_feedback ? Side::right : Side::left;
    // The circles in the order of the signal; the last one keeps the element.
    std::vector<int> circles;
    for (std::size_t i = 0; i + 1 < slots.size(); ++i) {
      Element circle = old;
      circle.key += "#" + std::to_string(i + 1);
      circle.out.assign(1, -1);
      circles.push_back(static_cast<int>(web_.elements.size()));
      web_.elements.push_back(std::move(circle));
      depth_.push_back(0);
    }
    circles.push_back(e);
    int before = -1;
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const int c = circles[i];
      std::vector<int> in;
      std::vector<std::string> text;
      std::vector<Side> side;
      const auto take = [&](int port, Side where) {
        if (port < 0) return;
        move_sink(e, port, c, static_cast<int>(in.size()));
        in.push_back(old.in[static_cast<std::size_t>(port)]);
        text.push_back(old.in_text[static_cast<std::size_t>(port)]);
        side.push_back(where);
      };
      if (i == 0) {
        take(main, start);
      } else {
        Net net;
        net.element = before;
        net.sinks = {{c, 0, false}};
        element(before).out[0] = static_cast<int>(web_.nets.size());
        in.push_back(static_cast<int>(web_.nets.size()));
        text.emplace_back(old.in_text[static_cast<std::size_t>(main)] == "×" ? "×" : "+");
        side.push_back(start);
        web_.nets.push_back(std::move(net));
      }
      take(slots[i].top, Side::top);
      take(slots[i].bottom, Side::bottom);
      Element& circle = element(c);
      circle.in = std::move(in);
      circle.in_text = std::move(text);
      circle.in_side = std::move(side);
      before = c;
    }
    for (Net& net : web_.nets)
      for (Sink& s : net.sinks)
        if (s.element < 0) s.element = -1 - s.element;
  }

  // Too many terms for circles.
  void make_box(int e) { element(e).shape = Shape::box; }

  Web& web_;
  std::vector<int> depth_;
};

}  // namespace

void split_circles(Web& web) { Splitter(web).run(); }

}  // namespace plantloop
