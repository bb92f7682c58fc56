// Numbers that sum up a recorded signal: extremes, means, and how it answers a step.
//
// A signal is what Recording::value says: straight lines between the rows of a continuous column, stairs for a discrete
// one. Crossings are computed on that, not on the rows.

#pragma once

#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/run/recording.h"

namespace plantloop {

// The step that a signal answers to. What is not given: `at` is the window's start, `until` its end, `from` the value
// just before `at`, `to` the value at `until`.
struct StepOf {
  std::optional<double> at, until;  // s
  std::optional<double> from, to;   // in the signal's unit
};

struct MeasureOptions {
  // The window, both ends included; of a jump at its start the right side counts, of one at its end the left, unless
  // the recording ends there.
  double from = -std::numeric_limits<double>::infinity();
  double until = std::numeric_limits<double>::infinity();
  StepOf step;
  double band = 0.02;  // settling_time: part of the step's height
};

struct MeasureInfo {
  std::string_view name;
  std::string_view summary;
  std::string_view unit;  // "": the signal's own
  bool of_step = false;   // uses MeasureOptions::step
};
const std::vector<MeasureInfo>& measures();

// With s(t) = (y(t) - from) / (to - from):
//   max, min, max_abs   over the window
//   rms                 root of the mean of y^2 over time
//   final               y at the window's end
//   overshoot           100 max(0, max s - 1), in %
//   undershoot          100 max(0, -min s), in %
//   settling_time       from `at` to the last time with |s - 1| > band; infinite when that is the end
//   rise_time           from the first s = 0.1 to the first s = 0.9; infinite when s does not get there
// As Simulink's stepinfo, but that bands and overshoot refer to the step's height, not to the final value. Not a number
// for an empty window and for a step without height. Throws std::invalid_argument for a name that measures() does not
// list.
double measure(const Recording& recording, std::size_t column, std::string_view name,
               const MeasureOptions& options = {});

}  // namespace plantloop
