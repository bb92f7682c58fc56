// Free runs that carry their uncertainty along.

#include <algorithm>
#include <cmath>

#include "identify/data/matching.h"
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

}  // namespace

UncertainPrediction UncertainMap::predict(const UncertainPoint& point) const {
  const Scaling &xs = map_->x_scaling(), &ys = map_->y_scaling();
  const VectorXd inverse = xs.scale.cwiseInverse();
  const UncertainPrediction found = propagator_.predict(
      {(point.mean - xs.offset).cwiseQuotient(xs.scale), point.covariance.cwiseProduct(inverse * inverse.transpose())});
  return {ys.offset + ys.scale.cwiseProduct(found.mean), found.covariance.cwiseProduct(ys.scale * ys.scale.transpose()),
          ys.scale.asDiagonal() * found.slope * inverse.asDiagonal()};
}

UncertainRun::UncertainRun(std::shared_ptr<const GpMap> map, RegressorSet regressors, Propagation method,
                           bool feed_noise)
    : map_(std::move(map), method), regressors_(std::move(regressors)), feed_noise_(feed_noise), depth_(0) {
  for (std::size_t r = 0; r < regressors_.list.size(); ++r) {
    for (const Factor& factor : regressors_.list[r].factors) {
      if (!factor.of_output) continue;
      if (regressors_.list[r].factors.size() > 1 || factor.power > 1)
        fail("uncertainty is carried along for single lags only, not for '{}'",
             to_text(regressors_.list[r], regressors_));
      lags_.push_back({static_cast<Index>(r), (factor.lag - 1) * outputs() + factor.channel});
      depth_ = std::max(depth_, factor.lag);
    }
  }
}

UncertainRun::Step UncertainRun::predict(const double* x, const double* state) const {
  const Index d = map_.map().inputs();
  const auto past = MatrixXd::Map(state + kept(), kept(), kept());
  UncertainPoint point{VectorXd::Map(x, d), MatrixXd::Zero(d, d)};
  for (const Lag& lag : lags_) {
    point.mean[lag.regressor] = state[lag.kept];
    for (const Lag& other : lags_) point.covariance(lag.regressor, other.regressor) = past(lag.kept, other.kept);
  }
  return map_.predict(point);
}

void UncertainRun::advance(const Step& step, const double* state, double* next) const {
  if (depth_ == 0) return;
  const Index m = outputs(), older = kept() - m;
  const auto past = MatrixXd::Map(state + kept(), kept(), kept());
  // cov(f, y(k - i)) = slope cov(x, y(k - i)), for all lags that are kept.
  MatrixXd cross = MatrixXd::Zero(m, kept());
  for (const Lag& lag : lags_) cross += step.slope.col(lag.regressor) * past.row(lag.kept);
  VectorXd mean(kept());
  MatrixXd covariance(kept(), kept());
  mean << step.mean, VectorXd::Map(state, older);
  covariance.topLeftCorner(m, m) = step.covariance;
  if (feed_noise_) {
    for (Index o = 0; o < m; ++o) covariance(o, o) += map_.map().noise_variance(o);
  }
  covariance.bottomRightCorner(older, older) = past.topLeftCorner(older, older);
  covariance.topRightCorner(m, older) = cross.leftCols(older);
  covariance.bottomLeftCorner(older, m) = cross.leftCols(older).transpose();
  VectorXd::Map(next, kept()) = mean;
  MatrixXd::Map(next + kept(), kept(), kept()) = covariance;
}

namespace {

// One row for each sample, of which the first are measured.
MatrixXd begun(const Experiment& experiment, Index first) {
  const Index m = experiment.y.cols(), measured = std::min(first, experiment.samples());
  MatrixXd result = MatrixXd::Zero(experiment.samples(), m + m * m);
  result.topLeftCorner(measured, m) = experiment.y.topRows(measured);
  return result;
}

void put_row(MatrixXd& result, Index k, const VectorXd& mean, const MatrixXd& covariance) {
  result.row(k) << mean.transpose(), covariance.reshaped().transpose();
}

}  // namespace

Outputs simulate_uncertain(const NarxModel& model, const DataSet& data, Propagation method, bool feed_noise) {
  const UncertainRun run(gp_of(model), model.regressors, method, feed_noise);
  const Index first = model.regressors.longest_lag(), m = run.outputs();
  check_data(model, data);
  check_free_run(data, first);
  Outputs outputs;
  for (const Experiment& experiment : data.experiments) {
    MatrixXd result = begun(experiment, first);
    VectorXd state = VectorXd::Zero(run.state_size()), next = state, x(model.map->inputs());
    for (Index i = 0; i < run.depth() && first - 1 - i < experiment.samples(); ++i)
      state.segment(i * m, m) = experiment.y.row(first - 1 - i).transpose();
    MatrixXd y = experiment.y;
    for (Index k = first; k < experiment.samples(); ++k) {
      fill_row(model.regressors, experiment.u, y, k, x.data());
      const UncertainRun::Step step = run.predict(x.data(), state.data());
      put_row(result, k, step.mean, step.covariance);
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
  if (trajectories < 2) fail("the number of trajectories is {}; it must be 2 or more", trajectories);
  const Index first = model.regressors.longest_lag(), m = map->outputs();
  check_data(model, data);
  check_free_run(data, first);
  const Scaling& ys = map->y_scaling();
  Random random(seed);
  Outputs outputs;
  for (const Experiment& experiment : data.experiments) {
    MatrixXd result = begun(experiment, first);
    std::vector<MatrixXd> past(static_cast<std::size_t>(trajectories), experiment.y);
    MatrixXd x(trajectories, map->inputs()), f(trajectories, m);
    VectorXd row(map->inputs());
    for (Index k = first; k < experiment.samples(); ++k) {
      for (int t = 0; t < trajectories; ++t) {
        fill_row(model.regressors, experiment.u, past[static_cast<std::size_t>(t)], k, row.data());
        x.row(t) = row.transpose();
      }
      std::vector<Prediction> at;
      for (const auto& process : map->processes()) at.push_back(process->predict(map->x_scaling().normalised(x)));
      for (int t = 0; t < trajectories; ++t) {
        for (Index o = 0; o < m; ++o) {
          const Prediction& its = at[static_cast<std::size_t>(o)];
          f(t, o) = ys.offset[o] + ys.scale[o] * (its.mean[t] + std::sqrt(its.variance[t]) * random.normal());
          const double noise = feed_noise ? std::sqrt(map->noise_variance(o)) * random.normal() : 0;
          past[static_cast<std::size_t>(t)](k, o) = f(t, o) + noise;
        }
      }
      const VectorXd mean = f.colwise().mean().transpose();
      const MatrixXd apart = f.rowwise() - mean.transpose();
      put_row(result, k, mean, apart.transpose() * apart / (trajectories - 1));
    }
    outputs.push_back(std::move(result));
  }
  return outputs;
}

}  // namespace plantloop::identify
