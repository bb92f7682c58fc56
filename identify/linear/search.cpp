// The prediction error method: criterion, exact gradient, starts.

#include "identify/linear/search.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/data/preprocess.h"
#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/filter.h"
#include "identify/linear/levenberg_marquardt.h"
#include "identify/linear/prediction_error.h"
#include "identify/linear/signal_units.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const VectorXd one = VectorXd::Ones(1);

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

// C and F without roots outside of the unit circle.
PolynomialModel mirrored(PolynomialModel m) {
  m.C = reflected(m.C);
  for (VectorXd& f : m.F) f = reflected(f);
  return m;
}

struct StartModel {
  std::string name;
  PolynomialModel model;
};

// ARX whose A serves as the model's A or, where the model has none, as F.
PolynomialModel from_arx(const PolynomialModel& arx, const PolynomialModel& empty) {
  PolynomialModel m = empty;
  const Index na = std::min(arx.A.size(), m.A.size());
  m.A.head(na) = arx.A.head(na);
  for (std::size_t i = 0; i < m.B.size(); ++i) {
    m.B[i] = arx.B[i];
    if (m.A.size() > 1) continue;
    const Index nf = std::min(arx.A.size(), m.F[i].size());
    m.F[i].head(nf) = arx.A.head(nf);
  }
  m.offset = m.A.size() > 1 || arx.integrates() ? arx.offset : arx.offset / arx.A.sum();
  return m;
}

Orders arx_orders(const Orders& o) {
  Orders arx{.nb = o.nb, .nf = {}, .delay = o.delay};
  arx.na = o.na;
  if (o.na == 0) {
    for (const int nf : o.nf) arx.na = std::max(arx.na, nf);
  }
  arx.nf.assign(o.nb.size(), 0);
  return arx;
}

// Noise from a long ARX model, then C or D by least squares with the noise as a known signal (J. Durbin 1960; E. Hannan
// and J. Rissanen 1982).
void add_noise_start(const LinearTask& task, const PolynomialModel& base, std::vector<StartModel>& starts) {
  const Orders& o = task.orders;
  if (o.nc + o.nd == 0 || o.na == 0) return;
  LinearTask extended = task;
  extended.orders = arx_orders(o);
  const int rows = static_cast<int>(task.data.samples());
  const int extra = std::clamp(rows / 50, o.nc + 4, 20);
  extended.orders.na += extra;
  for (int& nb : extended.orders.nb) nb += nb > 0 ? extra : 0;
  if (extended.orders.parameters() * 3 > rows) return;
  const PolynomialModel arx = fit_arx(extended, {});
  // Least squares of y on past y, u and noise: an ARX task in which the noise is one more input.
  LinearTask known = task;
  known.orders = arx_orders(o);
  known.orders.nb.push_back(o.nc);
  known.orders.nf.push_back(0);
  known.orders.delay.push_back(0);
  known.data.inputs.push_back({"noise of the start", ""});
  known.u0 = VectorXd::Zero(known.u0.size() + 1);
  for (Experiment& e : known.data.experiments) {
    const VectorXd v = errors_of(arx, e, task.output, arx.initial, nullptr);
    e.u.conservativeResize(e.y.rows(), e.u.cols() + 1);
    e.u.rightCols(1) = v;
  }
  const ArxRows with_noise =
      arx_rows(known.data, known.orders, known.output, known.offset, extended.orders.longest_lag());
  if (with_noise.y.size() < known.parameters()) return;
  const PolynomialModel second = fit_arx(known, {});
  PolynomialModel m = from_arx(second, base);
  m.C.tail(o.nc) = second.B.back();
  starts.push_back({"noise of a long ARX model", mirrored(std::move(m))});
}

// C and D of s = y - w, what a model without noise leaves, by the same two steps: s is an ARMA series.
bool add_noise_of(const LinearTask& task, PolynomialModel& m) {
  const Orders& o = task.orders;
  LinearTask series;
  series.data.Ts = task.data.Ts;
  series.data.outputs = {{"s", ""}};
  m.C = m.D = VectorXd::Ones(1);
  for (const Experiment& e : task.data.experiments) {
    const VectorXd s = errors_of(m, e, task.output, m.initial, nullptr);
    if (!s.allFinite()) return false;
    series.data.experiments.push_back({e.name, 0, MatrixXd(s.size(), 0), s});
  }
  const int rows = static_cast<int>(task.data.samples());
  LinearTask extended = series;
  extended.orders.na = std::clamp(rows / 50, o.nc + o.nd + 4, 20);
  if (extended.orders.na * 4 > rows) return false;
  const PolynomialModel ar = fit_arx(extended, {});
  series.orders = {.na = o.nd, .nb = {o.nc}, .nf = {0}, .delay = {0}};
  series.data.inputs = {{"noise of the start", ""}};
  series.u0 = VectorXd::Zero(1);
  for (Experiment& e : series.data.experiments) e.u = errors_of(ar, e, 0, Initial::estimate, nullptr);
  if (arx_rows(series.data, series.orders, 0, false, extended.orders.na).y.size() < series.orders.parameters())
    return false;
  const PolynomialModel arma = fit_arx(series, {});
  m.D = arma.A;
  m.C = VectorXd::Ones(o.nc + 1);
  m.C.tail(o.nc) = arma.B[0];
  m = mirrored(std::move(m));
  return true;
}

