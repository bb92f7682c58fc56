// pl.identify: state-space models, NARX models that are linear in their parameters, and model files.

#include "scripts/host/identify_models.h"

#include <fmt/format.h>

#include <algorithm>

#include "identify/model_file/model_file.h"
#include "scripts/host/identify_objects.h"

namespace plantloop::lua {
namespace {

using Eigen::Index;
using identify::RegressionModel;
using identify::RegressorSet;
using identify::StateSpaceModel;

int simulate_state_space(lua_State* L) {
  const Options o(L, 3, "the options of simulate", {"start", "samples"});
  push_outputs(L, identify::simulate(held_self<StateSpaceModel>(L, state_space_kind), data_argument(L, 2), start_of(o),
                                     start_samples(o)));
  return 1;
}

// Without a model of the noise, what is measured tells the state at the start and nothing later.
std::vector<Eigen::MatrixXd> predicted_linear(lua_State* L, const identify::DataSet& data) {
  return identify::simulate(held_self<StateSpaceModel>(L, state_space_kind), data, identify::StateStart::estimated);
}

int predict_state_space(lua_State* L) {
  if (is_given(L, 3)) integer_argument(L, 3, "steps", 1, 1'000'000);
  push_outputs(L, predicted_linear(L, data_argument(L, 2)));
  return 1;
}

int residuals_state_space(lua_State* L) {
  const identify::DataSet& data = data_argument(L, 2);
  push_residuals(L, data, predicted_linear(L, data));
  return 1;
}

int state_space_response(lua_State* L) {
  const auto number = [L](int at, const char* what) {
    return static_cast<std::size_t>(is_given(L, at) ? integer_argument(L, at, what, 1, 1000) - 1 : 0);
  };
  push_response(L, identify::frequency_response(held_self<StateSpaceModel>(L, state_space_kind), vector_of(L, 2, "w"),
                                                number(3, "input"), number(4, "output")));
  return 1;
}

int save_state_space(lua_State* L) {
  const StateSpaceModel& m = held_self<StateSpaceModel>(L, state_space_kind);
  write_and_push(L, text_argument(L, 2, "path"), identify::to_yaml("state_space_model", identify::to_item(m)),
                 {".yaml"});
  return 1;
}

const std::vector<Field<StateSpaceModel>>& state_space_fields_list() {
  using M = StateSpaceModel;
  static const std::vector<Field<M>> list{
      {"A", "pl.Vector", "n x n", [](lua_State* L, const M& m) { push_matrix(L, m.A); }},
      {"B", "pl.Vector", "n x inputs", [](lua_State* L, const M& m) { push_matrix(L, m.B); }},
      {"C", "pl.Vector", "outputs x n", [](lua_State* L, const M& m) { push_matrix(L, m.C); }},
      {"D", "pl.Vector", "outputs x inputs", [](lua_State* L, const M& m) { push_matrix(L, m.D); }},
      {"order", "integer", "n", [](lua_State* L, const M& m) { lua_pushinteger(L, m.order()); }},
      {"singular_values", "pl.Vector", "from which the order was read",
       [](lua_State* L, const M& m) { push_numbers(L, m.singular_values); }},
      {"poles", "pl.Vector", "real and imaginary parts, one row each",
       [](lua_State* L, const M& m) {
         const Eigen::VectorXcd z = m.poles();
         Eigen::MatrixXd parts(z.size(), 2);
         parts << z.real(), z.imag();
         push_matrix(L, parts);
       }},
      {"level", "pl.Vector", "of the outputs at rest, with the inputs at their operating point",
       [](lua_State* L, const M& m) { push_numbers(L, m.y0); }},
      {"Ts", "number", "s", [](lua_State* L, const M& m) { lua_pushnumber(L, m.Ts); }},
      {"stable", "boolean", "all poles inside the unit circle",
       [](lua_State* L, const M& m) { lua_pushboolean(L, m.is_stable() ? 1 : 0); }},
      {"report", "table", "method, samples, reached, measure, stopped, tried, warnings, text",
       [](lua_State* L, const M& m) { push_report(L, m.fit); }},
  };
  return list;
}

// The names of the data's signals in a text of regressors, or the terms of a polynomial.
RegressorSet regressors_of(const Options& o, const identify::DataSet& data) {
  if (!o.has("regressors")) throw ScriptError("'regressors' are missing, as in regressors = \"y(k-1), u(k-1..2)\"");
  RegressorSet set = identify::parse_regressors(o.text("regressors"), data);
  if (!o.has("degree")) return set;
  return identify::polynomial(set, integer(o, "degree", 1), !o.has("constant") || o.flag("constant"));
}

int regressors(lua_State* L) {
  const identify::DataSet& data = data_argument(L, 1);
  const RegressorSet set = identify::parse_regressors(text_argument(L, 2, "regressors"), data);
  const identify::Regression r = identify::make_regression(data, set);
  push_matrix(L, r.X);
  push_columns(L, r.Y);
  std::vector<std::string> names;
  for (const identify::Regressor& each : set.list) names.push_back(to_text(each, set));
  push_texts(L, names);
  return 3;
}

int regression(lua_State* L) {
  const identify::DataSet& data = data_argument(L, 1);
  const Options o(L, 2, "the options of regression", {"regressors", "degree", "constant", "ridge", "normalise"});
  push_regression_model(
      L, identify::fit_regression(data, regressors_of(o, data),
                                  {.ridge = o.number("ridge").value_or(0), .normalise = o.flag("normalise")},
                                  control_of(L)));
  return 1;
}

int polynomial(lua_State* L) {
  const identify::DataSet& data = data_argument(L, 1);
  const Options o(
      L, 2, "the options of polynomial",
      {"regressors", "degree", "constant", "most_terms", "normalise", "simulation", "validation", "iterations"});
  identify::SelectionOptions s;
  s.most_terms = integer(o, "most_terms", s.most_terms);
  s.iterations = integer(o, "iterations", s.iterations);
  s.validation = o.number("validation").value_or(s.validation);
  if (o.has("normalise")) s.normalise = o.flag("normalise");
  if (o.has("simulation")) s.simulation = o.flag("simulation");
  RegressorSet candidates = regressors_of(o, data);
  if (!o.has("degree")) candidates = identify::polynomial(candidates, 2);
  push_regression_model(L, identify::fit_selected(data, candidates, s, control_of(L)));
  return 1;
}

const RegressionModel& narx(lua_State* L) { return held_self<RegressionModel>(L, regression_kind); }

int simulate_narx(lua_State* L) {
  const RegressionModel& m = narx(L);
  const auto run = [&m](const identify::DataSet& data) { return identify::free_run(m, data); };
  const identify::DataSet& data = data_argument(L, 2);
  push_outputs(L, starts_at_zero(L, 3) ? identify::from_zero(data, m.regressors.longest_lag(), run) : run(data));
  return 1;
}

int residuals_narx(lua_State* L) {
  const identify::DataSet& data = data_argument(L, 2);
  push_residuals(L, data, identify::one_step(narx(L), data));
  return 1;
}

int predict_narx(lua_State* L) {
  const std::int64_t steps = is_given(L, 3) ? integer_argument(L, 3, "steps", 1, 1'000'000) : 1;
  push_outputs(L, identify::k_step(narx(L), data_argument(L, 2), static_cast<int>(steps)));
  return 1;
}

int fit_narx_free_run(lua_State* L) {
  RegressionModel m = narx(L);
  int iterations = 100;
  if (lua_type(L, 3) == LUA_TNUMBER) {
    iterations = static_cast<int>(integer_argument(L, 3, "iterations", 1, 100'000));
  } else {
    iterations = integer(Options(L, 3, "the options of fit_free_run", {"iterations"}), "iterations", iterations);
    if (iterations < 1) throw ScriptError("'iterations' must be 1 or more");
  }
  identify::fit_free_run(m, data_argument(L, 2), iterations, control_of(L));
  push_regression_model(L, std::move(m));
  return 1;
}

int save_narx(lua_State* L) {
  write_and_push(L, text_argument(L, 2, "path"), identify::to_yaml("regression_model", identify::to_item(narx(L))),
                 {".yaml"});
  return 1;
}

const std::vector<Field<RegressionModel>>& narx_fields_list() {
  using M = RegressionModel;
  static const std::vector<Field<M>> list{
      {"theta", "pl.Vector", "parameters; of several outputs one column each",
       [](lua_State* L, const M& m) { push_columns(L, m.theta); }},
      {"names", "string[]", "the regressors",
       [](lua_State* L, const M& m) {
         std::vector<std::string> names;
         for (const identify::Regressor& r : m.regressors.list) names.push_back(to_text(r, m.regressors));
         push_texts(L, names);
       }},
      {"deviations", "pl.Vector", "standard deviations of the first output's parameters",
       [](lua_State* L, const M& m) { push_numbers(L, m.covariance[0].diagonal().cwiseSqrt()); }},
      {"variance", "pl.Vector", "of each output's one-step error",
       [](lua_State* L, const M& m) { push_numbers(L, m.variance); }},
      {"longest_lag", "integer", "samples before the first prediction",
       [](lua_State* L, const M& m) { lua_pushinteger(L, m.regressors.longest_lag()); }},
      {"Ts", "number", "s", [](lua_State* L, const M& m) { lua_pushnumber(L, m.Ts); }},
      {"report", "table", "method, samples, reached, measure, iterations, stopped, tried, warnings, text",
       [](lua_State* L, const M& m) { push_report(L, m.fit); }},
  };
  return list;
}

int load(lua_State* L) {
  const std::string path = text_argument(L, 1, "path");
  const identify::Item item = identify::read_model_file(read_text(L, path), path);
  const std::string type = item.text("type");
  if (type == "linear_model") {
    push_linear_model(L, identify::polynomial_model_of(item));
  } else if (type == "state_space_model") {
    push_state_space(L, identify::state_space_of(item));
  } else if (type == "regression_model") {
    push_regression_model(L, identify::regression_model_of(item));
  } else if (type == "neural_state_space") {
    push_neural_state_space(L, identify::neural_state_space_of(item));
  } else {
    std::vector<std::string> known{"linear_model", "state_space_model", "regression_model", "neural_state_space"};
    for (const identify::ApproximatorType& each : identify::approximators()) known.emplace_back(each.name);
    if (std::find(known.begin(), known.end(), type) == known.end())
      throw ScriptError(fmt::format("'{}' holds a model of the type '{}'{}", path, type, suggestion(type, known)));
    push_learned_model(L, identify::read_narx(item));
  }
  return 1;
}

}  // namespace

void push_state_space(lua_State* L, StateSpaceModel m) {
  const auto bytes =
      static_cast<std::size_t>(m.A.size() + m.B.size() + m.C.size() + m.D.size()) * sizeof(double) + 1000;
  push_held(L, state_space_kind, std::move(m), bytes);
}

void push_regression_model(lua_State* L, RegressionModel m) {
  std::size_t bytes = 1000;
  for (const Eigen::MatrixXd& P : m.covariance) bytes += static_cast<std::size_t>(P.size()) * sizeof(double);
  push_held(L, regression_kind, std::move(m), bytes);
}

void push_response(lua_State* L, const identify::FrequencyResponse& r) {
  lua_newtable(L);
  const auto put = [L](const char* key, const Eigen::VectorXd& x) {
    if (x.size() == 0) return;
    push_numbers(L, x);
    lua_setfield(L, -2, key);
  };
  put("w", r.w);
  put("magnitude", r.magnitude());
  put("phase", r.phase());
  put("deviation", r.deviation);
  put("phase_deviation", r.phase_deviation);
}

Entries identify_model_functions() {
  return {
      {"regressors", guarded<regressors>, "data: pl.DataSet, regressors: string", "pl.Vector, pl.Vector, string[]",
       "the matrix of regressors, the outputs at its rows, and the regressors one by one"},
      {"regression", guarded<regression>,
       "data: pl.DataSet, options: {regressors: string, degree?: integer, constant?: boolean, ridge?: number, "
       "normalise?: boolean}",
       "pl.RegressionModel",
       "y(k) = theta . regressors by least squares, for each output; degree: all products of the regressors"},
      {"polynomial", guarded<polynomial>,
       "data: pl.DataSet, options: {regressors: string, degree?: integer, constant?: boolean, most_terms?: integer, "
       "normalise?: boolean, simulation?: boolean, validation?: number, iterations?: integer}",
       "pl.RegressionModel",
       "a polynomial NARX model: terms by orthogonal least squares, their number by the free run on the last part of "
       "the data, fitted to the free run"},
      {"load", guarded<load>, "path: string",
       "pl.LinearModel|pl.StateSpaceModel|pl.RegressionModel|pl.LearnedModel|pl.NeuralStateSpace",
       "reads a model file"},
  };
}

Entries state_space_methods() {
  return {
      {"simulate", guarded<simulate_state_space>,
       "data: pl.DataSet, options?: {start?: \"estimated\"|\"zero\", samples?: integer}", "pl.Vector",
       "free run from the state that fits best, or from rest"},
      {"predict", guarded<predict_state_space>, "data: pl.DataSet, steps?: integer", "pl.Vector",
       "the output for any number of steps ahead: as there is no model of the noise, that of the free run from the "
       "estimated start"},
      {"residuals", guarded<residuals_state_space>, "data: pl.DataSet", "pl.Vector", "measured less predicted"},
      {"response", guarded<state_space_response>, "w: pl.Vector, input?: integer, output?: integer", "table",
       "frequency response: w, magnitude, phase"},
      {"save", guarded<save_state_space>, "path: string", "string", "writes a model file, .yaml; gives the path"},
  };
}

Entries regression_model_methods() {
  return {
      {"simulate", guarded<simulate_narx>, "data: pl.DataSet, options?: {start?: \"measured\"|\"zero\"}", "pl.Vector",
       "free run: the outputs are the model's own, the first ones measured; start = \"zero\": all are its own, inputs "
       "and "
       "outputs were 0 before"},
      {"predict", guarded<predict_narx>, "data: pl.DataSet, steps?: integer", "pl.Vector",
       "the output that many steps after the last measured one"},
      {"residuals", guarded<residuals_narx>, "data: pl.DataSet", "pl.Vector",
       "measured less predicted one step ahead; the first ones, without a past, are NaN"},
      {"fit_free_run", guarded<fit_narx_free_run>, "data: pl.DataSet, options?: integer|{iterations?: integer}",
       "pl.RegressionModel", "the same regressors fitted to the error of the free run"},
      {"save", guarded<save_narx>, "path: string", "string", "writes a model file, .yaml; gives the path"},
  };
}

std::vector<FieldInfo> state_space_fields() { return infos_of(state_space_fields_list()); }
std::vector<FieldInfo> regression_model_fields() { return infos_of(narx_fields_list()); }

void open_models(lua_State* L) {
  open_held<StateSpaceModel>(L, state_space_kind, state_space_methods(), state_space_fields_list());
  open_held<RegressionModel>(L, regression_kind, regression_model_methods(), narx_fields_list());
}

}  // namespace plantloop::lua
