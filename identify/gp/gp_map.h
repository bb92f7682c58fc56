// Gaussian processes between normalised numbers as a model: one process for each output.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "identify/approximator.h"
#include "identify/gp/fit_gp.h"
#include "identify/gp/propagate.h"
#include "identify/gp/slopes.h"
#include "identify/narx/narx.h"
#include "identify/scaling.h"

namespace plantloop::identify {

class GpMap final : public Approximator {
 public:
  // Raises IdentifyError when sizes differ or there is no process.
  GpMap(std::vector<GaussianProcess> processes, Scaling x, Scaling y);

  std::string type() const override { return "gaussian_process"; }
  int inputs() const override { return processes_.front().inputs(); }
  int outputs() const override { return static_cast<int>(processes_.size()); }
  int scratch_size() const override { return 0; }
  void evaluate(const double* x, double* y, double* scratch) const override;
  void derivative(const double* x, double* jacobian, double* scratch) const override;
  bool has_variance() const override { return true; }
  void variance(const double* x, double* result, double* scratch) const override;
  void variance_derivative(const double* x, double* jacobian, double* scratch) const override;
  void write(Item& item) const override;

  // Of a measurement of the output, in its units.
  double noise_variance(int output) const;
  const std::vector<GaussianProcess>& processes() const { return processes_; }
  const Scaling& x_scaling() const { return x_; }
  const Scaling& y_scaling() const { return y_; }

 private:
  Eigen::MatrixXd point(const double* x) const;
  std::vector<GaussianProcess> processes_;
  Scaling x_, y_;
};

// The same processes with more measurements: hyperparameters and normalisation stay, the mean's coefficients are
// estimated anew. X, Y in the user's units. Raises IdentifyError.
std::shared_ptr<const GpMap> with_measurements(const GpMap& map, const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y);

struct GpMapFit {
  std::shared_ptr<const GpMap> model;
  FitReport report;  // of the first output; the others add their lines
};

// Normalises, and fits a process for each output. From more than `most` rows those are taken that lie far from each
// other. X: N x D, Y: N x outputs. Raises IdentifyError.
// `observations`: what else is known of each output, or none.
GpMapFit fit_gp_map(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y, const GpOptions& options = {}, int most = 1000,
                    const FitControl& control = {}, const std::vector<std::vector<Observation>>& observations = {});
// The same for regressors of data; `local_models` are linear models about their operating points, which stand for
// observations_of() them (J. Kocijan, D. Leith 2004; K. Azman, J. Kocijan 2007).
NarxModel fit_narx_gp(const DataSet& data, const RegressorSet& regressors, const GpOptions& options = {},
                      int most = 1000, const FitControl& control = {},
                      const std::vector<PolynomialModel>& local_models = {});

// The free run of a model that knows how uncertain it is, one sample after the other. The state holds mean and
// covariance of the last outputs, newest first: `depth` numbers and depth x depth.
class UncertainRun {
 public:
  // The model has one output and its regressors are single lags. `feed_noise`: the fed-back output includes the noise
  // v0, as the measured outputs did that a NARX model was made from. Raises IdentifyError.
  UncertainRun(std::shared_ptr<const GpMap> map, RegressorSet regressors, Propagation method, bool feed_noise = true);

  int depth() const { return depth_; }
  int state_size() const { return depth_ + depth_ * depth_; }
  // x: the regressors, of which those of the output are not read. mean and variance of the function now.
  struct Step {
    double mean = 0;
    double variance = 0;
    Eigen::VectorXd slope;  // by the regressors
  };
  Step predict(const double* x, const double* state) const;
  // The state after that step.
  void advance(const Step& step, const double* state, double* next) const;

 private:
  std::shared_ptr<const GpMap> map_;
  RegressorSet regressors_;
  Propagator propagator_;
  bool feed_noise_;
  int depth_;
  std::vector<std::pair<Eigen::Index, int>> lags_;  // regressor, lag of the output
};

// For each experiment samples x 2: mean and variance of the function. The first samples are the measured ones, with
// variance 0. Raises IdentifyError.
Outputs simulate_uncertain(const NarxModel& model, const DataSet& data, Propagation method, bool feed_noise = true);
// The same from trajectories that draw each output from its predicted distribution.
Outputs simulate_monte_carlo(const NarxModel& model, const DataSet& data, int trajectories, std::uint64_t seed = 1,
                             bool feed_noise = true);

}  // namespace plantloop::identify
