// Exact derivatives of operations, as operations.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/program/operation_graph.h"

namespace plantloop {

// An entry of a sparse matrix of derivatives.
struct Partial {
  std::uint32_t row, column;
  Value value;
};

// The partial of an operation's result with respect to operand `k` (0, 1, 2); `result` is the operation itself.
Value partial_of(const OperationGraph& graph, const Operation& o, Value result, int k);

// d roots[row] / d leaf, where a leaf is an operation of kind `op` and `column` its index (Op::state: the index of a
// state), in order of rows, columns ascending; entries that are zero by structure do not appear. Modes are frozen: the
// partials of min, max, abs and where are those of the active side. `opaque` receives the sites of kernels whose
// derivative is not known; their contribution is missing. Loops are differentiated at their solution.
std::vector<Partial> differentiate(OperationGraph& graph, const std::vector<std::uint32_t>& roots, Op op,
                                   std::vector<std::uint32_t>& opaque);

// The derivative of an operation by time along the run, where `derivatives` are those of the states: d/dt + sum of
// x_i' d/dx_i, modes frozen and held values constant. Kernels count as constant.
std::uint32_t slope(OperationGraph& graph, std::uint32_t operation, const std::vector<std::uint32_t>& derivatives);

// The same by these operations instead of leaves; `column` is a place among them. Whatever was made before the first of
// them does not depend on it. Operations are made at the graph's present rate. `only_continuous`: what is held does not
// move with the leaves.
std::vector<Partial> differentiate_by(OperationGraph& graph, const std::vector<std::uint32_t>& roots,
                                      const std::vector<std::uint32_t>& leaves, std::vector<std::uint32_t>& opaque,
                                      bool only_continuous = false);

}  // namespace plantloop