// Signals filtered by A of a long ARX model have nearly white noise, so that filtered least squares finds B and F as
// well as can be (Y. Zhu 2011); then C and D of what they leave.
bool whitened_start(const LinearTask& task, PolynomialModel& m) {
  LinearTask extended = task;
  extended.orders = arx_orders(task.orders);
  const int rows = static_cast<int>(task.data.samples());
  const int lags = std::clamp(rows / 30, extended.orders.na + 4, 20);
  extended.orders.na = lags;
  for (std::size_t i = 0; i < extended.orders.nb.size(); ++i) {
    if (extended.orders.nb[i] > 0) extended.orders.nb[i] = lags;
  }
  if (extended.parameters() * 3 > rows) return false;
  const VectorXd A = reflected(fit_arx(extended, {}).A);
  LinearOptions plain{.output = task.data.outputs[task.output].name, .offset = task.offset, .initial = task.initial};
  Orders orders = arx_orders(task.orders);
  if (orders.na == 0 || !(std::fabs(A.sum()) > 1e-6)) return false;
  const PolynomialModel white = fit_filtered(filter(task.data, A, one), orders, plain, 30);
  for (std::size_t i = 0; i < m.B.size(); ++i) {
    m.B[i] = white.B[i];
    const Index nf = std::min(white.F[i].size(), m.F[i].size());
    m.F[i].head(nf) = white.F[i].head(nf);
  }
  m.offset = white.offset / A.sum();
  return add_noise_of(task, m);
}

std::vector<StartModel> starts_of(const LinearTask& task, const LinearOptions& options, const PolynomialModel& empty,
                                  const FitControl& control) {
  std::vector<StartModel> starts;
  LinearTask linear = task;
  linear.orders = arx_orders(task.orders);
  const PolynomialModel arx = fit_arx(linear, {});
  starts.push_back({"ARX by least squares", mirrored(from_arx(arx, empty))});
  const bool rational = std::any_of(task.orders.nf.begin(), task.orders.nf.end(), [](int n) { return n > 0; });
  if (rational && task.orders.na == 0) {
    LinearOptions plain = options;
    plain.remove_means = false;
    plain.output = task.data.outputs[task.output].name;
    Orders orders = linear.orders;
    PolynomialModel filtered = fit_filtered(task.data, orders, plain, 30);
    PolynomialModel m = empty;
    for (std::size_t i = 0; i < m.B.size(); ++i) {
      m.B[i] = filtered.B[i];
      const Index nf = std::min(filtered.F[i].size(), m.F[i].size());
      m.F[i].head(nf) = filtered.F[i].head(nf);
    }
    m.offset = filtered.offset;
    starts.push_back({"filtered least squares", mirrored(std::move(m))});
  }
  add_noise_start(task, empty, starts);
  if (task.orders.na > 0 || task.orders.nc + task.orders.nd == 0) return starts;
  // Box-Jenkins: the noise of the best model without one.
  LinearTask quiet = task;
  quiet.orders.nc = quiet.orders.nd = 0;
  PolynomialModel m = rational ? search_linear(quiet, {.iterations = options.iterations}, control) : fit_arx(quiet, {});
  m.covariance = empty.covariance;
  if (PolynomialModel white = empty; whitened_start(task, white)) {
    starts.push_back({"filtered least squares of whitened signals, then the noise", std::move(white)});
  }
  if (!add_noise_of(task, m)) return starts;
  starts.push_back({"output error, then its noise", m});
  if (task.orders.nc == 0 || task.orders.nd == 0) return starts;
  // C and D may share roots, and where they part is not seen from there: once more with all in one of them.
  LinearTask autoregressive = task;
  autoregressive.orders.nc = 0;
  if (add_noise_of(autoregressive, m)) {
    m.C = VectorXd::Unit(task.orders.nc + 1, 0);
    starts.push_back({"output error, then its noise as an AR series", std::move(m)});
  }
  return starts;
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
