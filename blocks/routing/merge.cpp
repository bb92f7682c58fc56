// One signal that several conditional blocks write.

#include <fmt/format.h>
#include <limits>

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct Merge final : Block {
  static constexpr auto summary = "Show what the active one of several enabled or triggered blocks writes.";
  static constexpr auto details =
      "y is the entry whose block or subsystem is active; while none is, that of the one that was active last, and "
      "before the first activation `initial`. Each entry is an output of a block with enable: or trigger:, written as "
      "a plain name. Two that are active at one instant end the run with an error that names both.";
  static constexpr auto written = "in: [low, high]";
  static constexpr auto example = R"(
title: Two laws for one actuator
blocks:
  x: {type: integrator, in: u, initial: 0}
  fast: {expr: 2, enable: {when: x < 1, initial: 0}}
  slow: {expr: 1, enable: {when: x >= 1, initial: 0}}
  u: {type: merge, in: [fast, slow]}
simulation: {stop: 2}
expect:
  - {signal: x, at: 0.5, value: 1, abs: 1e-9}
  - {signal: x, at: 2, value: 2.5, abs: 1e-9}
)";

  Inputs entries{this, "entries", {.doc = "outputs of conditional blocks"}};
  Number start{this, "initial", {.init = 0, .doc = "the output before the first activation"}};
  Output y{this, "y", {.doc = "what the active one writes"}};

  void outputs(Now now, Out out) const override {
    const std::vector<Array> values = now[entries];
    const std::vector<Activity> activity = now.activity(entries);
    Array result = now[start];
    Value latest = std::numeric_limits<double>::lowest();
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Truth newer = Truth(activity[i].since > latest);
      result = where(newer, values[i], result);
      latest = where(newer, activity[i].since, latest);
    }
    out[y] = result;
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (std::size_t j = i + 1; j < values.size(); ++j) {
        insist(now, (!(activity[i].active && activity[j].active)).value(),
               fmt::format("'{}' merges '{}' and '{}', and both are active", now.path(), activity[i].path,
                           activity[j].path));
      }
    }
  }
};

}  // namespace

PLANTLOOP_BLOCK(merge, Merge)

}  // namespace plantloop
