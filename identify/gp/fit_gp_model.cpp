// Fits of models: normalisation, a process for each output, linear models as observations.

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "identify/error.h"
#include "identify/gp/gp_file.h"
#include "identify/gp/gp_map.h"
#include "identify/gp/inducing.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Normalised as the data are.
std::vector<Observation> normalised(std::vector<Observation> observations, const Scaling& x, const Scaling& y,
                                    Index output) {
  for (Observation& o : observations) {
    if (o.x.size() != x.size()) fail("an observation has {} inputs, the model {}", o.x.size(), x.size());
    if (!o.x.allFinite() || !std::isfinite(o.value)) fail("an observation has numbers that are not finite");
    o.x = (o.x - x.offset).cwiseQuotient(x.scale);
    double factor = 1 / y.scale[output];
    if (o.slope_of == 0) o.value -= y.offset[output];
    if (o.slope_of >= 1 && o.slope_of <= x.size()) factor *= x.scale[o.slope_of - 1];
    o.value *= factor;
    o.noise *= factor * factor;
  }
  return observations;
}

GpFit fit_with_slopes(const MatrixXd& x, const VectorXd& y, const std::vector<Observation>& known,
                      const GpOptions& options, const FitControl& control) {
  if (options.mean != "zero") fail("{}", slopes_need_zero_mean);
  const auto d = static_cast<int>(x.cols());
  MatrixXd rows(x.rows() + static_cast<Index>(known.size()), d + 2);
  rows.topRows(x.rows()) << x, VectorXd::Zero(x.rows()), VectorXd::Constant(x.rows(), -1);
  rows.bottomRows(rows.rows() - x.rows()) = rows_of(known, d);
  VectorXd targets(rows.rows());
  targets.head(y.size()) = y;
  for (std::size_t i = 0; i < known.size(); ++i) targets[y.size() + static_cast<Index>(i)] = known[i].value;
  return fit_gp(with_slopes(find_covariance(options.covariance), d), rows, targets, options, control);
}

}  // namespace

GpMapFit fit_gp_map(const MatrixXd& X, const MatrixXd& Y, const GpModelOptions& options, const FitControl& control,
                    const std::vector<std::vector<Observation>>& observations) {
  if (Y.cols() == 0) fail("there is no target");
  if (options.given.size() > 1 && static_cast<Index>(options.given.size()) != Y.cols())
    fail("there are hyperparameters of {} outputs, the data have {}", options.given.size(), Y.cols());
  if (!observations.empty() && static_cast<Index>(observations.size()) != Y.cols())
    fail("there are observations of {} outputs, the data have {}", observations.size(), Y.cols());
  for (Index o = 0; o < Y.cols(); ++o) check_data(X, Y.col(o));
  const Scaling xs = options.normalise ? standard_scaling(X) : no_scaling(X.cols());
  const Scaling ys = options.normalise ? standard_scaling(Y) : no_scaling(Y.cols());
  MatrixXd x = xs.normalised(X), y = ys.normalised(Y);
  GpMapFit fit;
  std::vector<std::string> warnings;
  std::optional<SparseOptions> sparse = options.sparse;
  if (sparse && !observations.empty())
    fail("local models are observations that need every point of their own; a sparse process cannot take them");
  if (sparse && sparse->inputs.size() > 0) {
    if (sparse->inputs.cols() != X.cols())
      fail("the inducing inputs have {} columns, the data {} inputs", sparse->inputs.cols(), X.cols());
    sparse->inputs = xs.normalised(sparse->inputs);
  }
  if (!sparse && x.rows() > options.most) {
    const std::vector<Index> rows = spread_subset(x, options.most, options.process.seed);
    warnings.push_back(fmt::format("Of {} rows the {} most spread ones were taken.", x.rows(), options.most));
    x = x(rows, Eigen::all).eval();
    y = y(rows, Eigen::all).eval();
  }
  GpMap::Processes processes;
  for (Index o = 0; o < y.cols(); ++o) {
    const auto known = observations.empty() ? std::vector<Observation>{}
                                            : normalised(observations[static_cast<std::size_t>(o)], xs, ys, o);
    GpOptions how = options.process;
    if (!options.given.empty()) how.start = options.given[options.given.size() > 1 ? static_cast<std::size_t>(o) : 0];
    FitReport report;
    if (sparse) {
      SparseFit found = fit_sparse(x, y.col(o), how, *sparse, control);
      processes.push_back(std::make_shared<SparseGaussianProcess>(std::move(found.model)));
      report = std::move(found.report);
    } else {
      GpFit found =
          known.empty() ? fit_gp(x, y.col(o), how, control) : fit_with_slopes(x, y.col(o), known, how, control);
      processes.push_back(std::make_shared<GaussianProcess>(std::move(found.model)));
      report = std::move(found.report);
    }
    if (o == 0) {
      fit.report = std::move(report);
    } else {
      for (const std::string& line : report.tried)
        fit.report.tried.push_back(fmt::format("output {}, {}", o + 1, line));
      fit.report.parameters += report.parameters;
      fit.report.warnings.insert(fit.report.warnings.end(), report.warnings.begin(), report.warnings.end());
    }
  }
  fit.report.warnings.insert(fit.report.warnings.end(), warnings.begin(), warnings.end());
  if (y.cols() > 1) fit.report.measure += " of the first output";
  if (options.normalise) fit.report.measure += ", normalised";
  fit.model = std::make_shared<GpMap>(std::move(processes), xs, ys);
  return fit;
}

NarxModel fit_narx_gp(const DataSet& data, const RegressorSet& regressors, const GpModelOptions& options,
                      const FitControl& control, const std::vector<PolynomialModel>& local_models) {
  const Regression rows = make_regression(data, regressors);
  std::vector<std::vector<Observation>> observations;
  if (!local_models.empty()) observations.resize(regressors.outputs.size());
  for (const PolynomialModel& local : local_models) {
    if (local.Ts != data.Ts) fail("a linear model has the sampling time {:g} s, the data {:g} s", local.Ts, data.Ts);
    const std::vector<Observation> known = observations_of(local, regressors);
    const auto output = std::find(regressors.outputs.begin(), regressors.outputs.end(), local.output.name);
    auto& list = observations[static_cast<std::size_t>(output - regressors.outputs.begin())];
    list.insert(list.end(), known.begin(), known.end());
  }
  GpMapFit fit = fit_gp_map(rows.X, rows.Y, options, control, observations);
  if (!local_models.empty())
    fit.report.options.push_back(fmt::format("{} linear local models as values and slopes", local_models.size()));
  if (rows.left_out > 0)
    fit.report.warnings.push_back(fmt::format("{} rows with missing values were left out.", rows.left_out));
  return make_narx(fit.model, regressors, data, fit.report);
}

}  // namespace plantloop::identify
