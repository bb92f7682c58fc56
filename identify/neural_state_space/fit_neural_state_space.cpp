// Neural state-space models: linear and Wiener models to begin with, then training through time.

#include "identify/neural_state_space/fit_neural_state_space.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "identify/data/preprocess.h"
#include "identify/data/undetermined.h"
#include "identify/error.h"
#include "identify/fit/parallel.h"
#include "identify/linear/fit_linear.h"
#include "identify/linear/least_squares.h"
#include "identify/linear/state_space.h"
#include "identify/mlp/problems.h"
#include "identify/model_file/model_file.h"
#include "identify/neural_state_space/state_space_training.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double free_decay = 1e-6;  // of what is not a weight of neurons
constexpr int trial_iterations = 15;

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

// A linear way to move the state, with the states that it gives on the data.
struct Beginning {
  std::string what;
  MatrixXd A, B;
  std::vector<VectorXd> x0;
  MatrixXd states;  // rows x n, of all experiments
};

// Normalised data.
struct Task {
  DataSet data;    // normalised, inputs late by their delays
  DataSet filled;  // the same without missing outputs
  Scaling u, y;
};

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

Task make_task(const DataSet& data, const std::vector<int>& delay, const Scaling* u, const Scaling* y) {
  for (const Experiment& e : data.experiments) {
    if (!e.u.allFinite()) fail("training for simulation needs every input; values are missing");
  }
  Task task;
  task.u = u != nullptr ? *u : standard_scaling(data.all_u());
  task.y = y != nullptr ? *y : scaling_of_measured(data.all_y());
  task.data = data;
  for (Experiment& e : task.data.experiments) {
    e.u = task.u.normalised(delayed(e.u, delay));
    e.y = task.y.normalised(e.y);
  }
  task.filled = task.data.missing() > 0 ? fill_missing(task.data, Fill::line) : task.data;
  return task;
}

MatrixXd states_of(const DataSet& data, const MatrixXd& A, const MatrixXd& B, const std::vector<VectorXd>& x0) {
  MatrixXd rows(data.samples(), A.rows());
  Index row = 0;
  for (std::size_t i = 0; i < data.experiments.size(); ++i) {
    VectorXd x = x0[i];
    for (Index k = 0; k < data.experiments[i].samples(); ++k) {
      rows.row(row++) = x.transpose();
      x = A * x + B * data.experiments[i].u.row(k).transpose();
    }
  }
  return rows;
}

// Adds the beginning in the basis in which the mean square of its states is the unit matrix; one that does not decay is
// slowed down first.
void add(std::vector<Beginning>& list, const DataSet& data, Beginning b) {
  const double radius = Eigen::EigenSolver<MatrixXd>(b.A, false).eigenvalues().cwiseAbs().maxCoeff();
  if (!(radius < 0.9995)) b.A *= 0.9995 / radius;
  b.states = states_of(data, b.A, b.B, b.x0);
  if (!b.states.allFinite()) return;
  const MatrixXd P = b.states.transpose() * b.states / static_cast<double>(b.states.rows());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> parts(P);
  const double greatest = parts.eigenvalues().maxCoeff();
  if (!(greatest > 0)) return;
  const VectorXd roots = parts.eigenvalues().cwiseMax(1e-10 * greatest).cwiseSqrt();
  const MatrixXd to = roots.cwiseInverse().asDiagonal() * parts.eigenvectors().transpose();
  const MatrixXd back = parts.eigenvectors() * roots.asDiagonal();
  b.A = to * b.A * back;
  b.B = to * b.B;
  for (VectorXd& x : b.x0) x = to * x;
  b.states = states_of(data, b.A, b.B, b.x0);
  list.push_back(std::move(b));
}

// What the outputs grow by until the next sample; the last one grows as the one before it.
DataSet increments(DataSet data) {
  for (Experiment& e : data.experiments) {
    const Index last = e.samples() - 1;
    for (Index k = 0; k < last; ++k) e.y.row(k) = (e.y.row(k + 1) - e.y.row(k)).eval();
    if (last > 0) e.y.row(last) = e.y.row(last - 1);
  }
  return data;
}

