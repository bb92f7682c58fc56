// Models for predictive controllers, by the names of their files.

#pragma once

#include <memory>
#include <string>

#include "learned/predictor.h"

namespace plantloop {

struct LoadedPredictor {
  std::string error;  // why the model cannot be used, as a user reads it; then there is no predictor
  std::shared_ptr<const Predictor> predictor;
  double Ts = 0;  // s; 0: the model has no sampling time of its own
};

// A model file: a map with regressors, polynomials or matrices. The same file with the same content gives the same
// predictor as long as it is in use or was used lately. May be called from several threads.
LoadedPredictor load_predictor(const std::string& path);

}  // namespace plantloop
