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

// What linear filters know of the noise: C e = D s, for each output, with s = y - map; C = 1 + c1 q^-1 + ..., D
// likewise.
struct NoiseFilters {
  std::vector<Eigen::VectorXd> C, D;  // both empty: there are none
  // Of c1 ... cnc, d1 ... dnd of each output one after the other; empty: nobody knows it.
  Eigen::MatrixXd covariance;
  bool empty() const { return C.empty(); }
};

// The structures, by what the past is that the map sees (M. Norgaard, O. Ravn, N. Poulsen, L. Hansen 2000, chapter 2):
//
//   NFIR    inputs
//   NARX    measured outputs and inputs; NOE: the same, trained for its own free run
//   NARMAX  prediction errors e = y - yhat besides: among the regressors, e(k-1), or by the linear filter C
//   NBJ     the model's own noise-free outputs and inputs, C e = D (y - map): nonlinear Box-Jenkins
struct NarxModel {
  std::shared_ptr<const Approximator> map;  // from the regressors to the outputs
  RegressorSet regressors;
  DataSet channels;  // sampling time, names and units; no experiments
  Item data;         // what the file says about the data; an empty mapping for a model made by hand
  FitReport fit;
  bool simulated = false;  // NBJ: past outputs are the map's own
  NoiseFilters noise;

  bool has_noise_model() const { return regressors.errors > 0 || !noise.empty(); }
};

// "NFIR", "NARX" (NOE models too), "NARMAX" or "NBJ".
std::string structure_name(const NarxModel& model);

// The model that runs when nobody knows the errors: all of them are 0, so regressors with one are left out and past
// outputs are the model's own.
NarxModel noise_free(const NarxModel& model);

// Regressors, inputs and outputs fit together. Raises IdentifyError.
NarxModel make_narx(std::shared_ptr<const Approximator> map, RegressorSet regressors, const DataSet& data,
                    FitReport fit = {});

// Raises IdentifyError unless the data have the model's signals and its sampling time.
void check_data(const NarxModel& model, const DataSet& data);

// As the functions of these names in validation/narx_prediction.h. With a noise model the errors before the first
// prediction of an experiment and those of missing outputs are 0, those of steps that are not measured yet too; the
// free run is that of noise_free().
Outputs one_step(const NarxModel& model, const DataSet& data);
Outputs k_step(const NarxModel& model, const DataSet& data, int steps);
Outputs free_run(const NarxModel& model, const DataSet& data);

// The model file and back.
std::string to_yaml(const NarxModel& model);
NarxModel read_narx(const Item& item);

}  // namespace plantloop::identify
