// Networks from many starts.

#include "identify/mlp/fit_mlp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "identify/data/matching.h"
#include "identify/data/preprocess.h"
#include "identify/error.h"
#include "identify/fit/parallel.h"
#include "identify/linear/least_squares.h"
#include "identify/mlp/fit_parts.h"
#include "identify/mlp/problems.h"

namespace plantloop::identify {
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

}  // namespace

double score(const TrainingResult& result, bool validated) {
  const double value = validated ? result.validation_sse : result.criterion;
  return std::isfinite(value) ? value : infinite;
}

std::string line_of(const std::string& what, const TrainingResult& result, Index targets, const Training* validation) {
  std::string text =
      fmt::format("{}: error {:.6g} (root mean square)", what, std::sqrt(result.sse / static_cast<double>(targets)));
  if (validation != nullptr)
    text += fmt::format(", validation {:.6g}",
                        std::sqrt(result.validation_sse / static_cast<double>(validation->targets())));
  return text + fmt::format(" after {} iterations; {}", result.iterations, result.stopped);
}

std::string measure_of(const MlpOptions& options) {
  return fmt::format("mean square of the error{}{}", options.normalise ? " of the normalised outputs" : "",
                     options.training.decay > 0 ? ", without the weight decay that the criterion has beside it" : "");
}