std::vector<Beginning> beginnings(const DataSet& data, int order) {
  std::vector<Beginning> list;
  const auto inputs = static_cast<Index>(data.inputs.size());
  const auto or_not = [](const auto& make) {
    try {
      make();
    } catch (const Cancelled&) {
      throw;
    } catch (const IdentifyError&) {
      // A linear method that these data do not allow is one way less to begin.
    }
  };
  or_not([&] {
    StateSpaceModel m = fit_subspace(data, {.order = order, .block_rows = std::max(10, 2 * order)});
    add(list, data, {"subspace method", m.A, m.B, m.x0, {}});
  });
  if (data.outputs.size() == 1 && inputs > 0) {
    or_not([&] {
      Orders orders;
      // All inputs share the poles when the error of an ARX model filtered by them is the output error.
      orders.nb.assign(static_cast<std::size_t>(inputs), std::max(1, order / static_cast<int>(inputs)));
      orders.nf = orders.nb;
      orders.delay.assign(static_cast<std::size_t>(inputs), 0);
      StateSpaceModel m = to_state_space(fit_linear(data, orders, {.iterations = 60}));
      if (m.order() != order) return;
      std::vector<VectorXd> x0(data.experiments.size(), VectorXd::Zero(order));
      add(list, data, {"output error", m.A, m.B, std::move(x0), {}});
    });
  }
  for (const double lag : {1.0, 3.0, 10.0, 30.0, 100.0}) {
    if (inputs == 0 || inputs > order || lag * 5 > static_cast<double>(data.samples())) continue;
    const double a = std::exp(-1 / lag);
    MatrixXd A = a * MatrixXd::Identity(order, order), B = MatrixXd::Zero(order, inputs);
    for (Index i = 0; i < order; ++i) {
      if (i < inputs) {
        B(i, i) = 1 - a;
      } else {
        A(i, i - inputs) = 1 - a;
      }
    }
    std::vector<VectorXd> x0;
    const MatrixXd rest = (MatrixXd::Identity(order, order) - A).partialPivLu().solve(B);
    for (const Experiment& e : data.experiments) x0.emplace_back(rest * e.u.row(0).transpose());
    add(list, data, {fmt::format("equal lags of {:g} samples", lag), A, B, std::move(x0), {}});
  }
  if (list.empty()) fail("no linear model of order {} could be made to begin with", order);
  return list;
}

struct Shapes {
  Network transition, output;
  Index parameters() const { return transition.parameters() + output.parameters(); }
};

Shapes shapes_of(int order, Index inputs, Index outputs, const NeuralStateSpaceOptions& o) {
  const int all = order + static_cast<int>(inputs);
  const bool feedthrough = o.feedthrough && !o.integrating;
  std::vector<int> layers = o.output_hidden;
  const bool projected = o.projections > 0;
  if (projected) layers.insert(layers.begin(), o.projections);
  Shapes shapes{make_network(all, o.hidden, order, o.activation, Activation::linear, !o.hidden.empty()),
                make_network(feedthrough ? all : order, layers, static_cast<int>(outputs), o.activation,
                             Activation::linear, !layers.empty() && !projected)};
  if (projected) shapes.output.layers.front().activation = Activation::linear;
  return shapes;
}

// Sets the linear part: matrix * input + constant, the neurons not yet connected to it.
void set_linear(Network& network, const MatrixXd& matrix, const VectorXd& constant) {
  Layer& last = network.layers.back();
  last.w.setZero();
  last.w.rightCols(1) = constant;
  if (network.layers.size() == 1) {
    last.w.leftCols(matrix.cols()) = matrix;
  } else if (network.direct.size() > 0) {
    network.direct = matrix;
  }
}

// Weights of the inputs so that sums over signals of mean square 1 spread over the bends of the neurons.
void spread_neurons(Network& network, Random& random) {
  for (std::size_t l = 0; l + 1 < network.layers.size(); ++l) {
    Layer& layer = network.layers[l];
    const double width = 2 / std::sqrt(static_cast<double>(layer.inputs()));
    for (Index i = 0; i < layer.neurons(); ++i) {
      for (Index j = 0; j < layer.inputs(); ++j) layer.w(i, j) = random.uniform(-width, width);
      layer.w(i, layer.inputs()) = random.uniform(-1.5, 1.5);
    }
  }
}

