// Units (S2, S3): known ones that differ must not meet. Numbers are never rescaled.

#pragma once

#include "engine/graph/graph.h"
#include "engine/graph/record.h"

namespace plantloop {

// Follows the units that the diagram states through expressions and the equations of the blocks, and reports where two
// that differ meet in a sum, a comparison, a choice or at a port. Nothing is done when the diagram states none.
void check_units(const Graph& graph, const RecordedGraph& recorded, Report& report);

}  // namespace plantloop
