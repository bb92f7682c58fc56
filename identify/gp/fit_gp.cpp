// Maximum likelihood from several starts.

#include "identify/gp/fit_gp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/error.h"
#include "identify/fit/parallel.h"
#include "identify/gp/fit_gp_parts.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd random_start(const VectorXd& guess, std::uint64_t seed, int number) {
  VectorXd logs = guess;
  if (number == 0) return logs;
  Random random = random_of_start(seed, number);
  const Index p = logs.size() - 1;
  for (Index i = 0; i < p; ++i) logs[i] += random.uniform(-3, 2);
  logs[p] += random.uniform(-5, 3);
  return logs;
}

Minimum maximise(const Covariance& covariance, MeanFunction mean, const MatrixXd& x, const VectorXd& y,
                 const VectorXd& guess, const VectorXd& start, const GpOptions& options, Watch& watch) {
  const Watched watched(watch);
  const Objective objective = [&](const VectorXd& logs, VectorXd* gradient) {
    watch.step();
    const Likelihood found = log_likelihood(covariance, mean, from_logs(logs), x, y, gradient != nullptr);
    if (gradient != nullptr) *gradient = -found.gradient;
    return -found.value;
  };
  MinimiseOptions how;
  how.method = options.method;
  how.max_iterations = options.max_iterations;
  how.lower = guess.array() - options.bound;
  how.upper = guess.array() + options.bound;
  return minimise(objective, start, how);
}

// The different optima, best first.
std::vector<GpOptimum> distinct(const std::vector<Minimum>& ends) {
  std::vector<GpOptimum> optima;
  std::vector<const Minimum*> order;
  for (const Minimum& end : ends) {
    if (std::isfinite(end.value)) order.push_back(&end);
  }
  std::stable_sort(order.begin(), order.end(), [](auto* a, auto* b) { return a->value < b->value; });
  std::vector<VectorXd> kept;
  for (const Minimum* end : order) {
    const bool known = std::any_of(kept.begin(), kept.end(),
                                   [&](const VectorXd& x) { return (x - end->x).cwiseAbs().maxCoeff() < 0.05; });
    if (known) continue;
    kept.push_back(end->x);
    optima.push_back({from_logs(end->x), -end->value});
  }
  return optima;
}

}  // namespace

GpFit fit_gp(const MatrixXd& x, const VectorXd& y, const GpOptions& options, const FitControl& control) {
  return fit_gp(find_covariance(options.covariance), x, y, options, control);
}

