// The matrices that regressors make of data.

#include "identify/regressors/regressors.h"

#include <algorithm>
#include <cmath>

#include "identify/data/matching.h"
#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

double power(double base, int exponent) {
  double result = base;
  for (int i = 1; i < exponent; ++i) result *= base;
  return result;
}

double value_at(const Regressor& r, const MatrixXd& u, const MatrixXd& y, Index k) {
  double value = 1;
  for (const Factor& f : r.factors) value *= power((f.of_output ? y : u)(k - f.lag, f.channel), f.power);
  return value;
}

}  // namespace

int Regressor::degree() const {
  int sum = 0;
  for (const Factor& f : factors) sum += f.power;
  return sum;
}

int RegressorSet::longest_lag() const {
  int most = 0;
  for (const Regressor& r : list) {
    for (const Factor& f : r.factors) most = std::max(most, f.lag);
  }
  return most;
}

bool RegressorSet::uses_outputs() const {
  return std::any_of(list.begin(), list.end(), [](const Regressor& r) {
    return std::any_of(r.factors.begin(), r.factors.end(), [](const Factor& f) { return f.of_output; });
  });
}

Eigen::VectorXd row_at(const RegressorSet& set, const MatrixXd& u, const MatrixXd& y, Index k) {
  Eigen::VectorXd x(set.size());
  for (Index i = 0; i < x.size(); ++i) x[i] = value_at(set.list[static_cast<std::size_t>(i)], u, y, k);
  return x;
}

Regression make_regression(const DataSet& data, const RegressorSet& set, Index first) {
  check(data);
  if (set.list.empty()) fail("there are no regressors");
  if (set.errors > 0)
    fail("'{}' stands for prediction errors; only an mlp is trained with them, as structure NARMAX",
         set.inputs[static_cast<std::size_t>(set.data_inputs())]);
  check_names(set.inputs, set.outputs, data);
  first = std::max<Index>(first, set.longest_lag());
  Index rows = 0;
  for (const Experiment& e : data.experiments) rows += std::max<Index>(0, e.samples() - first);
  Regression result;
  result.X.resize(rows, set.size());
  result.Y.resize(rows, static_cast<Index>(data.outputs.size()));
  Index at = 0;
  for (std::size_t i = 0; i < data.experiments.size(); ++i) {
    const Experiment& e = data.experiments[i];
    for (Index k = first; k < e.samples(); ++k) {
      result.X.row(at) = row_at(set, e.u, e.y, k).transpose();
      result.Y.row(at) = e.y.row(k);
      if (result.X.row(at).hasNaN() || result.Y.row(at).hasNaN()) {
        ++result.left_out;
        continue;
      }
      result.rows.push_back({i, k});
      ++at;
    }
  }
  result.X.conservativeResize(at, Eigen::NoChange);
  result.Y.conservativeResize(at, Eigen::NoChange);
  if (at == 0) {
    fail(
        "no row of regressors is left: the longest lag is {} samples, the data have {} samples in {} experiments, {} "
        "rows touch missing values",
        set.longest_lag(), data.samples(), data.experiments.size(), result.left_out);
  }
  return result;
}

}  // namespace plantloop::identify
