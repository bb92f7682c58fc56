// A lead-lag compensator.

#include "engine/block.h"

namespace plantloop {
namespace {

struct LeadLag final : Block {
  static constexpr auto summary = "Shift the phase by a lead-lag compensator.";
  static constexpr auto details =
      "y = k (lead s + 1)/(lag s + 1) u, as x' = (u - x)/lag,  y = k (x + lead/lag (u - x)). lead > lag advances the "
      "phase, lead < lag delays it; with lead 0 it is a lag.";
  static constexpr auto icon = "k*(lead*s + 1)/(lag*s + 1)";
  static constexpr auto example = R"(
blocks: {y: {type: lead_lag, in: 1, lead: 2, lag: 0.5}}
simulation: {stop: 2}
expect:
  - {signal: y, at: 0, value: 4}
  - {signal: y, at: 0.5, value: 1 + 3*exp(-1), abs: 1e-5}
)";

  Input u{this, "u", {.doc = "signal to compensate"}};
  Number k{this, "k", {.init = 1, .doc = "gain at rest"}};
  Number lead{this, "lead", {.init = 1, .unit = "s", .doc = "time constant of the numerator"}};
  Number lag{this, "lag", {.init = 0.1, .unit = "s", .doc = "time constant of the denominator", .above = 0}};
  Number initial_value{
      this, "initial", {.init = 0, .doc = "lagged input at the start; may read signals", .initial = true}};
  State x{this, "x", {.doc = "lagged input"}};
  Output y{this, "y", {.doc = "the compensated signal"}};

  void initial(Now now, Init init) const override { init[x] = now[initial_value]; }
  void outputs(Now now, Out out) const override {
    out[y] = now[k] * (now[x] + now[lead] / now[lag] * (now[u] - now[x]));
  }
  void derivatives(Now now, Rates rate) const override { rate[x] = (now[u] - now[x]) / now[lag]; }
};

}  // namespace

PLANTLOOP_BLOCK(lead_lag, LeadLag)

}  // namespace plantloop
