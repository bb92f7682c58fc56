// The instants at which a signal passes a level.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct HitCrossing final : Block {
  static constexpr auto summary = "Locate the instants at which a signal passes a level.";
  static constexpr auto details =
      "At each crossing of u with `level`, located exactly where u is continuous, `count` goes on by 1, `toggle` "
      "changes between 0 and 1, and `instant` takes the time. An instant has no width, so no pulse could show it: "
      "trigger and reset by `toggle` with edge: either. Of a sampled signal a crossing is found at the first sample "
      "beyond the level or on it. A signal that starts on the level does not cross it there.";
  static constexpr auto example = R"(
blocks:
  u: {type: sine}
  peak: {type: hit_crossing, in: u, level: 0.5, edge: rising}
simulation: {stop: 7}
expect:
  - {signal: peak.count, measure: final, value: 2}
  - {signal: peak.instant, measure: final, value: 2*pi + pi/6, abs: 1e-9}
)";

  Input u{this, "u", {.doc = "the signal"}};
  Number level{this, "level", {.init = 0, .doc = "what it passes"}};
  Choice edge{this, "edge", {.of = {"either", "rising", "falling"}, .doc = "in which direction"}};
  Discrete crossings{this, "count", {.doc = "crossings so far"}};
  Discrete latest{this, "instant", {.unit = "s", .doc = "time of the latest crossing"}};
  Discrete was{this,
               "was",
               {.init = 0, .doc = "side of the last sample: 1 above, -1 below, 0 on the level or before the first"}};
  Output count{this, "count", {.doc = "crossings so far"}};
  Output toggle{this, "toggle", {.doc = "0 after an even number of crossings, else 1"}};
  Output instant{
      this, "instant", {.doc = "time of the latest crossing; before the first one that of the start", .unit = "s"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void initial(Now now, Init init) const override { init[latest] = now.time(); }
  void outputs(Now now, Out out) const override {
    const Array n = passed(now);
    out[count] = n;
    out[toggle] = mod(n, 2.0);
    out[instant] = when(now);
  }
  void update(Now now, Next next) const override {
    next[crossings] = passed(now);
    next[latest] = when(now);
    next[was] = sign(distance(now));
  }
  void jumps(Now now, Jumps jump) const override {
    if (is_sampled(now)) return;
    const Direction direction = edge.is("rising")    ? Direction::rising
                                : edge.is("falling") ? Direction::falling
                                                     : Direction::either;
    jump.when(crossing(distance(now), direction)).set(crossings, now[crossings] + 1.0).set(latest, Array(now.time()));
  }

 private:
  Array distance(Now now) const { return now[u] - now[level]; }
  // Whether the present sample is beyond the level, or the first one on it.
  Truths crosses(Now now) const {
    const Truths up = now[was] < 0.0 && distance(now) >= 0.0, down = now[was] > 0.0 && distance(now) <= 0.0;
    return edge.is("rising") ? up : edge.is("falling") ? down : up || down;
  }
  Array passed(Now now) const { return is_sampled(now) ? now[crossings] + crosses(now).array : now[crossings]; }
  Array when(Now now) const {
    return is_sampled(now) ? where(crosses(now), Array(now.time()), now[latest]) : now[latest];
  }
};

}  // namespace

PLANTLOOP_BLOCK(hit_crossing, HitCrossing)

}  // namespace plantloop
