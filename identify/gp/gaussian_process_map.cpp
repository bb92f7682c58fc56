// Gaussian processes as a model between the user's numbers: scaling, derivatives, what is known of the data.

#include <algorithm>
#include <cmath>
#include <memory>

#include "identify/error.h"
#include "identify/gp/gp_file.h"
#include "identify/gp/gp_map.h"
#include "identify/gp/sparse.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

GpMap::Processes shared(const std::vector<GaussianProcess>& processes) {
  GpMap::Processes list;
  for (const GaussianProcess& each : processes) list.push_back(std::make_shared<GaussianProcess>(each));
  return list;
}

}  // namespace

GpMap::GpMap(Processes processes, Scaling x, Scaling y)
    : processes_(std::move(processes)), x_(std::move(x)), y_(std::move(y)) {
  if (processes_.empty()) fail("a model needs at least one process");
  for (const auto& process : processes_) {
    if (process->inputs() != x_.size()) fail("a process has {} inputs, the scaling {}", process->inputs(), x_.size());
  }
  if (y_.size() != static_cast<Index>(processes_.size()))
    fail("there are {} processes and {} scalings of outputs", processes_.size(), y_.size());
}

GpMap::GpMap(const std::vector<GaussianProcess>& processes, Scaling x, Scaling y)
    : GpMap(shared(processes), std::move(x), std::move(y)) {}

MatrixXd GpMap::point(const double* x) const {
  MatrixXd z(1, x_.size());
  for (Index i = 0; i < x_.size(); ++i) z(0, i) = (x[i] - x_.offset[i]) / x_.scale[i];
  return z;
}

void GpMap::evaluate(const double* x, double* y, double*) const {
  const MatrixXd z = point(x);
  for (Index o = 0; o < y_.size(); ++o) y[o] = y_.offset[o] + y_.scale[o] * process(o).predict_mean(z)[0];
}

void GpMap::derivative(const double* x, double* jacobian, double*) const {
  const MatrixXd z = point(x);
  const Index d = x_.size();
  for (Index o = 0; o < y_.size(); ++o) {
    const VectorXd slope = process(o).mean_gradient(z.row(0).transpose());
    for (Index i = 0; i < d; ++i) jacobian[o * d + i] = slope[i] * y_.scale[o] / x_.scale[i];
  }
}

void GpMap::variance(const double* x, double* result, double*) const {
  const MatrixXd z = point(x);
  for (Index o = 0; o < y_.size(); ++o) result[o] = y_.scale[o] * y_.scale[o] * process(o).predict(z).variance[0];
}

void GpMap::variance_derivative(const double* x, double* jacobian, double*) const {
  const MatrixXd z = point(x);
  const Index d = x_.size();
  for (Index o = 0; o < y_.size(); ++o) {
    const VectorXd slope = process(o).variance_gradient(z.row(0).transpose());
    for (Index i = 0; i < d; ++i) jacobian[o * d + i] = slope[i] * y_.scale[o] * y_.scale[o] / x_.scale[i];
  }
}

double GpMap::noise_variance(Index output) const {
  return y_.scale[output] * y_.scale[output] * process(output).hyperparameters().v0;
}

VectorXd GpMap::target_scales(Index output) const {
  const GpPosterior& of = process(output);
  VectorXd scales = VectorXd::Constant(static_cast<Index>(of.samples()), y_.scale[output]);
  if (of.x().cols() == x_.size()) return scales;
  for (Index i = 0; i < scales.size(); ++i) {
    const auto slope_of = static_cast<Index>(of.x()(i, x_.size()));
    if (slope_of > 0) scales[i] /= x_.scale[slope_of - 1];
  }
  return scales;
}

double GpMap::log_likelihood(Index output) const {
  return process(output).log_likelihood() - target_scales(output).array().log().sum();
}

Likelihood GpMap::likelihood(Index output) const {
  Likelihood found = process(output).likelihood();
  found.value -= target_scales(output).array().log().sum();
  if (found.by_inducing.size() > 0) found.by_inducing = found.by_inducing * x_.scale.cwiseInverse().asDiagonal();
  return found;
}

LeaveOneOut GpMap::leave_one_out(Index output) const {
  LeaveOneOut found = process(output).leave_one_out();
  const VectorXd scales = target_scales(output);
  const GpPosterior& of = process(output);
  for (Index i = 0; i < scales.size(); ++i) {
    const bool is_value = of.x().cols() == x_.size() || of.x()(i, x_.size()) == 0;
    found.mean[i] = (is_value ? y_.offset[output] : 0) + scales[i] * found.mean[i];
  }
  found.variance = found.variance.cwiseProduct(scales.cwiseAbs2());
  found.log_density.array() -= scales.array().log();
  found.log_probability = found.log_density.sum();
  return found;
}

void GpMap::write(Item& item) const {
  write_scaling(item, "x_scaling", x_);
  write_scaling(item, "y_scaling", y_);
  Item list = Item::list();
  for (const auto& process : processes_) {
    Item entry;
    process->write(entry);
    list.add(std::move(entry));
  }
  item.set("processes", std::move(list));
}

std::shared_ptr<const Approximator> read_gaussian_process(const Item& item) {
  GpMap::Processes processes;
  for (const Item& entry : item.items("processes")) {
    processes.push_back(read_process(entry));
    if (processes.back()->inputs() != processes.front()->inputs())
      entry.at(entry.has("points") ? "points" : "inducing")
          .wrong(fmt::format("all processes need {} inputs, as the first one", processes.front()->inputs()));
  }
  if (processes.empty()) item.at("processes").wrong("a model needs at least one process");
  Scaling x = read_scaling(item, "x_scaling", processes.front()->inputs());
  Scaling y = read_scaling(item, "y_scaling", static_cast<Index>(processes.size()));
  return std::make_shared<GpMap>(std::move(processes), std::move(x), std::move(y));
}

std::shared_ptr<const GpMap> with_measurements(const GpMap& map, const MatrixXd& X, const MatrixXd& Y) {
  if (X.rows() != Y.rows() || X.cols() != map.inputs() || Y.cols() != map.outputs())
    fail("the measurements are {} x {} and {} x {}; the model has {} inputs and {} outputs", X.rows(), X.cols(),
         Y.rows(), Y.cols(), map.inputs(), map.outputs());
  const MatrixXd x = map.x_scaling().normalised(X), y = map.y_scaling().normalised(Y);
  GpMap::Processes processes;
  for (std::size_t o = 0; o < map.processes().size(); ++o) {
    if (const auto* sparse = dynamic_cast<const SparseGaussianProcess*>(map.processes()[o].get())) {
      processes.push_back(std::make_shared<SparseGaussianProcess>(sparse->with(x, y.col(static_cast<Index>(o)))));
      continue;
    }
    const auto& old = dynamic_cast<const GaussianProcess&>(*map.processes()[o]);
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
    processes.push_back(std::make_shared<GaussianProcess>(old.shared_covariance(), old.mean_function(),
                                                          old.hyperparameters(), all_x, all_y));
  }
  return std::make_shared<const GpMap>(std::move(processes), map.x_scaling(), map.y_scaling());
}

}  // namespace plantloop::identify
