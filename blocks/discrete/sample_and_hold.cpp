// A signal taken at events and held in between.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct SampleAndHold final : Block {
  static constexpr auto summary = "Take the input when a gate opens, and hold it until the next time.";
  static constexpr auto details =
      "takes rising: y becomes u at the instant at which gate rises above 0;  falling: at which it falls to 0 or "
      "below;  either: at both;  level: y = u while gate > 0, then what u was (track and hold). Until the first time y "
      "is `initial`. Where u jumps at the same instant, its new value is taken. zero_order_hold samples at a rate.";
  static constexpr auto example = R"(
blocks:
  wave: {type: sine}
  peak: {type: sample_and_hold, in: {u: time, gate: wave > 0.5}}
simulation: {stop: 7}
expect:
  - {signal: peak, at: 6, value: pi/6, abs: 1e-9}
  - {signal: peak, at: 7, value: 2*pi + pi/6, abs: 1e-9}
)";

  Input u{this, "u", {.doc = "signal to take"}};
  Input gate{this, "gate", {.doc = "says when"}};
  Choice takes{this, "takes", {.of = {"rising", "falling", "either", "level"}, .doc = "what of the gate counts"}};
  Number initial_value{
      this, "initial", {.init = 0, .doc = "output until the first time; may read signals", .initial = true}};
  Discrete held{this, "held", {.doc = "what was taken last"}};
  Discrete was{
      this, "was", {.init = -1, .doc = "1 if the gate was open at the last sample, 0 if not, -1 before the first"}};
  Output y{this, "y", {.doc = "the held value"}};

  RateKind rate_kind() const override { return RateKind::any; }
  void initial(Now now, Init init) const override { init[held] = now[initial_value]; }
  void outputs(Now now, Out out) const override { out[y] = value(now); }
  void update(Now now, Next next) const override {
    next[held] = value(now);
    next[was] = (now[gate] > 0.0).array;
  }
  void jumps(Now now, Jumps jump) const override {
    if (is_sampled(now)) return;
    if (takes.is("rising") || takes.is("either")) jump.when(becomes(now[gate] > 0.0)).set(held, now[u]);
    if (!takes.is("rising")) jump.when(becomes(!(now[gate] > 0.0))).set(held, now[u]);
  }

 private:
  Array value(Now now) const {
    const Truths open = now[gate] > 0.0;
    if (takes.is("level")) return where(open, now[u], now[held]);
    if (!is_sampled(now)) return now[held];
    const Truths rises = open && equal(now[was], 0.0), falls = !open && equal(now[was], 1.0);
    return where(takes.is("rising") ? rises : takes.is("falling") ? falls : rises || falls, now[u], now[held]);
  }
};

}  // namespace

PLANTLOOP_BLOCK(sample_and_hold, SampleAndHold)

}  // namespace plantloop
