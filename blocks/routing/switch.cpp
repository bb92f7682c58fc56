// One of two signals, by a condition.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Switch final : Block {
  static constexpr auto summary = "Choose between two signals.";
  static constexpr auto details =
      "y = then where condition > threshold, else the other one, element by element. The one that is not chosen is not "
      "looked at.";
  static constexpr auto example = R"(
blocks: {y: {type: switch, in: {condition: time - 0.5, then: 1, else: 2}}}
simulation: {stop: 1}
expect:
  - {signal: y, at: 0.4, value: 2}
  - {signal: y, at: 0.7, value: 1}
)";

  Input condition{this, "condition", {.doc = "what decides"}};
  Input chosen{this, "then", {.doc = "signal while the condition holds"}};
  Input other{this, "else", {.doc = "signal while it does not"}};
  Number threshold{this, "threshold", {.init = 0, .doc = "the condition holds above this value"}};
  Output y{this, "y", {.doc = "the chosen signal"}};

  void outputs(Now now, Out out) const override {
    out[y] = where(now[condition] > now[threshold], now[chosen], now[other]);
  }
};

}  // namespace

PLANTLOOP_BLOCK(switch, Switch)

}  // namespace plantloop
