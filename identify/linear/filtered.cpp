// Iteratively filtered least squares (Steiglitz-McBride), and instrumental variables.

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/filter.h"
#include "identify/linear/fit_linear.h"
#include "identify/linear/levenberg_marquardt.h"
#include "identify/linear/signal_units.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const VectorXd one = VectorXd::Ones(1);

// All signals filtered by B/A from rest.
DataSet filtered(const DataSet& data, const VectorXd& B, const VectorXd& A) {
  DataSet result = data;
  for (Experiment& e : result.experiments) {
    for (MatrixXd* m : {&e.u, &e.y}) {
      for (Index c = 0; c < m->cols(); ++c) m->col(c) = filter(B, A, VectorXd(m->col(c)));
    }
  }
  return result;
}

// The data with the output replaced by the model's own, simulated from rest.
DataSet noise_free(const DataSet& data, std::size_t output, const PolynomialModel& arx) {
  DataSet result = data;
  const PolynomialModel::Common c = arx.common();
  const VectorXd A = reflected(c.denominator);
  for (Experiment& e : result.experiments) {
    VectorXd y = VectorXd::Zero(e.samples());
    for (std::size_t i = 0; i < c.numerators.size(); ++i) {
      y += filter(c.numerators[i], A, VectorXd(e.u.col(static_cast<Index>(i))));
    }
    e.y.col(static_cast<Index>(output)) = y;
  }
  return result;
}

// theta with Z'(y - Psi theta) = 0, by an orthonormal basis of the instruments, so that no condition is squared.
// Parameters that they do not determine are 0, and a warning counts them.
LeastSquares solve_instruments(const MatrixXd& Z, const ArxRows& rows) {
  if (!Z.allFinite()) fail("the instruments overflow: the first estimate, of least squares, is of no use");
  const VectorXd sizes = Z.colwise().stableNorm().transpose();
  Eigen::ColPivHouseholderQR<MatrixXd> qr(Z.rows(), Z.cols());
  qr.setThreshold(1e-12);
  qr.compute(Z * (sizes.array() > 0).select(sizes, 1.0).cwiseInverse().asDiagonal());
  const Index rank = qr.rank();
  if (rank == 0) fail("the instruments do not determine the parameters: the input does not excite the process");
  MatrixXd both(Z.rows(), rows.Psi.cols() + 1);
  both << rows.Psi, rows.y;
  both.applyOnTheLeft(qr.householderQ().adjoint());
  return least_squares(both.topLeftCorner(rank, rows.Psi.cols()), both.topRightCorner(rank, 1));
}

// The rows of one pass, of signals filtered by 1/F: y = [-y(k-i) | u_1(k-d-i) | ... | 1 | past of each experiment].
struct FilteredRows {
  MatrixXd X;
  VectorXd y;
};

// From rest, the first rows have no whole past and are left out; an estimated past makes them whole: impulses at the
// first samples.
FilteredRows filtered_rows(const LinearTask& task, const DataSet& data, const VectorXd& F) {
  const Orders& o = task.orders;
  const Index lag = o.longest_lag();
  const bool estimated = task.initial == Initial::estimate;
  const auto output = static_cast<Index>(task.output);
  Index pasts = 0;
  for (const Experiment& e : data.experiments) pasts += estimated ? std::min(lag, e.samples()) : 0;
  FilteredRows rows{MatrixXd::Zero(data.samples(), task.parameters() + pasts), VectorXd(data.samples())};
  Index row = 0, past = task.parameters();
  for (const Experiment& e : data.experiments) {
    const Index skipped = estimated ? 0 : std::min(lag, e.samples());
    const Index count = e.samples() - skipped;
    const auto put = [&](Index column, const VectorXd& series, double sign) {
      rows.X.col(column).segment(row, count) = sign * series.tail(count);
    };
    Index column = 0;
    const VectorXd y = filter(one, F, VectorXd(e.y.col(output)));
    for (Index i = 1; i <= o.na; ++i) put(column++, delayed(y, i), -1);
    for (std::size_t input = 0; input < o.nb.size(); ++input) {
      const VectorXd u = filter(one, F, VectorXd(e.u.col(static_cast<Index>(input))));
      for (Index i = 1; i <= o.nb[input]; ++i) put(column++, delayed(u, o.delay[input] + i), 1);
    }
    if (task.offset) put(column++, VectorXd::Ones(e.samples()), 1);
    for (Index i = 0; estimated && i < std::min(lag, e.samples()); ++i) {
      put(past++, delayed(impulse_response(one, F, e.samples()), i), 1);
    }
    rows.y.segment(row, count) = y.tail(count);
    row += count;
  }
  rows.X.conservativeResize(row, Eigen::NoChange);
  rows.y.conservativeResize(row);
  return rows;
}

