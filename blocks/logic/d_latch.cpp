// A flip-flop that takes a condition over when its clock says.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct DLatch final : Block {
  static constexpr auto summary = "Hold a condition as it was when the clock said so.";
  static constexpr auto details =
      "takes edge: q becomes 1 if d > 0, else 0, at the instant at which c rises above 0, and stays until the next one "
      "(a flip-flop);  level: q follows d while c > 0 and stays as it was while c <= 0 (a transparent latch). not_q is "
      "1 - q. Where the block is sampled, d reaches q at the sample of the edge, so a loop from q to d needs a "
      "unit_delay.";
  static constexpr auto example = R"(
title: Half the frequency of a clock
blocks:
  c: {type: pulse, period: 1, delay: 0.5}
  half: {type: d_latch, in: {d: half.not_q, c: c}}
simulation: {stop: 4}
expect:
  - {signal: half, at: 1, value: 1}
  - {signal: half, at: 2, value: 0}
  - {signal: half, at: 3, value: 1}
)";

  Input d{this, "d", {.doc = "the condition: holds while greater than 0"}};
  Input c{this, "c", {.doc = "the clock"}};
  Choice takes{
      this, "takes", {.of = {"edge", "level"}, .doc = "when d counts: at rising edges of c, or while c is high"}};
  Number initial_value{
      this, "initial", {.init = 0, .doc = "q at the start: 1 if greater than 0; may read signals", .initial = true}};
  Discrete state{this, "state", {.doc = "the last q"}};
  Discrete was{this, "was", {.init = -1, .doc = "1 if c was high at the last sample, 0 if not, -1 before the first"}};
  Output q{this, "q", {.doc = "1 or 0"}};
  Output not_q{this, "not_q", {.doc = "0 or 1"}};

  RateKind rate_kind() const override { return RateKind::any; }
  // What holds at the start is no event, so an open latch starts with what it gives.
  void initial(Now now, Init init) const override {
    const Array before = (now[initial_value] > 0.0).array;
    init[state] = takes.is("level") && !is_sampled(now) ? followed(now, before) : before;
  }
  void outputs(Now now, Out out) const override {
    out[q] = value(now);
    out[not_q] = 1.0 - value(now);
  }
  void update(Now now, Next next) const override {
    next[state] = value(now);
    next[was] = (now[c] > 0.0).array;
  }
  void jumps(Now now, Jumps jump) const override {
    if (is_sampled(now)) return;
    if (takes.is("level")) return follow(now, jump, state, value(now));
    jump.when(becomes(now[c] > 0.0)).set(state, (now[d] > 0.0).array);
  }

 private:
  Array followed(Now now, const Array& before) const { return where(now[c] > 0.0, (now[d] > 0.0).array, before); }
  Truths rises(Now now) const { return now[c] > 0.0 && equal(now[was], 0.0); }
  Array value(Now now) const {
    if (takes.is("level")) return followed(now, now[state]);
    return is_sampled(now) ? where(rises(now), (now[d] > 0.0).array, now[state]) : now[state];
  }
};

}  // namespace

PLANTLOOP_BLOCK(d_latch, DLatch)

}  // namespace plantloop