namespace {

// Training solves equations of as many unknowns as there are weights, again at each iteration.
void check_size(Index inputs, Index rows, Index outputs, const MlpOptions& options) {
  if (std::any_of(options.hidden.begin(), options.hidden.end(), [](int neurons) { return neurons < 1; })) return;
  const auto count = [&](const std::vector<int>& hidden) {
    double weights = options.direct ? static_cast<double>(inputs * outputs) : 0, before = static_cast<double>(inputs);
    for (const int neurons : hidden) {
      weights += neurons * (before + 1);
      before = neurons;
    }
    return weights + static_cast<double>(outputs) * (before + 1);
  };
  constexpr double most = 3000;
  const double weights = count(options.hidden), targets = static_cast<double>(rows * outputs);
  if (weights <= std::min(most, std::max(200.0, 10 * targets))) return;
  int neurons = 1;
  while (count({neurons + 1}) <= std::min(most, targets)) ++neurons;
  fail(
      "the network would have {:.0f} weights and there are {:.0f} targets. Training takes at most {:.0f} weights, and "
      "data determine no more than there are targets: one layer of {} neurons has {:.0f}",
      weights, targets, most, neurons, count({neurons}));
}

void check_options(const MlpOptions& options) {
  if (options.starts < 1) fail("the number of starts is {}; it must be 1 or more", options.starts);
  if (!(options.spread > 0)) fail("the spread of first weights is {:g}; it must be greater than 0", options.spread);
  if (!(options.training.decay >= 0)) fail("the weight decay is {:g}; it must be 0 or greater", options.training.decay);
  if (options.training.iterations < 1)
    fail("the number of iterations is {}; it must be 1 or more", options.training.iterations);
  if (options.refined < 1) fail("the number of refined starts is {}; it must be 1 or more", options.refined);
  if (options.training.patience < 1)
    fail("the patience is a number of iterations, 1 or more; it is {}", options.training.patience);
  if (options.one_step_iterations < 0)
    fail("the number of one-step iterations is {}; it must be 0 or more", options.one_step_iterations);
  if (std::any_of(options.horizons.begin(), options.horizons.end(), [](int length) { return length < 0; }))
    fail("the horizons of the free run are numbers of samples; 0 stands for the whole record");
  if (!options.horizons.empty() && !options.simulation)
    fail("'horizons' are lengths of free runs to train on; they need simulation = true");
  if (options.nc < 0 || options.nd < 0) fail("the orders of a noise model, 'nc' and 'nd', must be 0 or more");
  if (options.nd > 0 && !options.simulation)
    fail("a filter D ('nd') stands beside a simulated map only: structure NBJ; of NARMAX there is C ('nc')");
  if (options.activation == Activation::signum || options.output_activation == Activation::signum)
    fail(
        "a network of signum neurons has no gradient to follow; train it by the perceptron rule, or choose sigmoid or "
        "tanh");
}

void check_rows(const MatrixXd& X, const MatrixXd& Y) {
  if (X.rows() == 0 || X.cols() == 0 || Y.cols() == 0) fail("the data has no rows or no columns");
  if (X.rows() != Y.rows()) fail("the inputs have {} rows and the targets {}; they must agree", X.rows(), Y.rows());
  if (!X.allFinite() || !Y.allFinite()) fail("the data has numbers that are not finite; leave such rows out");
}

void warn(const Network& network, const MatrixXd& x, const TrainingResult& result, Index targets,
          std::vector<std::string>& warnings) {
  if (network.parameters() > targets)
    warnings.push_back(fmt::format("There are {} weights for {} targets; weight decay or fewer neurons are needed.",
                                   network.parameters(), targets));
  if (result.at_limit)
    warnings.push_back(fmt::format("Training stopped at its limit of {} iterations; more may improve the network.",
                                   result.iterations));
  if (result.ill_conditioned)
    warnings.emplace_back(
        "The normal equations were singular; Gauss-Newton left directions out that the data do not "
        "determine.");
  // A hidden neuron whose slope is nowhere above 1 % of its greatest does no work.
  const Layer& first = network.layers.front();
  if (network.layers.size() < 2 || first.activation == Activation::linear) return;
  const MatrixXd sums =
      (x * first.w.leftCols(first.inputs()).transpose()).rowwise() + first.w.col(first.inputs()).transpose();
  int saturated = 0;
  for (Index i = 0; i < first.neurons(); ++i) {
    if (first.w.row(i).isZero(0)) continue;  // pruned
    double greatest = 0;
    for (Index k = 0; k < sums.rows(); ++k) {
      const double s = sums(k, i);
      greatest = std::max(greatest, std::fabs(slope(first.activation, s, activate(first.activation, s))));
    }
    const double full = first.activation == Activation::sigmoid ? 0.25 : 1;
    saturated += greatest < 0.01 * full ? 1 : 0;
  }
  if (saturated > 0)
    warnings.push_back(
        fmt::format("{} of {} neurons of the first layer are saturated for all data.", saturated, first.neurons()));
}

// What a fit works on: all numbers normalised.
struct Task {
  Scaling x, y;
  MatrixXd X, Y;  // normalised rows
  std::optional<MatrixXd> X_validation, Y_validation;
  std::vector<const Training*> simulations;  // one after the other
  const Training* simulation_validation = nullptr;
};

Task normalised(const MatrixXd& X, const MatrixXd& Y, bool normalise) {
  Task task;
  task.x = normalise ? standard_scaling(X) : no_scaling(X.cols());
  task.y = normalise ? standard_scaling(Y) : no_scaling(Y.cols());
  task.X = task.x.normalised(X);
  task.Y = task.y.normalised(Y);
  return task;
}

MlpFit fit_task(const Task& task, const Network& shape, const std::vector<VectorXd>& starts, const MlpOptions& options,
                const FitControl& control) {
  const StaticTraining training(shape, task.X, task.Y);
  std::optional<StaticTraining> validation;
  if (task.X_validation) validation.emplace(shape, *task.X_validation, *task.Y_validation);
  const Training* check = validation ? &*validation : nullptr;
  const int count = static_cast<int>(starts.size());
  const int stages = static_cast<int>(task.simulations.size());
  const int later = stages > 0 ? std::min(options.refined, count) : 0;
  TrainingOptions first = options.training;
  if (later > 0 && options.one_step_iterations > 0) first.iterations = options.one_step_iterations;
  Watch watch(control, static_cast<double>(count) * first.iterations +
                           static_cast<double>(later) * stages * options.training.iterations);

  std::vector<TrainingResult> results(starts.size());
  parallel_for(count, options.threads, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    results[at] = train(training, starts[at], first, watch, check);
    watch.skip(first.iterations - results[at].iterations);
  });

