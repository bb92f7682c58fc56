// Networks whose linear part is a known model, the rest fitted without going through time.

#include "identify/neural_state_space/guesses.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "identify/data/preprocess.h"
#include "identify/error.h"
#include "identify/linear/least_squares.h"
#include "identify/mlp/problems.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Gaps become lines, the ends hold the nearest value; outputs of which an experiment has none are at their mean.
DataSet without_gaps(const DataSet& normalised) {
  DataSet filled = fill_missing(normalised, Fill::line);
  for (Experiment& e : filled.experiments) {
    for (Index o = 0; o < e.y.cols(); ++o) {
      auto y = e.y.col(o);
      Index first = 0, last = y.size() - 1;
      while (first < y.size() && std::isnan(y[first])) ++first;
      while (last > first && std::isnan(y[last])) --last;
      const bool none = first == y.size();
      y.head(first).setConstant(none ? 0 : y[first]);
      if (!none) y.tail(y.size() - 1 - last).setConstant(y[last]);
    }
  }
  return filled;
}

Scaling scaling_of_measured(const MatrixXd& y) {
  Scaling scaling = no_scaling(y.cols());
  for (Index c = 0; c < y.cols(); ++c) {
    std::vector<double> known;
    for (const double value : y.col(c)) {
      if (std::isfinite(value)) known.push_back(value);
    }
    if (known.empty()) fail("output {} has no measured value", c + 1);
    const Scaling own = standard_scaling(VectorXd::Map(known.data(), static_cast<Index>(known.size())));
    scaling.offset[c] = own.offset[0];
    scaling.scale[c] = own.scale[0];
  }
  return scaling;
}

// Least squares of each column of y by the rows and a constant, one row of coefficients for each.
struct Linear {
  MatrixXd matrix;
  VectorXd constant;
};
Linear linear_map(const MatrixXd& rows, const MatrixXd& y) {
  MatrixXd with_one(rows.rows(), rows.cols() + 1);
  with_one << rows, VectorXd::Ones(rows.rows());
  Linear map{MatrixXd(y.cols(), rows.cols()), VectorXd(y.cols())};
  for (Index o = 0; o < y.cols(); ++o) {
    const LeastSquares fit = least_squares(with_one, y.col(o), {.ridge = 1e-6});
    map.matrix.row(o) = fit.theta.head(rows.cols()).transpose();
    map.constant[o] = fit.theta[rows.cols()];
  }
  return map;
}

MatrixXd beside(const MatrixXd& left, const MatrixXd& right) {
  MatrixXd both(left.rows(), left.cols() + right.cols());
  both << left, right;
  return both;
}

// The states of the beginning lead to the increments of the output, which the last state sums up.
Guess integrating_start(const Beginning& b, const StateSpaceTask& task, Shapes shapes, Random& random) {
  const Index n = shapes.transition.outputs(), inputs = b.B.cols();
  const Linear map = linear_map(beside(b.states, task.data.all_u()), increments(task.filled).all_y());
  MatrixXd matrix = MatrixXd::Zero(n, n + inputs);
  matrix.topLeftCorner(n - 1, n - 1) = b.A;
  matrix.topRightCorner(n - 1, inputs) = b.B;
  matrix.bottomLeftCorner(1, n - 1) = map.matrix.leftCols(n - 1);
  matrix.bottomRightCorner(1, inputs) = map.matrix.rightCols(inputs);
  matrix(n - 1, n - 1) = 1;
  VectorXd constant = VectorXd::Zero(n);
  constant[n - 1] = map.constant[0];
  spread_neurons(shapes.transition, random);
  shapes.transition.layers.front().w.col(n - 1).setZero();
  set_linear(shapes.transition, matrix, constant);
  set_linear(shapes.output, MatrixXd::Identity(n, n).bottomRows(1), VectorXd::Zero(1));
  std::vector<VectorXd> x0;
  for (std::size_t i = 0; i < b.x0.size(); ++i) {
    x0.emplace_back(n);
    x0.back() << b.x0[i], task.filled.experiments[i].y(0, 0);
  }
  return {b.what, joined(shapes.transition, shapes.output, x0)};
}

// They lead to the outputs, by a static fit.
Guess wiener_start(const Beginning& b, const StateSpaceTask& task, Shapes shapes,
                   const NeuralStateSpaceOptions& options, Random& random, Watch& watch) {
  spread_neurons(shapes.transition, random);
  set_linear(shapes.transition, beside(b.A, b.B), VectorXd::Zero(b.A.rows()));
  const MatrixXd y = task.filled.all_y();
  const MatrixXd rows = shapes.output.inputs() > b.states.cols() ? beside(b.states, task.data.all_u()) : b.states;
  const Linear map = linear_map(rows, y);
  spread_neurons(shapes.output, random);
  set_linear(shapes.output, map.matrix, map.constant);
  if (shapes.output.layers.size() == 1) return {b.what, joined(shapes.transition, shapes.output, b.x0)};
  // What the first states left behind is not what the output shall explain.
  const std::vector<Index> settled = settled_rows(task.data, b.A);
  const StaticTraining training(shapes.output, rows(settled, Eigen::all), y(settled, Eigen::all));
  TrainingOptions how;
  how.iterations = 2 * trial_iterations;
  how.decays = decays_of(shapes.output, options.decay);
  const TrainingResult result = train(training, shapes.output.theta(), how, watch);
  shapes.output.set_theta(result.theta);
  return {b.what, joined(shapes.transition, shapes.output, b.x0),
          result.sse * static_cast<double>(rows.rows()) / static_cast<double>(settled.size())};
}

