// A whole step of a fixed-step method as operations: for small models, where the trips between stages cost more than
// the stages.

#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/program/operation_graph.h"

namespace plantloop {

// The states after one step of size h (s) from the present ones, modes and held values frozen; empty when the method is
// not one of euler, heun, rk4, when kernels take part, or when the step would be long.
std::vector<std::uint32_t> unroll(OperationGraph& graph, const std::vector<std::uint32_t>& derivatives,
                                  std::string_view method, double h);

}  // namespace plantloop
