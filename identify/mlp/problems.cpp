// Errors of networks and the normal equations of their derivatives, summed block by block.

#include "identify/mlp/problems.h"

#include <cmath>
#include <limits>

#include "identify/error.h"
#include "identify/mlp/normal_sum.h"
#include "identify/narx/regressor_row.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

StaticTraining::StaticTraining(Network shape, MatrixXd x, const MatrixXd& y)
    : network_(std::move(shape)), x_(x.transpose()), y_(y.transpose()) {}

double StaticTraining::sse(const VectorXd& theta) const {
  Network network = network_;
  network.set_theta(theta);
  VectorXd scratch(network.scratch_size()), out(network.outputs());
  double sum = 0;
  for (Index k = 0; k < x_.cols(); ++k) {
    if (k % 256 == 0) look_up();
    network.evaluate(x_.col(k).data(), out.data(), scratch.data());
    sum += (y_.col(k) - out).squaredNorm();
  }
  return sum;
}

double StaticTraining::normal(const VectorXd& theta, MatrixXd& R, VectorXd& g) const {
  Network network = network_;
  network.set_theta(theta);
  const Index p = network.parameters(), outputs = network.outputs();
  VectorXd scratch(network.scratch_size()), out(outputs), gradients(p * outputs);
  NormalSum sum(p, R, g);
  double sse = 0;
  for (Index k = 0; k < x_.cols(); ++k) {
    // Of one output the gradient is written where it is needed.
    network.differentiate(x_.col(k).data(), out.data(), outputs == 1 ? sum.next() : gradients.data(), nullptr,
                          scratch.data());
    for (Index o = 0; o < outputs; ++o) {
      if (outputs > 1) VectorXd::Map(sum.next(), p) = gradients.segment(o * p, p);
      const double error = y_(o, k) - out[o];
      sse += error * error;
      sum.add(error);
    }
  }
  sum.finish();
  return sse;
}

SimulationTraining::SimulationTraining(Network shape, Scaling x, Scaling y, RegressorSet regressors,
                                       const DataSet& data)
    : network_(std::move(shape)),
      x_(std::move(x)),
      y_(std::move(y)),
      regressors_(std::move(regressors)),
      experiments_(data.experiments) {
  const Index first = regressors_.longest_lag();
  for (const Experiment& experiment : experiments_) {
    if (!experiment.u.allFinite() || !experiment.y.topRows(std::min(first, experiment.samples())).allFinite())
      fail("training for simulation needs every input, and every output of the first {} samples; values are missing",
           first);
    for (Index k = first; k < experiment.samples(); ++k) {
      for (Index o = 0; o < experiment.y.cols(); ++o) targets_ += std::isfinite(experiment.y(k, o)) ? 1 : 0;
    }
  }
  if (targets_ == 0)
    fail("no sample is left to simulate: the experiments are not longer than the longest lag {}", first);
}

namespace {
constexpr double runaway = 1e12;  // of a sum of squares of normalised errors
}

double SimulationTraining::sse(const VectorXd& theta) const {
  Network network = network_;
  network.set_theta(theta);
  const Index first = regressors_.longest_lag(), outputs = network.outputs();
  VectorXd scratch(network.scratch_size()), out(outputs), x(network.inputs());
  double sum = 0;
  for (const Experiment& experiment : experiments_) {
    MatrixXd y = experiment.y;
    for (Index k = first; k < y.rows(); ++k) {
      if (k % 256 == 0) look_up();
      fill_row(regressors_, experiment.u, y, k, x.data());
      x = (x - x_.offset).cwiseQuotient(x_.scale);
      network.evaluate(x.data(), out.data(), scratch.data());
      for (Index o = 0; o < outputs; ++o) {
        y(k, o) = y_.offset[o] + y_.scale[o] * out[o];
        const double measured = experiment.y(k, o);
        if (std::isfinite(measured)) sum += std::pow((measured - y(k, o)) / y_.scale[o], 2);
      }
      // What grows beyond all bounds need not be followed to its end.
      if (!(sum < runaway)) return std::numeric_limits<double>::infinity();
    }
  }
  return sum;
}

double SimulationTraining::normal(const VectorXd& theta, MatrixXd& R, VectorXd& g) const {
  Network network = network_;
  network.set_theta(theta);
  const Index first = regressors_.longest_lag(), outputs = network.outputs(), p = network.parameters();
  const Index inputs = network.inputs(), depth = first + 1;
  VectorXd scratch(network.scratch_size()), out(outputs), x(inputs);
  MatrixXd by_theta(p, outputs), by_x(inputs, outputs);
  std::vector<RowSlope> slopes;
  // Sensitivities of the last outputs in a ring: dyhat(k - i)/dtheta, in units of the outputs.
  std::vector<MatrixXd> past(static_cast<std::size_t>(depth));
  NormalSum sum(p, R, g);
  double sse = 0;
  for (const Experiment& experiment : experiments_) {
    for (MatrixXd& s : past) s.setZero(p, outputs);
    MatrixXd y = experiment.y;
    for (Index k = first; k < y.rows(); ++k) {
      fill_row(regressors_, experiment.u, y, k, x.data());
      row_slopes(regressors_, experiment.u, y, k, slopes);
      x = (x - x_.offset).cwiseQuotient(x_.scale);
      network.differentiate(x.data(), out.data(), by_theta.data(), by_x.data(), scratch.data());
      MatrixXd& now = past[static_cast<std::size_t>(k % depth)];
      for (Index o = 0; o < outputs; ++o) {
        for (const RowSlope& slope : slopes) {
          const double weight = by_x(slope.regressor, o) / x_.scale[slope.regressor] * slope.value;
          by_theta.col(o) += weight * past[static_cast<std::size_t>((k - slope.lag) % depth)].col(slope.channel);
        }
        y(k, o) = y_.offset[o] + y_.scale[o] * out[o];
        const double measured = experiment.y(k, o);
        if (!std::isfinite(measured)) continue;
        const double error = (measured - y(k, o)) / y_.scale[o];
        sse += error * error;
        VectorXd::Map(sum.next(), p) = by_theta.col(o);
        sum.add(error);
      }
      if (!(sse < runaway)) return std::numeric_limits<double>::infinity();
      now = by_theta * y_.scale.asDiagonal();
    }
  }
  sum.finish();
  if (!std::isfinite(sse) || !R.allFinite() || !g.allFinite()) return std::numeric_limits<double>::infinity();
  return sse;
}

}  // namespace plantloop::identify
