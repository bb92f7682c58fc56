// A flip-flop that is set and reset.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct SrLatch final : Block {
  static constexpr auto summary = "Remember which of two conditions held last.";
  static constexpr auto details =
      "q is 1 while s > 0 and stays so until r > 0, then 0 until s > 0 again. While both hold, `both` decides. not_q "
      "is 1 - q.";
  static constexpr auto example = R"(
blocks:
  wave: {type: sine}
  pump: {type: sr_latch, in: {s: wave < -0.5, r: wave > 0.5}}
simulation: {stop: 8}
expect:
  - {signal: pump, at: 3.5, value: 0}
  - {signal: pump, at: 4, value: 1}
  - {signal: pump.not_q, at: 7, value: 1}
)";

  Input s{this, "s", {.doc = "sets q to 1 while greater than 0"}};
  Input r{this, "r", {.doc = "sets q to 0 while greater than 0"}};
  Choice both{this, "both", {.of = {"reset", "set"}, .doc = "what happens while both are greater than 0"}};
  Number initial_value{
      this, "initial", {.init = 0, .doc = "q at the start: 1 if greater than 0; may read signals", .initial = true}};
  Discrete state{this, "state", {.doc = "the last q"}};
  Output q{this, "q", {.doc = "1 or 0"}};
  Output not_q{this, "not_q", {.doc = "0 or 1"}};

  RateKind rate_kind() const override { return RateKind::any; }
  // What holds at the start is no event, so a continuous latch starts with what it gives.
  void initial(Now now, Init init) const override {
    const Array before = (now[initial_value] > 0.0).array;
    init[state] = is_sampled(now) ? before : value(now, before);
  }
  void outputs(Now now, Out out) const override {
    out[q] = value(now, now[state]);
    out[not_q] = 1.0 - value(now, now[state]);
  }
  void update(Now now, Next next) const override { next[state] = value(now, now[state]); }
  void jumps(Now now, Jumps jump) const override { follow(now, jump, state, value(now, now[state])); }

 private:
  Array value(Now now, const Array& before) const {
    const Truths on = now[s] > 0.0, off = now[r] > 0.0;
    if (both.is("set")) return where(on, 1.0, where(off, 0.0, before));
    return where(off, 0.0, where(on, 1.0, before));
  }
};

}  // namespace

PLANTLOOP_BLOCK(sr_latch, SrLatch)

}  // namespace plantloop
