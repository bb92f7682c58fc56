// Signals divided by powers of two, and models brought back.

#include "identify/linear/signal_units.h"

#include <algorithm>
#include <cmath>

namespace plantloop::identify {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

double unit_of(const VectorXd& values) {
  return std::exp2(std::clamp(std::round(std::log2(size_of(values))), -500.0, 500.0));
}

}  // namespace

double size_of(const VectorXd& values) {
  const VectorXd there = values.array().isFinite().select(values, 0.0);
  const double count = static_cast<double>(values.array().isFinite().count());
  const double size = there.stableNorm() / std::sqrt(std::max(1.0, count));
  return size > 0 && std::isfinite(size) ? size : 1;
}

SignalUnits units_of(const LinearTask& task) {
  SignalUnits units;
  const Eigen::MatrixXd u = task.data.all_u();
  units.u.resize(u.cols());
  for (Index i = 0; i < u.cols(); ++i) units.u[i] = unit_of(u.col(i));
  units.y = unit_of(task.data.all_y().col(static_cast<Index>(task.output)));
  return units;
}

LinearTask in_units(LinearTask task, const SignalUnits& units) {
  for (Experiment& e : task.data.experiments) {
    e.u *= units.u.cwiseInverse().asDiagonal();
    e.y.col(static_cast<Index>(task.output)) /= units.y;
  }
  return task;
}

VectorXd parameter_units(const PolynomialModel& model, const SignalUnits& units) {
  PolynomialModel factors = model;
  factors.set_parameters(VectorXd::Ones(model.parameters().size()));
  for (std::size_t i = 0; i < factors.B.size(); ++i) factors.B[i] *= units.y / units.u[static_cast<Index>(i)];
  factors.offset *= units.y;
  return factors.parameters();
}

void restore(PolynomialModel& model, const SignalUnits& units) {
  const VectorXd factors = parameter_units(model, units);
  model.set_parameters(model.parameters().cwiseProduct(factors));
  // What is not determined stays infinite, beside zeros.
  model.covariance = (factors.asDiagonal() * model.covariance * factors.asDiagonal()).eval();
  model.variance *= units.y * units.y;
  model.fit.reached *= units.y * units.y;
}

}  // namespace plantloop::identify
