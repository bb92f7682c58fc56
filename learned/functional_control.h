// Predictive functional control (J. Richalet; J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and
// Related Methods, 4.3 and 7.4) with any identified dynamic model of one input and one output, as a kernel.
//
// At sample k the inputs to come are u(k+j) = c_1 + c_2 j + c_3 j^2 + ..., held between the limits, and the
// coefficients are those with which the prediction meets the reference trajectory
//
//   target(h) = w(k+h) - lambda^h (w(k) - base),   base: the measured output, or the reference's own state r(k),
//   r(k+1) = w - lambda (w - r(k)),
//
// at the coincidence points h, in the sense of least squares. With `correction`, equation (4.1), the model runs in
// parallel with the plant: the prediction starts from its own outputs, and y - ym is added; without, it starts from the
// measured outputs.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/program/kernel.h"
#include "engine/program/status_kernel.h"
#include "identify/gp/gp_map.h"
#include "identify/narx/load.h"
#include "learned/narx_rows.h"

namespace plantloop {

struct FunctionalControl {
  std::vector<int> coincidence{8};  // points h >= 1, ascending; the last is the horizon
  int basis = 1;                    // coefficients c, at most as many as points
  int set_points = 1;               // 1, or horizon + 1: w now and at the samples to come
  bool from_reference = false;      // base is the reference's own state
  bool correction = true;
  bool limits_variance = false;
  identify::Propagation propagation = identify::Propagation::naive;  // of a Gaussian process's uncertainty
  int candidates = 301;  // constant inputs between the limits among which the search begins
  bool refines = true;   // the search goes on between them
  friend bool operator==(const FunctionalControl&, const FunctionalControl&) = default;
};

class FunctionalControlKernel final : public Kernel, public StatusKernel {
 public:
  // Why the model cannot be used so; "": it can.
  static std::string why_not(const identify::LoadedModel& model, const FunctionalControl& how);
  FunctionalControlKernel(std::shared_ptr<const identify::LoadedModel> model, FunctionalControl how);

  // Inputs, in this order: w (set_points of them), y, lower, upper, greatest change of u from the sample before,
  // greatest variance, lambda, r, the inputs u(k-1), u(k-2) ... (past_inputs()), the measured y(k-1), ..., and the
  // model's ym(k), ym(k-1), ... (past_outputs() of each).
  int past_inputs() const { return rows_.past_inputs(); }
  int past_outputs() const { return rows_.past_outputs(); }
  // Outputs: u(k); the predicted standard deviation of a measurement at the horizon, 0 where the model does not know;
  // the status; ym(k+1); r(k+1).
  enum Result { input, deviation, status, model_output, reference, results };
  // As status: the prediction meets the reference; a limit of the input keeps it from there; the limit on the variance
  // does; no input that was tried keeps that limit, and that of the least variance is taken.
  enum Status { met = 0, at_limit = 1, at_variance = 2, too_uncertain = 3 };

  std::string name() const override { return "predictive functional control"; }
  int outputs() const override { return results; }
  int status_output() const override { return status; }
  std::vector<std::string> status_words() const override;
  bool is_same(const Kernel& other) const override {
    const auto* const control = dynamic_cast<const FunctionalControlKernel*>(&other);
    return control && control->model_ == model_ && control->how_ == how_;
  }
  int scratch_size() const override;
  void evaluate(const KernelCall& call) const override;

 private:
  class Move;
  std::shared_ptr<const identify::LoadedModel> model_;
  std::optional<identify::UncertainRun> uncertain_;
  double noise_variance_ = 0;
  FunctionalControl how_;
  NarxRows rows_;
};

}  // namespace plantloop
