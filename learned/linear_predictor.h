// A linear model, of polynomials or of matrices, as a predictor.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "identify/linear/state_space.h"
#include "learned/predictor.h"

namespace plantloop {

// Why a controller cannot predict with the model, "" when it can.
std::string why_no_predictor(const identify::StateSpaceModel& model);

// x(k+1) = A x(k) + B (u(k) - u0), y(k) = y0 + C x(k). The state is x, and so are the extras when `with_states`.
class LinearPredictor final : public Predictor {
 public:
  LinearPredictor(std::shared_ptr<const identify::StateSpaceModel> model, bool with_states);

  int inputs() const override { return static_cast<int>(model_->B.cols()); }
  int outputs() const override { return static_cast<int>(model_->C.rows()); }
  int extras() const override { return with_states_ ? state_size() : 0; }
  int state_size() const override { return static_cast<int>(model_->A.rows()); }
  bool is_linear() const override { return true; }
  int dead_samples(int signal) const override { return dead_samples_[static_cast<std::size_t>(signal)]; }
  std::size_t room(int horizon, int variables) const override;
  void output(const double* state, double* y, double* room) const override;
  void predict(const double* state, const double* u, int horizon, bool with_extras, double* signals,
               double* room) const override;
  void sensitivities(const double* u, int horizon, bool with_extras, const double* by_variables, int variables,
                     double* result, double* room) const override;
  void advance(const double* state, const double* u, double* next, double* room) const override;
  void start(const double* u, const double* y, double* state) const override;
  bool is_made_of_outputs() const override { return false; }

 private:
  std::shared_ptr<const identify::StateSpaceModel> model_;
  bool with_states_;
  std::vector<int> dead_samples_;
};

}  // namespace plantloop
