// Prediction with a noise model: the errors of past predictions tell what the noise will be.

#pragma once

#include <Eigen/Core>

#include "identify/narx/narx.h"

namespace plantloop::identify {

// Of output o at sample k from the errors e and the parts s = y - map that the map does not explain, samples x outputs:
//   yhat(k) = map + sum c_i e(k-i) - sum d_i s(k-i);   what stands before the first sample is 0.
double filtered_noise(const NoiseFilters& noise, const Eigen::MatrixXd& e, const Eigen::MatrixXd& s, Eigen::Index k,
                      Eigen::Index o);

// The model has a noise model; experiments as validation/narx_prediction.h has them.
Outputs predict_with_noise(const NarxModel& model, const DataSet& data, int steps);

// The inputs with columns of zeros for the errors behind them.
Eigen::MatrixXd with_errors(const RegressorSet& set, const Eigen::MatrixXd& u);

}  // namespace plantloop::identify