  MlpFit fit;
  FitReport& report = fit.report;
  report.method = fmt::format("{}{}", name_of(options.training.method), stages > 0 ? ", through time" : "");
  report.samples = task.X.rows();
  report.parameters = shape.parameters();
  report.seed = options.seed;
  report.options.push_back(fmt::format("hidden {}", fmt::join(options.hidden, " ")));
  if (options.activation != Activation::tanh) report.options.push_back("activation " + name_of(options.activation));
  const MlpOptions usual;
  if (options.output_activation != usual.output_activation)
    report.options.push_back("output_activation " + name_of(options.output_activation));
  if (options.starts != usual.starts) report.options.push_back(fmt::format("starts {}", options.starts));
  if (options.spread != usual.spread) report.options.push_back(fmt::format("spread {:g}", options.spread));
  if (options.training.iterations != usual.training.iterations)
    report.options.push_back(fmt::format("iterations {}", options.training.iterations));
  if (!options.normalise) report.options.emplace_back("not normalised");
  if (stages > 0 && options.refined != usual.refined)
    report.options.push_back(fmt::format("refined {}", options.refined));
  if (check != nullptr && options.training.patience != usual.training.patience)
    report.options.push_back(fmt::format("patience {}", options.training.patience));
  if (options.direct) report.options.emplace_back("direct");
  if (options.training.decay > 0) report.options.push_back(fmt::format("decay {:g}", options.training.decay));
  if (!options.horizons.empty()) report.options.push_back(fmt::format("horizons {}", fmt::join(options.horizons, " ")));
  if (check != nullptr) report.options.emplace_back("validation");
  for (std::size_t i = 0; i < results.size(); ++i) {
    report.tried.push_back(line_of(fmt::format("start {}", i + 1), results[i], training.targets(), check));
    fit.errors.push_back(
        std::isfinite(results[i].sse) ? std::sqrt(results[i].sse / static_cast<double>(training.targets())) : infinite);
  }

  Index targets = training.targets();
  if (later > 0) {
    std::vector<int> order(results.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return score(results[static_cast<std::size_t>(a)], check != nullptr) <
             score(results[static_cast<std::size_t>(b)], check != nullptr);
    });
    check = task.simulation_validation;
    std::vector<TrainingResult> refined(static_cast<std::size_t>(later));
    parallel_for(later, options.threads, [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      refined[at].theta = results[static_cast<std::size_t>(order[at])].theta;
      for (const Training* simulation : task.simulations)
        refined[at] = train(*simulation, refined[at].theta, options.training, watch, check);
    });
    targets = task.simulations.back()->targets();
    for (std::size_t i = 0; i < refined.size(); ++i)
      report.tried.push_back(line_of(fmt::format("start {}, simulated", order[i] + 1), refined[i], targets, check));
    results = std::move(refined);
  }
  std::vector<int> by_score(results.size());
  std::iota(by_score.begin(), by_score.end(), 0);
  std::stable_sort(by_score.begin(), by_score.end(), [&](int a, int b) {
    return score(results[static_cast<std::size_t>(a)], check != nullptr) <
           score(results[static_cast<std::size_t>(b)], check != nullptr);
  });
  for (const int i : by_score) fit.ends.push_back(results[static_cast<std::size_t>(i)].theta);
  const int best = by_score.front();
  fit.training = results[static_cast<std::size_t>(best)];
  if (!std::isfinite(score(fit.training, check != nullptr)))
    fail("no start led to a finite error; the data may be too large, or the simulated model unstable from the start");
  Network network = shape;
  network.set_theta(fit.training.theta);
  report.reached = fit.training.sse / static_cast<double>(targets);
  report.measure = measure_of(options);
  report.iterations = fit.training.iterations;
  report.stopped = fit.training.stopped;
  warn(network, task.X, fit.training, targets, report.warnings);
  for (Index c = 0; c < task.X.cols(); ++c) {
    if ((task.X.col(c).array() == task.X(0, c)).all())
      report.warnings.push_back(fmt::format("Input {} is constant, so its weights are not determined.", c + 1));
  }
  fit.model = std::make_shared<Mlp>(std::move(network), task.x, task.y);
  return fit;
}

