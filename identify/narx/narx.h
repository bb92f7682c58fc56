// A learned map with the regressors it was made for: a dynamic model that predicts one step ahead or runs free.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "identify/approximator.h"
#include "identify/data/data_set.h"
#include "identify/fit_report.h"
#include "identify/regressors/regressors.h"
#include "identify/validation/narx_prediction.h"

namespace plantloop::identify {

struct NarxModel {
  std::shared_ptr<const Approximator> map;  // from the regressors to the outputs
  RegressorSet regressors;
  DataSet channels;  // sampling time, names and units; no experiments
  Item data;         // what the file says about the data; an empty mapping for a model made by hand
  FitReport fit;
};

// Regressors, inputs and outputs fit together. Raises IdentifyError.
NarxModel make_narx(std::shared_ptr<const Approximator> map, RegressorSet regressors, const DataSet& data,
                    FitReport fit = {});

// As the functions of these names in validation/narx_prediction.h.
Outputs one_step(const NarxModel& model, const DataSet& data);
Outputs k_step(const NarxModel& model, const DataSet& data, int steps);
Outputs free_run(const NarxModel& model, const DataSet& data);

// The model file and back.
std::string to_yaml(const NarxModel& model);
NarxModel read_narx(const Item& item);

}  // namespace plantloop::identify
