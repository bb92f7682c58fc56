// State-space models: conversion, free run, model files.

#include "identify/linear/state_space.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "identify/data/matching.h"
#include "identify/error.h"
#include "identify/linear/least_squares.h"
#include "identify/linear/signal_units.h"
#include "identify/model_file/model_file.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd respond(const StateSpaceModel& m, const MatrixXd& u, VectorXd x) {
  MatrixXd y(u.rows(), m.C.rows());
  for (Index k = 0; k < u.rows(); ++k) {
    const VectorXd uk = u.row(k).transpose() - m.u0;
    y.row(k) = (m.C * x + m.D * uk + m.y0).transpose();
    x = m.A * x + m.B * uk;
  }
  return y;
}

// The state that explains what the response from rest leaves, outputs divided by their sizes; samples with missing
// outputs do not count.
VectorXd best_start(const StateSpaceModel& m, const MatrixXd& y, const MatrixXd& from_rest) {
  MatrixXd rows(y.size(), m.order());
  VectorXd rest(y.size()), unit(y.cols());
  for (Index i = 0; i < y.cols(); ++i) unit[i] = size_of(y.col(i).array() - m.y0[i]);
  MatrixXd CA = unit.cwiseInverse().asDiagonal() * m.C;
  const double least = 1e-14 * CA.norm();
  Index at = 0;
  for (Index k = 0; k < y.rows() && CA.norm() > least; ++k, CA = CA * m.A) {
    for (Index i = 0; i < y.cols(); ++i) {
      if (std::isnan(y(k, i))) continue;
      rows.row(at) = CA.row(i);
      rest[at++] = (y(k, i) - from_rest(k, i)) / unit[i];
    }
  }
  if (at == 0 || !rows.topRows(at).allFinite()) return VectorXd::Zero(m.order());
  return least_squares(rows.topRows(at), rest.head(at)).theta;
}

}  // namespace

Eigen::VectorXcd StateSpaceModel::poles() const {
  if (A.rows() == 0) return {};
  Eigen::VectorXcd values = Eigen::EigenSolver<MatrixXd>(A, false).eigenvalues();
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) {
    return a.real() != b.real() ? a.real() < b.real() : a.imag() < b.imag();
  });
  return values;
}

bool StateSpaceModel::is_stable() const {
  const Eigen::VectorXcd z = poles();
  return z.size() == 0 || z.cwiseAbs().maxCoeff() < 1;
}

StateSpaceModel to_state_space(const PolynomialModel& model) {
  const PolynomialModel::Common c = model.common();
  Index n = c.denominator.size() - 1;
  for (const VectorXd& b : c.numerators) n = std::max(n, b.size() - 1);
  const auto inputs = static_cast<Index>(c.numerators.size());
  StateSpaceModel s;
  s.inputs = model.inputs;
  s.outputs = {model.output};
  s.Ts = model.Ts;
  s.u0 = model.u0;
  s.y0 = VectorXd::Constant(1, model.level());
  if (model.has_offset && model.integrates() && model.offset != 0) {
    std::size_t i = 0;
    while (i < model.B.size() && model.B[i].sum() == 0) ++i;
    if (i == model.B.size()) fail("the constant drives an integrator, and no input of the model could make up for it");
    s.u0[static_cast<Index>(i)] -= model.offset * model.F[i].sum() / model.B[i].sum();
  }
  VectorXd a = VectorXd::Zero(n + 1);
  a.head(c.denominator.size()) = c.denominator;
  s.A = MatrixXd::Zero(n, n);
  s.B = MatrixXd::Zero(n, inputs);
  s.C = MatrixXd::Zero(1, n);
  s.D = MatrixXd::Zero(1, inputs);
  if (n > 0) {
    s.A.col(0) = -a.tail(n);
    s.A.topRightCorner(n - 1, n - 1).setIdentity();
    s.C(0, 0) = 1;
  }
  for (Index i = 0; i < inputs; ++i) {
    VectorXd b = VectorXd::Zero(n + 1);
    const VectorXd& given = c.numerators[static_cast<std::size_t>(i)];
    b.head(given.size()) = given;
    s.D(0, i) = b[0];
    s.B.col(i) = b.tail(n) - b[0] * a.tail(n);
  }
  s.fit = model.fit;
  return s;
}

