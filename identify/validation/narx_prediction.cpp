// Predictions of models that map regressors to outputs.

#include "identify/validation/narx_prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/data/matching.h"
#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

void check_task(const RegressorSet& set, const DataSet& data) {
  check(data);
  check_names(set.inputs, set.outputs, data);
}

// Rows [from, until) computed in place; `y` holds what they look back to.
void run(const RegressorSet& set, const MatrixXd& u, MatrixXd& y, const Predictor& f, Index from, Index until,
         double limit) {
  for (Index k = from; k < until; ++k) {
    const VectorXd x = row_at(set, u, y, k);
    if (x.hasNaN()) {
      y.row(k).setConstant(nothing);
      continue;
    }
    y.row(k) = f(x).transpose();
    if (!(y.row(k).cwiseAbs().maxCoeff() <= limit)) {
      y.middleRows(k, until - k).setConstant(HUGE_VAL);
      return;
    }
  }
}

double limit_of(const DataSet& data) {
  double largest = 0;
  for (const Experiment& e : data.experiments) {
    for (const double v : e.y.reshaped()) {
      if (!std::isnan(v)) largest = std::max(largest, std::fabs(v));
    }
  }
  // Outputs that were only zero tell no range.
  return largest > 0 ? 1e6 * largest : std::numeric_limits<double>::infinity();
}

}  // namespace

Outputs one_step(const RegressorSet& set, const DataSet& data, const Predictor& f) { return k_step(set, data, f, 1); }

Outputs k_step(const RegressorSet& set, const DataSet& data, const Predictor& f, int steps) {
  check_task(set, data);
  if (steps < 1) fail("a prediction looks at least one step ahead, not {}", steps);
  const Index lag = set.longest_lag();
  const double limit = limit_of(data);
  Outputs result;
  for (const Experiment& e : data.experiments) {
    MatrixXd predicted = MatrixXd::Constant(e.y.rows(), e.y.cols(), nothing);
    MatrixXd y = e.y;
    for (Index k = lag + steps - 1; k < e.samples(); ++k) {
      const Index from = k - steps + 1;
      run(set, e.u, y, f, from, k + 1, limit);
      predicted.row(k) = y.row(k);
      y.middleRows(from, steps) = e.y.middleRows(from, steps);
    }
    result.push_back(std::move(predicted));
  }
  return result;
}

Outputs free_run(const RegressorSet& set, const DataSet& data, const Predictor& f) {
  check_task(set, data);
  check_free_run(data, set.uses_outputs() ? set.longest_lag() : 0);
  const double limit = limit_of(data);
  Outputs result;
  for (const Experiment& e : data.experiments) {
    const Index lag = std::min<Index>(set.longest_lag(), e.samples());
    MatrixXd y = e.y;
    run(set, e.u, y, f, lag, e.samples(), limit);
    result.push_back(std::move(y));
  }
  return result;
}

Outputs from_zero(const DataSet& data, Index lag, const std::function<Outputs(const DataSet&)>& run) {
  DataSet longer = data;
  for (Experiment& e : longer.experiments) {
    e.start -= static_cast<double>(lag) * data.Ts;
    for (MatrixXd* m : {&e.u, &e.y}) {
      MatrixXd padded = MatrixXd::Zero(m->rows() + lag, m->cols());
      padded.bottomRows(m->rows()) = *m;
      *m = std::move(padded);
    }
  }
  Outputs result = run(longer);
  for (MatrixXd& y : result) y = MatrixXd(y.bottomRows(y.rows() - lag));
  return result;
}

}  // namespace plantloop::identify