GpFit fit_gp(std::shared_ptr<const Covariance> covariance, const MatrixXd& x, const VectorXd& y,
             const GpOptions& options, const FitControl& control) {
  check_data(x, y);
  if (options.starts < 1) fail("the number of starts is {}; it must be 1 or more", options.starts);
  const double rows = static_cast<double>(x.rows());
  if (rows > 12000)  // three matrices of covariances in 4 GB
    fail(
        "an exact process of {} points needs about {:.0f} GB; take fewer points, or see all of them through inducing "
        "inputs, as the approximations fitc and vfe do",
        x.rows(), std::ceil(rows * rows * 8 * 3 / 1e9));
  const MeanFunction mean = find_mean_function(options.mean);
  FitReport report;
  report.measure = "log likelihood";
  report.method = fmt::format("maximum likelihood, {}",
                              options.method == Descent::quasi_newton ? "quasi-Newton" : "conjugate gradients");
  report.samples = y.size();
  report.parameters = covariance->count(covariance->inputs_of(x.cols())) + 1;
  report.seed = options.seed;
  report.options = {fmt::format("covariance {}", covariance->name()), fmt::format("mean {}", options.mean)};
  warn_of_data(x, covariance->inputs_of(x.cols()), y, report.warnings);

  if (options.start) check_hyperparameters(*covariance, covariance->inputs_of(x.cols()), *options.start);
  if (options.start && options.max_iterations == 0) {
    GaussianProcess model(covariance, mean, *options.start, x, y);
    report.method = "hyperparameters as given";
    report.seed = 0;
    report.reached = model.log_likelihood();
    report.tried = {fmt::format("given hyperparameters: log likelihood {:.6g}", report.reached)};
    report.stopped = "nothing was trained";
    warn_of_numbers(model, report.warnings);
    return {std::move(model), std::move(report), {}};
  }
  if (options.start && !(options.start->v0 > 0))
    throw IdentifyError("the noise variance v0 is 0; a fit that begins there needs one greater than 0");
  const VectorXd guess = options.start ? logs_of(*options.start) : first_guess(*covariance, x, y);
  if (!guess.allFinite()) fail("the numbers of the data are too large or too small; normalise them first");
  std::vector<Minimum> ends(static_cast<std::size_t>(options.starts));
  Watch watch(control, static_cast<double>(options.starts) * options.max_iterations);
  parallel_for(options.starts, options.threads, [&](int i) {
    const VectorXd start = random_start(guess, options.seed, i);
    Minimum& end = ends[static_cast<std::size_t>(i)];
    end = maximise(*covariance, mean, x, y, guess, start, options, watch);
    watch.skip(options.max_iterations - end.evaluations);
  });

  int best = -1;
  for (int i = 0; i < options.starts; ++i) {
    const Minimum& end = ends[static_cast<std::size_t>(i)];
    report.tried.push_back(fmt::format("start {}: log likelihood {:.6g} after {} iterations; {}", i + 1, -end.value,
                                       end.iterations, end.stop));
    if (std::isfinite(end.value) && (best < 0 || end.value < ends[static_cast<std::size_t>(best)].value)) best = i;
  }
  if (best < 0)
    fail("the likelihood is not defined at any of the starts: the covariances of the points are not positive definite");
  const Minimum& end = ends[static_cast<std::size_t>(best)];
  report.reached = -end.value;
  report.iterations = end.iterations;
  report.stopped = end.stop;
  GaussianProcess model(covariance, mean, from_logs(end.x), x, y);
  warn_of_result(model, y, guess, options.bound, report.warnings);
  return {std::move(model), std::move(report), distinct(ends)};
}

LeaveOneOut cross_validate(const GaussianProcess& model, int folds, bool refit) {
  const Index n = model.size();
  if (folds < 2 || folds > n) fail("{} folds of {} rows; there must be from 2 to {} folds", folds, n, n);
  LeaveOneOut result{VectorXd(n), VectorXd(n), {}, 0};
  std::vector<std::vector<Index>> members(static_cast<std::size_t>(folds));
  for (Index i = 0; i < n; ++i) members[static_cast<std::size_t>(i * folds / n)].push_back(i);
  for (const std::vector<Index>& held : members) {
    std::vector<Index> rest;
    for (Index i = 0; i < n; ++i) {
      if (i < held.front() || i > held.back()) rest.push_back(i);
    }
    const MatrixXd x = model.x()(rest, Eigen::all);
    const VectorXd y = model.y()(rest);
    Hyperparameters at = model.hyperparameters();
    if (refit) {
      const VectorXd logs = logs_of(at);
      Watch watch({}, 1);
      const Minimum end = maximise(model.covariance(), model.mean_function(), x, y, logs, logs, {}, watch);
      if (std::isfinite(end.value)) at = from_logs(end.x);
    }
    const GaussianProcess part(model.shared_covariance(), model.mean_function(), at, x, y);
    const Prediction predicted = part.predict(model.x()(held, Eigen::all));
    result.mean(held) = predicted.mean;
    result.variance(held) = predicted.variance + model.covariance().noise_variances(model.x()(held, Eigen::all), at.v0);
  }
  result.log_density = log_densities(model.y(), result.mean, result.variance);
  result.log_probability = result.log_density.sum();
  return result;
}

}  // namespace plantloop::identify
