// Learned models by the names of their files, each read once.

#pragma once

#include <memory>
#include <string>

#include "identify/linear/state_space.h"
#include "identify/narx/narx.h"
#include "identify/neural_state_space/neural_state_space.h"

namespace plantloop::identify {

// A model file as blocks need it.
struct LoadedModel {
  std::string error;  // why it cannot be used; then the rest is empty
  std::shared_ptr<const Approximator> map;
  bool dynamic = false;  // has regressors, so that `narx` is set
  NarxModel narx;        // noise_free() when the file has a noise model
  // The whole model when it has a noise model, else null.
  std::shared_ptr<const NarxModel> with_noise;
  // Of a file with a linear model instead, of polynomials or of matrices; `map` is null then. Polynomials become the
  // observer companion form.
  std::shared_ptr<const StateSpaceModel> linear;
  // Of a file with a neural state-space model instead; `map` is null then.
  std::shared_ptr<const NeuralStateSpace> neural;
};

// The last files with their content are kept, as a large Gaussian process takes long to prepare; a file that changed is
// read again. May be called from several threads.
std::shared_ptr<const LoadedModel> load_model(const std::string& path);

}  // namespace plantloop::identify
