// Multilayer perceptrons: layers of neurons, each a weighted sum through an activation.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/approximator.h"
#include "identify/mlp/activation.h"
#include "identify/random.h"
#include "identify/scaling.h"

namespace plantloop::identify {

// h = activation(w [x; 1]).
struct Layer {
  Eigen::MatrixXd w;  // neurons x (inputs + 1); the bias is the last column
  Activation activation = Activation::tanh;
  Eigen::Index neurons() const { return w.rows(); }
  Eigen::Index inputs() const { return w.cols() - 1; }
};

// Layers from the inputs to the outputs; the inputs of each are the neurons of the one before.
//
// theta: the weights from the last layer to the first one, in each row by row with the bias last. Of one hidden layer
// and one output that is W2_1 ... W2_H, b2, then W1 row by row. Direct connections, which lead from the inputs to the
// outputs past all layers, come last, row by row.
struct Network {
  std::vector<Layer> layers;
  Eigen::MatrixXd direct;  // outputs x inputs, or empty: none; only where the outputs are linear

  Eigen::Index inputs() const { return layers.front().inputs(); }
  Eigen::Index outputs() const { return layers.back().neurons(); }
  Eigen::Index parameters() const;
  Eigen::VectorXd theta() const;
  void set_theta(const Eigen::VectorXd& theta);

  // Doubles that the functions below may use.
  Eigen::Index scratch_size() const;
  void evaluate(const double* x, double* y, double* scratch) const;
  // The same, and dy/dtheta (parameters() numbers for each output) and dy/dx (inputs() numbers for each output); either
  // may be null.
  void differentiate(const double* x, double* y, double* by_theta, double* by_x, double* scratch) const;
};

// hidden: neurons of each hidden layer; all weights 0. Raises IdentifyError for sizes below 1, and for direct
// connections to outputs that are not linear.
Network make_network(int inputs, const std::vector<int>& hidden, int outputs, Activation hidden_activation,
                     Activation output_activation = Activation::linear, bool direct = false);
// Weights uniformly distributed on (-spread, spread).
void randomise(Network& network, double spread, Random& random);

// A network between normalised numbers, as a model.
class Mlp final : public Approximator {
 public:
  // Raises IdentifyError when sizes differ.
  Mlp(Network network, Scaling x, Scaling y);

  std::string type() const override { return "mlp"; }
  int inputs() const override { return static_cast<int>(network_.inputs()); }
  int outputs() const override { return static_cast<int>(network_.outputs()); }
  int scratch_size() const override;
  void evaluate(const double* x, double* y, double* scratch) const override;
  void derivative(const double* x, double* jacobian, double* scratch) const override;
  void write(Item& item) const override;

  const Network& network() const { return network_; }
  const Scaling& x_scaling() const { return x_; }
  const Scaling& y_scaling() const { return y_; }

 private:
  Network network_;
  Scaling x_, y_;
};

}  // namespace plantloop::identify
