// Gaussian processes as a model: scaling, derivatives, model file, fits.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "identify/error.h"
#include "identify/gp/gp_map.h"
#include "identify/gp/sparse.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

GpMap::GpMap(std::vector<GaussianProcess> processes, Scaling x, Scaling y)
    : processes_(std::move(processes)), x_(std::move(x)), y_(std::move(y)) {
  if (processes_.empty()) fail("a model needs at least one process");
  for (const GaussianProcess& process : processes_) {
    if (process.inputs() != x_.size()) fail("a process has {} inputs, the scaling {}", process.inputs(), x_.size());
  }
  if (y_.size() != static_cast<Index>(processes_.size()))
    fail("there are {} processes and {} scalings of outputs", processes_.size(), y_.size());
}

MatrixXd GpMap::point(const double* x) const {
  MatrixXd z(1, x_.size());
  for (Index i = 0; i < x_.size(); ++i) z(0, i) = (x[i] - x_.offset[i]) / x_.scale[i];
  return z;
}

void GpMap::evaluate(const double* x, double* y, double*) const {
  const MatrixXd z = point(x);
  for (Index o = 0; o < y_.size(); ++o) {
    const GaussianProcess& process = processes_[static_cast<std::size_t>(o)];
    y[o] = y_.offset[o] + y_.scale[o] * process.predict_mean(z)[0];
  }
}

void GpMap::derivative(const double* x, double* jacobian, double*) const {
  const MatrixXd z = point(x);
  const Index d = x_.size();
  for (Index o = 0; o < y_.size(); ++o) {
    const VectorXd slope = processes_[static_cast<std::size_t>(o)].mean_gradient(z.row(0).transpose());
    for (Index i = 0; i < d; ++i) jacobian[o * d + i] = slope[i] * y_.scale[o] / x_.scale[i];
  }
}

void GpMap::variance(const double* x, double* result, double*) const {
  const MatrixXd z = point(x);
  for (Index o = 0; o < y_.size(); ++o)
    result[o] = y_.scale[o] * y_.scale[o] * processes_[static_cast<std::size_t>(o)].predict(z).variance[0];
}

void GpMap::variance_derivative(const double* x, double* jacobian, double*) const {
  const MatrixXd z = point(x);
  const Index d = x_.size();
  for (Index o = 0; o < y_.size(); ++o) {
    const VectorXd slope = processes_[static_cast<std::size_t>(o)].variance_gradient(z.row(0).transpose());
    for (Index i = 0; i < d; ++i) jacobian[o * d + i] = slope[i] * y_.scale[o] * y_.scale[o] / x_.scale[i];
  }
}

double GpMap::noise_variance(int output) const {
  return y_.scale[output] * y_.scale[output] * processes_[static_cast<std::size_t>(output)].hyperparameters().v0;
}

void GpMap::write(Item& item) const {
  write_scaling(item, "x_scaling", x_);
  write_scaling(item, "y_scaling", y_);
  Item list = Item::list();
  for (const GaussianProcess& process : processes_) {
    const std::vector<std::string> names = process.covariance().names(process.inputs());
    Item hyperparameters;
    for (std::size_t i = 0; i < names.size(); ++i)
      hyperparameters.set(names[i], process.hyperparameters().theta[static_cast<Index>(i)]);
    hyperparameters.set("v0", process.hyperparameters().v0);
    Item entry;
    entry.set("covariance", process.covariance().name())
        .set("mean", name_of(process.mean_function()))
        .set("hyperparameters", std::move(hyperparameters));
    const Index d = process.inputs();
    if (process.x().cols() > d)
      entry.set("slope_of", VectorXd(process.x().col(d))).set("noise", VectorXd(process.x().col(d + 1)));
    list.add(entry.set("targets", process.y()).set("points", MatrixXd(process.x().leftCols(d))));
  }
  item.set("processes", std::move(list));
}

namespace {

constexpr const char* slopes_need_zero_mean =
    "observations of slopes need the mean zero; '+ linear' in the covariance stands for a linear one";

// What `make` gives; its complaint gets the place of the item.
template <typename Make>
auto placed(const Item& item, const Make& make) {
  try {
    return make();
  } catch (const IdentifyError& error) {
    item.wrong(error.what());
  }
}

// The two columns of observations of slopes, and the covariance that reads them.
void add_slopes(const Item& entry, std::shared_ptr<const Covariance>& covariance, MeanFunction mean, MatrixXd& x) {
  const Index d = x.cols();
  const VectorXd what = entry.vector("slope_of", x.rows()), noise = entry.vector("noise", x.rows());
  for (Index i = 0; i < x.rows(); ++i) {
    if (!(what[i] >= 0 && what[i] <= static_cast<double>(d)) || what[i] != std::floor(what[i]))
      entry.at("slope_of").wrong(fmt::format("each is the number of an input, 1 to {}, or 0 for a value", d));
    if (!(noise[i] == -1 || noise[i] >= 0) || !std::isfinite(noise[i]))
      entry.at("noise").wrong("each is a variance of 0 or more, or -1 where it is v0");
  }
  if (mean != MeanFunction::zero) entry.at("mean").wrong(slopes_need_zero_mean);
  covariance = placed(entry.at("covariance"), [&] { return with_slopes(covariance, static_cast<int>(d)); });
  x.conservativeResize(Eigen::NoChange, d + 2);
  x.col(d) = what;
  x.col(d + 1) = noise;
}

}  // namespace