// s2 (P'P)^-1 (phi'phi) (P'P)^-1; not finite where P does not determine the parameters.
MatrixXd sandwich(const MatrixXd& phi, const MatrixXd& P, double s2) {
  const MatrixXd inverse = covariance_of(P, 1);
  if (!inverse.allFinite()) return inverse;
  const MatrixXd half = phi * inverse;
  return s2 * half.transpose() * half;
}

}  // namespace

PolynomialModel fit_filtered(const DataSet& data, const Orders& orders, const LinearOptions& options, int passes) {
  LinearTask task = prepare(data, orders, options);
  refuse_missing(task.data, "filtered least squares");
  const SignalUnits units = units_of(task);
  task = in_units(std::move(task), units);
  const Index na = task.orders.na;
  if (na == 0) fail("filtered least squares needs 'na' of 1 or more");
  if (passes < 0) fail("the number of passes is {}; it must be 0 or more", passes);
  const auto output = static_cast<Index>(task.output);
  const Index p = task.parameters();
  // Of y about the level that the offset makes, each pass estimates by how much that level is wrong.
  const auto about = [&](double level) {
    DataSet data_about = task.data;
    for (Experiment& e : data_about.experiments) e.y.col(output).array() -= level;
    return data_about;
  };
  VectorXd F = one;
  double level = 0;
  VectorXd before = VectorXd::Zero(p);
  LeastSquares fit;
  FilteredRows rows;
  int pass = 0;
  bool settled = false;
  // The first pass filters nothing; `passes` more follow.
  for (; pass <= passes && !settled; ++pass) {
    rows = filtered_rows(task, about(level), F);
    if (rows.y.size() < rows.X.cols()) {
      fail("{} rows with a whole past do not determine {} parameters", rows.y.size(), rows.X.cols());
    }
    fit = least_squares(rows.X, rows.y);
    VectorXd next = VectorXd::Ones(na + 1);
    next.tail(na) = fit.theta.head(na);
    next = reflected(next);
    VectorXd now = fit.theta.head(p);
    now.head(na) = next.tail(na);
    if (task.offset) {
      const double ratio = F.sum() / next.sum();
      level += fit.theta[p - 1] * (std::isfinite(ratio) ? ratio : 1);
      now[p - 1] = level;
    }
    F = next;
    settled = (now - before).cwiseAbs().maxCoeff() < 1e-10 * std::max(1.0, task.offset ? std::fabs(level) : 1.0);
    before = now;
  }
  LinearTask oe = task;
  oe.orders.na = 0;
  oe.orders.nf.assign(oe.orders.nb.size(), task.orders.na);
  PolynomialModel model = begin_model(oe);
  // The model's parameters are b of each input, F as many times, the offset: a choice of those of the rows.
  MatrixXd choice = MatrixXd::Zero(oe.parameters(), rows.X.cols());
  const Index all_b = task.orders.parameters() - na;
  choice.block(0, na, all_b, all_b).setIdentity();
  for (std::size_t i = 0; i < model.F.size(); ++i) {
    choice.block(all_b + static_cast<Index>(i) * na, 0, na, na).setIdentity();
  }
  if (task.offset) choice(choice.rows() - 1, na + all_b) = 1;
  model.set_parameters(choice.leftCols(p) * before);
  model.variance = fit.s2;
  // The output without noise: what the rows and the past make of F.
  DataSet clean = task.data;
  Index past = p;
  for (Experiment& e : clean.experiments) {
    VectorXd w = VectorXd::Zero(e.samples());
    for (std::size_t i = 0; i < model.B.size(); ++i) {
      w += filter(model.numerator(i), F, VectorXd(e.u.col(static_cast<Index>(i))));
    }
    const Index length =
        task.initial == Initial::estimate ? std::min<Index>(task.orders.longest_lag(), e.samples()) : 0;
    VectorXd impulses = VectorXd::Zero(e.samples());
    impulses.head(length) = fit.theta.segment(past, length);
    past += length;
    e.y.col(output) = w + filter(one, F, impulses);
  }
  const MatrixXd all = sandwich(filtered_rows(task, about(level), F).X, filtered_rows(task, clean, F).X, fit.s2);
  model.covariance = all.allFinite() ? MatrixXd(choice * all * choice.transpose())
                                     : MatrixXd(VectorXd::Constant(oe.parameters(), HUGE_VAL).asDiagonal());
  model.fit.method = "filtered least squares";
  model.fit.samples = rows.y.size();
  model.fit.parameters = p;
  model.fit.reached = fit.sse / static_cast<double>(rows.y.size());
  restore(model, units);
  model.fit.options = options_of(options);
  model.fit.warnings.insert(model.fit.warnings.end(), fit.warnings.begin(), fit.warnings.end());
  if (!model.is_stable()) model.fit.warnings.emplace_back("the model is unstable");
  model.fit.tried = {fmt::format("the last of {} passes, {}", pass - 1, fit.account())};
  model.fit.iterations = pass - 1;
  model.fit.stopped = settled ? "no parameter changed by 1e-10" : fmt::format("the limit of {} passes", passes);
  return model;
}

