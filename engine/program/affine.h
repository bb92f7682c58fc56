// Which operations are affine in some of the leaves.

#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/program/operation_graph.h"

namespace plantloop {

// Whether all of `roots` are of the form c + sum a_i v_i, where the v_i are the leaves that `is_variable` names by
// operation and c and a_i do not depend on them. What a kernel or a loop makes of a variable counts as not affine.
bool are_affine(const OperationGraph& graph, const std::vector<std::uint32_t>& roots,
                const std::function<bool(const Operation&)>& is_variable);

}  // namespace plantloop
