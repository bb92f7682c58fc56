// What a loop needs to be solved: its exact Jacobian, and what it reads from outside.

#pragma once

#include "engine/program/operation_graph.h"

namespace plantloop {

// Completes graph.loops[index] once its unknowns and residuals stand there; `rate` is that at whose hits it is solved.
void complete_loop(OperationGraph& graph, std::uint32_t index, RateIndex rate);

// The inverse of the Jacobian at the solution, row by row, as operations that read the unknowns: of one unknown a
// quotient, else the unknowns of linear loops that are added to the graph.
std::vector<Value> inverse_jacobian(OperationGraph& graph, std::uint32_t index);

}  // namespace plantloop
