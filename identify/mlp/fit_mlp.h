// Multilayer perceptrons from data, from many starts.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "identify/fit/training.h"
#include "identify/mlp/network.h"
#include "identify/narx/narx.h"

namespace plantloop::identify {

struct MlpOptions {
  std::vector<int> hidden{10};
  Activation activation = Activation::tanh;
  Activation output_activation = Activation::linear;
  TrainingOptions training;
  int starts = 20;
  double spread = 0.5;    // first weights lie in (-spread, spread)
  bool normalise = true;  // inputs and outputs to mean 0 and standard deviation 1
  // Direct connections from the inputs to the outputs. A start is then the linear model of least squares, the neurons
  // not yet connected to the outputs, so that no start is worse than that.
  bool direct = false;
  std::uint64_t seed = 1;
  int threads = 0;  // 0: as many as the machine has; the result does not depend on it
  // Dynamic models: the criterion. With simulation the `refined` best starts of one-step training go on through time.
  bool simulation = false;
  int refined = 3;
  int one_step_iterations = 0;  // of the training before that; 0: training.iterations
  // Lengths in samples of the free runs to train on, one after the other; 0, or no list: whole experiments. A run over
  // a short piece of the record, from measured outputs, forgives a model that is not yet good.
  std::vector<int> horizons;
  // Orders of the linear filters of a noise model, C e = D (y - map). C alone makes a NARMAX model, as prediction
  // errors among the regressors do; with `simulation` a filter makes an NBJ model. D stands beside a simulated map
  // only.
  int nc = 0, nd = 0;
};

struct MlpFit {
  std::shared_ptr<const Mlp> model;
  FitReport report;            // `reached`: mean square of the error of the normalised outputs
  std::vector<double> errors;  // of each start, the root of it; infinite where it led nowhere
  TrainingResult training;     // of the start that was kept
  // Where the starts ended, or those that went on to simulation, best first.
  std::vector<Eigen::VectorXd> ends;
};

// A static map. X: N x D, Y: N x outputs. With validation data the start with the least validation error is kept, and
// each start ends early; without, the one with the least criterion. Raises IdentifyError.
MlpFit fit_mlp(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y, const MlpOptions& options = {},
               const FitControl& control = {});
MlpFit fit_mlp(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y, const Eigen::MatrixXd& X_validation,
               const Eigen::MatrixXd& Y_validation, const MlpOptions& options, const FitControl& control = {});

// A NARX model (criterion of one step) or NOE model (of simulation), NFIR when the regressors have no outputs. With
// simulation, validation is done by simulation too. `validation` may have no experiments.
//
// With a noise model (see MlpOptions::nc) that model without it comes first. Its `refined` best ends go on, the network
// and the noise together, by the prediction error method of mlp/noise_training.h: with no noise model to begin with,
// and beginning with the residuals of the first stage as known errors (extended least squares) or an AR model of them
// as D.
struct NarxMlpFit {
  NarxModel model;
  MlpFit map;
};
NarxMlpFit fit_narx_mlp(const DataSet& data, const RegressorSet& regressors, const DataSet& validation,
                        const MlpOptions& options, const FitControl& control = {});

// Goes on from a model: `map` may come from another fit, from a file, or be pruned (weights that are exactly 0 stay 0
// with `keep_zeros`). With simulation and `validation` the weights with the least error of its free run are kept.
NarxMlpFit refine_narx_mlp(const DataSet& data, const RegressorSet& regressors, const Mlp& map,
                           const MlpOptions& options, bool keep_zeros = false, const FitControl& control = {},
                           const DataSet& validation = {});

}  // namespace plantloop::identify
