// Models for predictive controllers, by the names of their files.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "learned/predictor.h"

namespace plantloop {

struct ModelUse {
  std::string path;
  std::vector<std::string> inputs, outputs;  // of a diagram: its signals; a model file has its own
  int substeps = 4;                          // of a diagram
  double Ts = 0;                             // s, of the controller; 0: only to be looked at
  friend bool operator==(const ModelUse&, const ModelUse&) = default;
};

struct LoadedPredictor {
  std::string error;  // why the model cannot be used, as a user reads it; then there is no predictor
  std::shared_ptr<const Predictor> predictor;
  double Ts = 0;  // s; 0: the model has no sampling time of its own
  bool is_diagram = false;
};

// A model file, which is a map with regressors, polynomials or matrices, or a diagram. The same files with the same
// content give the same predictor as long as it was used lately. May be called from several threads, and while a
// diagram is being compiled.
LoadedPredictor load_predictor(const ModelUse& use);

}  // namespace plantloop