MatrixXd states_at_rest(const StateSpaceModel& model) {
  const Eigen::FullPivLU<MatrixXd> lu(MatrixXd::Identity(model.order(), model.order()) - model.A);
  if (!lu.isInvertible()) return MatrixXd::Constant(model.B.rows(), model.B.cols(), HUGE_VAL);
  return lu.solve(model.B);
}

std::vector<MatrixXd> simulate(const StateSpaceModel& model, const DataSet& data, StateStart start, Index samples) {
  check_signals(model.inputs, model.outputs, model.Ts, data);
  check_free_run(data);
  std::vector<MatrixXd> result;
  for (const Experiment& e : data.experiments) {
    MatrixXd y = respond(model, e.u, VectorXd::Zero(model.order()));
    if (start == StateStart::estimated && model.order() > 0) {
      const Index used = std::clamp<Index>(samples, 0, e.samples());
      y = respond(model, e.u, best_start(model, e.y.topRows(used), y.topRows(used)));
    }
    result.push_back(std::move(y));
  }
  return result;
}

Item to_item(const StateSpaceModel& m) {
  const auto channels = [](const std::vector<Channel>& list, const VectorXd& offset) {
    Item items = Item::list();
    for (std::size_t i = 0; i < list.size(); ++i) {
      Item item;
      item.set("name", list[i].name);
      if (!list[i].unit.empty()) item.set("unit", list[i].unit);
      item.set("operating_point", offset[static_cast<Index>(i)]);
      items.add(std::move(item));
    }
    return items;
  };
  Item x0 = Item::list();
  for (const VectorXd& x : m.x0) x0.add(x);
  Item item;
  item.set("Ts", m.Ts)
      .set("order", m.order())
      .set("inputs", channels(m.inputs, m.u0))
      .set("outputs", channels(m.outputs, m.y0))
      .set("A", m.A)
      .set("B", m.B)
      .set("C", m.C)
      .set("D", m.D)
      .set("x0", x0)
      .set("singular_values", m.singular_values)
      .set("fit", to_item(m.fit));
  return item;
}

StateSpaceModel state_space_of(const Item& item) {
  item.only({"plantloop_model", "type", "data", "Ts", "order", "inputs", "outputs", "A", "B", "C", "D", "x0",
             "singular_values", "fit"});
  StateSpaceModel m;
  m.Ts = item.number("Ts");
  const auto channels = [&](std::string_view key, std::vector<Channel>& list, VectorXd& offset) {
    const std::vector<Item>& items = item.items(key);
    offset.resize(static_cast<Index>(items.size()));
    for (std::size_t i = 0; i < items.size(); ++i) {
      items[i].only({"name", "unit", "operating_point"});
      list.push_back({items[i].text("name"), items[i].has("unit") ? items[i].text("unit") : ""});
      offset[static_cast<Index>(i)] = items[i].number("operating_point");
    }
  };
  channels("inputs", m.inputs, m.u0);
  channels("outputs", m.outputs, m.y0);
  const Index n = item.integer("order");
  if (n < 0 || n > 10'000) item.at("order").wrong("'order' lies between 0 and 10000");
  m.A = item.matrix("A", n, n);
  m.B = item.matrix("B", n, m.u0.size());
  m.C = item.matrix("C", m.y0.size(), n);
  m.D = item.matrix("D", m.y0.size(), m.u0.size());
  const MatrixXd starts = item.matrix("x0", -1, n);
  for (Index i = 0; i < starts.rows(); ++i) m.x0.emplace_back(starts.row(i).transpose());
  m.singular_values = item.vector("singular_values");
  m.fit = fit_report_of(item.at("fit"));
  return m;
}

}  // namespace plantloop::identify