// The decay of each weight in the order of theta: that of the options for neurons, hardly any for the rest.
VectorXd decays_of(const Network& network, double decay) {
  Network marked = network;
  for (Layer& layer : marked.layers) layer.w.setConstant(decay);
  marked.layers.back().w.rightCols(1).setConstant(free_decay);
  if (marked.layers.size() == 1) marked.layers.back().w.setConstant(free_decay);
  if (marked.layers.front().activation == Activation::linear) marked.layers.front().w.setConstant(free_decay);
  marked.direct.setConstant(free_decay);
  return marked.theta();
}

// The weights of an integrating model's last state, which stay as they are, in the order of theta.
std::vector<bool> fixed_weights(Shapes shapes, std::size_t experiments) {
  const Index n = shapes.transition.outputs();
  shapes.transition.set_theta(VectorXd::Zero(shapes.transition.parameters()));
  shapes.transition.layers.front().w.col(n - 1).setOnes();
  if (shapes.transition.direct.size() > 0) shapes.transition.direct.col(n - 1).setOnes();
  const VectorXd marked = shapes.transition.theta();
  std::vector<bool> fixed(static_cast<std::size_t>(shapes.parameters() + n * static_cast<Index>(experiments)), false);
  for (Index i = 0; i < marked.size(); ++i) fixed[static_cast<std::size_t>(i)] = marked[i] != 0;
  for (Index i = 0; i < shapes.output.parameters(); ++i) fixed[static_cast<std::size_t>(marked.size() + i)] = true;
  return fixed;
}

// Whether the last state is the output and moves nothing but itself.
bool is_integrating(const Shapes& shapes) {
  const Network& f = shapes.transition;
  const Index n = f.outputs();
  const MatrixXd& way = f.direct.size() > 0 ? f.direct : f.layers.front().w;
  const bool of_neurons = f.direct.size() > 0 && !f.layers.front().w.col(n - 1).isZero(0);
  if (of_neurons || shapes.output.layers.size() > 1 || shapes.output.inputs() != n) return false;
  VectorXd own = VectorXd::Zero(n + 1);
  own[n - 1] = 1;
  return way.col(n - 1) == own.head(n) && shapes.output.layers.front().w == own.transpose();
}

VectorXd joined(const Network& transition, const Network& output, const std::vector<VectorXd>& x0) {
  VectorXd theta(transition.parameters() + output.parameters() + transition.outputs() * static_cast<Index>(x0.size()));
  theta.head(transition.parameters()) = transition.theta();
  theta.segment(transition.parameters(), output.parameters()) = output.theta();
  Index at = transition.parameters() + output.parameters();
  for (const VectorXd& x : x0) {
    theta.segment(at, x.size()) = x;
    at += x.size();
  }
  return theta;
}

