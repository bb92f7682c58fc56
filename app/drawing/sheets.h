// Graph -> sheet: a diagram, or the inside of one of its subsystems, as a plain drawing of blocks and wires.
//
// Wires are expressions: sums become circles, constant factors become gains, products of signals become circles too,
// and whatever else is computed becomes one box with its formula. Inputs that only parameters feed are not drawn.

#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "engine/graph/graph.h"
#include "render/diagram/sheet.h"

namespace plantloop {

struct SheetOptions {
  int depth = 0;       // how many levels of subsystems are drawn open, in frames
  bool rates = false;  // write the sampling times below the blocks
  bool sizes = false;  // write the sizes of vectors and matrices on the wires
  bool units = false;  // write the units on the wires
  // What stands on the wires of signals, by their full paths: their values in a run.
  std::map<std::string, std::string> values = {};
  std::set<std::string> hidden = {};  // full paths of blocks and subsystems that are not drawn
};

// `scope` is an index into Graph::scopes; 0 is the diagram.
Sheet sheet_of(const Graph& graph, std::uint32_t scope, const SheetOptions& options);

}  // namespace plantloop
