// How often a condition began to hold.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Counter final : Block {
  static constexpr auto summary = "Count how often a condition begins or ends to hold.";
  static constexpr auto details =
      "y goes on by `step` whenever u rises above 0 (edge rising), falls to 0 or below (falling), or either; of a "
      "continuous signal at the located instant, of a sampled one at the sample, which counts at once. What holds at "
      "the start is no edge. With `upper` y goes on at `lower` instead of passing it, and at `upper` instead of "
      "falling below `lower`. reset: puts it back to `initial`.";
  static constexpr auto example = R"(
blocks:
  wave: {type: sine, frequency: 2*pi}
  periods: {type: counter, in: wave > 0.5}
simulation: {stop: 3}
expect: [{signal: periods, measure: final, value: 3}]
)";

  Input u{this, "u", {.doc = "the condition: holds while greater than 0"}};
  Choice edge{this, "edge", {.of = {"rising", "falling", "either"}, .doc = "what counts"}};
  Number initial_value{this, "initial", {.init = 0, .doc = "count at the start; may read signals", .initial = true}};
  Number step{this, "step", {.init = 1, .doc = "what is added at each edge; below 0 it counts down"}};
  Number lower{this, "lower", {.init = 0, .doc = "least count, where there is an `upper`"}};
  Number upper{this, "upper", {.doc = "greatest count", .optional = true}};
  Discrete count{this, "count", {.doc = "edges so far"}};
  Discrete was{this, "was", {.init = -1, .doc = "1 if u held at the last sample, 0 if not, -1 before the first"}};
  Output y{this, "y", {.doc = "the count"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void check(Checking& checking) const override { check_order(checking, lower, upper, true); }
  void initial(Now now, Init init) const override { init[count] = now[initial_value]; }
  void outputs(Now now, Out out) const override { out[y] = value(now); }
  void update(Now now, Next next) const override {
    next[count] = value(now);
    next[was] = (now[u] > 0.0).array;
  }
  void jumps(Now now, Jumps jump) const override {
    if (is_sampled(now)) return;
    if (!edge.is("falling")) jump.when(becomes(now[u] > 0.0)).set(count, next_count(now));
    if (!edge.is("rising")) jump.when(becomes(!(now[u] > 0.0))).set(count, next_count(now));
  }

 private:
  Array next_count(Now now) const {
    Array more = now[count] + now[step];
    if (!now.given(upper)) return more;
    return where(more > now[upper], now[lower], where(more < now[lower], now[upper], more));
  }
  Array value(Now now) const {
    if (!is_sampled(now)) return now[count];
    const Truths holds = now[u] > 0.0, rising = holds && equal(now[was], 0.0), falling = !holds && equal(now[was], 1.0);
    const Truths edges = edge.is("rising") ? rising : edge.is("falling") ? falling : rising || falling;
    return where(edges, next_count(now), now[count]);
  }
};

}  // namespace

PLANTLOOP_BLOCK(counter, Counter)

}  // namespace plantloop
