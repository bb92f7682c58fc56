// The networks of a neural state-space model as one vector of weights.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "identify/mlp/network.h"
#include "identify/neural_state_space/fit_neural_state_space.h"

namespace plantloop::identify {

struct Shapes {
  Network transition, output;
  Eigen::Index parameters() const { return transition.parameters() + output.parameters(); }
};
// All weights 0.
Shapes shapes_of(int order, Eigen::Index inputs, Eigen::Index outputs, const NeuralStateSpaceOptions& options);

// Sets the linear part: matrix * input + constant, the neurons not yet connected to the output.
void set_linear(Network& network, const Eigen::MatrixXd& matrix, const Eigen::VectorXd& constant);
// Weights of the inputs so that sums over signals of mean square 1 spread over the bends of the neurons.
void spread_neurons(Network& network, Random& random);

// In the order of theta of StateSpaceTraining. The decay of each weight: `decay` for those of neurons, hardly any for
// the rest.
Eigen::VectorXd decays_of(const Network& network, double decay);
Eigen::VectorXd decays_of(const Shapes& shapes, double decay, Eigen::Index parameters);
// The weights of an integrating model's last state and of its output, which stay as they are.
std::vector<bool> fixed_weights(Shapes shapes, std::size_t experiments);
Eigen::VectorXd joined(const Network& transition, const Network& output, const std::vector<Eigen::VectorXd>& x0);

// Whether the last state is the output and moves nothing but itself.
bool is_integrating(const Shapes& shapes);

}  // namespace plantloop::identify
