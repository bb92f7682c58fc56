// The recursion of prediction errors and of their derivatives.

#include "identify/mlp/noise_training.h"

#include <Eigen/Eigenvalues>
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

template <typename Row>
double NoiseTraining::sweep(const VectorXd& theta, Row row) const {
  const Index first = regressors_.longest_lag(), outputs = network_.outputs(), p = parameters();
  const Index weights = network_.parameters(), inputs = network_.inputs();
  const Index depth = std::max<Index>({first, orders_.nc, orders_.nd}) + 1;
  MatrixXd by_theta(weights, outputs), by_x(inputs, outputs);
  std::vector<RowSlope> slopes;
  // Derivatives of the map, of what it does not explain and of the errors in rings, in units of the outputs.
  std::vector<MatrixXd> map_ring(static_cast<std::size_t>(depth)), rest_ring(map_ring), error_ring(map_ring);
  const auto place = [&](Index k) { return static_cast<std::size_t>(k % depth); };
  MatrixXd J(p, outputs);
  VectorXd errors(outputs);
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
      J.setZero();
      errors.setConstant(std::numeric_limits<double>::quiet_NaN());
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
        J.col(o) = -column / y_.scale[o];
        errors[o] = run.e(k, o) / y_.scale[o];
      }
      row(errors, J);
      map_ring[place(k)] = std::move(by_map);
      rest_ring[place(k)] = std::move(by_rest);
      error_ring[place(k)] = std::move(by_error);
    }
  }
  return sse;
}

double NoiseTraining::normal(const VectorXd& theta, MatrixXd& R, VectorXd& g) const {
  const Index p = parameters();
  NormalSum sum(p, R, g);
  const double sse = sweep(theta, [&](const VectorXd& errors, const MatrixXd& J) {
    for (Index o = 0; o < J.cols(); ++o) {
      if (!std::isfinite(errors[o])) continue;
      VectorXd::Map(sum.next(), p) = J.col(o);
      sum.add(errors[o]);
    }
  });
  sum.finish();
  if (!std::isfinite(sse) || !R.allFinite() || !g.allFinite()) return std::numeric_limits<double>::infinity();
  return sse;
}

MatrixXd NoiseTraining::covariance(const VectorXd& theta, const VectorXd& decays) const {
  const Index p = parameters(), own = filters(), outputs = network_.outputs();
  if (own == 0) return {};
  const MatrixXd unknown = VectorXd::Constant(own, std::numeric_limits<double>::infinity()).asDiagonal();
  MatrixXd R;
  VectorXd g;
  if (!std::isfinite(normal(theta, R, g))) return unknown;
  // In parameters of equal lengths, without directions that the data do not determine.
  const MatrixXd H = R + MatrixXd(decays.asDiagonal());
  const VectorXd scale = H.diagonal().cwiseSqrt().cwiseMax(1e-300);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scale.cwiseInverse().asDiagonal() * H *
                                                      scale.cwiseInverse().asDiagonal());
  if (eigen.info() != Eigen::Success) return unknown;
  VectorXd inverse = VectorXd::Zero(p);
  std::vector<bool> determined(static_cast<std::size_t>(own), true);
  for (Index i = 0; i < p; ++i) {
    if (eigen.eigenvalues()[i] > 1e-12 * eigen.eigenvalues()[p - 1]) {
      inverse[i] = 1 / eigen.eigenvalues()[i];
      continue;
    }
    for (Index c = 0; c < own; ++c) {
      if (std::fabs(eigen.eigenvectors()(p - own + c, i)) > 1e-6) determined[static_cast<std::size_t>(c)] = false;
    }
  }
  const MatrixXd half = scale.cwiseInverse().asDiagonal() * eigen.eigenvectors();
  const MatrixXd H_inverse = half * inverse.asDiagonal() * half.transpose();
  const double effective = H_inverse.cwiseProduct(R).sum() / static_cast<double>(outputs);

  MatrixXd S = MatrixXd::Zero(outputs, outputs), samples = S;
  sweep(theta, [&](const VectorXd& errors, const MatrixXd&) {
    for (Index a = 0; a < outputs; ++a) {
      for (Index b = 0; b < outputs; ++b) {
        if (!std::isfinite(errors[a] * errors[b])) continue;
        S(a, b) += errors[a] * errors[b];
        samples(a, b) += 1;
      }
    }
  });
  for (Index i = 0; i < S.size(); ++i) S.data()[i] /= std::max(1e-300, samples.data()[i] - effective);
  if (!(samples.diagonal().minCoeff() > effective)) return unknown;
  MatrixXd middle = MatrixXd::Zero(p, p);
  sweep(theta, [&](const VectorXd&, const MatrixXd& J) { middle.noalias() += J * S * J.transpose(); });
  const MatrixXd rows = H_inverse.bottomRows(own);
  MatrixXd covariance = rows * middle * rows.transpose();
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  for (Index c = 0; c < own; ++c) {
    if (determined[static_cast<std::size_t>(c)]) continue;
    covariance.row(c).setZero();
    covariance.col(c).setZero();
    covariance(c, c) = std::numeric_limits<double>::infinity();
  }
  return covariance;
}

}  // namespace plantloop::identify
