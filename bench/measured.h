// What one run of a benchmark gives, whoever computed it.

#pragma once

#include <chrono>
#include <string>

namespace plantloop::bench {

struct Measured {
  double seconds = 0;  // wall time of the simulation with its recording; reading and compiling not included
  double value = 0;    // last value of the last recorded signal: both sides must agree on it
};

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count(); }

 private:
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

// The engine's side, in engine_side.cpp: reads and compiles the diagram, then simulates it in this process.
Measured run_plantloop(const std::string& yaml_path);

}  // namespace plantloop::bench
