// Two stages: an exact process of a few rows, then all rows through the inducing inputs.

#include "identify/gp/fit_sparse.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/error.h"
#include "identify/fit/parallel.h"
#include "identify/gp/fit_gp_parts.h"
#include "identify/gp/inducing.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index most_rows_of_first_stage = 500;
// Above so many parameters the matrix of quasi-Newton costs more than it gains.
constexpr Index most_of_quasi_newton = 4000;

// Rows drawn without repetition, ascending.
std::vector<Index> drawn_rows(Index rows, Index count, std::uint64_t seed) {
  std::vector<Index> all(static_cast<std::size_t>(rows));
  std::iota(all.begin(), all.end(), Index{0});
  Random random(seed);
  for (Index i = 0; i < count; ++i) {
    const auto other = i + static_cast<Index>(random.index(static_cast<std::uint64_t>(rows - i)));
    std::swap(all[static_cast<std::size_t>(i)], all[static_cast<std::size_t>(other)]);
  }
  all.resize(static_cast<std::size_t>(count));
  std::sort(all.begin(), all.end());
  return all;
}

// N M, when it can be held.
double size_of(const MatrixXd& x, const SparseOptions& sparse) {
  const Index wanted = sparse.inputs.size() > 0 ? sparse.inputs.rows() : sparse.inducing;
  const Index count = std::min(wanted, std::max(x.rows(), sparse.inputs.rows()));
  const double cells = static_cast<double>(x.rows()) * static_cast<double>(count);
  // About seven matrices of that size.
  if (cells > 5e7)
    fail("{} rows through {} inducing inputs need about {:.0f} GB; choose fewer inducing inputs or rows", x.rows(),
         count, std::ceil(cells * 8 * 7 / 1e9));
  return cells;
}

MatrixXd first_inducing(const MatrixXd& x, const GpOptions& options, const SparseOptions& sparse,
                        std::vector<std::string>& warnings) {
  if (sparse.inputs.size() > 0) {
    if (sparse.inputs.cols() != x.cols())
      fail("the inducing inputs have {} columns, the data {} inputs", sparse.inputs.cols(), x.cols());
    if (!sparse.inputs.allFinite()) throw IdentifyError("an inducing input is not a finite number");
    return sparse.inputs;
  }
  if (sparse.inducing < 1) fail("the number of inducing inputs is {}; it must be 1 or more", sparse.inducing);
  MatrixXd u = clustered_inputs(x, sparse.inducing, options.seed);
  if (u.rows() < sparse.inducing)
    warnings.push_back(fmt::format("Only {} rows differ, so there are {} inducing inputs instead of {}.", u.rows(),
                                   u.rows(), sparse.inducing));
  return u;
}

// logs of theta and v0, then U column by column.
VectorXd packed(const VectorXd& logs, const MatrixXd& u, bool hold) {
  VectorXd all(logs.size() + (hold ? 0 : u.size()));
  all.head(logs.size()) = logs;
  if (!hold) all.tail(u.size()) = u.reshaped();
  return all;
}
MatrixXd inducing_of(const VectorXd& all, Index logs, const MatrixXd& begun) {
  if (all.size() == logs) return begun;
  return all.tail(begun.size()).reshaped(begun.rows(), begun.cols());
}

// Within the bounds of the guess, and U within the range of the data and once that range on each side.
MinimiseOptions search_of(const VectorXd& guess, const VectorXd& start, const MatrixXd& x, const MatrixXd& u,
                          const GpOptions& options) {
  MinimiseOptions how;
  how.method = start.size() > most_of_quasi_newton ? Descent::conjugate_gradient : options.method;
  how.max_iterations = options.max_iterations;
  how.lower = how.upper = start;
  how.lower.head(guess.size()) = guess.array() - options.bound;
  how.upper.head(guess.size()) = guess.array() + options.bound;
  for (Index d = 0; d < x.cols() && start.size() > guess.size(); ++d) {
    const double least = std::min(x.col(d).minCoeff(), u.col(d).minCoeff());
    const double most = std::max(x.col(d).maxCoeff(), u.col(d).maxCoeff());
    const double range = most - least;
    how.lower.segment(guess.size() + d * u.rows(), u.rows()).setConstant(least - range);
    how.upper.segment(guess.size() + d * u.rows(), u.rows()).setConstant(most + range);
  }
  return how;
}

void warn_of_inducing(const MatrixXd& u, std::vector<std::string>& warnings) {
  Index together = 0;
  for (Index i = 1; i < u.rows(); ++i) {
    const double nearest = (u.topRows(i).rowwise() - u.row(i)).rowwise().squaredNorm().minCoeff();
    if (nearest < 1e-12 * (1 + u.row(i).squaredNorm())) ++together;
  }
  if (together > 0)
    warnings.push_back(fmt::format("{} of {} inducing inputs lie on another one; fewer of them would do the same.",
                                   together, u.rows()));
}

}  // namespace

