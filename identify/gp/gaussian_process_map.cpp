// Gaussian processes as a model: scaling, derivatives, model file, fits.

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
    list.add(Item()
                 .set("covariance", process.covariance().name())
                 .set("mean", name_of(process.mean_function()))
                 .set("hyperparameters", std::move(hyperparameters))
                 .set("targets", process.y())
                 .set("points", process.x()));
  }
  item.set("processes", std::move(list));
}

namespace {

// What `make` gives; its complaint gets the place of the item.
template <typename Make>
auto placed(const Item& item, const Make& make) {
  try {
    return make();
  } catch (const IdentifyError& error) {
    item.wrong(error.what());
  }
}

}  // namespace

std::shared_ptr<const Approximator> read_gaussian_process(const Item& item) {
  std::vector<GaussianProcess> processes;
  for (const Item& entry : item.items("processes")) {
    entry.only({"covariance", "mean", "hyperparameters", "targets", "points"});
    const auto covariance = placed(entry.at("covariance"), [&] { return find_covariance(entry.text("covariance")); });
    const MeanFunction mean = placed(entry.at("mean"), [&] { return find_mean_function(entry.text("mean")); });
    const VectorXd y = entry.vector("targets");
    const MatrixXd x = entry.matrix("points", y.size());
    if (x.cols() == 0) entry.at("points").wrong("a point needs at least one input");
    if (!processes.empty() && x.cols() != processes[0].inputs())
      entry.at("points").wrong(fmt::format("all processes need {} inputs, as the first one", processes[0].inputs()));
    std::vector<std::string> names = covariance->names(static_cast<int>(x.cols()));
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
    MatrixXd all_x(old.size() + x.rows(), x.cols());
    VectorXd all_y(all_x.rows());
    all_x << old.x(), x;
    all_y << old.y(), y.col(static_cast<Index>(o));
    // From all of them at once, as the model file will be read: the same bits.
    processes.emplace_back(old.shared_covariance(), old.mean_function(), old.hyperparameters(), all_x, all_y);
  }
  return std::make_shared<const GpMap>(std::move(processes), map.x_scaling(), map.y_scaling());
}

GpMapFit fit_gp_map(const MatrixXd& X, const MatrixXd& Y, const GpOptions& options, int most,
                    const FitControl& control) {
  if (Y.cols() == 0) fail("there is no target");
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
    GpFit found = fit_gp(x, y.col(o), options, control);
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
                      const FitControl& control) {
  const Regression rows = make_regression(data, regressors);
  GpMapFit fit = fit_gp_map(rows.X, rows.Y, options, most, control);
  if (rows.left_out > 0)
    fit.report.warnings.push_back(fmt::format("{} rows with missing values were left out.", rows.left_out));
  return make_narx(fit.model, regressors, data, fit.report);
}

}  // namespace plantloop::identify
