// Exact partial derivatives of what a diagram computes, as operations: what linear models are made of.
//
// Between hits the held values stand still and the states flow; at a hit held values and next values are computed anew.
// Columns of all: the states by number, the discrete states, the parameters asked for, the held values, the time.

#pragma once

#include <cstdint>
#include <vector>

#include "engine/program/differentiate.h"
#include "engine/program/resolve.h"

namespace plantloop {

struct LinearPartials {
  std::vector<std::uint32_t> held;  // operations that keep their value between hits and are read in between
  std::vector<Partial> flow;        // rows: derivatives by number, then watches
  // For each set of rates: rows: the held values, then the next values, then watches; those that do not change at such
  // a hit have no entries but the watches.
  std::vector<std::vector<Partial>> hits;
  std::vector<std::uint32_t> opaque;  // sites of kernels whose derivative is not known: their part is missing
};

struct LinearRequest {
  std::vector<std::uint32_t> by;    // parameters of the Record
  std::vector<std::uint32_t> open;  // watches that count as constant where they are read
  std::vector<Mask> hits;           // sets of rates that have their hits at one instant
};
LinearPartials linear_partials(Resolved& resolved, std::size_t states, std::size_t discretes,
                               const LinearRequest& request);

}  // namespace plantloop
