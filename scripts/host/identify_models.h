// Identified models as scripts hold them.

#pragma once

#include <cstdint>
#include <vector>

#include "identify/linear/polynomial_model.h"
#include "identify/linear/regression_model.h"
#include "identify/linear/state_space.h"
#include "identify/narx/narx.h"
#include "identify/neural_state_space/neural_state_space.h"
#include "identify/spectra/spectra.h"
#include "scripts/host/api.h"

namespace plantloop::lua {

inline constexpr const char* linear_kind = "linear model";
inline constexpr const char* state_space_kind = "state-space model";
inline constexpr const char* regression_kind = "regression model";
inline constexpr const char* learned_kind = "learned model";
inline constexpr const char* neural_state_space_kind = "neural state-space model";

void push_linear_model(lua_State* L, identify::PolynomialModel model);
void push_state_space(lua_State* L, identify::StateSpaceModel model);
void push_regression_model(lua_State* L, identify::RegressionModel model);
void push_learned_model(lua_State* L, identify::NarxModel model);
void push_neural_state_space(lua_State* L, identify::NeuralStateSpace model);
// The options `regressors`, which must be given, and `seed`.
identify::RegressorSet plain_regressors(const Options& o, const identify::DataSet& data);
std::uint64_t seed_of(const Options& o);
// Methods of learned models that only a Gaussian process has.
Entries gaussian_process_methods();
// {w = ..., magnitude = ..., phase = ..., deviation = ..., phase_deviation = ...}
void push_response(lua_State* L, const identify::FrequencyResponse& response);

}  // namespace plantloop::lua
