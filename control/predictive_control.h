// Model predictive control with any predictor, as a kernel: the moves of one sample by control/move_problem.h.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "control/move_problem.h"
#include "engine/program/kernel.h"
#include "engine/program/status_kernel.h"
#include "learned/predictor.h"

namespace plantloop {

struct PredictiveControl {
  int first = 1;                  // N1
  std::vector<int> blocks{1};     // how long each move is held, in samples; the last one to the end of the horizon
  int horizon = 8;                // N2
  bool knows_set_points = false;  // w now and at the samples of the horizon, else w now
  bool from_reference = false;    // the reference trajectory begins at its own state
  bool correction = true;         // (4.1)
  bool measures_state = false;    // the model's state is an input
  SearchOptions search;
  friend bool operator==(const PredictiveControl&, const PredictiveControl&) = default;
};

class PredictiveControlKernel final : public Kernel, public StatusKernel {
 public:
  PredictiveControlKernel(std::shared_ptr<const Predictor> predictor, PredictiveControl how);

  // Inputs, in this order; u, y, v: numbers of inputs, outputs and moves times inputs.
  //   w: outputs, or (horizon + 1) x outputs; y: outputs; the state, when it is measured
  //   lower, upper, greatest change: inputs each
  //   alpha: (horizon - N1 + 1) x outputs; beta: moves x inputs
  //   least, most: signals each; the weight of slacks; lambda
  //   r: outputs; u(k-1): inputs; the last moves: moves x inputs; the state that the model
  //   advanced to from the sample before
  // Limits beyond MoveNumbers::no_limit are none.
  int variables() const { return blocks_.moves * predictor_->inputs(); }
  const Predictor& predictor() const { return *predictor_; }

  // Outputs: u, the standard deviations of the outputs at the horizon (0 where the model knows none), the four below,
  // the moves, r(k+1), the next state.
  enum Result { status, cost, excess, iterations, results };
  int at_deviation() const { return predictor_->inputs(); }
  int at(Result result) const { return at_deviation() + predictor_->outputs() + result; }
  int at_moves() const { return at(results); }
  int at_reference() const { return at_moves() + variables(); }
  int at_state() const { return at_reference() + predictor_->outputs(); }

  std::string name() const override { return "model predictive control"; }
  int outputs() const override { return at_state() + predictor_->state_size(); }
  int status_output() const override { return at(status); }
  std::vector<std::string> status_words() const override;
  bool is_same(const Kernel& other) const override {
    const auto* const control = dynamic_cast<const PredictiveControlKernel*>(&other);
    return control && control->predictor_ == predictor_ && control->how_ == how_;
  }
  int scratch_size() const override;
  void evaluate(const KernelCall& call) const override;

 private:
  struct Work;
  std::shared_ptr<const Predictor> predictor_;
  PredictiveControl how_;
  MoveBlocks blocks_;
};

}  // namespace plantloop
