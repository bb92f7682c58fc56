// Predictions of any model that maps regressors to outputs: one step, k steps, free run.

#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "identify/data/data_set.h"
#include "identify/regressors/regressors.h"

namespace plantloop::identify {

// The outputs (as many as the data have) that a model gives for one row of regressors, as row_at() makes it.
using Predictor = std::function<Eigen::VectorXd(const Eigen::VectorXd& x)>;

// Samples x outputs for each experiment.
using Outputs = std::vector<Eigen::MatrixXd>;

// y(k) from measured outputs up to k - 1. Rows without a whole past (the first longest_lag() of each experiment, and
// those that touch missing values) are NaN.
Outputs one_step(const RegressorSet& set, const DataSet& data, const Predictor& f);
// y(k) from measured outputs up to k - steps, between them the model's own. The first longest_lag() + steps - 1 rows
// are NaN.
Outputs k_step(const RegressorSet& set, const DataSet& data, const Predictor& f, int steps);
// All outputs are the model's own; the first longest_lag() rows of each experiment are the measured ones and must not
// be missing. From where the outputs leave 1e6 times the measured range on, they are infinite: the model diverges.
Outputs free_run(const RegressorSet& set, const DataSet& data, const Predictor& f);
// A free run of any model with a past, `run`, from zero: as if `lag` samples with inputs and outputs of 0 went before,
// so that already the first row is the model's own.
Outputs from_zero(const DataSet& data, Eigen::Index lag, const std::function<Outputs(const DataSet&)>& run);

}  // namespace plantloop::identify
