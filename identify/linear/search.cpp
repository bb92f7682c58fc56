// The prediction error method: criterion, exact gradient, starts.

#include "identify/linear/search.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/filter.h"
#include "identify/linear/levenberg_marquardt.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const VectorXd one = VectorXd::Ones(1);

// Writes a series, delayed by 1 ... count samples, into columns from `column` on.
void put_delays(MatrixXd& J, Index row, Index& column, const VectorXd& series, Index count, double sign) {
  for (Index i = 1; i <= count; ++i) J.col(column++).segment(row, series.size()) = sign * delayed(series, i);
}

// v of one experiment, whose signals are about the operating point, and its part of the Jacobian.
VectorXd errors_of(const PolynomialModel& m, const Experiment& e, std::size_t output, Index row, MatrixXd* J) {
  const VectorXd y = e.y.col(static_cast<Index>(output));
  std::vector<VectorXd> w;
  VectorXd s = filter(m.A, one, y);
  for (std::size_t i = 0; i < m.B.size(); ++i) {
    w.push_back(filter(m.numerator(i), m.F[i], e.u.col(static_cast<Index>(i))));
    s -= w[i];
  }
  VectorXd v = filter(m.D, m.C, s);
  if (J == nullptr) return v;
  Index column = 0;
  put_delays(*J, row, column, filter(m.D, m.C, y), m.A.size() - 1, 1);
  for (std::size_t i = 0; i < m.B.size(); ++i) {
    // The delay of -1 is a shift to the left, so the filter is applied to u and the columns are shifted by d + j.
    const VectorXd u = filter(m.D, multiply(m.C, m.F[i]), e.u.col(static_cast<Index>(i)));
    for (Index j = 1; j <= m.B[i].size(); ++j) J->col(column++).segment(row, v.size()) = -delayed(u, m.delay[i] + j);
  }
  put_delays(*J, row, column, filter(one, m.C, v), m.C.size() - 1, -1);
  put_delays(*J, row, column, filter(one, m.C, s), m.D.size() - 1, 1);
  for (std::size_t i = 0; i < m.B.size(); ++i) {
    put_delays(*J, row, column, filter(m.D, multiply(m.C, m.F[i]), w[i]), m.F[i].size() - 1, 1);
  }
  return v;
}

// With the signals as they are: the operating point is already taken away.
VectorXd errors(const PolynomialModel& m, const DataSet& data, std::size_t output, MatrixXd* J) {
  VectorXd v(data.samples());
  if (J != nullptr) J->resize(v.size(), m.orders().parameters());
  Index row = 0;
  for (const Experiment& e : data.experiments) {
    v.segment(row, e.samples()) = errors_of(m, e, output, row, J);
    row += e.samples();
  }
  return v;
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
    const VectorXd v = errors_of(arx, e, task.output, 0, nullptr);
    e.u.conservativeResize(e.y.rows(), e.u.cols() + 1);
    e.u.rightCols(1) = v;
  }
  const ArxRows with_noise = arx_rows(known.data, known.orders, known.output, extended.orders.longest_lag());
  if (with_noise.y.size() < known.orders.parameters()) return;
  const PolynomialModel second = fit_arx(known, {});
  PolynomialModel m = from_arx(second, base);
  m.C.tail(o.nc) = second.B.back();
  starts.push_back({"noise of a long ARX model", mirrored(std::move(m))});
}

std::vector<StartModel> starts_of(const LinearTask& task, const LinearOptions& options, const PolynomialModel& empty) {
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
    starts.push_back({"filtered least squares", mirrored(std::move(m))});
  }
  add_noise_start(task, empty, starts);
  return starts;
}

void add_warnings(PolynomialModel& model, const MarquardtResult& best) {
  if (!best.converged) model.fit.warnings.emplace_back("the search stopped at its limit; the estimate may be improved");
  if (!model.is_stable()) model.fit.warnings.emplace_back("the model is unstable");
  const VectorXd deviations = model.covariance.diagonal().cwiseSqrt();
  const VectorXd theta = model.parameters();
  const std::vector<std::string> names = model.parameter_names();
  for (Index i = 0; i < theta.size(); ++i) {
    if (!(deviations[i] <= 10 * std::max(std::fabs(theta[i]), 1e-3))) {
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

PolynomialModel search_linear(const LinearTask& task, const LinearOptions& options, const FitControl& control) {
  refuse_missing(task.data, "the prediction error method");
  const PolynomialModel empty = begin_model(task);
  PolynomialModel trial = empty;
  const Residuals criterion = [&](const VectorXd& theta, MatrixXd* J) {
    trial.set_parameters(theta);
    return errors(trial, task.data, task.output, J);
  };
  const auto project = [&](const VectorXd& theta) {
    PolynomialModel m = empty;
    m.set_parameters(theta);
    return mirrored(std::move(m)).parameters();
  };
  const double rows = static_cast<double>(task.data.samples());
  PolynomialModel model = empty;
  MarquardtResult best;
  best.sse = std::numeric_limits<double>::infinity();
  for (const StartModel& start : starts_of(task, options, empty)) {
    if (!std::isfinite(criterion(start.model.parameters(), nullptr).squaredNorm())) continue;
    MarquardtResult result =
        minimise_squares(criterion, start.model.parameters(), {.iterations = options.iterations}, project, control);
    model.fit.tried.push_back(fmt::format("{}: mean square {:.6g} after {} iterations, {}", start.name,
                                          result.sse / rows, result.iterations, result.stopped));
    if (result.sse < best.sse) best = std::move(result);
  }
  if (best.theta.size() == 0) fail("the search found no start at which the prediction error is finite");
  model.set_parameters(best.theta);
  const double freedom = rows - static_cast<double>(best.theta.size());
  model.variance = best.sse / freedom;
  model.covariance = covariance_of(best.jacobian, model.variance);
  model.fit.method = "prediction error method, Levenberg-Marquardt";
  model.fit.samples = task.data.samples();
  model.fit.parameters = best.theta.size();
  model.fit.reached = best.sse / rows;
  model.fit.iterations = best.iterations;
  model.fit.stopped = best.stopped;
  model.fit.options = options_of(options);
  add_warnings(model, best);
  return model;
}

}  // namespace plantloop::identify
