// One of two signals, by a condition.

#include "engine/block.h"

namespace plantloop {
namespace {

struct Switch final : Block {
  static constexpr auto summary = "Choose between two signals.";
  static constexpr auto details =
      "y = then where condition > threshold, else the other one, element by element. The one that is not chosen is not "
      "looked at.";

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
