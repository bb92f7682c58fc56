// Regressors as text, `y(k-1), u(k-1..4), u(k-1)^2, y(k-1)*u(k-2), 1`, and the matrices that they make of data.

#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "identify/data/data_set.h"

namespace plantloop::identify {

// One signal at one lag, to a power: y2(k-3)^2.
struct Factor {
  bool of_output = false;
  int channel = 0;  // among the outputs or the inputs, from 0
  int lag = 1;      // samples, at least 1 for outputs and at least 0 for inputs
  int power = 1;    // at least 1
  friend auto operator<=>(const Factor&, const Factor&) = default;
};

// A product of factors, sorted, each signal and lag once; no factors are the constant 1.
struct Regressor {
  std::vector<Factor> factors;
  int degree() const;
  friend bool operator==(const Regressor&, const Regressor&) = default;
};

// Regressors of signals with these names.
struct RegressorSet {
  std::vector<std::string> inputs, outputs;
  std::vector<Regressor> list;
  // The last ones of `inputs`, one for each output, are no signals of the data but prediction errors e = y - yhat,
  // which a model with a noise model makes itself; 0: there are none.
  int errors = 0;

  Eigen::Index size() const { return static_cast<Eigen::Index>(list.size()); }
  int longest_lag() const;  // samples that must have passed before the first row
  bool uses_outputs() const;
  int data_inputs() const { return static_cast<int>(inputs.size()) - errors; }
  bool is_error(const Factor& factor) const { return !factor.of_output && factor.channel >= data_inputs(); }
};

// Reads a list. A name is a signal's, or y, u (of the only one), y1, u2 ... (by number). `y(k-1..3)` stands for three
// regressors, `u(k..2)` for lags 0 to 2; a product of ranges for all products; `1` for the constant. `e(k-1)`, or
// `e2(k-1)` of output 2, are prediction errors where no signal has that name. Raises IdentifyError with the place in
// the text: unknown names, outputs and errors at lag 0, regressors written twice.
RegressorSet parse_regressors(std::string_view text, const DataSet& data);
RegressorSet parse_regressors(std::string_view text, std::vector<std::string> inputs, std::vector<std::string> outputs);

// `y(k-1)*u(k-2)^2`, with the signals' names; reading it gives the same regressor.
std::string to_text(const Regressor& regressor, const RegressorSet& set);
std::string to_text(const RegressorSet& set);

// All products of the set's regressors up to a degree, `constant` first when asked for: the terms of a polynomial
// NARX model. The set's own regressors must be single signals to the power 1.
RegressorSet polynomial(const RegressorSet& set, int degree, bool constant = true);

// The row of regressors for sample k of signals with `samples x channels` values; k is at least longest_lag().
Eigen::VectorXd row_at(const RegressorSet& set, const Eigen::MatrixXd& u, const Eigen::MatrixXd& y, Eigen::Index k);

// What one-step prediction is fitted to. A row is left out when it or its target touches a missing value.
struct Regression {
  struct Row {
    std::size_t experiment;
    Eigen::Index sample;
  };
  Eigen::MatrixXd X;      // rows x regressors
  Eigen::MatrixXd Y;      // rows x outputs: the outputs at the rows' samples
  std::vector<Row> rows;  // where they come from
  Eigen::Index left_out = 0;
};

// The rows of all experiments, those before `first` samples of each left out (longest_lag() if that is more). Raises
// IdentifyError when no row is left.
Regression make_regression(const DataSet& data, const RegressorSet& set, Eigen::Index first = 0);

}  // namespace plantloop::identify
