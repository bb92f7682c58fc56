// Iteratively filtered least squares (Steiglitz-McBride), and instrumental variables.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/filter.h"
#include "identify/linear/fit_linear.h"

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

// theta with Z'(y - Psi theta) = 0.
VectorXd solve_instruments(const MatrixXd& Z, const ArxRows& rows) {
  return (Z.transpose() * rows.Psi).fullPivLu().solve(Z.transpose() * rows.y);
}

}  // namespace

PolynomialModel fit_filtered(const DataSet& data, const Orders& orders, const LinearOptions& options, int passes) {
  LinearTask task = prepare(data, orders, options);
  refuse_missing(task.data, "filtered least squares");
  if (task.orders.na == 0) fail("filtered least squares needs 'na' of 1 or more");
  VectorXd F = one;
  VectorXd before = VectorXd::Zero(task.orders.parameters());
  const DataSet original = task.data;
  PolynomialModel arx;
  int pass = 0;
  bool settled = false;
  // The first pass filters nothing; `passes` more follow.
  for (; pass <= passes && !settled; ++pass) {
    task.data = filtered(original, one, F);
    arx = fit_arx(task, {});
    arx.A = reflected(arx.A);
    settled = (arx.parameters() - before).cwiseAbs().maxCoeff() < 1e-10;
    before = arx.parameters();
    F = arx.A;
  }
  LinearTask oe = task;
  oe.orders.na = 0;
  oe.orders.nf.assign(oe.orders.nb.size(), task.orders.na);
  PolynomialModel model = begin_model(oe);
  model.B = arx.B;
  for (VectorXd& f : model.F) f = arx.A;
  model.variance = arx.variance;
  // From the order a, b to b, f: the covariance of the last pass, for one input.
  if (model.B.size() == 1) {
    const Index na = task.orders.na;
    const Index nb = model.B[0].size();
    model.covariance.topLeftCorner(nb, nb) = arx.covariance.bottomRightCorner(nb, nb);
    model.covariance.bottomRightCorner(na, na) = arx.covariance.topLeftCorner(na, na);
    model.covariance.topRightCorner(nb, na) = arx.covariance.bottomLeftCorner(nb, na);
    model.covariance.bottomLeftCorner(na, nb) = arx.covariance.topRightCorner(na, nb);
  } else {
    model.covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  model.fit = arx.fit;
  model.fit.method = "filtered least squares";
  model.fit.tried = {fmt::format("the last of {} passes, {}", pass - 1, arx.fit.tried.front())};
  model.fit.iterations = pass - 1;
  model.fit.stopped = settled ? "no parameter changed by 1e-10" : fmt::format("the limit of {} passes", passes);
  return model;
}

PolynomialModel fit_instrumental(const DataSet& data, const Orders& orders, const LinearOptions& options) {
  LinearTask task = prepare(data, orders, options);
  refuse_missing(task.data, "the instrumental variables");
  if (task.orders.na == 0 || task.orders.nb.empty()) fail("instrumental variables need 'na' and an input");
  PolynomialModel model = fit_arx(task, {});
  const ArxRows rows = arx_rows(task.data, task.orders, task.output);
  const DataSet instruments = noise_free(task.data, task.output, model);
  model.set_parameters(solve_instruments(arx_rows(instruments, task.orders, task.output).Psi, rows));
  // An AR model of the equation error whitens it.
  LinearTask noise;
  noise.data.Ts = data.Ts;
  noise.data.outputs = {{"w", ""}};
  for (const Experiment& e : task.data.experiments) {
    VectorXd w = filter(model.A, one, e.y.col(static_cast<Index>(task.output)));
    for (std::size_t i = 0; i < model.B.size(); ++i) {
      w -= filter(model.numerator(i), one, VectorXd(e.u.col(static_cast<Index>(i))));
    }
    noise.data.experiments.push_back({e.name, 0, MatrixXd(w.size(), 0), w});
  }
  noise.orders.na = std::min<int>(task.orders.parameters(), static_cast<int>(data.samples() / 10));
  const VectorXd L = noise.orders.na > 0 ? fit_arx(noise, {}).A : one;
  const DataSet whitened = filtered(task.data, L, one);
  const DataSet clean = filtered(noise_free(task.data, task.output, model), L, one);
  const ArxRows white = arx_rows(whitened, task.orders, task.output);
  const MatrixXd Z = arx_rows(clean, task.orders, task.output).Psi;
  const VectorXd theta = solve_instruments(Z, white);
  model.set_parameters(theta);
  const VectorXd e = white.y - white.Psi * theta;
  const double s2 = e.squaredNorm() / static_cast<double>(e.size() - theta.size());
  model.covariance = s2 * (Z.transpose() * Z).inverse();
  model.variance = s2;
  const double first = model.fit.reached;
  model.fit.method = "instrumental variables, four steps";
  model.fit.tried = {fmt::format("ARX by least squares for the first instruments: mean square {:.6g}", first),
                     fmt::format("instruments and signals filtered by an AR model of order {}: mean square {:.6g}",
                                 noise.orders.na, e.squaredNorm() / static_cast<double>(e.size()))};
  model.fit.reached = e.squaredNorm() / static_cast<double>(e.size());
  model.fit.stopped = "solved directly";
  model.fit.warnings = undetermined(task.data);
  if (!theta.allFinite())
    fail("the instruments do not determine the parameters: the input does not excite the process");
  if (!model.is_stable()) model.fit.warnings.emplace_back("the model is unstable");
  return model;
}

}  // namespace plantloop::identify
