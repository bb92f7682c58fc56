// Starts by least squares: of ARX models, of filtered and whitened signals, of poles on a grid, and of the noise they
// leave.

#include "identify/linear/starts.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "identify/data/preprocess.h"
#include "identify/linear/arx.h"
#include "identify/linear/filter.h"
#include "identify/linear/prediction_error.h"
#include "identify/linear/search.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const VectorXd one = VectorXd::Ones(1);

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

// Real poles from a coarse grid of time constants, the same for all inputs, with B, the offset and the free responses
// by least squares: of those the best. It is the start where noise hides the slow poles from all methods that use past
// outputs.
bool grid_start(const LinearTask& task, PolynomialModel& m) {
  constexpr double grid[] = {0.985, 0.95, 0.88, 0.75, 0.5, 0.2};
  const Index size = std::size(grid);
  const int order = *std::max_element(task.orders.nf.begin(), task.orders.nf.end());
  if (order > 3) return false;
  const Index begin = m.initial == Initial::estimate ? first_determined(m) : 0;
  const Index free = m.initial == Initial::estimate ? order : 0;
  const Index all_b = std::accumulate(task.orders.nb.begin(), task.orders.nb.end(), 0);
  const Index own = all_b + (task.offset ? 1 : 0);
  const auto experiments = static_cast<Index>(task.data.experiments.size());
  if (task.data.samples() <= own + free * experiments + begin * experiments) return false;
  double least = std::numeric_limits<double>::infinity();
  const auto count = static_cast<int>(std::pow(size, order));
  for (int code = 0; code < count; ++code) {
    // The digits are the poles, falling; each set of them once.
    PolynomialModel trial = m;
    std::vector<double> poles;
    bool falling = true;
    for (int digit = code, i = 0; i < order; ++i, digit /= static_cast<int>(size)) {
      poles.push_back(grid[digit % size]);
      falling = falling && (i == 0 || poles[static_cast<std::size_t>(i - 1)] >= poles.back());
    }
    if (!falling) continue;
    VectorXd common = one;
    for (const double pole : poles) common = multiply(common, Eigen::Vector2d(1, -pole));
    for (VectorXd& f : trial.F) {
      const Index nf = f.size() - 1;
      f = one;
      for (Index i = 0; i < nf; ++i) f = multiply(f, Eigen::Vector2d(1, -poles[static_cast<std::size_t>(i)]));
    }
    MatrixXd X = MatrixXd::Zero(task.data.samples(), own + free * experiments);
    VectorXd y = VectorXd::Zero(X.rows());
    Index row = 0, past = own;
    for (const Experiment& e : task.data.experiments) {
      const Index rows = e.samples() - std::min(begin, e.samples());
      Index column = 0;
      const auto put = [&](const VectorXd& series) { X.col(column++).segment(row, rows) = series.tail(rows); };
      for (std::size_t i = 0; i < trial.B.size(); ++i) {
        const VectorXd u = filter(one, trial.F[i], e.u.col(static_cast<Index>(i)));
        for (Index j = 1; j <= trial.B[i].size(); ++j) put(delayed(u, trial.delay[i] + j));
      }
      if (task.offset) put(VectorXd::Ones(e.samples()));
      column = past;
      const VectorXd h = delayed(impulse_response(one, common, e.samples()), begin);
      for (Index j = 0; j < free; ++j) put(delayed(h, j));
      past = column;
      y.segment(row, rows) = e.y.col(static_cast<Index>(task.output)).tail(rows);
      row += rows;
    }
    const VectorXd theta = X.topRows(row).colPivHouseholderQr().solve(y.head(row));
    const double sse = (y.head(row) - X.topRows(row) * theta).squaredNorm();
    if (!(sse < least)) continue;
    least = sse;
    Index at = 0;
    for (VectorXd& b : trial.B) {
      b = theta.segment(at, b.size());
      at += b.size();
    }
    if (task.offset) trial.offset = theta[at];
    m = std::move(trial);
  }
  return std::isfinite(least);
}

}  // namespace

PolynomialModel mirrored(PolynomialModel m) {
  m.C = reflected(m.C);
  for (VectorXd& f : m.F) f = reflected(f);
  return m;
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
    if (PolynomialModel grid = empty; task.orders.nc + task.orders.nd == 0 && grid_start(task, grid)) {
      starts.push_back({"poles of a grid", std::move(grid)});
    }
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

}  // namespace plantloop::identify
