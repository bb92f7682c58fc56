// Entries `processes` of model files, and back.

#include "identify/gp/gp_file.h"

#include <fmt/format.h>

#include <cmath>

#include "identify/error.h"
#include "identify/gp/gaussian_process.h"
#include "identify/gp/slopes.h"
#include "identify/gp/sparse.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void write_process(const GpPosterior& process, Item& entry) {
  const std::vector<std::string> names = process.covariance().names(process.inputs());
  Item hyperparameters;
  for (std::size_t i = 0; i < names.size(); ++i)
    hyperparameters.set(names[i], process.hyperparameters().theta[static_cast<Index>(i)]);
  hyperparameters.set("v0", process.hyperparameters().v0);
  entry.set("covariance", process.covariance().name())
      .set("mean", name_of(process.mean_function()))
      .set("hyperparameters", std::move(hyperparameters));
}

void GaussianProcess::write(Item& entry) const {
  write_process(*this, entry);
  const Index d = inputs();
  if (x_.cols() > d) entry.set("slope_of", VectorXd(x_.col(d))).set("noise", VectorXd(x_.col(d + 1)));
  entry.set("targets", y_).set("points", MatrixXd(x_.leftCols(d)));
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

Hyperparameters read_hyperparameters(const Item& entry, const Covariance& covariance, int inputs) {
  std::vector<std::string> names = covariance.names(inputs);
  Hyperparameters at{VectorXd(static_cast<Index>(names.size())), 0};
  const Item& values = entry.at("hyperparameters");
  for (std::size_t i = 0; i < names.size(); ++i) at.theta[static_cast<Index>(i)] = values.number(names[i]);
  at.v0 = values.number("v0");
  names.emplace_back("v0");
  values.only(names);
  return at;
}

void check_finite(const Item& entry, const char* key, bool is_finite) {
  if (!is_finite) entry.at(key).wrong("each must be a finite number");
}

std::shared_ptr<const GpPosterior> read_sparse(const Item& entry, std::shared_ptr<const Covariance> covariance,
                                               MeanFunction mean) {
  entry.only({"covariance", "mean", "hyperparameters", "approximation", "samples", "log_likelihood", "jitter",
              "mean_coefficients", "weights", "inducing", "precision"});
  SparseGaussianProcess::Content c;
  c.method = placed(entry.at("approximation"), [&] { return find_sparse_method(entry.text("approximation")); });
  c.weights = entry.vector("weights");
  const Index m = c.weights.size();
  if (m == 0) entry.at("weights").wrong("there must be one for each inducing input, at least one");
  c.inducing = entry.matrix("inducing", m);
  if (c.inducing.cols() == 0) entry.at("inducing").wrong("a point needs at least one input");
  c.precision = entry.matrix("precision", m, m);
  check_finite(entry, "weights", c.weights.allFinite());
  check_finite(entry, "inducing", c.inducing.allFinite());
  check_finite(entry, "precision", c.precision.allFinite());
  if (c.precision != c.precision.transpose()) entry.at("precision").wrong("the matrix must be symmetric");
  c.jitter = entry.number("jitter");
  if (!(c.jitter >= 0 && c.jitter < 1)) entry.at("jitter").wrong("it is a part of the covariances, from 0 to 1");
  const Index coefficients = mean_basis(mean, c.inducing.topRows(1)).cols();
  if (coefficients > 0) c.mean_coefficients = entry.vector("mean_coefficients", coefficients);
  c.hyperparameters = read_hyperparameters(entry, *covariance, static_cast<int>(c.inducing.cols()));
  c.samples = entry.integer("samples");
  if (c.samples < 0) entry.at("samples").wrong("it must be 0 or more");
  c.log_likelihood = entry.number("log_likelihood");
  c.covariance = std::move(covariance);
  c.mean = mean;
  return placed(entry, [&] { return std::make_shared<SparseGaussianProcess>(std::move(c)); });
}

}  // namespace

std::shared_ptr<const GpPosterior> read_process(const Item& entry) {
  auto covariance = placed(entry.at("covariance"), [&] { return find_covariance(entry.text("covariance")); });
  const MeanFunction mean = placed(entry.at("mean"), [&] { return find_mean_function(entry.text("mean")); });
  if (entry.has("approximation")) return read_sparse(entry, covariance, mean);
  entry.only({"covariance", "mean", "hyperparameters", "slope_of", "noise", "targets", "points"});
  const VectorXd y = entry.vector("targets");
  MatrixXd x = entry.matrix("points", y.size());
  if (x.cols() == 0) entry.at("points").wrong("a point needs at least one input");
  if (entry.has("slope_of")) add_slopes(entry, covariance, mean, x);
  Hyperparameters at = read_hyperparameters(entry, *covariance, covariance->inputs_of(x.cols()));
  return placed(entry, [&] { return std::make_shared<GaussianProcess>(covariance, mean, std::move(at), x, y); });
}

}  // namespace plantloop::identify
