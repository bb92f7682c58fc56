// A small diagram for every block type, made from its declarations alone.

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/block.h"

namespace plantloop::family {

// Pieces of a diagram that holds one instance, `it`, of a type.
struct Sample {
  const BlockType* type = nullptr;
  std::vector<std::pair<std::string, std::string>> parameters;  // that have no default, with values that fit
  std::vector<std::pair<std::string, int>> inputs;              // ports that need a wire, with their number of elements
  bool list = false;                                            // the inputs are entries of one list port
  bool sampled = false;                                         // runs at a rate of 0.1 s
  std::string_view written;                                     // of a block with a form of its own: its keys
  bool closed = false;  // each input is the signal minus the block's own output, as a constraint needs it

  // One line for `blocks:`. The inputs are called `<prefix>1`, `<prefix>2`, ...
  std::string instance(const std::string& name, const std::string& prefix = "in") const;
  // All that `record:` can show of an instance.
  std::vector<std::string> outputs(const std::string& name) const;
};

// A wire with so many elements: `signal` for one, "[signal, 0.9*signal, ...]" for more.
std::string wire(const std::string& signal, int elements);

// All types of the catalogue, each with the first combination of sizes that checks without a finding.
const std::vector<Sample>& samples();

// The whole file: smooth signals into the sample.
std::string diagram(const Sample& sample);

}  // namespace plantloop::family
