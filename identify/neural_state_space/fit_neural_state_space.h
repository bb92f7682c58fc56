// Neural state-space models from data, trained for the error of their free run.

#pragma once

#include <cstdint>
#include <vector>

#include "identify/fit/training.h"
#include "identify/neural_state_space/neural_state_space.h"

namespace plantloop::identify {

struct NeuralStateSpaceOptions {
  int order = 2;
  std::vector<int> hidden{8};      // neurons of the transition's hidden layers; none: it is linear
  std::vector<int> output_hidden;  // the same of the output
  // Of the output with neurons: so many linear combinations of what it reads are all that they see, and there is no
  // path past them. With 1 and a linear transition that is a Wiener model. 0: they see everything, beside a direct
  // path.
  int projections = 0;
  // The last state is the output itself, and nothing but its own next value depends on it: x_n(k+1) = x_n + f_n, as of
  // a position that is driven by a speed. For one output.
  bool integrating = false;
  Activation activation = Activation::tanh;
  std::vector<int> delay;   // of each input or once for all, samples; none: 0
  bool feedthrough = true;  // whether the output reads the inputs
  // Of the weights of neurons, as TrainingOptions::decay; the linear part is free but for 1e-6.
  double decay = 1e-3;
  int iterations = 100;
  int starts = 6;   // random first weights for each way to begin, tried with a few iterations
  int refined = 2;  // so many of them are trained to their end
  std::uint64_t seed = 1;
  int threads = 0;  // 0: as many as the machine has; the result does not depend on it
};

// Begins with linear models: by the subspace method, output error models, and chains of equal lags (Laguerre) with
// several poles; then the state of each is known, and static networks from it to the output are trained, which is a
// Wiener model. The best of these, with neurons that do not yet act on the state, are trained through time by
// Levenberg-Marquardt. Data are normalised, the state is moved to the basis in which its mean square is the unit
// matrix. Raises IdentifyError.
NeuralStateSpace fit_neural_state_space(const DataSet& data, const NeuralStateSpaceOptions& options = {},
                                        const FitControl& control = {});

// The model trained on, with its own structure, normalisation and start; `data` may be others.
NeuralStateSpace refine(const NeuralStateSpace& model, const DataSet& data, const NeuralStateSpaceOptions& options = {},
                        const FitControl& control = {});

}  // namespace plantloop::identify
