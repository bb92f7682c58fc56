// What the training of a neural state-space model through time may begin with.

#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "identify/fit/parallel.h"
#include "identify/fit/training.h"
#include "identify/neural_state_space/beginnings.h"
#include "identify/neural_state_space/shapes.h"
#include "identify/scaling.h"

namespace plantloop::identify {

inline constexpr int trial_iterations = 15;  // of each guess, before the best ones are trained to their end

// Data of a fit.
struct StateSpaceTask {
  DataSet data;    // normalised, inputs late by their delays
  DataSet filled;  // the same without missing outputs
  Scaling u, y;
};
// Without scalings those of the data are made. Raises IdentifyError for missing inputs and outputs without a value.
StateSpaceTask make_task(const DataSet& data, const std::vector<int>& delay, const Scaling* u, const Scaling* y);

struct Guess {
  std::string what;
  Eigen::VectorXd theta;  // of StateSpaceTraining
  double sse = std::numeric_limits<double>::infinity();
};
// The best `starts` of them, best ones first: each beginning with several draws of neurons, and the best of those with
// other neurons where there are fewer. The output is fitted to the states that a beginning gives, or of an integrating
// model to the increments. Adds lines about the best ones to `tried`. The watch counts steps_of_guesses().
std::vector<Guess> best_guesses(const std::vector<Beginning>& begin, const StateSpaceTask& task, const Shapes& shapes,
                                const Training& training, const NeuralStateSpaceOptions& options, Watch& watch,
                                std::vector<std::string>& tried);
int steps_of_guesses(std::size_t beginnings, const NeuralStateSpaceOptions& options);

}  // namespace plantloop::identify
