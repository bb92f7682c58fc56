// The recursion of prediction errors and of their derivatives.

#include "identify/mlp/noise_training.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/error.h"
#include "identify/mlp/normal_sum.h"
#include "identify/narx/noise_prediction.h"
#include "identify/narx/regressor_row.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {
constexpr double runaway = 1e12;  // of a sum of squares of normalised errors
}

NoiseTraining::NoiseTraining(Network shape, Scaling x, Scaling y, RegressorSet regressors, const DataSet& data,
                             NoiseOrders orders)
    : network_(std::move(shape)),
      x_(std::move(x)),
      y_(std::move(y)),
      regressors_(std::move(regressors)),
      experiments_(data.experiments),
      orders_(orders) {
  const Index first = regressors_.longest_lag();
  for (Experiment& experiment : experiments_) {
    if (!experiment.u.allFinite() || !experiment.y.topRows(std::min(first, experiment.samples())).allFinite())
      fail(
          "training with a noise model needs every input, and every output of the first {} samples; values are missing",
          first);
    for (Index k = first; k < experiment.samples(); ++k) {
      for (Index o = 0; o < experiment.y.cols(); ++o) targets_ += std::isfinite(experiment.y(k, o)) ? 1 : 0;
    }
    experiment.u = with_errors(regressors_, experiment.u);
  }
  if (targets_ == 0)
    fail("no sample is left to predict: the experiments are not longer than the longest lag {}", first);
}

NoiseFilters NoiseTraining::filters_of(const VectorXd& theta) const {
  NoiseFilters result;
  if (filters() == 0) return result;
  Index at = network_.parameters();
  for (Index o = 0; o < network_.outputs(); ++o) {
    for (const auto& [order, list] : {std::pair(orders_.nc, &result.C), std::pair(orders_.nd, &result.D)}) {
      VectorXd polynomial = VectorXd::Ones(order + 1);
      polynomial.tail(order) = theta.segment(at, order);
      list->push_back(std::move(polynomial));
      at += order;
    }
  }
  return result;
}

// One experiment, sample by sample.
struct NoiseTraining::Run {
  const NoiseTraining& t;
  Network network;
  NoiseFilters noise;
  const Experiment& experiment;
  MatrixXd u, y, e, s;
  VectorXd scratch, x, out;

  Run(const NoiseTraining& training, const VectorXd& theta, const Experiment& of)
      : t(training),
        network(training.network_),
        noise(training.filters_of(theta)),
        experiment(of),
        u(of.u),
        y(of.y),
        e(MatrixXd::Zero(of.y.rows(), of.y.cols())),
        s(e),
        scratch(network.scratch_size()),
        x(network.inputs()),
        out(network.outputs()) {
    network.set_theta(theta.head(network.parameters()));
  }

  // Regressors, normalised; false: they touch a missing output.
  bool row(Index k) {
    fill_row(t.regressors_, u, y, k, x.data());
    x = (x - t.x_.offset).cwiseQuotient(t.x_.scale);
    return !x.hasNaN();
  }
  // From the network's output at k.
  void take(Index k, bool whole) {
    for (Index o = 0; o < out.size(); ++o) {
      const double map = t.y_.offset[o] + t.y_.scale[o] * out[o];
      const bool known = whole && std::isfinite(experiment.y(k, o));
      const double rest = known ? experiment.y(k, o) - map : 0;
      e(k, o) = known ? rest - filtered_noise(noise, e, s, k, o) : 0;
      s(k, o) = rest;
      if (t.regressors_.errors > 0) u(k, t.regressors_.data_inputs() + o) = e(k, o);
      if (t.orders_.simulated) y(k, o) = map;
    }
  }
  double square(Index k) const { return e.row(k).transpose().cwiseQuotient(t.y_.scale).squaredNorm(); }
};

double NoiseTraining::sse(const VectorXd& theta) const {
  double sum = 0;
  for (const Experiment& experiment : experiments_) {
    Run run(*this, theta, experiment);
    for (Index k = regressors_.longest_lag(); k < experiment.samples(); ++k) {
      const bool whole = run.row(k);
      if (whole) run.network.evaluate(run.x.data(), run.out.data(), run.scratch.data());
      run.take(k, whole);
      sum += run.square(k);
      if (!(sum < runaway)) return std::numeric_limits<double>::infinity();
    }
  }
  return sum;
}

