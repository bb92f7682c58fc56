// What the fits of networks share.

#pragma once

#include <Eigen/Core>
#include <string>

#include "identify/mlp/fit_mlp.h"

namespace plantloop::identify {

// What starts are compared by: the validation error, or the criterion; infinite where there is none.
double score(const TrainingResult& result, bool validated);
// A line of a report's `tried`.
// What the number that a fit reached is.
std::string measure_of(const MlpOptions& options);
std::string line_of(const std::string& what, const TrainingResult& result, Eigen::Index targets,
                    const Training* validation);

// fit_narx_mlp() for models with a noise model; the options are checked.
NarxMlpFit fit_with_noise(const DataSet& data, const RegressorSet& regressors, const DataSet& validation,
                          const MlpOptions& options, const FitControl& control);

}  // namespace plantloop::identify