SparseFit fit_sparse(const MatrixXd& x, const VectorXd& y, const GpOptions& options, const SparseOptions& sparse,
                     const FitControl& control) {
  check_data(x, y);
  if (options.starts < 1) fail("the number of starts is {}; it must be 1 or more", options.starts);
  if (sparse.refined < 1) fail("the number of refined optima is {}; it must be 1 or more", sparse.refined);
  const std::shared_ptr<const Covariance> covariance = find_covariance(options.covariance);
  const MeanFunction mean = find_mean_function(options.mean);
  if (options.start) check_hyperparameters(*covariance, static_cast<int>(x.cols()), *options.start);
  FitReport report;
  report.samples = y.size();
  report.seed = options.seed;
  warn_of_data(x, x.cols(), y, report.warnings);
  const double cells = size_of(x, sparse);
  const MatrixXd u = first_inducing(x, options, sparse, report.warnings);
  report.options = {fmt::format("covariance {}", covariance->name()), fmt::format("mean {}", options.mean),
                    fmt::format("approximation {}", name_of(sparse.method)),
                    fmt::format("inducing inputs {}{}", u.rows(), sparse.hold ? ", held" : "")};
  const std::string criterion = sparse.method == SparseMethod::fitc ? "FITC likelihood" : "variational bound";
  if (options.start && options.max_iterations == 0) {
    SparseGaussianProcess model(sparse.method, covariance, mean, *options.start, x, y, u);
    report.method = fmt::format("{}, hyperparameters as given", criterion);
    report.parameters = options.start->theta.size() + 1;
    report.seed = 0;
    report.reached = model.log_likelihood();
    report.tried = {fmt::format("{} at the given hyperparameters: {:.6g}", criterion, report.reached)};
    report.stopped = "nothing was trained";
    warn_of_inducing(u, report.warnings);
    warn_of_numbers(model, report.warnings);
    return {std::move(model), std::move(report)};
  }
  if (options.start && !(options.start->v0 > 0))
    throw IdentifyError("the noise variance v0 is 0; a fit that begins there needs one greater than 0");

  const VectorXd guess = options.start ? logs_of(*options.start) : first_guess(*covariance, x, y);
  if (!guess.allFinite()) fail("the numbers of the data are too large or too small; normalise them first");
  std::vector<VectorXd> starts;
  if (options.start) {
    starts.push_back(guess);
  } else {
    const std::vector<Index> rows = drawn_rows(x.rows(), std::min(x.rows(), most_rows_of_first_stage), options.seed);
    const GpFit first = fit_gp(covariance, x(rows, Eigen::all), y(rows), options,
                               {[&](double fraction) { control.step(0.2 * fraction); }, control.cancel});
    for (const std::string& line : first.report.tried)
      report.tried.push_back(fmt::format("exact process of {} rows, {}", rows.size(), line));
    for (const GpOptimum& optimum : first.optima) {
      if (static_cast<int>(starts.size()) < sparse.refined) starts.push_back(logs_of(optimum.hyperparameters));
    }
  }

  const Index logs = guess.size();
  const auto count = static_cast<int>(starts.size());
  std::vector<Minimum> ends(starts.size());
  Watch watch({[&](double fraction) { control.step(0.2 + 0.8 * fraction); }, control.cancel},
              static_cast<double>(count) * options.max_iterations);
  // Two of them at a time need the memory twice.
  parallel_for(count, cells > 1e7 ? 1 : options.threads, [&](int i) {
    const VectorXd start = packed(starts[static_cast<std::size_t>(i)], u, sparse.hold);
    const Objective objective = [&](const VectorXd& at, VectorXd* gradient) {
      watch.step();
      const Likelihood found = sparse_likelihood(sparse.method, *covariance, mean, from_logs(at.head(logs)), x, y,
                                                 inducing_of(at, logs, u), gradient != nullptr);
      if (gradient != nullptr) *gradient = packed(-found.gradient, -found.by_inducing, sparse.hold);
      return -found.value;
    };
    Minimum& end = ends[static_cast<std::size_t>(i)];
    end = minimise(objective, start, search_of(guess, start, x, u, options));
    watch.skip(options.max_iterations - end.evaluations);
  });
  int best = -1;
  for (int i = 0; i < count; ++i) {
    const Minimum& end = ends[static_cast<std::size_t>(i)];
    report.tried.push_back(fmt::format("{} from {} {}: {:.6g} after {} iterations; {}", criterion,
                                       options.start ? "given hyperparameters" : "optimum", i + 1, -end.value,
                                       end.iterations, end.stop));
    if (std::isfinite(end.value) && (best < 0 || end.value < ends[static_cast<std::size_t>(best)].value)) best = i;
  }
  if (best < 0)
    fail(
        "the likelihood is not defined at any of the starts: the covariances of the inducing inputs are not positive "
        "definite");
  const Minimum& end = ends[static_cast<std::size_t>(best)];
  report.method = fmt::format("{}, {}", criterion,
                              end.x.size() > most_of_quasi_newton || options.method == Descent::conjugate_gradient
                                  ? "conjugate gradients"
                                  : "quasi-Newton");
  report.parameters = end.x.size();
  report.reached = -end.value;
  report.iterations = end.iterations;
  report.stopped = end.stop;
  SparseGaussianProcess model(sparse.method, covariance, mean, from_logs(end.x.head(logs)), x, y,
                              inducing_of(end.x, logs, u));
  warn_of_result(model, y, guess, options.bound, report.warnings);
  warn_of_inducing(model.inducing(), report.warnings);
  return {std::move(model), std::move(report)};
}

}  // namespace plantloop::identify