// An output network on the known states of a beginning.
struct Guess {
  std::string what;
  VectorXd theta;
  double sse = std::numeric_limits<double>::infinity();
};

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
    const LeastSquares fit = least_squares(with_one, y.col(o), {.ridge = free_decay});
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
Guess integrating_start(const Beginning& b, const Task& task, Shapes shapes, Random& random) {
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

// The rows at which the first state of their experiment has decayed to a tenth, or two thirds of them.
std::vector<Index> settled_rows(const DataSet& data, const MatrixXd& A) {
  Index long_enough = 0;
  for (MatrixXd power = A; power.norm() > 0.1 && long_enough < data.samples(); power = (power * A).eval())
    ++long_enough;
  std::vector<Index> rows;
  Index first = 0;
  for (const Experiment& e : data.experiments) {
    for (Index k = std::min(long_enough, e.samples() / 3); k < e.samples(); ++k) rows.push_back(first + k);
    first += e.samples();
  }
  return rows;
}

// The states of the beginning lead to the outputs.
Guess wiener_start(const Beginning& b, const Task& task, Shapes shapes, const NeuralStateSpaceOptions& options,
                   Random& random, Watch& watch) {
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

// The first states that the weights of a start make most probable.
void find_first_states(Guess& guess, const Task& task, Shapes shapes, Index targets) {
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

std::string line_of(const std::string& what, const TrainingResult& result, Index targets) {
  return fmt::format("{}: error {:.6g} after {} iterations; {}", what,
                     std::sqrt(result.sse / static_cast<double>(targets)), result.iterations, result.stopped);
}

// The model of the trained weights.
NeuralStateSpace finished(const DataSet& data, const Task& task, const Shapes& shapes, const TrainingResult& best,
                          const std::vector<int>& delay) {
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
  const Task task = make_task(data, delay, nullptr, nullptr);
  const std::vector<Beginning> begin = options.integrating ? beginnings(increments(task.filled), options.order - 1)
                                                           : beginnings(task.filled, options.order);
  const Shapes shapes = shapes_of(options.order, static_cast<Index>(data.inputs.size()),
                                  static_cast<Index>(data.outputs.size()), options);
  const StateSpaceTraining training(shapes.transition, shapes.output, task.data.experiments);
  if (options.integrating && data.outputs.size() > 1)
    fail("an integrating model has one output, the data {}", data.outputs.size());
  const int draws = options.output_hidden.empty() ? 1 : options.starts;
  const int ways = static_cast<int>(begin.size()) * draws;
  Watch watch(control, (options.output_hidden.empty() ? 0 : ways * 2 * trial_iterations) +
                           options.starts * trial_iterations + options.refined * options.iterations);

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
  NeuralStateSpace model;
  std::vector<std::string> tried;
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

  TrainingOptions how;
  how.decays = VectorXd::Constant(training.parameters(), free_decay);
  how.decays.head(shapes.transition.parameters()) = decays_of(shapes.transition, options.decay);
  how.decays.segment(shapes.transition.parameters(), shapes.output.parameters()) =
      decays_of(shapes.output, options.decay);
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
  for (const std::size_t i : order) tried.push_back(line_of(starts[i].what, trials[i], training.targets()));
  order.resize(std::min<std::size_t>(order.size(), static_cast<std::size_t>(options.refined)));
  from.clear();
  for (const std::size_t i : order) from.push_back(trials[i].theta);
  const std::vector<TrainingResult> results = train_all(static_cast<int>(order.size()), options.iterations, from);
  for (std::size_t i = 0; i < order.size(); ++i)
    tried.push_back(line_of(starts[order[i]].what + ", trained on", results[i], training.targets()));
  const TrainingResult& best = results[best_first(results).front()];
  if (!std::isfinite(best.criterion)) fail("no start led to a finite error; the data may be too large");
  model = finished(data, task, shapes, best, delay);
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
  const Task task = make_task(data, model.delay, &u, &model.output->y_scaling());
  const Shapes shapes{model.transition->network(), model.output->network()};
  const StateSpaceTraining training(shapes.transition, shapes.output, task.data.experiments);
  Watch watch(control, options.iterations);
  TrainingOptions how;
  how.iterations = options.iterations;
  how.decays = VectorXd::Constant(training.parameters(), free_decay);
  how.decays.head(shapes.transition.parameters()) = decays_of(shapes.transition, options.decay);
  how.decays.segment(shapes.transition.parameters(), shapes.output.parameters()) =
      decays_of(shapes.output, options.decay);
  if (is_integrating(shapes)) how.fixed = fixed_weights(shapes, data.experiments.size());
  const TrainingResult result =
      train(training, joined(shapes.transition, shapes.output, first_states(model, data)), how, watch);
  if (!std::isfinite(result.criterion)) fail("the model runs away on these data from the start");
  NeuralStateSpace refined = finished(data, task, shapes, result, model.delay);
  refined.fit.tried.push_back(line_of("the given model", result, training.targets()));
  report_on(refined, data, shapes, result, training.targets(), options);
  return refined;
}

}  // namespace plantloop::identify
