// Checks an arrangement without looking at pixels.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/diagram/arrangement.h"

namespace plantloop {
namespace {

constexpr double tiny = 0.05;

class Checker {
 public:
  Checker(const Sheet& sheet, const Arrangement& a, std::string path) : sheet_(sheet), a_(a), path_(std::move(path)) {}

  std::vector<std::string> run() {
    check_blocks();
    check_lines();
    check_arrows();
    check_nets_apart();
    check_main_path();
    for (const PlacedFrame& f : a_.frames) {
      const SheetBlock& block =
          sheet_.blocks[static_cast<std::size_t>(a_.blocks[static_cast<std::size_t>(f.block)].block)];
      const std::vector<std::string> inner = Checker(*block.inside, f.inside, path_ + block.path + ".").run();
      found_.insert(found_.end(), inner.begin(), inner.end());
    }
    return std::move(found_);
  }

 private:
  std::string name(std::size_t placed) const {
    const int b = a_.blocks[placed].block;
    return path_ + (b >= 0 ? sheet_.blocks[static_cast<std::size_t>(b)].path : "a result");
  }
  std::string name(const PlacedNet& net) const {
    if (net.wire < 0) return "a wire inside a sum";
    const SheetWire& wire = sheet_.wires[static_cast<std::size_t>(net.wire)];
    return "the wire of " + path_ + sheet_.blocks[static_cast<std::size_t>(wire.from.block)].path;
  }

  void check_blocks() {
    for (std::size_t i = 0; i < a_.blocks.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (a_.blocks[i].box.meets(a_.blocks[j].box))
          found_.push_back(fmt::format("{} and {} overlap", name(j), name(i)));
  }

  // Calls with both ends of every straight part.
  template <typename Call>
  static void each_part(const PlacedNet& net, Call call) {
    for (const Curve& line : net.lines)
      for (std::size_t i = 0; i + 1 < line.size(); ++i) call(line[i], line[i + 1]);
  }

  void check_lines() {
    for (const PlacedNet& net : a_.nets)
      each_part(net, [&](Spot p, Spot q) {
        if (std::abs(p.x - q.x) > tiny && std::abs(p.y - q.y) > tiny)
          found_.push_back(fmt::format("{} is slanted", name(net)));
        for (std::size_t i = 0; i < a_.blocks.size(); ++i) {
          const Box b = a_.blocks[i].box.grown(-0.5);
          if (std::max(p.x, q.x) > b.left && std::min(p.x, q.x) < b.right && std::max(p.y, q.y) > b.top &&
              std::min(p.y, q.y) < b.bottom)
            found_.push_back(fmt::format("{} crosses {}", name(net), name(i)));
        }
      });
  }

  bool ends_at(const PlacedNet& net, Spot at, Side side) const {
    for (const Curve& line : net.lines)
      for (const bool front : {true, false}) {
        const Spot end = front ? line.front() : line.back(), before = front ? line[1] : line[line.size() - 2];
        if (std::abs(end.x - at.x) > tiny || std::abs(end.y - at.y) > tiny) continue;
        const bool level = std::abs(before.y - end.y) < tiny;
        if ((side == Side::left && level && before.x < end.x) || (side == Side::right && level && before.x > end.x) ||
            (side == Side::top && !level && before.y < end.y) || (side == Side::bottom && !level && before.y > end.y))
          return true;
      }
    return false;
  }

  void check_arrows() {
    for (const PlacedNet& net : a_.nets) {
      for (std::size_t i = 0; i < net.arrows.size(); ++i) {
        const PlacedArrow& arrow = net.arrows[i];
        const PlacedBlock& b = a_.blocks[static_cast<std::size_t>(arrow.block)];
        const bool on_port = std::any_of(b.inputs.begin(), b.inputs.end(), [&](const PlacedPort& p) {
          return p.side == arrow.side && std::abs(p.at.x - arrow.tip.x) < tiny && std::abs(p.at.y - arrow.tip.y) < tiny;
        });
        if (!on_port || !ends_at(net, arrow.tip, arrow.side))
          found_.push_back(
              fmt::format("{} does not end on a port of {}", name(net), name(static_cast<std::size_t>(arrow.block))));
        if (net.bends[i] < 0)
          found_.push_back(fmt::format("{} does not reach {}", name(net), name(static_cast<std::size_t>(arrow.block))));
        if (net.bends[i] > 4)
          found_.push_back(fmt::format("{} has {} bends on its way to {}", name(net), net.bends[i],
                                       name(static_cast<std::size_t>(arrow.block))));
      }
    }
  }

  void check_nets_apart() {
    for (std::size_t i = 0; i < a_.nets.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        bool overlap = false;
        each_part(a_.nets[i], [&](Spot p, Spot q) {
          each_part(a_.nets[j], [&](Spot r, Spot s) { overlap = overlap || lie_on_each_other(p, q, r, s); });
        });
        if (overlap) found_.push_back(fmt::format("{} lies on {}", name(a_.nets[i]), name(a_.nets[j])));
      }
  }

  static bool lie_on_each_other(Spot p, Spot q, Spot r, Spot s) {
    const auto shared = [](double a, double b, double c, double d) {
      return std::min(std::max(a, b), std::max(c, d)) - std::max(std::min(a, b), std::min(c, d)) > tiny;
    };
    const bool level = std::abs(p.y - q.y) < tiny, other = std::abs(r.y - s.y) < tiny;
    if (level != other) return false;
    return level ? std::abs(p.y - r.y) < 3 && shared(p.x, q.x, r.x, s.x)
                 : std::abs(p.x - r.x) < 3 && shared(p.y, q.y, r.y, s.y);
  }

  void check_main_path() {
    for (std::size_t i = 0; i + 1 < a_.main_path.size(); ++i) {
      const Box &b = a_.blocks[static_cast<std::size_t>(a_.main_path[i])].box,
                &c = a_.blocks[static_cast<std::size_t>(a_.main_path[i + 1])].box;
      if (b.right >= c.left)
        found_.push_back(fmt::format("the forward path turns back from {} to {}",
                                     name(static_cast<std::size_t>(a_.main_path[i])),
                                     name(static_cast<std::size_t>(a_.main_path[i + 1]))));
    }
  }

  const Sheet& sheet_;
  const Arrangement& a_;
  std::string path_;
  std::vector<std::string> found_;
};

}  // namespace

std::vector<std::string> faults(const Sheet& sheet, const Arrangement& arrangement) {
  return Checker(sheet, arrangement, "").run();
}

}  // namespace plantloop
