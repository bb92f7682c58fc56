// NARX models that are linear in their parameters: y(k) = sum_j theta_j x_j(k), x the regressors; polynomial NARX
// models among them.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/data/preprocess.h"
#include "identify/fit_report.h"
#include "identify/regressors/regressors.h"
#include "identify/validation/narx_prediction.h"

namespace plantloop::identify {

struct RegressionModel {
  RegressorSet regressors;
  std::vector<Channel> inputs, outputs;
  double Ts = 1;                            // s
  bool normalised = false;                  // the regressors are of signals (x - offset)/scale
  Normalisation normalisation;              // only then
  Eigen::MatrixXd theta;                    // regressors x outputs
  std::vector<Eigen::MatrixXd> covariance;  // of each output's parameters
  Eigen::VectorXd variance;                 // of each output's error that was fitted, in the units of the regression
  FitReport fit;
};

struct RegressionOptions {
  double ridge = 0;
  bool normalise = false;  // fit normalised signals; polynomials want it
};
// Every regressor, for all outputs, by least squares.
RegressionModel fit_regression(const DataSet& data, const RegressorSet& set, const RegressionOptions& options = {},
                               const FitControl& control = {});

struct SelectionOptions {
  int most_terms = 20;
  bool normalise = true;
  // Fit the chosen terms to the error of the free run (exact gradients through time), not only to that of one step.
  bool simulation = true;
  // The number of terms is the one with the least free-run error on the last part of each experiment, which the choice
  // does not see; then all data are fitted.
  double validation = 0.3;
  int iterations = 60;  // of each fit of the free run, at most
};

// Terms from the candidates by orthogonal least squares: each next one explains most of what is left (S. Chen, S.
// Billings and W. Luo 1989; the error reduction ratio). One output. Candidates that diverge in free run are not taken
// unless all do, which is a warning.
RegressionModel fit_selected(const DataSet& data, const RegressorSet& candidates, const SelectionOptions& options = {},
                             const FitControl& control = {});

// The places of the columns of X in the order in which orthogonal least squares takes them, at most `most`, and the
// error reduction ratio of each: the part of y'y that it explains. Columns that depend on those before are not taken.
struct ForwardSelection {
  std::vector<Eigen::Index> order;
  std::vector<double> err;
};
ForwardSelection forward_selection(const Eigen::MatrixXd& X, const Eigen::VectorXd& y, Eigen::Index most);

// The fit of the free run: minimises sum (y - simulated)^2 from the model's own parameters. One output.
void fit_free_run(RegressionModel& model, const DataSet& data, int iterations, const FitControl& control = {});

Outputs one_step(const RegressionModel& model, const DataSet& data);
Outputs k_step(const RegressionModel& model, const DataSet& data, int steps);
Outputs free_run(const RegressionModel& model, const DataSet& data);

Item to_item(const RegressionModel& model);
RegressionModel regression_model_of(const Item& item);

}  // namespace plantloop::identify
