// Gaussian processes between normalised numbers as a model: one process for each output.

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "identify/approximator.h"
#include "identify/gp/fit_sparse.h"
#include "identify/gp/propagate.h"
#include "identify/gp/slopes.h"
#include "identify/narx/narx.h"
#include "identify/scaling.h"

namespace plantloop::identify {

class GpMap final : public Approximator {
 public:
  using Processes = std::vector<std::shared_ptr<const GpPosterior>>;
  // Raises IdentifyError when sizes differ or there is no process.
  GpMap(Processes processes, Scaling x, Scaling y);
  GpMap(const std::vector<GaussianProcess>& processes, Scaling x, Scaling y);

  std::string type() const override { return "gaussian_process"; }
  int inputs() const override { return processes_.front()->inputs(); }
  int outputs() const override { return static_cast<int>(processes_.size()); }
  int scratch_size() const override { return 0; }
  void evaluate(const double* x, double* y, double* scratch) const override;
  void derivative(const double* x, double* jacobian, double* scratch) const override;
  bool has_variance() const override { return true; }
  void variance(const double* x, double* result, double* scratch) const override;
  void variance_derivative(const double* x, double* jacobian, double* scratch) const override;
  void write(Item& item) const override;

  // Of a measurement of the output, in its units.
  double noise_variance(Eigen::Index output) const;
  // Of the targets in their units: densities of normalised ones, divided by the scales. The derivatives are by the
  // logarithms of the hyperparameters, which are those between normalised numbers.
  double log_likelihood(Eigen::Index output) const;
  Likelihood likelihood(Eigen::Index output) const;
  LeaveOneOut leave_one_out(Eigen::Index output) const;
  const Processes& processes() const { return processes_; }
  const GpPosterior& process(Eigen::Index output) const { return *processes_[static_cast<std::size_t>(output)]; }
  const Scaling& x_scaling() const { return x_; }
  const Scaling& y_scaling() const { return y_; }

 private:
  Eigen::MatrixXd point(const double* x) const;
  // What a target of the process stands for in the user's units; of slopes too.
  Eigen::VectorXd target_scales(Eigen::Index output) const;
  Processes processes_;
  Scaling x_, y_;
};

// The same processes with more measurements: hyperparameters and normalisation stay, the mean's coefficients are
// estimated anew. X, Y in the user's units. Raises IdentifyError.
std::shared_ptr<const GpMap> with_measurements(const GpMap& map, const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y);

struct GpMapFit {
  std::shared_ptr<const GpMap> model;
  FitReport report;  // of the first output; the others add their lines
};

struct GpModelOptions {
  GpOptions process;  // of each output
  int most = 1000;    // from more rows those are taken that lie far from each other
  bool normalise = true;
  // Of each output, or one for all: GpOptions::start, between normalised numbers.
  std::vector<Hyperparameters> given;
  // All rows through inducing inputs, which `inputs` gives in the user's units; then `most` says nothing.
  std::optional<SparseOptions> sparse;
};

// A process for each output. X: N x D, Y: N x outputs; `observations`: what else is known of each output, or none.
// Raises IdentifyError.
GpMapFit fit_gp_map(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y, const GpModelOptions& options = {},
                    const FitControl& control = {}, const std::vector<std::vector<Observation>>& observations = {});
// The same for regressors of data; `local_models` are linear models about their operating points, which stand for
// observations_of() them (J. Kocijan, D. Leith 2004; K. Azman, J. Kocijan 2007).
NarxModel fit_narx_gp(const DataSet& data, const RegressorSet& regressors, const GpModelOptions& options = {},
                      const FitControl& control = {}, const std::vector<PolynomialModel>& local_models = {});
inline NarxModel fit_narx_gp(const DataSet& data, const RegressorSet& regressors, const GpOptions& process) {
  return fit_narx_gp(data, regressors, GpModelOptions{.process = process});
}

// The map at points that are themselves uncertain, all in the user's units.
class UncertainMap {
 public:
  // Raises IdentifyError as Propagator does.
  UncertainMap(std::shared_ptr<const GpMap> map, Propagation method)
      : map_(std::move(map)), propagator_(map_->processes(), method) {}
  UncertainPrediction predict(const UncertainPoint& point) const;
  const GpMap& map() const { return *map_; }

 private:
  std::shared_ptr<const GpMap> map_;
  Propagator propagator_;
};

// The free run of a model that knows how uncertain it is, one sample after the other. All outputs are fed back, and the
// state holds mean and covariance of the last ones together: n = depth x outputs numbers, newest sample first and
// within a sample in the order of the outputs, then n x n.
class UncertainRun {
 public:
  // The regressors of outputs are single lags. `feed_noise`: the fed-back outputs include the noise v0 of each, as the
  // measured outputs did that a NARX model was made from. Raises IdentifyError.
  UncertainRun(std::shared_ptr<const GpMap> map, RegressorSet regressors, Propagation method, bool feed_noise = true);

  int depth() const { return depth_; }
  int outputs() const { return map_.map().outputs(); }
  int state_size() const { return kept() + kept() * kept(); }
  // x: the regressors, of which those of outputs are not read. Of the functions now; slopes are by the regressors.
  using Step = UncertainPrediction;
  Step predict(const double* x, const double* state) const;
  // The state after that step.
  void advance(const Step& step, const double* state, double* next) const;

 private:
  int kept() const { return depth_ * outputs(); }
  UncertainMap map_;
  RegressorSet regressors_;
  bool feed_noise_;
  int depth_;
  struct Lag {
    Eigen::Index regressor, kept;  // which of the kept numbers it is
  };
  std::vector<Lag> lags_;
};

// For each experiment samples x (m + m^2): means of the m functions, then their covariances row by row; so for one
// output mean and variance. The first samples are the measured ones, with covariance 0. Raises IdentifyError.
Outputs simulate_uncertain(const NarxModel& model, const DataSet& data, Propagation method, bool feed_noise = true);
// The same from trajectories that draw the outputs from their predicted distributions.
Outputs simulate_monte_carlo(const NarxModel& model, const DataSet& data, int trajectories, std::uint64_t seed = 1,
                             bool feed_noise = true);

}  // namespace plantloop::identify
