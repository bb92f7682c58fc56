// Evaluating networks forwards, and their exact derivatives backwards.

#include "identify/mlp/network.h"

#include <algorithm>

#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::VectorXd;

Index Network::parameters() const {
  Index count = 0;
  for (const Layer& layer : layers) count += layer.w.size();
  return count + direct.size();
}

VectorXd Network::theta() const {
  VectorXd all(parameters());
  Index at = 0;
  for (auto layer = layers.rbegin(); layer != layers.rend(); ++layer) {
    for (Index i = 0; i < layer->neurons(); ++i) {
      all.segment(at, layer->w.cols()) = layer->w.row(i).transpose();
      at += layer->w.cols();
    }
  }
  all.tail(direct.size()) = direct.reshaped<Eigen::RowMajor>();
  return all;
}

void Network::set_theta(const VectorXd& theta) {
  Index at = 0;
  for (auto layer = layers.rbegin(); layer != layers.rend(); ++layer) {
    for (Index i = 0; i < layer->neurons(); ++i) {
      layer->w.row(i) = theta.segment(at, layer->w.cols()).transpose();
      at += layer->w.cols();
    }
  }
  direct.reshaped<Eigen::RowMajor>() = theta.segment(at, direct.size());
}

// Of each layer its sums s and its outputs h; then two rows for the way back.
Index Network::scratch_size() const {
  Index sum = 0, widest = inputs();
  for (const Layer& layer : layers) {
    sum += 2 * layer.neurons();
    widest = std::max(widest, layer.neurons());
  }
  return sum + 2 * widest;
}

namespace {

// h and s of a layer; s = bias + sum over the inputs in their order.
void forward(const Layer& layer, const double* x, double* s, double* h) {
  const Index n = layer.neurons(), inputs = layer.inputs();
  const double* w = layer.w.data();
  const double* bias = w + n * inputs;
  for (Index i = 0; i < n; ++i) s[i] = bias[i];
  for (Index k = 0; k < inputs; ++k) {
    for (Index i = 0; i < n; ++i) s[i] += w[k * n + i] * x[k];
  }
  for (Index i = 0; i < n; ++i) h[i] = activate(layer.activation, s[i]);
}

void add_direct(const Eigen::MatrixXd& direct, const double* x, double* y) {
  for (Index k = 0; k < direct.cols(); ++k) {
    for (Index o = 0; o < direct.rows(); ++o) y[o] += direct(o, k) * x[k];
  }
}

}  // namespace

void Network::evaluate(const double* x, double* y, double* scratch) const {
  const double* const first = x;
  for (const Layer& layer : layers) {
    double* h = &layer == &layers.back() ? y : scratch + layer.neurons();
    forward(layer, x, scratch, h);
    x = h;
    scratch += 2 * layer.neurons();
  }
  add_direct(direct, first, y);
}

void Network::differentiate(const double* x, double* y, double* by_theta, double* by_x, double* scratch) const {
  const Index p = parameters();
  double* at = scratch;
  const double* input = x;
  for (const Layer& layer : layers) {
    forward(layer, input, at, at + layer.neurons());
    input = at + layer.neurons();
    at += 2 * layer.neurons();
  }
  const double* const sums_end = at;
  const Index widest = (scratch + scratch_size() - at) / 2;
  double* delta = at;            // dy/ds of the layer
  double* before = at + widest;  // dy/dh of the layer before
  for (Index o = 0; o < outputs(); ++o) {
    const double* end = sums_end;
    double* gradient = by_theta == nullptr ? nullptr : by_theta + o * p;
    for (std::size_t l = layers.size(); l-- > 0;) {
      const Layer& layer = layers[l];
      const Index n = layer.neurons(), inputs = layer.inputs();
      const double* h = end - n;
      const double* s = end - 2 * n;
      if (l + 1 == layers.size()) {
        std::fill(delta, delta + n, 0.0);
        delta[o] = slope(layer.activation, s[o], h[o]);
        y[o] = h[o];
      } else {
        for (Index i = 0; i < n; ++i) delta[i] = before[i] * slope(layer.activation, s[i], h[i]);
      }
      end -= 2 * n;
      const double* below = l == 0 ? x : end - layers[l - 1].neurons();
      if (gradient != nullptr) {
        for (Index i = 0; i < n; ++i, gradient += inputs + 1) {
          for (Index k = 0; k < inputs; ++k) gradient[k] = delta[i] * below[k];
          gradient[inputs] = delta[i];
        }
      }
      if (l == 0 && by_x == nullptr) continue;
      double* target = l == 0 ? by_x + o * inputs : before;
      const double* w = layer.w.data();
      for (Index k = 0; k < inputs; ++k) {
        double sum = 0;
        for (Index i = 0; i < n; ++i) sum += w[k * n + i] * delta[i];
        target[k] = sum;
      }
    }
    if (direct.size() == 0) continue;
    if (gradient != nullptr) {
      std::fill(gradient, gradient + direct.size(), 0.0);
      std::copy(x, x + inputs(), gradient + o * inputs());
    }
    if (by_x != nullptr) VectorXd::Map(by_x + o * inputs(), inputs()) += direct.row(o).transpose();
  }
  add_direct(direct, x, y);
}

Network make_network(int inputs, const std::vector<int>& hidden, int outputs, Activation hidden_activation,
                     Activation output_activation, bool direct) {
  if (inputs < 1 || outputs < 1)
    fail("a network with {} inputs and {} outputs; there must be at least one", inputs, outputs);
  Network network;
  int below = inputs;
  for (const int neurons : hidden) {
    if (neurons < 1) fail("a hidden layer of {} neurons; there must be at least one", neurons);
    network.layers.push_back({Eigen::MatrixXd::Zero(neurons, below + 1), hidden_activation});
    below = neurons;
  }
  network.layers.push_back({Eigen::MatrixXd::Zero(outputs, below + 1), output_activation});
  if (!direct) return network;
  if (output_activation != Activation::linear)
    fail("direct connections need linear outputs, those of this network are {}", name_of(output_activation));
  network.direct.setZero(outputs, inputs);
  return network;
}

void randomise(Network& network, double spread, Random& random) {
  VectorXd theta(network.parameters());
  for (double& weight : theta) weight = random.uniform(-spread, spread);
  network.set_theta(theta);
}

}  // namespace plantloop::identify
