// Tables of candidate orders and delays.

#include "identify/linear/order.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/data/matching.h"
#include "identify/error.h"
#include "identify/linear/arx.h"
#include "identify/linear/least_squares.h"
#include "identify/validation/metrics.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinite = std::numeric_limits<double>::infinity();

void check_range(int least, int most, int lowest, const char* name) {
  if (least < lowest || most < least || most > 200)
    fail("'{}' runs from {} or more to 200 or less, not from {} to {}", name, lowest, least, most);
}

double free_run(const PolynomialModel& model, const DataSet& data) {
  if (!model.is_stable()) return infinite;
  const std::size_t output = match(model, data);
  if (!can_run_free(data, model.orders().longest_lag(), {output})) return infinite;
  const Series simulated = simulate(model, data);
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < simulated.size(); ++i) {
    const VectorXd y = data.experiments[i].y.col(static_cast<Index>(output));
    for (Index k = 0; k < y.size(); ++k) {
      if (std::isnan(y[k])) continue;
      sum += (y[k] - simulated[i][k]) * (y[k] - simulated[i][k]);
      count += 1;
    }
  }
  const double rmse = std::sqrt(sum / count);
  return std::isfinite(rmse) ? rmse : infinite;
}

template <typename Key>
std::size_t least(const std::vector<ArxCandidate>& list, Key key) {
  const auto best =
      std::min_element(list.begin(), list.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  return static_cast<std::size_t>(best - list.begin());
}

}  // namespace

ArxTable arx_table(const DataSet& given, const OrderRange& range, const LinearOptions& options,
                   const DataSet* validation, const FitControl& control) {
  check_range(range.na_least, range.na_most, 0, "na");
  check_range(range.nb_least, range.nb_most, given.inputs.empty() ? 0 : 1, "nb");
  check_range(range.delay_least, range.delay_most, -1, "delay");
  // One regression holds the columns of all: y lags 1 ... na_most, lags delay_least + 1 ... delay_most + nb_most of
  // each input.
  const auto inputs = static_cast<int>(given.inputs.size());
  const int width = range.nb_most + range.delay_most - range.delay_least;
  if (validation != nullptr) check_signals(given.inputs, given.outputs, given.Ts, *validation);
  const LinearTask task =
      prepare(given, {.na = range.na_most, .nb = {width}, .nf = {0}, .delay = {range.delay_least}}, options);
  const ArxRows rows = arx_rows(task.data, task.orders, task.output, task.offset);
  MatrixXd all(rows.Psi.rows(), rows.Psi.cols() + 1);
  all << rows.Psi, rows.y;
  const Index kept = std::min(all.rows(), all.cols());
  MatrixXd R = MatrixXd::Zero(all.cols(), all.cols());
  R.topRows(kept) = Eigen::HouseholderQR<MatrixXd>(all).matrixQR().topRows(kept).triangularView<Eigen::Upper>();

  ArxTable table;
  table.rows = rows.y.size();
  const auto samples = static_cast<double>(table.rows);
  const int total = (range.na_most - range.na_least + 1) * (range.nb_most - range.nb_least + 1) *
                    (range.delay_most - range.delay_least + 1);
  for (int na = range.na_least; na <= range.na_most; ++na) {
    for (int nb = range.nb_least; nb <= range.nb_most; ++nb) {
      for (int delay = range.delay_least; delay <= range.delay_most; ++delay) {
        control.step(static_cast<double>(table.candidates.size()) / total);
        ArxCandidate c;
        c.orders.na = na;
        c.orders.nb.assign(given.inputs.size(), nb);
        c.orders.nf.assign(given.inputs.size(), 0);
        c.orders.delay.assign(given.inputs.size(), delay);
        c.parameters = c.orders.parameters() + (task.offset ? 1 : 0);
        if (c.parameters == 0 || c.parameters >= table.rows) continue;
        MatrixXd X(R.rows(), c.parameters);
        X.leftCols(na) = R.leftCols(na);
        for (int i = 0; i < inputs; ++i) {
          X.middleCols(na + i * nb, nb) = R.middleCols(range.na_most + i * width + delay - range.delay_least, nb);
        }
        if (task.offset) X.rightCols(1) = R.col(R.cols() - 2);
        const LeastSquares fit = least_squares(X, R.rightCols(1));
        c.sse = fit.sse;
        c.aic = akaike(c.sse, samples, c.parameters);
        c.mdl = minimum_description_length(c.sse, samples, c.parameters);
        c.fpe = final_prediction_error(c.sse, samples, c.parameters);
        LinearTask own = task;
        own.orders = c.orders;
        PolynomialModel model = begin_model(own);
        model.set_parameters(fit.theta);
        c.simulated = free_run(model, validation != nullptr ? *validation : given);
        table.candidates.push_back(std::move(c));
      }
    }
  }
  if (table.candidates.empty()) fail("{} rows are too few for the least of these orders", table.rows);
  table.best_aic = least(table.candidates, [](const ArxCandidate& c) { return c.aic; });
  table.best_mdl = least(table.candidates, [](const ArxCandidate& c) { return c.mdl; });
  table.best_fpe = least(table.candidates, [](const ArxCandidate& c) { return c.fpe; });
  table.best_simulated = least(table.candidates, [](const ArxCandidate& c) { return c.simulated; });
  return table;
}

InformationTest information_test(const DataSet& data, int highest, int delay, const LinearOptions& options) {
  check_range(1, highest, 1, "order");
  InformationTest test;
  for (int n = 1; n <= highest; ++n) {
    const LinearTask task = prepare(data, {.na = n, .nb = {n}, .nf = {0}, .delay = {delay}}, options);
    ArxRows rows = arx_rows(task.data, task.orders, task.output, task.offset);
    // With an offset it stands first and does not count: what is left are deviations from the means.
    if (task.offset) rows.Psi.col(0).swap(rows.Psi.col(rows.Psi.cols() - 1));
    // The determinant of R'R/N is the product of R's squared diagonal: never negative by rounding.
    const MatrixXd R = Eigen::HouseholderQR<MatrixXd>(rows.Psi).matrixQR();
    double determinant = 1;
    for (Index i = task.offset ? 1 : 0; i < R.cols(); ++i) {
      determinant *= i < R.rows() ? R(i, i) * R(i, i) / static_cast<double>(rows.y.size()) : 0;
    }
    test.determinants.push_back(determinant);
  }
  double jump = 0;
  for (std::size_t n = 1; n + 1 < test.determinants.size(); ++n) {
    const double before = test.determinants[n - 1] / test.determinants[n];
    const double after = test.determinants[n] / test.determinants[n + 1];
    if (after / before > jump) {
      jump = after / before;
      test.order = static_cast<int>(n) + 1;
    }
  }
  return test;
}

std::vector<DelayCandidate> delay_table(const DataSet& data, int order, int delay_least, int delay_most,
                                        const LinearOptions& options, const FitControl& control) {
  check_range(delay_least, delay_most, -1, "delay");
  check_range(order, order, 1, "order");
  std::vector<DelayCandidate> table;
  for (int d = delay_least; d <= delay_most; ++d) {
    control.step(static_cast<double>(d - delay_least) / (delay_most - delay_least + 1));
    const PolynomialModel model = fit_linear(data, {.nb = {order}, .nf = {order}, .delay = {d}}, options);
    table.push_back({d, model.is_stable() ? std::sqrt(model.fit.reached) : infinite});
  }
  return table;
}

}  // namespace plantloop::identify
