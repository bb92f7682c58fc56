// Neural state-space models: linear and Wiener models to begin with, then training through time.

#include "identify/neural_state_space/fit_neural_state_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/fit/parallel.h"
#include "identify/mlp/fit_parts.h"
#include "identify/model_file/model_file.h"
#include "identify/neural_state_space/beginnings.h"
#include "identify/neural_state_space/guesses.h"
#include "identify/neural_state_space/shapes.h"
#include "identify/neural_state_space/state_space_training.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void check_options(const NeuralStateSpaceOptions& o) {
  if (o.order < 1 || o.order > 100) fail("'order' lies between 1 and 100, it is {}", o.order);
  if (o.starts < 1) fail("the number of starts is {}; it must be 1 or more", o.starts);
  if (o.refined < 1) fail("the number of starts that are refined is {}; it must be 1 or more", o.refined);
  if (o.iterations < 1) fail("the number of iterations is {}; it must be 1 or more", o.iterations);
  if (!(o.decay >= 0)) fail("the weight decay is {:g}; it must be 0 or greater", o.decay);
  if (o.integrating && (o.order < 2 || !o.output_hidden.empty()))
    fail("an integrating model has an order of 2 or more, and its output, the last state, has no neurons");
  if (o.projections < 0) fail("the number of projections is {}; it must be 0 or more", o.projections);
  if (o.projections > 0 && o.output_hidden.empty())
    fail("projections are what the output's neurons see; give them 'output_hidden'");
  if (o.activation == Activation::signum) fail("neurons of signum have no gradient to follow; choose sigmoid or tanh");
}

// The model of the trained weights.
NeuralStateSpace finished(const DataSet& data, const StateSpaceTask& task, const Shapes& shapes,
                          const TrainingResult& best, const std::vector<int>& delay) {
  NeuralStateSpace model;
  model.inputs = data.inputs;
  model.outputs = data.outputs;
  model.Ts = data.Ts;
  model.delay = delay;
  Network f = shapes.transition, g = shapes.output;
  const Index n = f.outputs(), inputs = task.u.size();
  f.set_theta(best.theta.head(f.parameters()));
  g.set_theta(best.theta.segment(f.parameters(), g.parameters()));
  Scaling x = no_scaling(n + inputs);
  x.offset.tail(inputs) = task.u.offset;
  x.scale.tail(inputs) = task.u.scale;
  const Scaling states{x.offset.head(g.inputs()), x.scale.head(g.inputs())};
  model.transition = std::make_shared<Mlp>(std::move(f), x, no_scaling(n));
  model.output = std::make_shared<Mlp>(std::move(g), states, task.y);
  for (std::size_t i = 0; i < data.experiments.size(); ++i)
    model.x0.emplace_back(best.theta.segment(shapes.parameters() + n * static_cast<Index>(i), n));
  // The root of each output's mean square error.
  model.deviations = VectorXd::Zero(task.y.size());
  VectorXd counts = VectorXd::Zero(task.y.size());
  for (std::size_t i = 0; i < data.experiments.size(); ++i) {
    const Experiment& e = data.experiments[i];
    const MatrixXd run = simulate_from(model, e, model.x0[i]);
    for (Index k = 0; k < e.samples(); ++k) {
      for (Index o = 0; o < e.y.cols(); ++o) {
        if (!std::isfinite(e.y(k, o))) continue;
        model.deviations[o] += std::pow(e.y(k, o) - run(k, o), 2);
        ++counts[o];
      }
    }
  }
  model.deviations = model.deviations.cwiseQuotient(counts.cwiseMax(1)).cwiseSqrt();
  model.data = data_item(data);
  return model;
}

void report_on(NeuralStateSpace& model, const DataSet& data, const Shapes& shapes, const TrainingResult& best,
               Index targets, const NeuralStateSpaceOptions& options) {
  FitReport& report = model.fit;
  report.method = "neural state space, levenberg_marquardt through time";
  report.samples = targets;
  report.parameters = shapes.parameters() + model.order() * static_cast<Index>(model.x0.size());
  report.reached = best.sse / static_cast<double>(targets);
  report.measure = "mean square of the error of the normalised outputs";
  report.iterations = best.iterations;
  report.stopped = best.stopped;
  report.seed = options.seed;
  report.data = hash(data);
  report.options.push_back(fmt::format("decay {:g}", options.decay));
  for (std::string& warning : undetermined(data)) report.warnings.push_back(std::move(warning));
  const Index missing = data.samples() * static_cast<Index>(data.outputs.size()) - targets;
  if (missing > 0) report.warnings.push_back(fmt::format("{} missing outputs were left out.", missing));
  if (report.parameters > targets)
    report.warnings.push_back(
        fmt::format("There are {} parameters for {} measured outputs; weight decay, fewer neurons "
                    "or a lower order are needed.",
                    report.parameters, targets));
}

}  // namespace