std::shared_ptr<const Approximator> read_gaussian_process(const Item& item) {
  std::vector<GaussianProcess> processes;
  for (const Item& entry : item.items("processes")) {
    entry.only({"covariance", "mean", "hyperparameters", "slope_of", "noise", "targets", "points"});
    auto covariance = placed(entry.at("covariance"), [&] { return find_covariance(entry.text("covariance")); });
    const MeanFunction mean = placed(entry.at("mean"), [&] { return find_mean_function(entry.text("mean")); });
    const VectorXd y = entry.vector("targets");
    MatrixXd x = entry.matrix("points", y.size());
    if (x.cols() == 0) entry.at("points").wrong("a point needs at least one input");
    if (!processes.empty() && x.cols() != processes[0].inputs())
      entry.at("points").wrong(fmt::format("all processes need {} inputs, as the first one", processes[0].inputs()));
    if (entry.has("slope_of")) add_slopes(entry, covariance, mean, x);
    std::vector<std::string> names = covariance->names(covariance->inputs_of(x.cols()));
    Hyperparameters at{VectorXd(static_cast<Index>(names.size())), 0};
    const Item& values = entry.at("hyperparameters");
    for (std::size_t i = 0; i < names.size(); ++i) at.theta[static_cast<Index>(i)] = values.number(names[i]);
    at.v0 = values.number("v0");
    names.emplace_back("v0");
    values.only(names);
    placed(entry, [&] { return &processes.emplace_back(covariance, mean, std::move(at), x, y); });
  }
  if (processes.empty()) item.at("processes").wrong("a model needs at least one process");
  Scaling x = read_scaling(item, "x_scaling", processes[0].inputs());
  Scaling y = read_scaling(item, "y_scaling", static_cast<Index>(processes.size()));
  return std::make_shared<GpMap>(std::move(processes), std::move(x), std::move(y));
}

std::shared_ptr<const GpMap> with_measurements(const GpMap& map, const MatrixXd& X, const MatrixXd& Y) {
  if (X.rows() != Y.rows() || X.cols() != map.inputs() || Y.cols() != map.outputs())
    fail("the measurements are {} x {} and {} x {}; the model has {} inputs and {} outputs", X.rows(), X.cols(),
         Y.rows(), Y.cols(), map.inputs(), map.outputs());
  const MatrixXd x = map.x_scaling().normalised(X), y = map.y_scaling().normalised(Y);
  std::vector<GaussianProcess> processes;
  for (std::size_t o = 0; o < map.processes().size(); ++o) {
    const GaussianProcess& old = map.processes()[o];
    MatrixXd all_x(old.size() + x.rows(), old.x().cols());
    VectorXd all_y(all_x.rows());
    all_x.topRows(old.size()) = old.x();
    all_x.bottomRows(x.rows()).leftCols(x.cols()) = x;
    if (all_x.cols() > x.cols()) {  // values with the noise v0
      all_x.col(x.cols()).tail(x.rows()).setZero();
      all_x.col(x.cols() + 1).tail(x.rows()).setConstant(-1);
    }
    all_y << old.y(), y.col(static_cast<Index>(o));
    // From all of them at once, as the model file will be read: the same bits.
    processes.emplace_back(old.shared_covariance(), old.mean_function(), old.hyperparameters(), all_x, all_y);
  }
  return std::make_shared<const GpMap>(std::move(processes), map.x_scaling(), map.y_scaling());
}

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

GpMapFit fit_gp_map(const MatrixXd& X, const MatrixXd& Y, const GpOptions& options, int most, const FitControl& control,
                    const std::vector<std::vector<Observation>>& observations) {
  if (Y.cols() == 0) fail("there is no target");
  if (!observations.empty() && static_cast<Index>(observations.size()) != Y.cols())
    fail("there are observations of {} outputs, the data have {}", observations.size(), Y.cols());
  check_data(X, Y.col(0));
  const Scaling xs = standard_scaling(X), ys = standard_scaling(Y);
  MatrixXd x = xs.normalised(X), y = ys.normalised(Y);
  GpMapFit fit;
  std::vector<std::string> warnings;
  if (x.rows() > most) {
    const std::vector<Index> rows = spread_subset(x, most, options.seed);
    warnings.push_back(fmt::format("Of {} rows the {} most spread ones were taken.", x.rows(), most));
    x = x(rows, Eigen::all).eval();
    y = y(rows, Eigen::all).eval();
  }
  std::vector<GaussianProcess> processes;
  for (Index o = 0; o < y.cols(); ++o) {
    const auto known = observations.empty() ? std::vector<Observation>{}
                                            : normalised(observations[static_cast<std::size_t>(o)], xs, ys, o);
    GpFit found =
        known.empty() ? fit_gp(x, y.col(o), options, control) : fit_with_slopes(x, y.col(o), known, options, control);
    processes.push_back(std::move(found.model));
    if (o == 0) {
      fit.report = std::move(found.report);
    } else {
      for (const std::string& line : found.report.tried)
        fit.report.tried.push_back(fmt::format("output {}, {}", o + 1, line));
      fit.report.parameters += found.report.parameters;
      fit.report.warnings.insert(fit.report.warnings.end(), found.report.warnings.begin(), found.report.warnings.end());
    }
  }
  fit.report.warnings.insert(fit.report.warnings.end(), warnings.begin(), warnings.end());
  fit.model = std::make_shared<GpMap>(std::move(processes), xs, ys);
  return fit;
}

NarxModel fit_narx_gp(const DataSet& data, const RegressorSet& regressors, const GpOptions& options, int most,
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
  GpMapFit fit = fit_gp_map(rows.X, rows.Y, options, most, control, observations);
  if (!local_models.empty())
    fit.report.options.push_back(fmt::format("{} linear local models as values and slopes", local_models.size()));
  if (rows.left_out > 0)
    fit.report.warnings.push_back(fmt::format("{} rows with missing values were left out.", rows.left_out));
  return make_narx(fit.model, regressors, data, fit.report);
}

}  // namespace plantloop::identify
