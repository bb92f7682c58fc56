// Forward selection of terms, and the fit of the free run.

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/error.h"
#include "identify/linear/levenberg_marquardt.h"
#include "identify/linear/regression_model.h"
#include "identify/narx/regressor_row.h"
#include "identify/validation/metrics.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Errors of the free run and their exact derivative: S(k) = x(k) + sum_i slope_i(k) S(k-i).
class FreeRunErrors {
 public:
  FreeRunErrors(const RegressorSet& set, const DataSet& data) : set_(set), data_(data), lag_(set.longest_lag()) {
    for (const Experiment& e : data.experiments) {
      rows_ += std::max<Index>(0, e.samples() - lag_);
      if (e.samples() > 0) limit_ = std::max(limit_, 1e3 * e.y.cwiseAbs().maxCoeff());
    }
  }

  VectorXd operator()(const VectorXd& theta, MatrixXd* J) const {
    VectorXd errors(rows_);
    if (J != nullptr) J->resize(rows_, theta.size());
    Index row = 0;
    for (const Experiment& e : data_.experiments) {
      MatrixXd y = e.y;
      MatrixXd S = MatrixXd::Zero(theta.size(), J != nullptr ? e.samples() : 0);  // one column for each sample
      VectorXd slopes(lag_ + 1), x(theta.size());
      std::vector<RowSlope> parts;
      for (Index k = lag_; k < e.samples(); ++k, ++row) {
        fill_row(set_, e.u, y, k, x.data());
        y(k, 0) = theta.dot(x);
        if (!(std::fabs(y(k, 0)) < limit_)) return VectorXd::Constant(rows_, HUGE_VAL);
        errors[row] = y(k, 0) - e.y(k, 0);
        if (J == nullptr) continue;
        slopes.setZero();
        // What a past output's change does to the next one.
        row_slopes(set_, e.u, y, k, parts);
        for (const RowSlope& part : parts) slopes[part.lag] += theta[part.regressor] * part.value;
        S.col(k) = x;
        for (Index i = 1; i <= lag_; ++i) {
          if (slopes[i] != 0) S.col(k).noalias() += slopes[i] * S.col(k - i);
        }
      }
      if (J == nullptr || e.samples() <= lag_) continue;
      const Index own = e.samples() - lag_;
      J->middleRows(row - own, own) = S.rightCols(own).transpose();
    }
    return errors;
  }

 private:
  const RegressorSet& set_;
  const DataSet& data_;
  Index lag_;
  Index rows_ = 0;
  double limit_ = 1e-300;
};

void refuse_several_outputs(const DataSet& data) {
  if (data.outputs.size() != 1) {
    fail("terms are selected for one output, the data have {}: make a data set of each", data.outputs.size());
  }
}

double free_run_error(const RegressionModel& model, const DataSet& data) {
  const Outputs y = free_run(model, data);
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const Experiment& e = data.experiments[i];
    for (Index k = model.regressors.longest_lag(); k < e.samples(); ++k) {
      if (std::isnan(e.y(k, 0))) continue;
      const double error = y[i](k, 0) - e.y(k, 0);
      sum += error * error;
      count += 1;
    }
  }
  const double rmse = std::sqrt(sum / count);
  return std::isfinite(rmse) ? rmse : HUGE_VAL;
}

RegressorSet first_terms(const RegressorSet& candidates, const ForwardSelection& chosen, std::size_t count) {
  RegressorSet set{candidates.inputs, candidates.outputs, {}, candidates.errors};
  for (std::size_t i = 0; i < count; ++i)
    set.list.push_back(candidates.list[static_cast<std::size_t>(chosen.order[i])]);
  return set;
}

ForwardSelection select(const DataSet& data, const RegressorSet& candidates, const SelectionOptions& options) {
  const DataSet scaled = options.normalise ? fit_normalisation(data).apply(data) : data;
  const Regression r = make_regression(scaled, candidates);
  return forward_selection(r.X, r.Y.col(0), options.most_terms);
}

// One step and, when asked for, the free run. Where that does not begin to converge the one-step fit stays.
RegressionModel fit_terms(const DataSet& data, const RegressorSet& set, const SelectionOptions& options,
                          const FitControl& control) {
  RegressionModel model = fit_regression(data, set, {.normalise = options.normalise});
  if (options.simulation && data.missing() == 0) fit_free_run(model, data, options.iterations, control);
  return model;
}

}  // namespace

ForwardSelection forward_selection(const MatrixXd& X, const VectorXd& y, Index most) {
  if (X.rows() != y.size()) fail("there are {} rows of regressors and {} targets", X.rows(), y.size());
  ForwardSelection result;
  MatrixXd W = X;  // columns without their part along those chosen
  const VectorXd lengths = X.colwise().squaredNorm();
  std::vector<bool> used(static_cast<std::size_t>(X.cols()));
  VectorXd rest = y;
  const double total = y.squaredNorm();
  while (static_cast<Index>(result.order.size()) < std::min(most, X.cols()) && total > 0) {
    Index best = -1;
    double best_err = 0;
    for (Index j = 0; j < X.cols(); ++j) {
      const double length = W.col(j).squaredNorm();
      if (used[static_cast<std::size_t>(j)] || !(length > 1e-10 * lengths[j])) continue;
      const double part = W.col(j).dot(rest);
      const double err = part * part / (length * total);
      if (err > best_err) {
        best_err = err;
        best = j;
      }
    }
    if (best < 0) break;
    used[static_cast<std::size_t>(best)] = true;
    const VectorXd w = W.col(best) / W.col(best).norm();
    rest -= w * w.dot(rest);
    for (Index j = 0; j < X.cols(); ++j) {
      if (!used[static_cast<std::size_t>(j)]) W.col(j) -= w * w.dot(W.col(j));
    }
    result.order.push_back(best);
    result.err.push_back(best_err);
  }
  return result;
}

