// What the mathematics did: an error of a run, with its time and place.

#pragma once

#include <limits>
#include <stdexcept>
#include <string>

namespace plantloop {

// Thrown when a run cannot go on. `what()` is the whole message for the user, time and block included.
class RunError : public std::runtime_error {
 public:
  explicit RunError(const std::string& message, double time = std::numeric_limits<double>::quiet_NaN(),
                    std::string place = {})
      : std::runtime_error(message), time_(time), place_(std::move(place)) {}
  double time() const { return time_; }                // simulated time in s; NaN when it has none
  const std::string& place() const { return place_; }  // path of the block; "" when it has none

 private:
  double time_;
  std::string place_;
};

// Thrown when a limit (rows, memory, steps, time) was reached or the run was cancelled.
class LimitError : public RunError {
 public:
  using RunError::RunError;
};

}  // namespace plantloop
