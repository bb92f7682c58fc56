// ARX and FIR by least squares.

#include "identify/linear/arx.h"

#include <algorithm>
#include <cmath>

#include "identify/data/undetermined.h"
#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;

ArxRows arx_rows(const DataSet& data, const Orders& orders, std::size_t output, bool offset, Index first) {
  first = std::max<Index>(first, orders.longest_lag());
  const Index columns = orders.na + [&] {
    Index sum = 0;
    for (const int nb : orders.nb) sum += nb;
    return sum + (offset ? 1 : 0);
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
      if (offset) row[column] = 1;
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
  if (options.offset) list.emplace_back("offset");
  if (options.initial) list.push_back(*options.initial == Initial::rest ? "initial rest" : "initial estimate");
  if (options.ridge != usual.ridge) list.push_back(fmt::format("ridge {}", options.ridge));
  if (options.iterations != usual.iterations) list.push_back(fmt::format("iterations {}", options.iterations));
  return list;
}

PolynomialModel begin_model(const LinearTask& task) {
  PolynomialModel model = make_polynomial_model(task.orders, task.data, task.output);
  model.structure = structure_name(task.orders);
  model.u0 = task.u0;
  model.y0 = task.y0;
  model.has_offset = task.offset;
  model.initial = task.initial;
  model.covariance = Eigen::MatrixXd::Zero(task.parameters(), task.parameters());
  model.fit.data = task.hash;
  model.fit.warnings = undetermined(task.data);
  return model;
}

void warn_of_constant(PolynomialModel& model, const Eigen::VectorXd& v) {
  constexpr Index blocks = 20;
  if (model.has_offset || v.size() < 5 * blocks) return;
  Eigen::VectorXd means(blocks);
  for (Index i = 0; i < blocks; ++i) {
    const Index from = i * v.size() / blocks;
    means[i] = v.segment(from, (i + 1) * v.size() / blocks - from).mean();
  }
  const double mean = means.mean();
  const double deviation = std::sqrt((means.array() - mean).square().sum() / (blocks * (blocks - 1)));
  // Student's t of 19 degrees of freedom is beyond 8 once in ten million times.
  if (std::fabs(mean) > 8 * deviation &&
      std::fabs(mean) > 0.02 * std::sqrt(v.squaredNorm() / static_cast<double>(v.size()))) {
    model.fit.warnings.push_back(fmt::format(
        "the prediction errors have the mean {:.3g}: estimate a constant, 'offset', or remove the means", mean));
  }
}

PolynomialModel fit_arx(const LinearTask& task, const LinearOptions& options) {
  const ArxRows rows = arx_rows(task.data, task.orders, task.output, task.offset);
  if (rows.y.size() < task.parameters()) {
    fail("{} rows with a whole past do not determine {} parameters", rows.y.size(), task.parameters());
  }
  const LeastSquares fit =
      least_squares(rows.Psi, rows.y, {.ridge = options.ridge, .free_columns = task.offset ? 1 : 0});
  PolynomialModel model = begin_model(task);
  model.set_parameters(fit.theta);
  model.variance = fit.s2;
  model.covariance = fit.covariance;
  model.fit.method = options.ridge > 0 ? "least squares with ridge" : "least squares";
  model.fit.samples = rows.y.size();
  model.fit.parameters = task.parameters();
  model.fit.reached = fit.sse / static_cast<double>(rows.y.size());
  model.fit.stopped = "solved directly";
  model.fit.tried.push_back(fit.account());
  model.fit.options = options_of(options);
  model.fit.warnings.insert(model.fit.warnings.end(), fit.warnings.begin(), fit.warnings.end());
  if (rows.left_out > 0) {
    model.fit.warnings.push_back(fmt::format("{} rows that touch missing values are left out", rows.left_out));
  }
  if (!model.is_stable()) model.fit.warnings.emplace_back("the model is unstable");
  warn_of_constant(model, fit.residuals);
  return model;
}

}  // namespace plantloop::identify