NeuralStateSpace fit_neural_state_space(const DataSet& data, const NeuralStateSpaceOptions& options,
                                        const FitControl& control) {
  check(data);
  check_options(options);
  if (data.inputs.empty()) fail("a neural state-space model needs an input");
  std::vector<int> delay = options.delay;
  if (delay.empty()) delay = {0};
  if (delay.size() == 1) delay.assign(data.inputs.size(), delay[0]);
  if (delay.size() != data.inputs.size())
    fail("there are {} delays for {} inputs; give one for each, or one for all", delay.size(), data.inputs.size());
  if (std::any_of(delay.begin(), delay.end(), [](int d) { return d < 0; }))
    fail("a delay is a number of samples, 0 or more");
  const StateSpaceTask task = make_task(data, delay, nullptr, nullptr);
  const std::vector<Beginning> begin = options.integrating ? beginnings(increments(task.filled), options.order - 1)
                                                           : beginnings(task.filled, options.order);
  const Shapes shapes = shapes_of(options.order, static_cast<Index>(data.inputs.size()),
                                  static_cast<Index>(data.outputs.size()), options);
  const StateSpaceTraining training(shapes.transition, shapes.output, task.data.experiments);
  if (options.integrating && data.outputs.size() > 1)
    fail("an integrating model has one output, the data {}", data.outputs.size());
  Watch watch(control, static_cast<double>(steps_of_guesses(begin.size(), options)) +
                           options.starts * trial_iterations + options.refined * options.iterations);

  std::vector<std::string> tried;
  const std::vector<Guess> starts = best_guesses(begin, task, shapes, training, options, watch, tried);

  TrainingOptions how;
  how.decays = decays_of(shapes, options.decay, training.parameters());
  if (options.integrating) how.fixed = fixed_weights(shapes, data.experiments.size());
  const auto train_all = [&](int count, int iterations, const std::vector<VectorXd>& from) {
    TrainingOptions own = how;
    own.iterations = iterations;
    std::vector<TrainingResult> results(static_cast<std::size_t>(count));
    parallel_for(count, options.threads, [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      results[at] = train(training, from[at], own, watch);
      watch.skip(iterations - results[at].iterations);
    });
    return results;
  };
  const auto best_first = [](const std::vector<TrainingResult>& results) {
    std::vector<std::size_t> order(results.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto score = [&](std::size_t i) {
      return std::isfinite(results[i].criterion) ? results[i].criterion : std::numeric_limits<double>::infinity();
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return score(a) < score(b); });
    return order;
  };
  std::vector<VectorXd> from;
  for (const Guess& start : starts) from.push_back(start.theta);
  const std::vector<TrainingResult> trials = train_all(options.starts, trial_iterations, from);
  std::vector<std::size_t> order = best_first(trials);
  for (const std::size_t i : order) tried.push_back(line_of(starts[i].what, trials[i], training.targets(), nullptr));
  order.resize(std::min<std::size_t>(order.size(), static_cast<std::size_t>(options.refined)));
  from.clear();
  for (const std::size_t i : order) from.push_back(trials[i].theta);
  const std::vector<TrainingResult> results = train_all(static_cast<int>(order.size()), options.iterations, from);
  for (std::size_t i = 0; i < order.size(); ++i)
    tried.push_back(line_of(starts[order[i]].what + ", trained on", results[i], training.targets(), nullptr));
  const TrainingResult& best = results[best_first(results).front()];
  if (!std::isfinite(best.criterion)) fail("no start led to a finite error; the data may be too large");
  NeuralStateSpace model = finished(data, task, shapes, best, delay);
  model.fit.tried = std::move(tried);
  report_on(model, data, shapes, best, training.targets(), options);
  return model;
}

NeuralStateSpace refine(const NeuralStateSpace& model, const DataSet& data, const NeuralStateSpaceOptions& options,
                        const FitControl& control) {
  check(data);
  check(model);
  check_options(options);
  const Scaling& x = model.transition->x_scaling();
  const auto inputs = static_cast<Index>(model.inputs.size());
  const Scaling u{x.offset.tail(inputs), x.scale.tail(inputs)};
  const StateSpaceTask task = make_task(data, model.delay, &u, &model.output->y_scaling());
  const Shapes shapes{model.transition->network(), model.output->network()};
  const StateSpaceTraining training(shapes.transition, shapes.output, task.data.experiments);
  Watch watch(control, options.iterations);
  TrainingOptions how;
  how.iterations = options.iterations;
  how.decays = decays_of(shapes, options.decay, training.parameters());
  if (is_integrating(shapes)) how.fixed = fixed_weights(shapes, data.experiments.size());
  const TrainingResult result =
      train(training, joined(shapes.transition, shapes.output, first_states(model, data)), how, watch);
  if (!std::isfinite(result.criterion)) fail("the model runs away on these data from the start");
  NeuralStateSpace refined = finished(data, task, shapes, result, model.delay);
  refined.fit.tried.push_back(line_of("the given model", result, training.targets(), nullptr));
  report_on(refined, data, shapes, result, training.targets(), options);
  return refined;
}

}  // namespace plantloop::identify