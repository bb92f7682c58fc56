// Where a NaN or an infinity was born.

#pragma once

#include <cstdint>
#include <string>

#include "engine/base/error.h"
#include "engine/run/frame.h"

namespace plantloop {

// "not a number", "infinite", or the number.
std::string number_in_words(double value);

// The error that says `what` happened at time t (s), and which operation of which block first gave a value that is not
// finite from finite operands, below the operation `root` of the Program's graph and with the frame's present values.
RunError not_finite(const Frame& frame, std::uint32_t root, const std::string& what, double t);

// The error that a solver met at a state: with the state's name, and where its derivative came from when that is not
// finite.
RunError solver_failed(const Frame& frame, std::uint32_t derivative, const RunError& error, const std::string& number,
                       const std::string& state);

}  // namespace plantloop
