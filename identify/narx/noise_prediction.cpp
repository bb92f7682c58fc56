// One recursion through a record, and short runs that start from it.

#include "identify/narx/noise_prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// The record of one experiment; rows are filled one after the other.
class Recursion {
 public:
  Recursion(const NarxModel& model, const Experiment& experiment)
      : model_(model),
        measured_(experiment.y),
        u_(with_errors(model.regressors, experiment.u)),
        y_(experiment.y),
        s_(MatrixXd::Zero(experiment.y.rows(), experiment.y.cols())),
        x_(model.map->inputs()),
        out_(model.map->outputs()),
        scratch_(static_cast<std::size_t>(model.map->scratch_size())) {}

  // yhat(k), from what stands before it. With `known` the errors are those of the measured outputs, else 0.
  VectorXd step(Index k, bool known) {
    VectorXd predicted(out_.size());
    x_ = row_at(model_.regressors, u_, y_, k);
    const bool whole = !x_.hasNaN();
    if (whole) model_.map->evaluate(x_.data(), out_.data(), scratch_.data());
    if (!whole) out_.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (Index o = 0; o < out_.size(); ++o) {
      const double noise = filtered_noise(model_.noise, e_, s_, k, o);
      predicted[o] = out_[o] + noise;
      double error = known ? measured_(k, o) - predicted[o] : 0;
      double rest = known ? measured_(k, o) - out_[o] : noise;
      if (std::isnan(error) || std::isnan(rest)) error = rest = 0;
      e_(k, o) = error;
      if (model_.regressors.errors > 0) u_(k, model_.regressors.data_inputs() + o) = error;
      s_(k, o) = rest;
      if (model_.simulated) y_(k, o) = out_[o];
      if (!model_.simulated && !known) y_(k, o) = predicted[o];
    }
    return predicted;
  }

  // The measured rows again, of which the errors are those that were kept.
  struct Rows {
    MatrixXd u, y, e, s;
  };
  Rows keep(Index from, Index count) const {
    return {u_.middleRows(from, count), y_.middleRows(from, count), e_.middleRows(from, count),
            s_.middleRows(from, count)};
  }
  void restore(Index from, const Rows& rows) {
    u_.middleRows(from, rows.u.rows()) = rows.u;
    y_.middleRows(from, rows.y.rows()) = rows.y;
    e_.middleRows(from, rows.e.rows()) = rows.e;
    s_.middleRows(from, rows.s.rows()) = rows.s;
  }

 private:
  const NarxModel& model_;
  const MatrixXd& measured_;
  MatrixXd u_, y_, s_;
  MatrixXd e_ = MatrixXd::Zero(s_.rows(), s_.cols());
  VectorXd x_, out_;
  std::vector<double> scratch_;
};

}  // namespace

MatrixXd with_errors(const RegressorSet& set, const MatrixXd& u) {
  MatrixXd all = MatrixXd::Zero(u.rows(), u.cols() + set.errors);
  all.leftCols(u.cols()) = u;
  return all;
}

double filtered_noise(const NoiseFilters& noise, const MatrixXd& e, const MatrixXd& s, Index k, Index o) {
  if (noise.empty()) return 0;
  const VectorXd& C = noise.C[static_cast<std::size_t>(o)];
  const VectorXd& D = noise.D[static_cast<std::size_t>(o)];
  double sum = 0;
  for (Index i = 1; i < C.size() && i <= k; ++i) sum += C[i] * e(k - i, o);
  for (Index i = 1; i < D.size() && i <= k; ++i) sum -= D[i] * s(k - i, o);
  return sum;
}

Outputs predict_with_noise(const NarxModel& model, const DataSet& data, int steps) {
  check(data);
  if (steps < 1) fail("a prediction looks at least one step ahead, not {}", steps);
  const Index first = model.regressors.longest_lag();
  Outputs result;
  for (const Experiment& experiment : data.experiments) {
    MatrixXd predicted =
        MatrixXd::Constant(experiment.y.rows(), experiment.y.cols(), std::numeric_limits<double>::quiet_NaN());
    Recursion recursion(model, experiment);
    for (Index k = first; k < experiment.samples(); ++k) {
      // Before the measured output of sample k is taken in, the run of `steps` that ends at k + steps - 1.
      if (steps > 1 && k + steps <= experiment.samples()) {
        const Recursion::Rows rows = recursion.keep(k, steps);
        VectorXd last;
        for (Index j = k; j < k + steps; ++j) last = recursion.step(j, false);
        predicted.row(k + steps - 1) = last.transpose();
        recursion.restore(k, rows);
      }
      const VectorXd now = recursion.step(k, true);
      if (steps == 1) predicted.row(k) = now.transpose();
    }
    result.push_back(std::move(predicted));
  }
  return result;
}

}  // namespace plantloop::identify
