// Polynomial NARX models as maps with a past, so that blocks run them as they run networks.

#pragma once

#include "identify/linear/regression_model.h"
#include "identify/narx/narx.h"

namespace plantloop::identify {

// The same model: its regressors are the single signals and lags that occur in it, its map the normalisation and the
// sum of products. Free run and prediction give the numbers of `model`.
NarxModel to_narx(const RegressionModel& model);

}  // namespace plantloop::identify
