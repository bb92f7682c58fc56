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

// What a fit is about, and its report on the way.
class SparseTraining {
 public:
  SparseTraining(const MatrixXd& x, const VectorXd& y, const GpOptions& options, const SparseOptions& sparse,
                 const FitControl& control)
      : x_(x),
        y_(y),
        options_(options),
        sparse_(sparse),
        control_(control),
        covariance_(find_covariance(options.covariance)),
        mean_(find_mean_function(options.mean)),
        criterion_(sparse.method == SparseMethod::fitc ? "FITC likelihood" : "variational bound"),
        cells_(size_of(x, sparse)) {
    if (options.start) check_hyperparameters(*covariance_, static_cast<int>(x.cols()), *options.start);
    report_.samples = y.size();
    report_.measure = criterion_;
    report_.seed = options.seed;
    warn_of_data(x, x.cols(), y, report_.warnings);
    u_ = first_inducing(x, options, sparse, report_.warnings);
    report_.options = {fmt::format("covariance {}", covariance_->name()), fmt::format("mean {}", options.mean),
                       fmt::format("approximation {}", name_of(sparse.method)),
                       fmt::format("inducing inputs {}{}", u_.rows(), sparse.hold ? ", held" : "")};
  }

  SparseFit evaluated() {
    SparseGaussianProcess model = process(*options_.start, u_);
    report_.method = fmt::format("{}, hyperparameters as given", criterion_);
    report_.parameters = options_.start->theta.size() + 1;
    report_.seed = 0;
    report_.reached = model.log_likelihood();
    report_.tried = {fmt::format("{} at the given hyperparameters: {:.6g}", criterion_, report_.reached)};
    report_.stopped = "nothing was trained";
    warn_of_inducing(u_, report_.warnings);
    warn_of_numbers(model, report_.warnings);
    return {std::move(model), std::move(report_)};
  }

  SparseFit trained() {
    if (options_.start && !(options_.start->v0 > 0))
      throw IdentifyError("the noise variance v0 is 0; a fit that begins there needs one greater than 0");
    guess_ = options_.start ? logs_of(*options_.start) : first_guess(*covariance_, x_, y_);
    if (!guess_.allFinite()) fail("the numbers of the data are too large or too small; normalise them first");
    const Minimum end = best_of(descents(options_.start ? std::vector<VectorXd>{guess_} : first_stage()));
    const bool conjugate = end.x.size() > most_of_quasi_newton || options_.method == Descent::conjugate_gradient;
    report_.method = fmt::format("{}, {}", criterion_, conjugate ? "conjugate gradients" : "quasi-Newton");
    report_.parameters = end.x.size();
    report_.reached = -end.value;
    report_.iterations = end.iterations;
    report_.stopped = end.stop;
    SparseGaussianProcess model = process(from_logs(end.x.head(guess_.size())), inducing_of(end.x, guess_.size(), u_));
    warn_of_result(model, y_, guess_, options_.bound, report_.warnings);
    warn_of_inducing(model.inducing(), report_.warnings);
    return {std::move(model), std::move(report_)};
  }

 private:
  SparseGaussianProcess process(Hyperparameters at, MatrixXd u) const {
    return {sparse_.method, covariance_, mean_, std::move(at), x_, y_, std::move(u)};
  }

  // The best optima of an exact process of some rows.
  std::vector<VectorXd> first_stage() {
    const std::vector<Index> rows = drawn_rows(x_.rows(), std::min(x_.rows(), most_rows_of_first_stage), options_.seed);
    const GpFit first =
        fit_gp(covariance_, x_(rows, Eigen::all), y_(rows), options_,
               {[&](double fraction) { control_.step(0.2 * fraction); }, control_.cancel, control_.deadline});
    for (const std::string& line : first.report.tried)
      report_.tried.push_back(fmt::format("exact process of {} rows, {}", rows.size(), line));
    std::vector<VectorXd> starts;
    for (const GpOptimum& optimum : first.optima) {
      if (static_cast<int>(starts.size()) < sparse_.refined) starts.push_back(logs_of(optimum.hyperparameters));
    }
    return starts;
  }

  std::vector<Minimum> descents(const std::vector<VectorXd>& starts) const {
    const auto count = static_cast<int>(starts.size());
    std::vector<Minimum> ends(starts.size());
    Watch watch({[&](double fraction) { control_.step(0.2 + 0.8 * fraction); }, control_.cancel, control_.deadline},
                static_cast<double>(count) * options_.max_iterations);
    // Two of them at a time need the memory twice.
    parallel_for(count, cells_ > 1e7 ? 1 : options_.threads, [&](int i) {
      const VectorXd start = packed(starts[static_cast<std::size_t>(i)], u_, sparse_.hold);
      const Objective objective = [&](const VectorXd& at, VectorXd* gradient) {
        watch.step();
        const Watched watched(watch);
        return value(at, gradient);
      };
      Minimum& end = ends[static_cast<std::size_t>(i)];
      end = minimise(objective, start, search_of(guess_, start, x_, u_, options_));
      watch.skip(options_.max_iterations - end.evaluations);
    });
    return ends;
  }
  double value(const VectorXd& at, VectorXd* gradient) const {
    const Index logs = guess_.size();
    const Likelihood found = sparse_likelihood(sparse_.method, *covariance_, mean_, from_logs(at.head(logs)), x_, y_,
                                               inducing_of(at, logs, u_), gradient != nullptr);
    if (gradient != nullptr) *gradient = packed(-found.gradient, -found.by_inducing, sparse_.hold);
    return -found.value;
  }

  Minimum best_of(const std::vector<Minimum>& ends) {
    const Minimum* best = nullptr;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      report_.tried.push_back(fmt::format("{} from {} {}: {:.6g} after {} iterations; {}", criterion_,
                                          options_.start ? "given hyperparameters" : "optimum", i + 1, -ends[i].value,
                                          ends[i].iterations, ends[i].stop));
      if (std::isfinite(ends[i].value) && (best == nullptr || ends[i].value < best->value)) best = &ends[i];
    }
    if (best == nullptr)
      fail(
          "the likelihood is not defined at any of the starts: the covariances of the inducing inputs are not positive "
          "definite");
    return *best;
  }

  const MatrixXd& x_;
  const VectorXd& y_;
  const GpOptions& options_;
  const SparseOptions& sparse_;
  const FitControl& control_;
  std::shared_ptr<const Covariance> covariance_;
  MeanFunction mean_;
  std::string criterion_;
  double cells_;
  MatrixXd u_;      // where the inducing inputs begin
  VectorXd guess_;  // the middle of the bounds
  FitReport report_;
};

}  // namespace

SparseFit fit_sparse(const MatrixXd& x, const VectorXd& y, const GpOptions& options, const SparseOptions& sparse,
                     const FitControl& control) {
  check_data(x, y);
  if (options.starts < 1) fail("the number of starts is {}; it must be 1 or more", options.starts);
  if (sparse.refined < 1) fail("the number of refined optima is {}; it must be 1 or more", sparse.refined);
  SparseTraining training(x, y, options, sparse, control);
  return options.start && options.max_iterations == 0 ? training.evaluated() : training.trained();
}

}  // namespace plantloop::identify
