// The free run of a learned map, and its derivatives carried forward beside it.

#include "learned/narx_predictor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "identify/gp/gp_map.h"

namespace plantloop {

using identify::LoadedModel;

std::string why_no_predictor(const LoadedModel& model) {
  if (!model.dynamic)
    return fmt::format("the model has no regressors, so it is no dynamic model but a map '{}'", model.map->type());
  const identify::RegressorSet& set = model.narx.regressors;
  bool reads_input = false;
  for (const identify::Regressor& regressor : set.list) {
    for (const identify::Factor& factor : regressor.factors) {
      if (factor.lag == 0)
        return fmt::format("the regressor '{}' feeds the input through at once, so there is nothing to predict",
                           to_text(regressor, set));
      reads_input = reads_input || !factor.of_output;
    }
  }
  return reads_input ? "" : "the model does not depend on its input";
}

NarxPredictor::NarxPredictor(std::shared_ptr<const LoadedModel> model, bool with_variance)
    : model_(std::move(model)),
      map_(*model_->map),
      rows_(model_->narx.regressors),
      inputs_(static_cast<int>(model_->narx.regressors.inputs.size())),
      outputs_(static_cast<int>(model_->narx.regressors.outputs.size())),
      dead_samples_(rows_.shortest_input() - 1),
      with_variance_(with_variance),
      is_linear_(map_.is_affine()) {
  for (const identify::Regressor& regressor : model_->narx.regressors.list)
    is_linear_ = is_linear_ && regressor.degree() <= 1;
  const auto gp = std::dynamic_pointer_cast<const identify::GpMap>(model_->map);
  for (int o = 0; o < outputs_; ++o) noise_variance_.push_back(gp ? gp->noise_variance(o) : 0);
}

// Parts of the room. u and y run with time and begin with the past, so do their derivatives.
struct NarxPredictor::Work {
  double *u, *y, *x, *slopes, *by_u, *by_y, *map;
  std::size_t size;
};

NarxPredictor::Work NarxPredictor::work(double* room, int horizon, int variables) const {
  Room parts(room);
  const int us = (past_u() + horizon) * inputs_, ys = (rows_.past_outputs() + horizon) * outputs_;
  Work w{};
  w.u = parts.take(us);
  w.y = parts.take(ys);
  w.x = parts.take(horizon * rows_.size());
  w.slopes = parts.take(outputs_ * rows_.size());
  w.map = parts.take(map_.scratch_size());
  // Last, since predictions do without.
  w.by_u = parts.take(static_cast<std::size_t>(us) * static_cast<std::size_t>(variables));
  w.by_y = parts.take(static_cast<std::size_t>(ys) * static_cast<std::size_t>(variables));
  w.size = parts.taken();
  return w;
}

std::size_t NarxPredictor::room(int horizon, int variables) const { return work(nullptr, horizon, variables).size; }

void NarxPredictor::output(const double* state, double* y, double*) const {
  std::copy_n(state + state_size() - outputs_, outputs_, y);
}

void NarxPredictor::predict(const double* state, const double* u, int horizon, bool with_extras, double* signals,
                            double* room) const {
  const Work w = work(room, horizon, 0);
  const int older_u = past_u() * inputs_, older_y = rows_.past_outputs() * outputs_;
  std::copy_n(state, older_u, w.u);
  std::copy_n(u, horizon * inputs_, w.u + older_u);
  std::copy_n(state + older_u, older_y, w.y);
  for (int j = 0; j < horizon; ++j) {
    double* const x = w.x + j * rows_.size();
    double* const y = w.y + older_y + j * outputs_;
    rows_.row(w.u + older_u + j * inputs_, y - outputs_, x);
    map_.evaluate(x, y, w.map);
    double* const to = signals + j * this->signals();
    std::copy_n(y, outputs_, to);
    if (!with_extras || !with_variance_) continue;
    map_.variance(x, to + outputs_, w.map);
    for (int o = 0; o < outputs_; ++o) to[outputs_ + o] += noise_variance_[static_cast<std::size_t>(o)];
  }
}

void NarxPredictor::sensitivities(const double*, int horizon, bool with_extras, const double* by_variables,
                                  int variables, double* result, double* room) const {
  const Work w = work(room, horizon, variables);
  const int older_u = past_u() * inputs_, older_y = rows_.past_outputs() * outputs_;
  std::fill_n(w.by_u, older_u * variables, 0.0);
  std::copy_n(by_variables, horizon * inputs_ * variables, w.by_u + older_u * variables);
  std::fill_n(w.by_y, (older_y + horizon * outputs_) * variables, 0.0);
  for (int j = 0; j < horizon; ++j) {
    const double* const x = w.x + j * rows_.size();
    const double* const u = w.u + older_u + j * inputs_;
    const double* const y = w.y + older_y + (j - 1) * outputs_;
    const double* const by_u = w.by_u + (older_u + j * inputs_) * variables;
    double* const by_y = w.by_y + (older_y + (j - 1) * outputs_) * variables;
    const auto chain = [&](int o, double* to) {
      for (int r = 0; r < rows_.size(); ++r) {
        const double slope = w.slopes[o * rows_.size() + r];
        if (slope != 0) rows_.add_slope(r, slope, u, y, by_u, by_y, variables, to);
      }
    };
    map_.derivative(x, w.slopes, w.map);
    double* const row = result + j * signals() * variables;
    for (int o = 0; o < outputs_; ++o) {
      chain(o, by_y + (outputs_ + o) * variables);
      std::copy_n(by_y + (outputs_ + o) * variables, variables, row + o * variables);
    }
    if (!with_extras || !with_variance_) continue;
    map_.variance_derivative(x, w.slopes, w.map);
    for (int o = 0; o < outputs_; ++o) {
      std::fill_n(row + (outputs_ + o) * variables, variables, 0.0);
      chain(o, row + (outputs_ + o) * variables);
    }
  }
}

void NarxPredictor::advance(const double* state, const double* u, double* next, double* room) const {
  const Work w = work(room, 1, 0);
  const int older_u = past_u() * inputs_, older_y = rows_.past_outputs() * outputs_;
  std::copy_n(state, older_u, w.u);
  std::copy_n(u, inputs_, w.u + older_u);
  std::copy_n(state + older_u, older_y, w.y);
  rows_.row(w.u + older_u, w.y + older_y - outputs_, w.x);
  map_.evaluate(w.x, w.y + older_y, w.map);
  std::copy_n(w.u + inputs_, older_u, next);
  std::copy_n(w.y + outputs_, older_y, next + older_u);
}

void NarxPredictor::start(const double* u, const double* y, double* state) const {
  for (int i = 0; i < past_u(); ++i, state += inputs_) std::copy_n(u, inputs_, state);
  for (int i = 0; i < rows_.past_outputs(); ++i, state += outputs_) std::copy_n(y, outputs_, state);
}

void NarxPredictor::measure(const double* y, double* state) const {
  std::copy_n(y, outputs_, state + state_size() - outputs_);
}

}  // namespace plantloop
