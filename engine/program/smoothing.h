// How smooth what comes out of one history is where it goes into another one.

#pragma once

#include <cstdint>
#include <vector>

#include "engine/program/resolve.h"

namespace plantloop {

// A kernel with histories whose outputs reach a signal, and the fewest integrations on the way there.
struct Smoothed {
  std::uint32_t kernel;  // of the Record
  int integrations;
};

// What reaches an operation through operations and states without another kernel with histories in between. What is
// held in between, sampled states, modes and what jumps set, changes at instants of its own and is not followed.
std::vector<Smoothed> histories_behind(const Resolved& resolved, std::uint32_t operation);

}  // namespace plantloop
