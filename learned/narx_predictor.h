// Any identified dynamic model as a predictor.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "identify/narx/load.h"
#include "learned/narx_rows.h"
#include "learned/predictor.h"

namespace plantloop {

// Why a controller cannot predict with a model: it is no dynamic model, feeds its input through or does not read it;
// "" when it can.
std::string why_no_predictor(const identify::LoadedModel& model);

// The state is u(k-L+1), ..., u(k-1), then y(k-M+1), ..., y(k), for the longest lags L and M. Extras are the variances
// of measurements when `with_variance`, which the map must know: those of the last step alone at the predicted means.
class NarxPredictor final : public Predictor {
 public:
  NarxPredictor(std::shared_ptr<const identify::LoadedModel> model, bool with_variance);

  int inputs() const override { return inputs_; }
  int outputs() const override { return outputs_; }
  int extras() const override { return with_variance_ ? outputs_ : 0; }
  bool has_variances() const override { return with_variance_; }
  int state_size() const override { return past_u() * inputs_ + rows_.past_outputs() * outputs_; }
  bool is_linear() const override { return is_linear_; }
  int dead_samples(int) const override { return dead_samples_; }
  std::size_t room(int horizon, int variables) const override;
  void output(const double* state, double* y, double* room) const override;
  void predict(const double* state, const double* u, int horizon, bool with_extras, double* signals,
               double* room) const override;
  void sensitivities(const double* u, int horizon, bool with_extras, const double* by_variables, int variables,
                     double* result, double* room) const override;
  void advance(const double* state, const double* u, double* next, double* room) const override;
  void start(const double* u, const double* y, double* state) const override;
  bool is_made_of_outputs() const override { return true; }
  void measure(const double* y, double* state) const override;

 private:
  struct Work;
  Work work(double* room, int horizon, int variables) const;
  int past_u() const { return rows_.past_inputs() - 1; }

  std::shared_ptr<const identify::LoadedModel> model_;
  const identify::Approximator& map_;
  NarxRows rows_;
  int inputs_, outputs_, dead_samples_;
  bool with_variance_, is_linear_;
  std::vector<double> noise_variance_;
};

}  // namespace plantloop
