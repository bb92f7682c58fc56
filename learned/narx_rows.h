// Regressors along arrays that run with time, and how a step depends on the past.

#pragma once

#include <vector>

#include "identify/narx/narx.h"

namespace plantloop {

// Pointers `u` and `y` are to the inputs and outputs of one sample k; those before stand before them, sample by sample.
class NarxRows {
 public:
  explicit NarxRows(const identify::RegressorSet& set);

  int size() const { return static_cast<int>(products_.size()); }
  // The longest lag, at least 1.
  int past_inputs() const { return past_inputs_; }
  int past_outputs() const { return past_outputs_; }
  int shortest_input() const { return shortest_input_; }  // lag; past_inputs() when no input is read

  // The regressors of y(k+1).
  void row(const double* u, const double* y, double* x) const;
  // Adds weight times the derivative of regressor r of y(k+1) by variables that u and y depend on: `by_u` and `by_y`
  // stand as u and y do, with a row of `variables` numbers for each.
  void add_slope(int r, double weight, const double* u, const double* y, const double* by_u, const double* by_y,
                 int variables, double* result) const;

 private:
  struct Place {
    bool of_output;
    int offset;  // from u or y
    int power;
  };
  std::vector<std::vector<Place>> products_;
  int past_inputs_ = 1, past_outputs_ = 1, shortest_input_ = 0;
};

}  // namespace plantloop
