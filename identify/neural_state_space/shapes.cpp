// Shapes, first weights and their order.

#include "identify/neural_state_space/shapes.h"

#include <cmath>

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double free_decay = 1e-6;  // of what is not a weight of neurons

}  // namespace

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

VectorXd decays_of(const Network& network, double decay) {
  Network marked = network;
  for (Layer& layer : marked.layers) layer.w.setConstant(decay);
  marked.layers.back().w.rightCols(1).setConstant(free_decay);
  if (marked.layers.size() == 1) marked.layers.back().w.setConstant(free_decay);
  if (marked.layers.front().activation == Activation::linear) marked.layers.front().w.setConstant(free_decay);
  marked.direct.setConstant(free_decay);
  return marked.theta();
}

VectorXd decays_of(const Shapes& shapes, double decay, Index parameters) {
  VectorXd all = VectorXd::Constant(parameters, free_decay);
  all.head(shapes.transition.parameters()) = decays_of(shapes.transition, decay);
  all.segment(shapes.transition.parameters(), shapes.output.parameters()) = decays_of(shapes.output, decay);
  return all;
}

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

}  // namespace plantloop::identify
