// Moving a compiled diagram's frame to a rest.

#pragma once

#include <utility>
#include <vector>

#include "engine/analysis/linear_program.h"
#include "engine/analysis/linearise.h"

namespace plantloop {

// A TrimRequest by numbers.
struct TrimPoint {
  struct Bound {
    std::size_t index = 0;
    double lower = -unbounded, upper = unbounded;
  };
  std::vector<Bound> probes;                            // free ones, with bounds of the wire's value
  std::vector<Bound> states;                            // by place; then the discrete states
  std::vector<std::pair<std::size_t, double>> fixed;    // states and their values
  std::vector<std::pair<std::size_t, double>> outputs;  // watches and what they must be
  std::vector<std::size_t> probe_outputs;               // the watch that shows each free probe's wire
};

// Leaves the frame at the point that was found.
Trim go_to_rest(LinearProgram& program, const TrimPoint& point);

}  // namespace plantloop
