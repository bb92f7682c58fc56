// Matrices along a horizon, and with them the derivatives.

#include "learned/linear_predictor.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace plantloop {

std::string why_no_predictor(const identify::StateSpaceModel& model) {
  if (model.B.cols() == 0) return "the model has no input";
  if (!model.D.isZero(0))
    return "the model feeds its input through at once (D is not 0), so its output is no prediction";
  if (model.A.rows() == 0 || model.B.isZero(0)) return "the model does not depend on its input";
  return {};
}

LinearPredictor::LinearPredictor(std::shared_ptr<const identify::StateSpaceModel> model, bool with_states)
    : model_(std::move(model)), with_states_(with_states) {
  Eigen::MatrixXd reached = model_->B;  // A^d B
  dead_samples_.assign(static_cast<std::size_t>(signals()), state_size());
  for (int d = 0; d < state_size(); ++d, reached = model_->A * reached) {
    for (int s = 0; s < signals(); ++s) {
      const bool is_reached =
          s < outputs() ? !(model_->C.row(s) * reached).isZero(0) : !reached.row(s - outputs()).isZero(0);
      int& dead = dead_samples_[static_cast<std::size_t>(s)];
      if (is_reached) dead = std::min(dead, d);
    }
  }
}

std::size_t LinearPredictor::room(int, int variables) const {
  return 2 * static_cast<std::size_t>(state_size()) * (1 + static_cast<std::size_t>(variables));
}

void LinearPredictor::output(const double* state, double* y, double*) const {
  for (int o = 0; o < outputs(); ++o) {
    double sum = 0;
    for (int i = 0; i < state_size(); ++i) sum += model_->C(o, i) * state[i];
    y[o] = model_->y0[o] + sum;
  }
}

void LinearPredictor::advance(const double* state, const double* u, double* next, double*) const {
  for (int i = 0; i < state_size(); ++i) {
    double sum = 0;
    for (int j = 0; j < state_size(); ++j) sum += model_->A(i, j) * state[j];
    for (int j = 0; j < inputs(); ++j) sum += model_->B(i, j) * (u[j] - model_->u0[j]);
    next[i] = sum;
  }
}

void LinearPredictor::predict(const double* state, const double* u, int horizon, bool with_extras, double* signals,
                              double* room) const {
  const int n = state_size();
  double *now = room, *next = room + n;
  std::copy_n(state, n, now);
  for (int j = 0; j < horizon; ++j, signals += this->signals()) {
    advance(now, u + j * inputs(), next, nullptr);
    for (int i = 0; i < n; ++i) next[i] += state[n + i];
    std::swap(now, next);
    output(now, signals, nullptr);
    if (with_extras && with_states_) std::copy_n(now, n, signals + outputs());
  }
}

void LinearPredictor::sensitivities(const double*, int horizon, bool with_extras, const double* by_variables,
                                    int variables, double* result, double* room) const {
  const int n = state_size();
  double *now = room, *next = room + n * variables;
  std::fill_n(now, n * variables, 0.0);
  const auto add = [variables](double factor, const double* row, double* to) {
    if (factor == 0) return;
    for (int v = 0; v < variables; ++v) to[v] += factor * row[v];
  };
  for (int j = 0; j < horizon; ++j, result += signals() * variables) {
    std::fill_n(next, n * variables, 0.0);
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < n; ++k) add(model_->A(i, k), now + k * variables, next + i * variables);
      for (int k = 0; k < inputs(); ++k)
        add(model_->B(i, k), by_variables + (j * inputs() + k) * variables, next + i * variables);
    }
    std::swap(now, next);
    std::fill_n(result, outputs() * variables, 0.0);
    for (int o = 0; o < outputs(); ++o) {
      for (int k = 0; k < n; ++k) add(model_->C(o, k), now + k * variables, result + o * variables);
    }
    if (with_extras && with_states_) std::copy_n(now, n * variables, result + outputs() * variables);
  }
}

void LinearPredictor::start(const double*, const double*, double* state) const {
  std::fill_n(state, state_size(), 0.0);
}

}  // namespace plantloop
