// The end of a run, by a condition.

#include <memory>

#include "engine/block.h"
#include "engine/program/kernel.h"

namespace plantloop {
namespace {

class EndOfRun final : public Kernel {
 public:
  std::string name() const override { return "end of the run"; }
  int outputs() const override { return 0; }
  bool starts_with_inputs() const override { return false; }
  void evaluate(const KernelCall&) const override {}
  void advance(const KernelCall& call) const override {
    if (call.in[0] > 0) *call.end = true;
  }
};

struct Stop final : Block {
  static constexpr auto summary = "End the run when a condition holds.";
  static constexpr auto details =
      "The run ends at the instant at which u rises above 0, as if that were its stop time: located exactly where u is "
      "continuous, else at the sample. What happens at that instant is still recorded. Of a vector one element is "
      "enough.";
  static constexpr auto example = R"(
title: A fall until the ground is reached
blocks:
  h: {type: integrator, in: v, initial: 5}
  v: {type: integrator, in: -10}
  ground: {type: stop, in: h <= 0}
simulation: {stop: 100}
expect:
  - {signal: h, measure: final, value: 0, abs: 1e-9}
  - {signal: v, measure: final, value: -10, abs: 1e-9}
)";

  Input u{this, "u", {.doc = "the condition: holds while greater than 0"}};
  Output y{this, "y", {.doc = "1 where the condition holds, else 0"}};

  void outputs(Now now, Out out) const override {
    const Array holds = (now[u] > 0.0).array;
    out[y] = holds;
    now.kernel(std::make_shared<EndOfRun>(), {}, {greatest(holds)});
  }
};

}  // namespace

PLANTLOOP_BLOCK(stop, Stop)

}  // namespace plantloop
