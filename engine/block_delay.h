// Dead times: the past of a continuous signal, kept and read.

#pragma once

#include <functional>
#include <optional>

#include "engine/block.h"

namespace plantloop {

// How far back `u` is read, in s.
struct DeadTime {
  Value delay;
  // The bounds of a delay that changes along the run; it must keep them. Without: it is a parameter.
  std::optional<Value> shortest, longest;
  // The value before the start; without: that at the start.
  std::optional<Value> past;
  // A delay shorter than a step: false: steps are limited to the (shortest) delay; true: the value between the last
  // step's end and now is interpolated with the present one, so u reaches the output at the same instant.
  bool reads_present = false;
};

// u(t - delay). Where u is not smooth, the output is not smooth one delay later: such instants are steps' ends. To be
// called in outputs() of a continuous block.
Value delayed(Now now, Value u, const DeadTime& time);

// x with x(t) = next(x)(t - delay), element by element: a loop that a dead time closes. `next` gives what comes out one
// delay later; before the start that was `time.past`, which must be given.
Array delayed_loop(Now now, const Shape& shape, const DeadTime& time, const std::function<Array(const Array&)>& next);

}  // namespace plantloop
