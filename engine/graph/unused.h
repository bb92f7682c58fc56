// Outputs that are for nobody.

#pragma once

#include "engine/graph/graph.h"

namespace plantloop {

// A note on the blocks and subsystems of the diagram whose outputs nobody reads, records, draws or expects.
void check_unused(const Graph& graph, Report& report);

}  // namespace plantloop
