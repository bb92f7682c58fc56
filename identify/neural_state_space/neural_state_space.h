// Nonlinear models in state space whose two functions are networks: x(k+1) = f(x, u), y = g(x, u).

#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <vector>

#include "identify/data/data_set.h"
#include "identify/fit_report.h"
#include "identify/linear/state_space.h"
#include "identify/mlp/network.h"

namespace plantloop::identify {

// The state is what the fit made it: its mean square is about 1 over the data. The networks have direct connections, so
// that a linear model is among them. (J. Suykens, B. De Moor, J. Vandewalle 1995; J. Paduart et al. 2010 with
// polynomials.)
struct NeuralStateSpace {
  std::vector<Channel> inputs, outputs;
  double Ts = 1;                          // s
  std::vector<int> delay;                 // of each input, samples: u is u(k - delay)
  std::shared_ptr<const Mlp> transition;  // from [x; u] to the next x
  std::shared_ptr<const Mlp> output;      // from [x; u], or from x alone, to y
  Eigen::VectorXd deviations;             // root mean square of each output's error over the data of the fit
  std::vector<Eigen::VectorXd> x0;        // the first state of each experiment of these data
  FitReport fit;
  Item data;  // what the file says about the data; empty for a model made by hand

  Eigen::Index order() const { return transition->outputs(); }
  bool has_feedthrough() const { return output->inputs() > transition->outputs(); }
};

// Sizes fit together. Raises IdentifyError.
void check(const NeuralStateSpace& model);

// Free run: samples x outputs of each experiment. Inputs before an experiment are its first ones. The first state is 0,
// or the most probable one given the first `samples` measured outputs: it minimises
//   sum |y - yhat|^2/deviations^2 + |x0|^2/9,
// by Levenberg-Marquardt from the best ones of several guesses: 0, the model's own first states, random ones. Missing
// outputs do not count. Raises IdentifyError for other signals, another sampling time and missing inputs.
std::vector<Eigen::MatrixXd> simulate(const NeuralStateSpace& model, const DataSet& data,
                                      StateStart start = StateStart::estimated,
                                      Eigen::Index samples = std::numeric_limits<Eigen::Index>::max());

// The most probable first state of each experiment, as above; and the free run of one from a given state.
std::vector<Eigen::VectorXd> first_states(const NeuralStateSpace& model, const DataSet& data,
                                          Eigen::Index samples = std::numeric_limits<Eigen::Index>::max(),
                                          int guesses = 200);
Eigen::MatrixXd simulate_from(const NeuralStateSpace& model, const Experiment& experiment, const Eigen::VectorXd& x0);

Item to_item(const NeuralStateSpace& model);
NeuralStateSpace neural_state_space_of(const Item& item);

// The inputs of an experiment as the model sees them, each late by its delay.
Eigen::MatrixXd delayed(const Eigen::MatrixXd& u, const std::vector<int>& delay);

}  // namespace plantloop::identify
