// The subspace method PO-MOESP.

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/linear/least_squares.h"
#include "identify/linear/signal_units.h"
#include "identify/linear/state_space.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Columns are times, rows [1; Uf; Up; Yp; Yf], each of `i` blocks and the ones only with an offset; experiments stand
// beside each other.
MatrixXd hankel(const DataSet& data, Index i, bool offset) {
  const auto m = static_cast<Index>(data.inputs.size());
  const auto l = static_cast<Index>(data.outputs.size());
  Index columns = 0;
  for (const Experiment& e : data.experiments) columns += std::max<Index>(0, e.samples() - 2 * i + 1);
  // Transposed: one row for each time, which is what QR wants.
  const Index one = offset ? 1 : 0;
  MatrixXd H = MatrixXd::Ones(columns, one + 2 * i * (m + l));
  Index row = 0;
  for (const Experiment& e : data.experiments) {
    for (Index k = 0; k + 2 * i <= e.samples(); ++k, ++row) {
      for (Index b = 0; b < i; ++b) {
        H.row(row).segment(one + b * m, m) = e.u.row(k + i + b);
        H.row(row).segment(one + (i + b) * m, m) = e.u.row(k + b);
        H.row(row).segment(one + 2 * i * m + b * l, l) = e.y.row(k + b);
        H.row(row).segment(one + 2 * i * m + (i + b) * l, l) = e.y.row(k + i + b);
      }
    }
  }
  return H;
}

// Where the ratio of neighbouring singular values is greatest; below rounding there is nothing to compare.
int order_of(const VectorXd& s, int highest) {
  int best = 1;
  double ratio = 0;
  for (int n = 1; n <= highest && n < s.size(); ++n) {
    const double floor = 1e-12 * s[0];
    if (s[n - 1] <= floor) break;
    const double own = s[n - 1] / std::max(s[n], floor);
    if (own > ratio) {
      ratio = own;
      best = n;
    }
  }
  return best;
}

// B, D, the outputs' offset and the first states are linear in the simulated output. `data` and model.C are in `units`
// of the outputs; the model is in the user's at the end.
void fit_inputs(StateSpaceModel& model, const DataSet& data, const VectorXd& units, bool feedthrough, bool offset) {
  const Index n = model.order();
  const auto m = static_cast<Index>(data.inputs.size());
  const auto l = static_cast<Index>(data.outputs.size());
  const auto starts = static_cast<Index>(data.experiments.size());
  const Index at_offset = n * m + (feedthrough ? l * m : 0);
  const Index columns = at_offset + (offset ? l : 0) + n * starts;
  MatrixXd X = MatrixXd::Zero(data.samples() * l, columns);
  VectorXd y(X.rows());
  Index row = 0;
  for (Index which = 0; which < starts; ++which) {
    const Experiment& e = data.experiments[static_cast<std::size_t>(which)];
    // States driven by each input through each entry of B, and by the first state.
    MatrixXd driven = MatrixXd::Zero(n, n * m);
    MatrixXd free = MatrixXd::Identity(n, n);
    for (Index k = 0; k < e.samples(); ++k) {
      X.block(row, 0, l, n * m) = model.C * driven;
      if (feedthrough) {
        for (Index j = 0; j < m; ++j) {
          for (Index o = 0; o < l; ++o) X(row + o, n * m + j * l + o) = e.u(k, j);
        }
      }
      if (offset) X.block(row, at_offset, l, l).setIdentity();
      X.block(row, columns - n * starts + n * which, l, n) = model.C * free;
      y.segment(row, l) = e.y.row(k).transpose();
      row += l;
      driven = (model.A * driven).eval();
      for (Index j = 0; j < m; ++j) driven.middleCols(j * n, n).diagonal().array() += e.u(k, j);
      free = (model.A * free).eval();
    }
  }
  if (!X.allFinite()) fail("the identified model of order {} is so unstable that its response overflows", n);
  const LeastSquares fit = least_squares(X, y);
  model.B = fit.theta.head(n * m).reshaped(n, m);
  model.D = MatrixXd::Zero(l, m);
  if (feedthrough) model.D = fit.theta.segment(n * m, l * m).reshaped(l, m);
  if (offset) model.y0 += units.cwiseProduct(fit.theta.segment(at_offset, l));
  for (Index i = 0; i < starts; ++i) model.x0.emplace_back(fit.theta.segment(columns - n * starts + n * i, n));
  model.fit.warnings.insert(model.fit.warnings.end(), fit.warnings.begin(), fit.warnings.end());
  model.C = (units.asDiagonal() * model.C).eval();
  model.D = (units.asDiagonal() * model.D).eval();
  model.fit.reached =
      (units.asDiagonal() * fit.residuals.reshaped(l, data.samples())).squaredNorm() / static_cast<double>(y.size());
  model.fit.parameters = n * n + n * l + columns;
}

