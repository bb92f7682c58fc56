// The prediction error method: the search from several starts, and what it warns of.

#include "identify/linear/search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/filter.h"
#include "identify/linear/levenberg_marquardt.h"
#include "identify/linear/prediction_error.h"
#include "identify/linear/signal_units.h"
#include "identify/linear/starts.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// With the signals as they are: the operating point is already taken away.
VectorXd errors(const PolynomialModel& m, const DataSet& data, std::size_t output, MatrixXd* J) {
  VectorXd v(data.samples());
  if (J != nullptr) J->resize(v.size(), m.parameters().size());
  Index row = 0;
  MatrixXd own;
  for (const Experiment& e : data.experiments) {
    v.segment(row, e.samples()) = errors_of(m, e, output, m.initial, J == nullptr ? nullptr : &own);
    if (J != nullptr) J->middleRows(row, e.samples()) = own;
    row += e.samples();
  }
  return v;
}

// How many values of the past are estimated beside the parameters.
Index unknown_past(const PolynomialModel& m, const DataSet& data) {
  Index count = 0;
  if (m.initial == Initial::rest) return count;
  for (const Experiment& e : data.experiments) count += values_of_the_past(m, e.samples());
  return count;
}

// From rest, the first prediction errors are far greater than those after them where the record did not begin so.
void warn_of_the_start(PolynomialModel& model, const DataSet& data, const VectorXd& v) {
  if (model.initial == Initial::estimate) return;
  double first = 0;
  Index count = 0, row = 0;
  for (const Experiment& e : data.experiments) {
    const Index early = values_of_the_past(model, e.samples());
    first += v.segment(row, early).squaredNorm();
    count += early;
    row += e.samples();
  }
  if (v.size() < 3 * count || count == 0) return;
  const double later = (v.squaredNorm() - first) / static_cast<double>(v.size() - count);
  // The sum of `count` squares of variance 1 is beyond this once in a million times.
  if (first > later * (20 + 3 * static_cast<double>(count))) {
    model.fit.warnings.push_back(
        fmt::format("the first prediction errors are {:.2g} times as large as the others, as when the record does not "
                    "begin at rest: estimate its past with initial = \"estimate\", and with offset = true where the "
                    "level is not known",
                    std::sqrt(first / static_cast<double>(count) / later)));
  }
}

void add_warnings(PolynomialModel& model, const MarquardtResult& best, const VectorXd& units) {
  if (!best.converged) model.fit.warnings.emplace_back("the search stopped at its limit; the estimate may be improved");
  if (!model.is_stable()) model.fit.warnings.emplace_back("the model is unstable");
  if (!is_stable(model.C, 0.9999)) {
    model.fit.warnings.emplace_back(
        "C has a root on the unit circle: the record does not tell the noise model, or its order is too high");
  }
  const VectorXd deviations = model.covariance.diagonal().cwiseSqrt();
  const VectorXd theta = model.parameters();
  const std::vector<std::string> names = model.parameter_names();
  for (Index i = 0; i < theta.size(); ++i) {
    if (!(deviations[i] <= 10 * std::max(std::fabs(theta[i]), 1e-3 * units[i]))) {
      model.fit.warnings.push_back(
          fmt::format("{} = {:.3g} has a standard deviation of {:.2g}: the order is too high, or the input does not "
                      "excite it",
                      names[static_cast<std::size_t>(i)], theta[i], deviations[i]));
      return;
    }
  }
}

}  // namespace

VectorXd prediction_errors(const PolynomialModel& model, const DataSet& data, MatrixXd* jacobian) {
  const std::size_t output = match(model, data);
  DataSet about = data;
  for (Experiment& e : about.experiments) {
    e.u.rowwise() -= model.u0.transpose();
    e.y.col(static_cast<Index>(output)).array() -= model.y0;
  }
  return errors(model, about, output, jacobian);
}

PolynomialModel search_linear(const LinearTask& given, const LinearOptions& options, const FitControl& control) {
  refuse_missing(given.data, "the prediction error method");
  const SignalUnits units = units_of(given);
  const LinearTask task = in_units(given, units);
  const double square = units.y * units.y;
  const PolynomialModel empty = begin_model(task);
  const Index unknown = task.parameters() + unknown_past(empty, task.data);
  if (unknown >= task.data.samples()) {
    fail("{} parameters, of which {} are of the past before the records, cannot be estimated from {} samples", unknown,
         unknown - task.parameters(), task.data.samples());
  }
  PolynomialModel trial = empty;
  const Residuals criterion = [&](const VectorXd& theta, MatrixXd* J) {
    trial.set_parameters(theta);
    return errors(trial, task.data, task.output, J);
  };
  // A root that leaves the unit circle is mirrored, which leaves the spectrum of the noise as it is, or else stops at
  // the circle: an optimum there is no local minimum of mirrored steps.
  const auto allowed = [&](const VectorXd& theta) {
    PolynomialModel m = empty;
    m.set_parameters(theta);
    const VectorXd inside = mirrored(m).parameters();
    if (inside == theta) return std::vector<VectorXd>{theta};
    m.C = clamped(m.C);
    for (VectorXd& f : m.F) f = clamped(f);
    return std::vector<VectorXd>{inside, m.parameters()};
  };
  const double rows = static_cast<double>(task.data.samples());
  PolynomialModel model = empty;
  MarquardtResult best;
  best.sse = std::numeric_limits<double>::infinity();
  for (const StartModel& start : starts_of(task, options, empty, control)) {
    if (!std::isfinite(criterion(start.model.parameters(), nullptr).squaredNorm())) continue;
    MarquardtResult result =
        minimise_squares(criterion, start.model.parameters(), {.iterations = options.iterations}, allowed, control);
    model.fit.tried.push_back(fmt::format("{}: mean square {:.6g} after {} iterations, {}", start.name,
                                          square * result.sse / rows, result.iterations, result.stopped));
    if (result.sse < best.sse) best = std::move(result);
  }
  if (best.theta.size() == 0) fail("the search found no start at which the prediction error is finite");
  model.set_parameters(best.theta);
  const double freedom = rows - static_cast<double>(best.theta.size() + unknown_past(model, task.data));
  model.variance = best.sse / freedom;
  model.covariance = covariance_of(best.jacobian, model.variance);
  model.fit.method = "prediction error method, Levenberg-Marquardt";
  model.fit.samples = task.data.samples();
  model.fit.parameters = best.theta.size();
  model.fit.reached = best.sse / rows;
  model.fit.iterations = best.iterations;
  model.fit.stopped = best.stopped;
  model.fit.options = options_of(options);
  restore(model, units);
  add_warnings(model, best, parameter_units(model, units));
  warn_of_the_start(model, given.data, best.residuals);
  warn_of_constant(model, units.y * best.residuals);
  return model;
}

}  // namespace plantloop::identify
