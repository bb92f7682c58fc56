// From a Record, in any order and with forward references, to operations in order with the roots that a run needs.

#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/report.h"
#include "engine/program/operation_graph.h"
#include "engine/program/record.h"

namespace plantloop {

// Everything that a run computes, as operations of `graph`; indices are those of the Record.
struct Resolved {
  OperationGraph graph;
  std::vector<std::uint32_t> derivatives;     // per continuous state
  std::vector<std::uint32_t> nexts;           // per discrete state
  std::vector<std::uint32_t> initial_states;  // evaluated once at the start
  std::vector<std::uint32_t> initial_discretes;
  std::vector<std::uint32_t> initial_kernels;  // kernel operations of the initial list, one per kernel
  std::vector<std::uint32_t> watches, numbers;
  struct Jump {
    std::uint32_t guard;
    std::uint32_t enabled;
    std::vector<std::uint32_t> values;  // in the order of the Record's assignments
  };
  std::vector<Jump> jumps;
  std::vector<std::uint32_t> activations;                      // per activation of the Record, from 1
  std::vector<std::pair<std::uint32_t, std::uint32_t>> holds;  // condition and value
  struct Schedule {
    std::vector<std::uint32_t> times;
    std::uint32_t first = 0, period = 0;
  };
  std::vector<Schedule> schedules;
  std::vector<std::vector<std::uint32_t>> advance_inputs;  // per kernel of the Record
};

// Algebraic loops are torn and stand in `graph.loops`; each is a note, or an error when `loops_are_errors`. Reports
// loops that cannot be solved and initial values that depend on each other, each with its closed path; after an error
// the result is of no use.
Resolved resolve(const Record& record, const std::vector<Value>& watches, const std::vector<Value>& numbers,
                 bool loops_are_errors, Report& report);

}  // namespace plantloop
