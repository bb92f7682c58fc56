// Programs written in a test, compiled, and evaluated once.

#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/report.h"
#include "engine/program/program.h"
#include "engine/program/resolve.h"
#include "engine/run/frame.h"

namespace plantloop::testing_programs {

// A state with this derivative and initial value; its value.
struct StateIn {
  Value value;
  std::uint32_t index;
};
StateIn add_state(Recorder& recorder, const std::string& name, Value initial = 0);
StateIn add_discrete(Recorder& recorder, const std::string& name, RateIndex rate, Value initial = 0);

// The program; fails the test with the findings when there is none.
std::shared_ptr<const Program> compiled(const Recorder& recorder, std::vector<Value> watches = {},
                                        std::vector<Value> numbers = {}, const std::string& unroll_method = {},
                                        double unroll_step = 0);
// The findings of compiling, one message a line; "" when there are none. Algebraic loops are errors unless solved.
std::string findings_of(const Recorder& recorder, bool solve_loops = false);

// A frame in which states, time and parameters are set by the test.
class Evaluation {
 public:
  explicit Evaluation(std::shared_ptr<const Program> program) : frame_(std::move(program)) {}
  Frame& frame() { return frame_; }
  void set_state(std::uint32_t index, double value) { frame_.states()[frame_.program->place_of_state[index]] = value; }
  void set_discrete(std::uint32_t index, double value) { frame_.arena[frame_.program->discretes[index]] = value; }
  void set_time(double t) { frame_.arena[frame_.program->time] = t; }
  // Runs the parameters' list, the held one and takes modes until they stay.
  void settle();
  double mode(std::size_t index) { return frame_.arena[frame_.program->modes[index]]; }
  std::vector<double> watches();
  std::vector<double> derivatives();  // by the Record's states
  // df[row]/dx[column], by the Record's states, zeros where nothing is stored.
  std::vector<std::vector<double>> jacobian();

 private:
  std::vector<double> roots(const List& list);
  Frame frame_;
};

// Equal bits, or both not a number.
bool same_bits(double a, double b);

}  // namespace plantloop::testing_programs
