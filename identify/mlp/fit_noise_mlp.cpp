// Networks with a model of the noise: NARMAX and NBJ.

#include <algorithm>
#include <cmath>
#include <optional>

#include "identify/error.h"
#include "identify/fit/parallel.h"
#include "identify/linear/least_squares.h"
#include "identify/mlp/fit_parts.h"
#include "identify/mlp/noise_training.h"
#include "identify/mlp/problems.h"
#include "identify/narx/noise_prediction.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Regressors without prediction errors, and where they stand among all.
RegressorSet without_errors(const RegressorSet& set, std::vector<Index>& kept) {
  RegressorSet rest{set.inputs, set.outputs, {}, 0};
  rest.inputs.resize(static_cast<std::size_t>(set.data_inputs()));
  for (std::size_t i = 0; i < set.list.size(); ++i) {
    const std::vector<Factor>& factors = set.list[i].factors;
    if (std::any_of(factors.begin(), factors.end(), [&](const Factor& f) { return set.is_error(f); })) continue;
    rest.list.push_back(set.list[i]);
    kept.push_back(static_cast<Index>(i));
  }
  if (rest.list.empty()) fail("there must be a regressor that is no prediction error");
  return rest;
}

// The same network with more inputs, whose weights are 0.
Network with_inputs(const Network& network, const std::vector<Index>& kept, Index inputs) {
  Network wide = network;
  MatrixXd& w = wide.layers.front().w;
  const MatrixXd narrow = w;
  w.setZero(narrow.rows(), inputs + 1);
  w.rightCols(1) = narrow.rightCols(1);
  if (wide.direct.size() > 0) wide.direct.setZero(network.outputs(), inputs);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    w.col(kept[i]) = narrow.col(static_cast<Index>(i));
    if (wide.direct.size() > 0) wide.direct.col(kept[i]) = network.direct.col(static_cast<Index>(i));
  }
  return wide;
}

// d of (1 + d1 q^-1 + ...) s = white, by least squares: one column after the other for each output.
VectorXd autoregression(const MatrixXd& s, int nc, int nd) {
  VectorXd filters = VectorXd::Zero((nc + nd) * s.cols());
  for (Index o = 0; o < s.cols() && nd > 0 && s.rows() > 2 * nd; ++o) {
    MatrixXd past(s.rows() - nd, nd);
    for (Index i = 1; i <= nd; ++i) past.col(i - 1) = -s.col(o).segment(nd - i, past.rows());
    filters.segment(o * (nc + nd) + nc, nd) = least_squares(past, s.col(o).tail(past.rows())).theta;
  }
  return filters;
}

// Data whose inputs are followed by prediction errors, given for all experiments below each other.
DataSet with_known_errors(const DataSet& data, const RegressorSet& set, const MatrixXd& e) {
  DataSet known = data;
  for (std::size_t i = static_cast<std::size_t>(set.data_inputs()); i < set.inputs.size(); ++i)
    known.inputs.push_back({set.inputs[i], ""});
  Index at = 0;
  for (Experiment& experiment : known.experiments) {
    const Index rows = experiment.samples();
    experiment.u = with_errors(set, experiment.u);
    experiment.u.rightCols(set.errors) = e.middleRows(at, rows);
    at += rows;
  }
  return known;
}

}  // namespace