PolynomialModel fit_instrumental(const DataSet& data, const Orders& orders, const LinearOptions& options) {
  LinearTask task = prepare(data, orders, options);
  refuse_missing(task.data, "the instrumental variables");
  if (task.orders.na == 0 || task.orders.nb.empty()) fail("instrumental variables need 'na' and an input");
  const SignalUnits units = units_of(task);
  task = in_units(std::move(task), units);
  PolynomialModel model = fit_arx(task, {});
  const ArxRows rows = arx_rows(task.data, task.orders, task.output, task.offset);
  const DataSet instruments = noise_free(task.data, task.output, model);
  model.set_parameters(solve_instruments(arx_rows(instruments, task.orders, task.output, task.offset).Psi, rows).theta);
  // An AR model of the equation error whitens it.
  LinearTask noise;
  noise.data.Ts = data.Ts;
  noise.data.outputs = {{"w", ""}};
  for (const Experiment& e : task.data.experiments) {
    VectorXd w = filter(model.A, one, e.y.col(static_cast<Index>(task.output))).array() - model.offset;
    for (std::size_t i = 0; i < model.B.size(); ++i) {
      w -= filter(model.numerator(i), one, VectorXd(e.u.col(static_cast<Index>(i))));
    }
    // The first ones lack their past.
    w = VectorXd(w.tail(std::max<Index>(0, w.size() - task.orders.longest_lag())));
    if (w.size() > 0) noise.data.experiments.push_back({e.name, 0, MatrixXd(w.size(), 0), w});
  }
  noise.orders.na = std::min<int>(task.orders.parameters(), static_cast<int>(data.samples() / 10));
  const VectorXd L = noise.orders.na > 0 ? fit_arx(noise, {}).A : one;
  const DataSet whitened = filtered(task.data, L, one);
  const DataSet clean = filtered(noise_free(task.data, task.output, model), L, one);
  const Index begin = task.orders.longest_lag() + noise.orders.na;
  ArxRows white = arx_rows(whitened, task.orders, task.output, task.offset, begin);
  MatrixXd Z = arx_rows(clean, task.orders, task.output, task.offset, begin).Psi;
  if (task.offset) {
    white.Psi.rightCols(1) *= L.sum();
    Z.rightCols(1) *= L.sum();
  }
  if (white.y.size() <= task.parameters()) {
    fail("{} rows with a whole past do not determine {} parameters", white.y.size(), task.parameters());
  }
  const LeastSquares solved = solve_instruments(Z, white);
  const VectorXd& theta = solved.theta;
  model.set_parameters(theta);
  const VectorXd e = white.y - white.Psi * theta;
  const double s2 = e.squaredNorm() / static_cast<double>(e.size() - theta.size());
  model.covariance = covariance_of(Z, s2);
  model.variance = s2;
  const double first = model.fit.reached, square = units.y * units.y;
  model.fit.method = "instrumental variables, four steps";
  model.fit.tried = {fmt::format("ARX by least squares for the first instruments: mean square {:.6g}", square * first),
                     fmt::format("instruments and signals filtered by an AR model of order {}: mean square {:.6g}",
                                 noise.orders.na, square * e.squaredNorm() / static_cast<double>(e.size()))};
  model.fit.reached = e.squaredNorm() / static_cast<double>(e.size());
  restore(model, units);
  model.fit.stopped = "solved directly";
  model.fit.warnings = undetermined(task.data);
  for (const std::string& warning : solved.warnings) model.fit.warnings.push_back(warning);
  if (!model.is_stable()) model.fit.warnings.emplace_back("the model is unstable");
  warn_of_constant(model, units.y * e);
  return model;
}

}  // namespace plantloop::identify
