// Networks of local models: affine models, each valid in a part of the operating space, blended by smooth weights.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "identify/approximator.h"
#include "identify/fit_report.h"
#include "identify/narx/narx.h"

namespace plantloop::identify {

// An affine model y = parameters [x; 1] around a centre of the scheduling variables.
struct LocalModel {
  Eigen::VectorXd centre;      // S
  Eigen::VectorXd width;       // S, standard deviations of the weight
  Eigen::MatrixXd parameters;  // outputs x (D + 1), offset last
};

// y = sum_i mu_i(s) parameters_i [x; 1],  mu_i = w_i/sum_j w_j,  w_i = exp(-1/2 sum ((s - centre_i)/width_i)^2), where
// s are some of the regressors x. All numbers in the user's units. Far from all centres the nearest one, in its own
// widths, gets all the weight.
class LocalModelNetwork final : public Approximator {
 public:
  // scheduling: which regressors, from 0. Raises IdentifyError when sizes differ.
  LocalModelNetwork(std::vector<int> scheduling, std::vector<LocalModel> models);

  std::string type() const override { return "local_model_network"; }
  int inputs() const override { return static_cast<int>(models_.front().parameters.cols()) - 1; }
  int outputs() const override { return static_cast<int>(models_.front().parameters.rows()); }
  int scratch_size() const override { return 2 * static_cast<int>(models_.size()); }
  void evaluate(const double* x, double* y, double* scratch) const override;
  void derivative(const double* x, double* jacobian, double* scratch) const override;
  void write(Item& item) const override;

  // mu at regressors x, one for each model.
  void weights(const double* x, double* mu) const;
  const std::vector<LocalModel>& models() const { return models_; }
  const std::vector<int>& scheduling() const { return scheduling_; }

 private:
  std::vector<int> scheduling_;
  std::vector<LocalModel> models_;
};

enum class LocalEstimation {
  global,  // all parameters at once: the least error of the whole network
  local,   // each model by itself, rows weighted by its mu: models that are right around their centres
};

struct LocalModelOptions {
  std::vector<int> scheduling;  // regressors from 0; empty: all
  LocalEstimation estimation = LocalEstimation::local;
  double ridge = 1e-8;
  double width = 1.0 / 3;        // of a cell
  Eigen::VectorXd lower, upper;  // box of the scheduling variables; empty: that of the data
};

struct LocalModelFit {
  std::shared_ptr<const LocalModelNetwork> model;
  FitReport report;            // `reached`: mean square of the error
  std::vector<double> errors;  // of a tree: the root mean square for 1, 2, ... models
};

// A grid of `cells` equal cells along each scheduling variable. X: N x D, Y: N x outputs. Raises IdentifyError.
LocalModelFit fit_local_grid(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y, int cells,
                             const LocalModelOptions& options = {}, const FitControl& control = {});

// LOLIMOT (O. Nelles 2001): from one model to `models`, each time the worst cell (greatest sum of mu e^2) is cut in
// half along the axis that helps most; local estimation while the tree grows, the estimation asked for at the end.
// Where no cut helps, the next worst cell is tried. Never more models than rows over parameters of each: they would see
// fewer rows than they have parameters. A warning says so.
LocalModelFit fit_lolimot(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y, int models,
                          const LocalModelOptions& options = {}, const FitControl& control = {});

// The free run with blended outputs: each local model has a past of outputs of its own, and only the outputs are
// blended. free_run() blends parameters: one past for all. They agree for static models and differ for dynamic ones.
// The scheduling variables see the blended output. The model's map must be a LocalModelNetwork. Raises IdentifyError.
Outputs simulate_blended_outputs(const NarxModel& model, const DataSet& data);

}  // namespace plantloop::identify