NarxMlpFit fit_with_noise(const DataSet& data, const RegressorSet& regressors, const DataSet& validation,
                          const MlpOptions& options, const FitControl& control) {
  if (options.simulation && regressors.errors > 0)
    fail("NBJ has its noise model beside the map, so no prediction errors are among its regressors");
  if (options.simulation && !regressors.uses_outputs())
    fail("NBJ simulates its past outputs, but there are none among the regressors");
  MlpOptions plain = options;
  plain.nc = plain.nd = 0;
  std::vector<Index> kept;
  const RegressorSet rest = without_errors(regressors, kept);
  const NarxMlpFit base = fit_narx_mlp(data, rest, validation, plain, control);
  const Scaling& ys = base.map.model->y_scaling();
  const NoiseOrders orders{options.nc, options.nd, options.simulation};

  // What the first stage left over is the scale of the errors, and the first guess of them.
  const Network narrow = base.map.model->network();
  const NoiseTraining residual(narrow, base.map.model->x_scaling(), ys, rest, data, {0, 0, options.simulation});
  const MatrixXd left = residual.errors(narrow.theta());
  Scaling xs = no_scaling(regressors.size());
  RegressorSet all = regressors;
  all.errors = 0;
  std::optional<Regression> rows;
  if (regressors.errors > 0) {
    rows = make_regression(with_known_errors(data, regressors, left), all);
    if (options.normalise) xs.scale = standard_scaling(rows->X).scale;
  }
  for (std::size_t i = 0; i < kept.size(); ++i) {
    xs.offset[kept[i]] = base.map.model->x_scaling().offset[static_cast<Index>(i)];
    xs.scale[kept[i]] = base.map.model->x_scaling().scale[static_cast<Index>(i)];
  }

  const Network shape = with_inputs(narrow, kept, regressors.size());
  const NoiseTraining training(shape, xs, ys, regressors, data, orders);
  std::optional<NoiseTraining> held;
  if (!validation.experiments.empty()) held.emplace(shape, xs, ys, regressors, validation, orders);
  const Training* check = held ? &*held : nullptr;
  TrainingOptions how = options.training;
  how.fixed.clear();
  // Weight decay is of the network's weights, not of the filters.
  how.decays = VectorXd::Zero(training.parameters());
  how.decays.head(shape.parameters()).setConstant(options.training.decay);
  const int count = std::min<int>(options.refined, static_cast<int>(base.map.ends.size()));
  const int kinds = rows ? 2 : 1;
  Watch watch(control, static_cast<double>(count) * (2 * kinds - 1) * how.iterations);
  std::vector<TrainingResult> results(static_cast<std::size_t>(count * kinds));
  parallel_for(count * kinds, options.threads, [&](int i) {
    Network from = narrow;
    from.set_theta(base.map.ends[static_cast<std::size_t>(i / kinds)]);
    VectorXd theta(training.parameters());
    MatrixXd s;
    residual.errors(from.theta(), &s);
    from = with_inputs(from, kept, regressors.size());
    if (i % kinds == 1) {
      const StaticTraining known(shape, xs.normalised(rows->X), ys.normalised(rows->Y));
      from.set_theta(train(known, from.theta(), options.training, watch).theta);
    }
    theta << from.theta(), autoregression(s, options.nc, options.nd);
    results[static_cast<std::size_t>(i)] = train(training, theta, how, watch, check);
  });

  NarxMlpFit fit;
  fit.map = base.map;
  FitReport& report = fit.map.report;
  report.method = fmt::format("{}, prediction error method with a noise model", name_of(how.method));
  report.parameters = training.parameters();
  report.samples = training.targets();
  if (options.nc > 0) report.options.push_back(fmt::format("nc {}", options.nc));
  if (options.nd > 0) report.options.push_back(fmt::format("nd {}", options.nd));
  std::size_t best = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto end = static_cast<int>(i) / kinds + 1;
    report.tried.push_back(line_of(
        fmt::format("end {} with {}", end, kinds == 2 && i % 2 == 1 ? "extended least squares" : "a noise model"),
        results[i], training.targets(), check));
    if (score(results[i], check != nullptr) < score(results[best], check != nullptr)) best = i;
  }
  fit.map.training = results[best];
  if (!std::isfinite(score(fit.map.training, check != nullptr)))
    fail("no start of the noise model led to a finite error; fewer prediction errors or lower orders may help");
  Network network = shape;
  network.set_theta(fit.map.training.theta.head(shape.parameters()));
  report.reached = fit.map.training.sse / static_cast<double>(training.targets());
  report.iterations = fit.map.training.iterations;
  report.stopped = fit.map.training.stopped;
  fit.map.model = std::make_shared<Mlp>(std::move(network), xs, ys);
  fit.map.ends.clear();
  for (const TrainingResult& result : results) fit.map.ends.push_back(result.theta);
  fit.model = make_narx(fit.map.model, regressors, data, report);
  fit.model.simulated = options.simulation;
  fit.model.noise = training.filters_of(fit.map.training.theta);
  fit.model.noise.covariance = training.covariance(fit.map.training.theta, how.decays);
  return fit;
}

}  // namespace plantloop::identify
