// ARX and FIR by least squares.

#include "identify/linear/arx.h"

#include <algorithm>

#include "identify/data/undetermined.h"
#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;

ArxRows arx_rows(const DataSet& data, const Orders& orders, std::size_t output, Index first) {
  first = std::max<Index>(first, orders.longest_lag());
  const Index columns = orders.na + [&] {
    Index sum = 0;
    for (const int nb : orders.nb) sum += nb;
    return sum;
  }();
  Index count = 0;
  for (const Experiment& e : data.experiments) count += std::max<Index>(0, e.samples() - first);
  ArxRows rows{Eigen::MatrixXd(count, columns), Eigen::VectorXd(count)};
  Index at = 0;
  for (const Experiment& e : data.experiments) {
    const auto y = e.y.col(static_cast<Index>(output));
    for (Index k = first; k < e.samples(); ++k) {
      auto row = rows.Psi.row(at);
      for (int i = 1; i <= orders.na; ++i) row[i - 1] = -y[k - i];
      Index column = orders.na;
      for (std::size_t input = 0; input < orders.nb.size(); ++input) {
        for (int i = 1; i <= orders.nb[input]; ++i) {
          row[column++] = e.u(k - orders.delay[input] - i, static_cast<Index>(input));
        }
      }
      rows.y[at] = y[k];
      if (row.hasNaN() || std::isnan(y[k])) {
        ++rows.left_out;
      } else {
        ++at;
      }
    }
  }
  rows.Psi.conservativeResize(at, Eigen::NoChange);
  rows.y.conservativeResize(at);
  return rows;
}

std::string structure_name(const Orders& o) {
  const bool f = std::any_of(o.nf.begin(), o.nf.end(), [](int n) { return n > 0; });
  if (o.nc + o.nd == 0 && !f) return o.na > 0 ? (o.nb.empty() ? "AR" : "ARX") : "FIR";
  if (o.nd == 0 && !f) return o.nb.empty() ? "ARMA" : "ARMAX";
  if (o.na > 0) return "general";
  return o.nc + o.nd == 0 ? "OE" : "BJ";
}

std::vector<std::string> options_of(const LinearOptions& options) {
  const LinearOptions usual;
  std::vector<std::string> list;
  if (options.remove_means) list.emplace_back("remove_means");
  if (options.ridge != usual.ridge) list.push_back(fmt::format("ridge {}", options.ridge));
  if (options.iterations != usual.iterations) list.push_back(fmt::format("iterations {}", options.iterations));
  return list;
}

PolynomialModel begin_model(const LinearTask& task) {
  PolynomialModel model = make_polynomial_model(task.orders, task.data, task.output);
  model.structure = structure_name(task.orders);
  model.u0 = task.u0;
  model.y0 = task.y0;
  model.fit.data = task.hash;
  model.fit.warnings = undetermined(task.data);
  return model;
}

PolynomialModel fit_arx(const LinearTask& task, const LinearOptions& options) {
  const ArxRows rows = arx_rows(task.data, task.orders, task.output);
  if (rows.y.size() < task.orders.parameters()) {
    fail("{} rows with a whole past do not determine {} parameters", rows.y.size(), task.orders.parameters());
  }
  const LeastSquares fit = least_squares(rows.Psi, rows.y, {.ridge = options.ridge});
  PolynomialModel model = begin_model(task);
  model.set_parameters(fit.theta);
  model.variance = fit.s2;
  model.covariance = fit.covariance;
  model.fit.method = options.ridge > 0 ? "least squares with ridge" : "least squares";
  model.fit.samples = rows.y.size();
  model.fit.parameters = task.orders.parameters();
  model.fit.reached = fit.sse / static_cast<double>(rows.y.size());
  model.fit.stopped = "solved directly";
  model.fit.tried.push_back(fit.account());
  model.fit.options = options_of(options);
  model.fit.warnings.insert(model.fit.warnings.end(), fit.warnings.begin(), fit.warnings.end());
  if (rows.left_out > 0) {
    model.fit.warnings.push_back(fmt::format("{} rows that touch missing values are left out", rows.left_out));
  }
  if (!model.is_stable()) model.fit.warnings.emplace_back("the model is unstable");
  return model;
}

}  // namespace plantloop::identify
