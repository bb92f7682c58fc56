// A sampled subsystem as a function block in structured text (IEC 61131-3), for a programmable controller.

#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/base/report.h"
#include "engine/run/diagram.h"

namespace plantloop {

struct StructuredTextRequest {
  std::string part;  // path of the subsystem, "loop.controller"
  std::string name;  // of the function block; "": the part's
  Overrides set;
};

// A FUNCTION_BLOCK that computes, when it is called once in each period, what the part computes at its hits: the same
// operations on LREAL numbers in the same order, with the parameters' values as constants and the states as the
// diagram's start sets them. Its inputs and outputs are scalars; all of its states have one rate. Nothing after
// reporting, with its block and place, what has no counterpart: continuous states, kernels (delays, tables of more than
// linear pieces, learned maps), the time, modes of continuous signals, conditional parts.
std::optional<std::string> structured_text(const std::shared_ptr<const Model>& model,
                                           const StructuredTextRequest& request, Report& report);

}  // namespace plantloop
