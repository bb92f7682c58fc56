// Linear dynamics by several methods, in a common basis.

#include "identify/neural_state_space/beginnings.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/error.h"
#include "identify/linear/fit_linear.h"
#include "identify/linear/state_space.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd states_of(const DataSet& data, const MatrixXd& A, const MatrixXd& B, const std::vector<VectorXd>& x0) {
  MatrixXd rows(data.samples(), A.rows());
  Index row = 0;
  for (std::size_t i = 0; i < data.experiments.size(); ++i) {
    VectorXd x = x0[i];
    for (Index k = 0; k < data.experiments[i].samples(); ++k) {
      rows.row(row++) = x.transpose();
      x = A * x + B * data.experiments[i].u.row(k).transpose();
    }
  }
  return rows;
}

// Adds the beginning in the basis in which the mean square of its states is the unit matrix; one that does not decay is
// slowed down first.
void add(std::vector<Beginning>& list, const DataSet& data, Beginning b) {
  const double radius = Eigen::EigenSolver<MatrixXd>(b.A, false).eigenvalues().cwiseAbs().maxCoeff();
  if (!(radius < 0.9995)) b.A *= 0.9995 / radius;
  b.states = states_of(data, b.A, b.B, b.x0);
  if (!b.states.allFinite()) return;
  const MatrixXd P = b.states.transpose() * b.states / static_cast<double>(b.states.rows());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> parts(P);
  const double greatest = parts.eigenvalues().maxCoeff();
  if (!(greatest > 0)) return;
  const VectorXd roots = parts.eigenvalues().cwiseMax(1e-10 * greatest).cwiseSqrt();
  const MatrixXd to = roots.cwiseInverse().asDiagonal() * parts.eigenvectors().transpose();
  const MatrixXd back = parts.eigenvectors() * roots.asDiagonal();
  b.A = to * b.A * back;
  b.B = to * b.B;
  for (VectorXd& x : b.x0) x = to * x;
  b.states = states_of(data, b.A, b.B, b.x0);
  list.push_back(std::move(b));
}

}  // namespace

DataSet increments(DataSet data) {
  for (Experiment& e : data.experiments) {
    const Index last = e.samples() - 1;
    for (Index k = 0; k < last; ++k) e.y.row(k) = (e.y.row(k + 1) - e.y.row(k)).eval();
    if (last > 0) e.y.row(last) = e.y.row(last - 1);
  }
  return data;
}

std::vector<Beginning> beginnings(const DataSet& data, int order) {
  std::vector<Beginning> list;
  const auto inputs = static_cast<Index>(data.inputs.size());
  const auto or_not = [](const auto& make) {
    try {
      make();
    } catch (const Cancelled&) {
      throw;
    } catch (const IdentifyError&) {
      // A linear method that these data do not allow is one way less to begin.
    }
  };
  or_not([&] {
    StateSpaceModel m = fit_subspace(data, {.order = order, .block_rows = std::max(10, 2 * order)});
    add(list, data, {"subspace method", m.A, m.B, m.x0, {}});
  });
  if (data.outputs.size() == 1 && inputs > 0) {
    or_not([&] {
      Orders orders;
      // Each input has poles of its own; together they make the order where it is a multiple of the inputs.
      orders.nb.assign(static_cast<std::size_t>(inputs), std::max(1, order / static_cast<int>(inputs)));
      orders.nf = orders.nb;
      orders.delay.assign(static_cast<std::size_t>(inputs), 0);
      StateSpaceModel m = to_state_space(fit_linear(data, orders, {.iterations = 60}));
      if (m.order() != order) return;
      std::vector<VectorXd> x0(data.experiments.size(), VectorXd::Zero(order));
      add(list, data, {"output error", m.A, m.B, std::move(x0), {}});
    });
  }
  for (const double lag : {1.0, 3.0, 10.0, 30.0, 100.0}) {
    if (inputs == 0 || inputs > order || lag * 5 > static_cast<double>(data.samples())) continue;
    const double a = std::exp(-1 / lag);
    MatrixXd A = a * MatrixXd::Identity(order, order), B = MatrixXd::Zero(order, inputs);
    for (Index i = 0; i < order; ++i) {
      if (i < inputs) {
        B(i, i) = 1 - a;
      } else {
        A(i, i - inputs) = 1 - a;
      }
    }
    std::vector<VectorXd> x0;
    const MatrixXd rest = (MatrixXd::Identity(order, order) - A).partialPivLu().solve(B);
    for (const Experiment& e : data.experiments) x0.emplace_back(rest * e.u.row(0).transpose());
    add(list, data, {fmt::format("equal lags of {:g} samples", lag), A, B, std::move(x0), {}});
  }
  if (list.empty()) fail("no linear model of order {} could be made to begin with", order);
  return list;
}

std::vector<Index> settled_rows(const DataSet& data, const MatrixXd& A) {
  Index long_enough = 0;
  for (MatrixXd power = A; power.norm() > 0.1 && long_enough < data.samples(); power = (power * A).eval())
    ++long_enough;
  std::vector<Index> rows;
  Index first = 0;
  for (const Experiment& e : data.experiments) {
    for (Index k = std::min(long_enough, e.samples() / 3); k < e.samples(); ++k) rows.push_back(first + k);
    first += e.samples();
  }
  return rows;
}

}  // namespace plantloop::identify
