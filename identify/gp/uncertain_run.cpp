// Free runs that carry their uncertainty along.

#include <algorithm>
#include <cmath>

#include "identify/error.h"
#include "identify/gp/gp_map.h"
#include "identify/narx/regressor_row.h"
#include "identify/random.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::shared_ptr<const GpMap> gp_of(const NarxModel& model) {
  auto map = std::dynamic_pointer_cast<const GpMap>(model.map);
  if (!map) fail("only a Gaussian process knows how uncertain it is, this is '{}'", model.map->type());
  return map;
}

void check_start(const Experiment& experiment, Index first) {
  if (!experiment.u.allFinite() || !experiment.y.topRows(std::min(first, experiment.samples())).allFinite())
    fail("a simulation needs every input, and every output of the first {} samples; values are missing", first);
}

}  // namespace

UncertainRun::UncertainRun(std::shared_ptr<const GpMap> map, RegressorSet regressors, Propagation method,
                           bool feed_noise)
    : map_(std::move(map)),
      regressors_(std::move(regressors)),
      propagator_(map_->processes().front(), method),
      feed_noise_(feed_noise),
      depth_(0) {
  if (map_->outputs() != 1) fail("uncertainty is carried along for one output, this model has {}", map_->outputs());
  for (std::size_t r = 0; r < regressors_.list.size(); ++r) {
    for (const Factor& factor : regressors_.list[r].factors) {
      if (!factor.of_output) continue;
      if (regressors_.list[r].factors.size() > 1 || factor.power > 1)
        fail("uncertainty is carried along for single lags only, not for '{}'",
             to_text(regressors_.list[r], regressors_));
      lags_.emplace_back(static_cast<Index>(r), factor.lag);
      depth_ = std::max(depth_, factor.lag);
    }
  }
}

UncertainRun::Step UncertainRun::predict(const double* x, const double* state) const {
  const Index d = map_->inputs();
  const Scaling& xs = map_->x_scaling();
  const auto past = MatrixXd::Map(state + depth_, depth_, depth_);
  UncertainPoint point{VectorXd::Map(x, d), MatrixXd::Zero(d, d)};
  for (const auto& [r, lag] : lags_) {
    point.mean[r] = state[lag - 1];
    for (const auto& [s, other] : lags_)
      point.covariance(r, s) = past(lag - 1, other - 1) / (xs.scale[r] * xs.scale[s]);
  }
  point.mean = (point.mean - xs.offset).cwiseQuotient(xs.scale);
  const UncertainPrediction found = propagator_.predict(point);
  const double scale = map_->y_scaling().scale[0];
  return {map_->y_scaling().offset[0] + scale * found.mean, scale * scale * found.variance,
          scale * found.slope.cwiseQuotient(xs.scale)};
}

void UncertainRun::advance(const Step& step, const double* state, double* next) const {
  if (depth_ == 0) return;
  const auto past = MatrixXd::Map(state + depth_, depth_, depth_);
  // cov(y(k - i), f) = cov(y(k - i), x) slope, for all lags that are kept.
  VectorXd cross = VectorXd::Zero(depth_);
  for (const auto& [r, lag] : lags_) cross += step.slope[r] * past.col(lag - 1);
  VectorXd mean(depth_);
  MatrixXd covariance(depth_, depth_);
  mean[0] = step.mean;
  mean.tail(depth_ - 1) = VectorXd::Map(state, depth_ - 1);
  covariance(0, 0) = step.variance + (feed_noise_ ? map_->noise_variance(0) : 0);
  covariance.bottomRightCorner(depth_ - 1, depth_ - 1) = past.topLeftCorner(depth_ - 1, depth_ - 1);
  covariance.col(0).tail(depth_ - 1) = cross.head(depth_ - 1);
  covariance.row(0).tail(depth_ - 1) = cross.head(depth_ - 1).transpose();
  VectorXd::Map(next, depth_) = mean;
  MatrixXd::Map(next + depth_, depth_, depth_) = covariance;
}

Outputs simulate_uncertain(const NarxModel& model, const DataSet& data, Propagation method, bool feed_noise) {
  const UncertainRun run(gp_of(model), model.regressors, method, feed_noise);
  const Index first = model.regressors.longest_lag();
  Outputs outputs;
  for (const Experiment& experiment : data.experiments) {
    check_start(experiment, first);
    MatrixXd result = MatrixXd::Zero(experiment.samples(), 2);
    result.col(0).head(std::min(first, experiment.samples())) =
        experiment.y.col(0).head(std::min(first, experiment.samples()));
    VectorXd state = VectorXd::Zero(run.state_size()), next = state, x(model.map->inputs());
    for (int i = 0; i < run.depth() && first - 1 - i < experiment.samples(); ++i)
      state[i] = experiment.y(first - 1 - i, 0);
    MatrixXd y = experiment.y;
    for (Index k = first; k < experiment.samples(); ++k) {
      fill_row(model.regressors, experiment.u, y, k, x.data());
      const UncertainRun::Step step = run.predict(x.data(), state.data());
      result.row(k) << step.mean, step.variance;
      run.advance(step, state.data(), next.data());
      state.swap(next);
    }
    outputs.push_back(std::move(result));
  }
  return outputs;
}

Outputs simulate_monte_carlo(const NarxModel& model, const DataSet& data, int trajectories, std::uint64_t seed,
                             bool feed_noise) {
  const auto map = gp_of(model);
  if (map->outputs() != 1) fail("trajectories are drawn for one output, this model has {}", map->outputs());
  if (trajectories < 2) fail("the number of trajectories is {}; it must be 2 or more", trajectories);
  const Index first = model.regressors.longest_lag();
  const double scale = map->y_scaling().scale[0], offset = map->y_scaling().offset[0];
  Random random(seed);
  Outputs outputs;
  for (const Experiment& experiment : data.experiments) {
    check_start(experiment, first);
    MatrixXd result = MatrixXd::Zero(experiment.samples(), 2);
    result.col(0).head(std::min(first, experiment.samples())) =
        experiment.y.col(0).head(std::min(first, experiment.samples()));
    std::vector<MatrixXd> past(static_cast<std::size_t>(trajectories), experiment.y);
    MatrixXd x(trajectories, map->inputs());
    VectorXd row(map->inputs()), f(trajectories);
    for (Index k = first; k < experiment.samples(); ++k) {
      for (int t = 0; t < trajectories; ++t) {
        fill_row(model.regressors, experiment.u, past[static_cast<std::size_t>(t)], k, row.data());
        x.row(t) = row.transpose();
      }
      const Prediction at = map->processes()[0].predict(map->x_scaling().normalised(x));
      for (int t = 0; t < trajectories; ++t) {
        f[t] = offset + scale * (at.mean[t] + std::sqrt(at.variance[t]) * random.normal());
        const double noise = feed_noise ? std::sqrt(map->noise_variance(0)) * random.normal() : 0;
        past[static_cast<std::size_t>(t)](k, 0) = f[t] + noise;
      }
      const double mean = f.mean();
      result.row(k) << mean, (f.array() - mean).square().sum() / (trajectories - 1);
    }
    outputs.push_back(std::move(result));
  }
  return outputs;
}

}  // namespace plantloop::identify