void fit_free_run(RegressionModel& model, const DataSet& data, int iterations, const FitControl& control) {
  refuse_several_outputs(data);
  refuse_missing(data, "the fit of the free run");
  const DataSet scaled = model.normalised ? model.normalisation.apply(data) : data;
  const FreeRunErrors errors(model.regressors, scaled);
  VectorXd start = model.theta.col(0);
  const auto finite = [&](const VectorXd& theta) { return std::isfinite(errors(theta, nullptr).squaredNorm()); };
  // A model that diverges may run over short pieces of the record, be mended there, and run over longer ones then.
  const Index lag = model.regressors.longest_lag();
  for (Index length = 10 + 2 * lag; length < scaled.samples() && !finite(start); length *= 4) {
    const DataSet pieces = in_pieces(scaled, length, lag);
    const FreeRunErrors short_runs(model.regressors, pieces);
    if (!std::isfinite(short_runs(start, nullptr).squaredNorm())) break;
    start = minimise_squares([&](const VectorXd& theta, MatrixXd* J) { return short_runs(theta, J); }, start,
                             {.iterations = std::min(iterations, 20), .gradient = 1e-6, .step = 1e-8}, {}, control)
                .theta;
  }
  if (!finite(start)) {
    model.fit.warnings.emplace_back("the one-step model diverges in free run, so that only one step is fitted");
    return;
  }
  const MarquardtResult best =
      minimise_squares([&](const VectorXd& theta, MatrixXd* J) { return errors(theta, J); }, start,
                       {.iterations = iterations, .gradient = 1e-9, .step = 1e-11}, {}, control);
  const auto rows = static_cast<double>(best.residuals.size());
  model.theta.col(0) = best.theta;
  const double freedom = rows - static_cast<double>(best.theta.size());
  if (freedom > 0) {
    model.variance[0] = best.sse / freedom;
    model.covariance[0] = covariance_of(best.jacobian, model.variance[0]);
  }
  model.fit.method = "least squares, then the free run by Levenberg-Marquardt";
  model.fit.reached = best.sse / rows;
  model.fit.iterations = best.iterations;
  model.fit.stopped = best.stopped;
}

RegressionModel fit_selected(const DataSet& data, const RegressorSet& candidates, const SelectionOptions& options,
                             const FitControl& control) {
  check(data);
  refuse_several_outputs(data);
  if (options.most_terms < 1) fail("'most_terms' is at least 1, not {}", options.most_terms);
  if (options.iterations < 0) fail("the number of iterations is {}; it must be 0 or more", options.iterations);
  if (!(options.validation > 0 && options.validation < 1)) {
    fail("'validation' is the part of the record that is held back, greater than 0 and less than 1; it is {:g}",
         options.validation);
  }
  const auto [train, held] = split(data, 1 - options.validation);
  const ForwardSelection path = select(train, candidates, options);
  if (path.order.empty()) fail("no candidate explains anything of the output; is it constant?");

  FitReport report;
  std::size_t best_count = 0;
  double best_error = HUGE_VAL;
  RegressionModel best;
  const std::size_t total = path.order.size();
  for (std::size_t count = 1; count <= total; ++count) {
    control.step(0.8 * static_cast<double>(count) / static_cast<double>(total));
    // Every size up to 8, then in steps of a tenth and more.
    if (count > 8 && count % std::max<std::size_t>(1, count / 8) != 0 && count != total) continue;
    FitControl inner{{}, control.cancel, control.deadline};
    const RegressionModel model = fit_terms(train, first_terms(candidates, path, count), options, inner);
    const double error = free_run_error(model, held);
    report.tried.push_back(fmt::format("{} terms, the last {}: free run {:.5g} on what was held back", count,
                                       to_text(model.regressors.list.back(), candidates), error));
    if (error < best_error) {
      best_error = error;
      best_count = count;
      best = model;
    }
  }
  const bool all_diverge = best_count == 0;
  if (all_diverge) best_count = std::min<std::size_t>(total, 3);
  RegressionModel model = fit_terms(data, first_terms(candidates, path, best_count), options, control);
  if (!all_diverge && options.simulation && data.missing() == 0) {
    // The model that was chosen is a second start: the one-step fit to all data may diverge where that of a part did
    // not.
    fit_free_run(best, data, options.iterations, control);
    if (free_run_error(best, data) < free_run_error(model, data)) {
      best.fit.samples = model.fit.samples;
      best.fit.data = model.fit.data;
      model = std::move(best);
    }
  }
  model.fit.tried = report.tried;
  model.fit.options.push_back(fmt::format("most_terms {}", options.most_terms));
  if (!options.simulation) model.fit.options.emplace_back("one step only");
  model.fit.method = "orthogonal least squares, then " + model.fit.method;
  if (all_diverge) model.fit.warnings.emplace_back("every choice of terms diverges in free run");
  return model;
}

}  // namespace plantloop::identify
