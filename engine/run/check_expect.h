// What can be said against `expect:` before anything has run.

#pragma once

#include "engine/graph/graph.h"
#include "engine/program/record.h"
#include "engine/run/simulation.h"

namespace plantloop {

// Reports events that no block has, times outside of the run that the file describes, ranges that are empty, and
// baselines that cannot be read. `record` is that of the graph.
void check_expect(const Graph& graph, const Record& record, const SimulationOptions& options, Report& report);

}  // namespace plantloop