MatrixXd NoiseTraining::errors(const VectorXd& theta, MatrixXd* s) const {
  Index rows = 0, at = 0;
  for (const Experiment& experiment : experiments_) rows += experiment.samples();
  MatrixXd all(rows, network_.outputs());
  if (s != nullptr) s->resize(rows, network_.outputs());
  for (const Experiment& experiment : experiments_) {
    Run run(*this, theta, experiment);
    for (Index k = regressors_.longest_lag(); k < experiment.samples(); ++k) {
      const bool whole = run.row(k);
      if (whole) run.network.evaluate(run.x.data(), run.out.data(), run.scratch.data());
      run.take(k, whole);
    }
    all.middleRows(at, experiment.samples()) = run.e;
    if (s != nullptr) s->middleRows(at, experiment.samples()) = run.s;
    at += experiment.samples();
  }
  return all;
}

double NoiseTraining::normal(const VectorXd& theta, MatrixXd& R, VectorXd& g) const {
  const Index first = regressors_.longest_lag(), outputs = network_.outputs(), p = parameters();
  const Index weights = network_.parameters(), inputs = network_.inputs();
  const Index depth = std::max<Index>({first, orders_.nc, orders_.nd}) + 1;
  MatrixXd by_theta(weights, outputs), by_x(inputs, outputs);
  std::vector<RowSlope> slopes;
  // Derivatives of the map, of what it does not explain and of the errors in rings, in units of the outputs.
  std::vector<MatrixXd> map_ring(static_cast<std::size_t>(depth)), rest_ring(map_ring), error_ring(map_ring);
  const auto place = [&](Index k) { return static_cast<std::size_t>(k % depth); };
  NormalSum sum(p, R, g);
  double sse = 0;
  for (const Experiment& experiment : experiments_) {
    for (auto* const ring : {&map_ring, &rest_ring, &error_ring}) {
      for (MatrixXd& m : *ring) m.setZero(p, outputs);
    }
    Run run(*this, theta, experiment);
    for (Index k = first; k < experiment.samples(); ++k) {
      const bool whole = run.row(k);
      MatrixXd by_map = MatrixXd::Zero(p, outputs), by_rest = by_map, by_error = by_map;
      if (whole) {
        run.network.differentiate(run.x.data(), run.out.data(), by_theta.data(), by_x.data(), run.scratch.data());
        row_slopes(regressors_, run.u, run.y, k, slopes);
        by_map.topRows(weights) = by_theta * y_.scale.asDiagonal();
        for (const RowSlope& slope : slopes) {
          if (!slope.of_error && !orders_.simulated) continue;
          const VectorXd past =
              (slope.of_error ? error_ring : map_ring)[place(k - slope.lag)].col(slope.channel) * slope.value;
          for (Index o = 0; o < outputs; ++o)
            by_map.col(o) += y_.scale[o] * by_x(slope.regressor, o) / x_.scale[slope.regressor] * past;
        }
      }
      run.take(k, whole);
      sse += run.square(k);
      if (!(sse < runaway)) return std::numeric_limits<double>::infinity();
      for (Index o = 0; o < outputs; ++o) {
        if (!whole || !std::isfinite(experiment.y(k, o))) continue;
        by_rest.col(o) = -by_map.col(o);
        auto column = by_error.col(o);
        column = by_rest.col(o);
        Index at = weights + o * (orders_.nc + orders_.nd);
        for (Index i = 1; i <= orders_.nc; ++i, ++at) {
          if (i > k) continue;
          column -= run.noise.C[static_cast<std::size_t>(o)][i] * error_ring[place(k - i)].col(o);
          column[at] -= run.e(k - i, o);
        }
        for (Index i = 1; i <= orders_.nd; ++i, ++at) {
          if (i > k) continue;
          column += run.noise.D[static_cast<std::size_t>(o)][i] * rest_ring[place(k - i)].col(o);
          column[at] += run.s(k - i, o);
        }
        VectorXd::Map(sum.next(), p) = -column / y_.scale[o];
        sum.add(run.e(k, o) / y_.scale[o]);
      }
      map_ring[place(k)] = std::move(by_map);
      rest_ring[place(k)] = std::move(by_rest);
      error_ring[place(k)] = std::move(by_error);
    }
  }
  sum.finish();
  if (!std::isfinite(sse) || !R.allFinite() || !g.allFinite()) return std::numeric_limits<double>::infinity();
  return sse;
}

}  // namespace plantloop::identify