// X, Y: normalised rows.
std::vector<VectorXd> random_starts(Network shape, const MatrixXd& X, const MatrixXd& Y, const MlpOptions& options) {
  MatrixXd linear;  // of [x; 1], a column for each output
  if (options.direct) {
    MatrixXd rows(X.rows(), X.cols() + 1);
    rows << X, VectorXd::Ones(X.rows());
    linear.resize(rows.cols(), Y.cols());
    for (Index o = 0; o < Y.cols(); ++o) linear.col(o) = least_squares(rows, Y.col(o)).theta;
  }
  std::vector<VectorXd> starts;
  for (int i = 0; i < options.starts; ++i) {
    Random random = random_of_start(options.seed, i);
    randomise(shape, options.spread, random);
    if (options.direct) {
      Layer& last = shape.layers.back();
      last.w.setZero();
      last.w.rightCols(1) = linear.bottomRows(1).transpose();
      shape.direct = linear.topRows(X.cols()).transpose();
    }
    starts.push_back(shape.theta());
  }
  return starts;
}

Network shape_for(Index inputs, Index outputs, const MlpOptions& options) {
  return make_network(static_cast<int>(inputs), options.hidden, static_cast<int>(outputs), options.activation,
                      options.output_activation, options.direct);
}

}  // namespace

MlpFit fit_mlp(const MatrixXd& X, const MatrixXd& Y, const MlpOptions& options, const FitControl& control) {
  check_options(options);
  check_rows(X, Y);
  check_size(X.cols(), X.rows(), Y.cols(), options);
  const Network shape = shape_for(X.cols(), Y.cols(), options);
  const Task task = normalised(X, Y, options.normalise);
  return fit_task(task, shape, random_starts(shape, task.X, task.Y, options), options, control);
}

MlpFit fit_mlp(const MatrixXd& X, const MatrixXd& Y, const MatrixXd& X_validation, const MatrixXd& Y_validation,
               const MlpOptions& options, const FitControl& control) {
  check_options(options);
  check_rows(X, Y);
  check_rows(X_validation, Y_validation);
  if (X.cols() != X_validation.cols() || Y.cols() != Y_validation.cols())
    fail("the validation data has {} inputs and {} outputs, the data {} and {}", X_validation.cols(),
         Y_validation.cols(), X.cols(), Y.cols());
  check_size(X.cols(), X.rows(), Y.cols(), options);
  const Network shape = shape_for(X.cols(), Y.cols(), options);
  Task task = normalised(X, Y, options.normalise);
  task.X_validation = task.x.normalised(X_validation);
  task.Y_validation = task.y.normalised(Y_validation);
  return fit_task(task, shape, random_starts(shape, task.X, task.Y, options), options, control);
}

namespace {

std::vector<std::unique_ptr<SimulationTraining>> simulations_of(const Network& shape, const Task& task,
                                                                const RegressorSet& regressors, const DataSet& data,
                                                                std::vector<int> horizons) {
  if (horizons.empty()) horizons = {0};
  std::vector<std::unique_ptr<SimulationTraining>> simulations;
  for (const int length : horizons)
    simulations.push_back(std::make_unique<SimulationTraining>(
        shape, task.x, task.y, regressors, length > 0 ? in_pieces(data, length, regressors.longest_lag()) : data));
  return simulations;
}

}  // namespace

