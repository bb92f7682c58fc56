// What stands on the face of a block: its formula with the numbers of the diagram, or a curve of what it does.

#pragma once

#include "engine/graph/graph.h"
#include "render/diagram/sheet.h"

namespace plantloop {

// Sets shape, formula and curves of a block of a type (not of an expression block or subsystem).
//
// A type that states an `icon`, a formula over its parameters and s or z, shows that. A type without states that has
// one input shows its characteristic, a source its waveform: both are found by running the block alone. All others show
// their names.
void give_face(const Graph& graph, const GraphBlock& block, SheetBlock& into);

}  // namespace plantloop
