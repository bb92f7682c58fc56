// Random equations over all operations, with the value of each computed beside the recorder.

#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "tests/program/programs.h"

namespace plantloop::testing_programs {

struct RandomEquations {
  std::vector<Value> values;
  std::vector<double> numbers;  // the value of each by plain arithmetic
  // Whether the value, and all that it was computed from, is finite and does not hang on the sign of a zero.
  std::vector<bool> clean;
};

struct RandomShape {
  int layers = 20;
  int width = 4;         // operations of one kind in a layer
  bool regular = false;  // operands of a layer stand side by side
  bool smooth = false;   // only operations with derivatives, on moderate values
};

inline constexpr int leaf_count = 12;  // the first of RandomEquations::values: states, parameters, discretes, time

// Leaves: 4 states, 4 parameters, 2 discrete states of 2 rates, time; then the layers.
RandomEquations random_equations(Recorder& recorder, std::mt19937& random, const RandomShape& shape);
// Gives an evaluation the values of the leaves that the numbers were computed with.
void set_leaves(Evaluation& evaluation);

std::vector<Op> all_operations();

}  // namespace plantloop::testing_programs