// Outputs of size 1, so that none outweighs the others for its unit.
VectorXd take_units(DataSet& data) {
  const MatrixXd y = data.all_y();
  VectorXd units(y.cols());
  for (Index o = 0; o < y.cols(); ++o) units[o] = size_of(y.col(o));
  for (Experiment& e : data.experiments) e.y *= units.cwiseInverse().asDiagonal();
  return units;
}

void remove_means(DataSet& data, StateSpaceModel& model) {
  model.u0 = data.all_u().colwise().mean().transpose();
  model.y0 = data.all_y().colwise().mean().transpose();
  for (Experiment& e : data.experiments) {
    e.u.rowwise() -= model.u0.transpose();
    e.y.rowwise() -= model.y0.transpose();
  }
}

}  // namespace

StateSpaceModel fit_subspace(const DataSet& given, const SubspaceOptions& options, const FitControl& control) {
  check(given);
  refuse_missing(given, "the subspace method");
  if (given.inputs.empty()) fail("the subspace method needs an input");
  if ((given.all_y().rowwise() - given.all_y().row(0)).isZero(0))
    fail("no output varies: there is no dynamics to find");
  const Index i = options.block_rows;
  if (i < 2 || i > 1000) fail("'block_rows' lies between 2 and 1000, it is {}", i);
  if (options.highest < 1) fail("'highest' is the order to choose from, 1 or more; it is {}", options.highest);
  const int needed = options.order > 0 ? options.order : 1;
  if (options.order < 0 || needed >= i) {
    fail("'order' lies between 0 and block_rows - 1 = {}, it is {}", i - 1, options.order);
  }
  DataSet data = given;
  StateSpaceModel model;
  model.inputs = data.inputs;
  model.outputs = data.outputs;
  model.Ts = data.Ts;
  const auto m = static_cast<Index>(data.inputs.size());
  const auto l = static_cast<Index>(data.outputs.size());
  model.u0 = VectorXd::Zero(m);
  model.y0 = VectorXd::Zero(l);
  if (options.remove_means) remove_means(data, model);
  const VectorXd units = take_units(data);

  MatrixXd H = hankel(data, i, options.offset);
  if (H.rows() < H.cols()) {
    fail("{} block rows of {} signals need experiments with {} samples or more in all; take fewer block rows", i, m + l,
         H.cols() + 2 * i - 1);
  }
  control.step(0.1);
  const MatrixXd R =
      Eigen::HouseholderQR<Eigen::Ref<MatrixXd>>(H).matrixQR().topRows(H.cols()).triangularView<Eigen::Upper>();
  // L = R': rows Yf, columns of [Up; Yp].
  const Index one = options.offset ? 1 : 0;
  const MatrixXd L = R.block(one + i * m, one + i * (2 * m + l), i * (m + l), i * l).transpose();
  const Eigen::BDCSVD<MatrixXd> svd(L, Eigen::ComputeThinU);
  model.singular_values = svd.singularValues();
  control.step(0.6);
  const int order = options.order > 0
                        ? options.order
                        : order_of(model.singular_values, std::min<int>(options.highest, static_cast<int>(i) - 1));
  const MatrixXd gamma = svd.matrixU().leftCols(order) * model.singular_values.head(order).cwiseSqrt().asDiagonal();
  model.C = gamma.topRows(l);
  model.A = gamma.topRows((i - 1) * l).colPivHouseholderQr().solve(gamma.bottomRows((i - 1) * l));
  model.fit.method = "subspace method PO-MOESP";
  model.fit.tried.push_back(
      fmt::format("singular values: {:.4g}",
                  fmt::join(model.singular_values.head(std::min<Index>(12, model.singular_values.size())), ", ")));
  model.fit.samples = data.samples();
  model.fit.stopped = "solved directly";
  model.fit.data = hash(given);
  model.fit.warnings = undetermined(given);
  model.fit.options.push_back(fmt::format("block_rows {}", i));
  if (options.remove_means) model.fit.options.emplace_back("remove_means");
  if (options.offset) model.fit.options.emplace_back("offset");
  fit_inputs(model, data, units, options.feedthrough, options.offset);
  if (!model.is_stable()) model.fit.warnings.emplace_back("the model is unstable");
  control.step(1);
  return model;
}

}  // namespace plantloop::identify
