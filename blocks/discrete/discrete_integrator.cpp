// The sum of a signal's samples, times the period.

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct DiscreteIntegrator final : Block {
  static constexpr auto summary = "Integrate the samples of the input.";
  static constexpr auto details =
      "With the period T and the state x:  forward (Euler): y = x, x+ = y + T u;  backward: y = x + T u, x+ = y;  "
      "trapezoidal: y = x + T u/2, x+ = y + T u/2.  With lower or upper both y and x stay within the limits.";
  static constexpr auto example = R"(
blocks: {y: {type: discrete_integrator, in: 2, rate: 0.1}}
simulation: {stop: 1}
expect: [{signal: y, at: 0.5, value: 1, abs: 1e-12}]
)";

  Input u{this, "u", {.doc = "signal to integrate"}};
  Choice method{this, "method", {.of = {"forward", "backward", "trapezoidal"}, .doc = "how a sample counts"}};
  Number initial_value{this, "initial", {.init = 0, .doc = "x at the start; may read signals", .initial = true}};
  Limits limits{this, "least value of the integral", "greatest value of the integral"};
  Discrete x{this, "x", {.doc = "the integral so far"}};
  Output y{this, "y", {.doc = "the integral"}};

  void check(Checking& checking) const override { limits.check(checking); }
  void initial(Now now, Init init) const override { init[x] = limits.clamp(now, now[initial_value]); }
  void outputs(Now now, Out out) const override { out[y] = integral(now); }
  void update(Now now, Next next) const override {
    next[x] = method.is("backward") ? integral(now) : limits.clamp(now, integral(now) + share(now) * now[u]);
  }

 private:
  // The part of a period that a sample counts for, before it and after it.
  Value share(Now now) const { return method.is("trapezoidal") ? 0.5 * now.period() : now.period(); }
  Array integral(Now now) const {
    return method.is("forward") ? now[x] : limits.clamp(now, now[x] + share(now) * now[u]);
  }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_integrator, DiscreteIntegrator)

}  // namespace plantloop