// Sets the first states to those that the weights of a guess make most probable.
void find_first_states(Guess& guess, const StateSpaceTask& task, Shapes shapes, Index targets) {
  const Index n = shapes.transition.outputs();
  shapes.transition.set_theta(guess.theta.head(shapes.transition.parameters()));
  shapes.output.set_theta(guess.theta.segment(shapes.transition.parameters(), shapes.output.parameters()));
  NeuralStateSpace model;
  model.inputs = task.data.inputs;
  model.outputs = task.data.outputs;
  model.Ts = task.data.Ts;
  model.delay.assign(model.inputs.size(), 0);
  model.transition = std::make_shared<Mlp>(shapes.transition, no_scaling(shapes.transition.inputs()), no_scaling(n));
  model.output = std::make_shared<Mlp>(shapes.output, no_scaling(shapes.output.inputs()), no_scaling(task.y.size()));
  model.deviations = VectorXd::Constant(task.y.size(), std::sqrt(guess.sse / static_cast<double>(targets) + 1e-12));
  model.x0 = {guess.theta.segment(shapes.parameters(), n)};
  Index at = shapes.parameters();
  for (const VectorXd& x : first_states(model, task.filled, 100, 40)) {
    guess.theta.segment(at, n) = x;
    at += n;
  }
}

// How many times each beginning is drawn.
int draws_of(const NeuralStateSpaceOptions& options) { return options.output_hidden.empty() ? 1 : options.starts; }

}  // namespace

StateSpaceTask make_task(const DataSet& data, const std::vector<int>& delay, const Scaling* u, const Scaling* y) {
  for (const Experiment& e : data.experiments) {
    if (!e.u.allFinite()) fail("training for simulation needs every input; values are missing");
  }
  StateSpaceTask task;
  task.u = u != nullptr ? *u : standard_scaling(data.all_u());
  task.y = y != nullptr ? *y : scaling_of_measured(data.all_y());
  task.data = data;
  for (Experiment& e : task.data.experiments) {
    e.u = task.u.normalised(delayed(e.u, delay));
    e.y = task.y.normalised(e.y);
  }
  task.filled = task.data.missing() > 0 ? without_gaps(task.data) : task.data;
  return task;
}

int steps_of_guesses(std::size_t beginnings, const NeuralStateSpaceOptions& options) {
  return static_cast<int>(beginnings) * draws_of(options) * (options.output_hidden.empty() ? 0 : 2 * trial_iterations);
}

std::vector<Guess> best_guesses(const std::vector<Beginning>& begin, const StateSpaceTask& task, const Shapes& shapes,
                                const Training& training, const NeuralStateSpaceOptions& options, Watch& watch,
                                std::vector<std::string>& tried) {
  const int draws = draws_of(options), ways = static_cast<int>(begin.size()) * draws;
  std::vector<Guess> starts(static_cast<std::size_t>(ways));
  parallel_for(ways, options.threads, [&](int i) {
    const Beginning& b = begin[static_cast<std::size_t>(i / draws)];
    Random random = random_of_start(options.seed, i);
    Guess guess = options.integrating ? integrating_start(b, task, shapes, random)
                                      : wiener_start(b, task, shapes, options, random, watch);
    guess.what += fmt::format(", start {}", i + 1);
    if (draws == 1) guess.sse = training.sse(guess.theta);
    starts[static_cast<std::size_t>(i)] = std::move(guess);
  });
  // The best ones first, and of those the best one of each beginning.
  const auto less = [](const Guess& a, const Guess& b) { return a.sse < b.sse; };
  for (int i = 0; i < ways; i += draws) std::stable_sort(starts.begin() + i, starts.begin() + i + draws, less);
  std::vector<Guess> firsts, others;
  for (int i = 0; i < ways; ++i)
    (i % draws == 0 ? firsts : others).push_back(std::move(starts[static_cast<std::size_t>(i)]));
  std::stable_sort(firsts.begin(), firsts.end(), less);
  std::stable_sort(others.begin(), others.end(), less);
  starts = std::move(firsts);
  starts.insert(starts.end(), others.begin(), others.end());
  const double targets = static_cast<double>(training.targets());
  for (std::size_t i = 0; i < std::min<std::size_t>(starts.size(), 8); ++i)
    tried.push_back(fmt::format("{}: error {:.6g} before training through time", starts[i].what,
                                std::sqrt(starts[i].sse / targets)));
  // Where there are fewer ways than starts the best ones get other neurons.
  const auto chosen = static_cast<std::size_t>(options.starts);
  for (std::size_t i = 0; starts.size() < chosen; ++i) {
    Guess again = starts[i];
    Network f = shapes.transition;
    f.set_theta(again.theta.head(f.parameters()));
    Random random = random_of_start(options.seed, ways + static_cast<int>(i));
    spread_neurons(f, random);
    if (options.integrating) f.layers.front().w.col(f.outputs() - 1).setZero();
    again.theta.head(f.parameters()) = f.theta();
    again.what += fmt::format(", other neurons {}", i + 1);
    starts.push_back(std::move(again));
  }
  starts.resize(chosen);
  if (draws > 1) {
    parallel_for(options.starts, options.threads, [&](int i) {
      find_first_states(starts[static_cast<std::size_t>(i)], task, shapes, training.targets());
    });
  }
  return starts;
}

}  // namespace plantloop::identify