NarxMlpFit fit_narx_mlp(const DataSet& data, const RegressorSet& regressors, const DataSet& validation,
                        const MlpOptions& options, const FitControl& control) {
  check_options(options);
  if (!validation.experiments.empty()) check_signals(data.inputs, data.outputs, data.Ts, validation);
  if (regressors.errors > 0 || options.nc > 0 || options.nd > 0)
    return fit_with_noise(data, regressors, validation, options, control);
  const Regression rows = make_regression(data, regressors);
  check_rows(rows.X, rows.Y);
  check_size(rows.X.cols(), rows.X.rows(), rows.Y.cols(), options);
  const Network shape = shape_for(rows.X.cols(), rows.Y.cols(), options);
  Task task = normalised(rows.X, rows.Y, options.normalise);
  const bool validated = !validation.experiments.empty();
  if (validated) {
    const Regression held = make_regression(validation, regressors);
    task.X_validation = task.x.normalised(held.X);
    task.Y_validation = task.y.normalised(held.Y);
  }
  std::vector<std::unique_ptr<SimulationTraining>> simulations;
  std::optional<SimulationTraining> simulation_validation;
  if (options.simulation) {
    simulations = simulations_of(shape, task, regressors, data, options.horizons);
    for (const auto& each : simulations) task.simulations.push_back(each.get());
    if (validated)
      task.simulation_validation = &simulation_validation.emplace(shape, task.x, task.y, regressors, validation);
  }
  MlpFit fit = fit_task(task, shape, random_starts(shape, task.X, task.Y, options), options, control);
  if (rows.left_out > 0)
    fit.report.warnings.push_back(fmt::format("{} rows with missing values were left out.", rows.left_out));
  return {make_narx(fit.model, regressors, data, fit.report), fit};
}

NarxMlpFit refine_narx_mlp(const DataSet& data, const RegressorSet& regressors, const Mlp& map,
                           const MlpOptions& options, bool keep_zeros, const FitControl& control,
                           const DataSet& validation) {
  check_options(options);
  const Regression rows = make_regression(data, regressors);
  Task task;
  task.x = map.x_scaling();
  task.y = map.y_scaling();
  if (rows.X.cols() != task.x.size() || rows.Y.cols() != task.y.size())
    fail("the model has {} inputs and {} outputs, the regressors give {} and {}", task.x.size(), task.y.size(),
         rows.X.cols(), rows.Y.cols());
  task.X = task.x.normalised(rows.X);
  task.Y = task.y.normalised(rows.Y);
  const VectorXd start = map.network().theta();
  MlpOptions how = options;
  if (keep_zeros) {
    how.training.fixed.assign(static_cast<std::size_t>(start.size()), false);
    for (Index i = 0; i < start.size(); ++i) how.training.fixed[static_cast<std::size_t>(i)] = start[i] == 0;
  }
  if (options.simulation) {
    // The start is what shall be refined, not what one-step training makes of it.
    const auto simulations = simulations_of(map.network(), task, regressors, data, options.horizons);
    std::optional<SimulationTraining> held;
    if (!validation.experiments.empty()) held.emplace(map.network(), task.x, task.y, regressors, validation);
    const Training* check = held ? &*held : nullptr;
    Watch watch(control, static_cast<double>(simulations.size()) * how.training.iterations);
    MlpFit fit;
    fit.training.theta = start;
    for (const auto& simulation : simulations)
      fit.training = train(*simulation, fit.training.theta, how.training, watch, check);
    Network network = map.network();
    network.set_theta(fit.training.theta);
    const auto targets = simulations.back()->targets();
    fit.report.method = name_of(how.training.method) + ", through time";
    fit.report.samples = task.X.rows();
    fit.report.parameters = network.parameters();
    fit.report.tried.push_back(line_of("the given model", fit.training, targets, check));
    fit.report.reached = fit.training.sse / static_cast<double>(targets);
    fit.report.measure = measure_of(options);
    fit.report.iterations = fit.training.iterations;
    fit.report.stopped = fit.training.stopped;
    warn(network, task.X, fit.training, targets, fit.report.warnings);
    fit.errors = {std::sqrt(fit.report.reached)};
    fit.model = std::make_shared<Mlp>(std::move(network), task.x, task.y);
    return {make_narx(fit.model, regressors, data, fit.report), fit};
  }
  MlpFit fit = fit_task(task, map.network(), {start}, how, control);
  return {make_narx(fit.model, regressors, data, fit.report), fit};
}

}  // namespace plantloop::identify
