// One row of regressors from the past, and how it depends on the past outputs.

#pragma once

#include <Eigen/Core>

#include "identify/regressors/regressors.h"

namespace plantloop::identify {

// x for sample k from u (samples x inputs) and y (samples x outputs); k is at least set.longest_lag().
void fill_row(const RegressorSet& set, const Eigen::MatrixXd& u, const Eigen::MatrixXd& y, Eigen::Index k, double* x);

// d x_r/d y_channel(k - lag), or d x_r/d e_channel(k - lag), where it is not zero at every instant.
struct RowSlope {
  Eigen::Index regressor;
  int channel;  // of the output whose value or prediction error it is
  int lag;
  double value;
  bool of_error;
};
// All of them at sample k, in the order of the regressors; `slopes` is emptied first.
void row_slopes(const RegressorSet& set, const Eigen::MatrixXd& u, const Eigen::MatrixXd& y, Eigen::Index k,
                std::vector<RowSlope>& slopes);

}  // namespace plantloop::identify
