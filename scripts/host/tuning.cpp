// Controllers from linear models and from step tests.

#include <fmt/format.h>

#include <cmath>

#include "scripts/host/api.h"
#include "scripts/host/controller_design.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

using Eigen::VectorXd;

void set_number(lua_State* L, const char* key, double value) {
  lua_pushnumber(L, value);
  lua_setfield(L, -2, key);
}

int pole_placement(lua_State* L) {
  const Array& a = array_argument(L, 1, "A");
  const Array& b = array_argument(L, 2, "B");
  const Array& poles = array_argument(L, 3, "poles");
  if (a.rows != a.columns) throw ScriptError(fmt::format("A must be square, it is {}", shape_text(a)));
  if (b.size() != a.rows)
    throw ScriptError(fmt::format("B has one column of {} numbers, for one input; it is {}", a.rows, shape_text(b)));
  if (length(poles) != a.rows || (poles.is_matrix && poles.columns != 2))
    throw ScriptError(fmt::format(
        "there are as many poles as states, {}, as numbers or as rows of real and imaginary part; here is {}", a.rows,
        shape_text(poles)));
  const VectorXd gains = placed(matrix_view(a), VectorXd::Map(b.data(), b.size()), polynomial_of_poles(L, 3));
  push_vector(L, {gains.data(), static_cast<std::size_t>(gains.size())});
  return 1;
}

void push_gains(lua_State* L, const identify::ControllerPoint& c) {
  lua_newtable(L);
  set_number(L, "kp", c.kp);
  set_number(L, "ki", c.ki);
  set_number(L, "kd", c.kd);
  if (c.K.size() == 0) return;
  push_vector(L, {c.K.data(), static_cast<std::size_t>(c.K.size())});
  lua_setfield(L, -2, "K");
}

double needed(const Options& options, const char* key, const char* what) {
  const auto value = options.number(key);
  if (!value) throw ScriptError(fmt::format("'{}' is missing, {}", key, what));
  return *value;
}
double positive(const Options& options, const char* key) {
  const double value = needed(options, key, "a number greater than 0");
  if (!(value > 0)) options.wrong(key, "a number greater than 0");
  return value;
}
double not_zero(const Options& options, const char* key) {
  const double value = needed(options, key, "a number other than 0");
  if (value == 0) options.wrong(key, "a number other than 0");
  return value;
}

int lambda_tuning(lua_State* L) {
  const Options options(L, 1, "the options of lambda_tuning",
                        {"gain", "time_constant", "dead_time", "lambda", "derivative"});
  const double gain = not_zero(options, "gain"), T = positive(options, "time_constant"),
               lambda = positive(options, "lambda");
  const double theta = options.number("dead_time").value_or(0);
  if (theta < 0) options.wrong("dead_time", "a number of at least 0");
  push_gains(L, lambda_tuned({gain, T, theta}, lambda, options.flag("derivative")));
  return 1;
}

int step_test(lua_State* L) {
  const Array& time = vector_argument(L, 1, "time");
  const Array& y = vector_argument(L, 2, "y");
  const Options options(L, 3, "the options of step_test", {"size", "at"});
  if (time.size() != y.size() || time.size() < 3)
    throw ScriptError(
        fmt::format("time and y are of one length of at least 3, they have {} and {} numbers", time.size(), y.size()));
  const double size = not_zero(options, "size");  // by how much the input was changed
  const double at = options.number("at").value_or(time.data()[0]);
  const Lag lag = lag_of(time.values(), y.values(), size, at);
  lua_newtable(L);
  set_number(L, "gain", lag.gain);
  set_number(L, "time_constant", lag.time_constant);
  set_number(L, "dead_time", lag.dead_time);
  return 1;
}

int tune(lua_State* L) {
  const LinearModel model = linear_model_argument(L, 1);
  push_gains(L, designed(L, Options(L, 2, "the options of tune", design_options()), model));
  return 1;
}

}  // namespace

Entries tuning_functions() {
  return {
      {"pole_placement", guarded<pole_placement>, "A: pl.Vector, B: pl.Vector, poles: pl.Vector", "pl.Vector",
       "the gains K with which u = -K x gives A - B K these poles, for one input"},
      {"lambda_tuning", guarded<lambda_tuning>,
       "options: {gain: number, time_constant: number, dead_time?: number, lambda: number, derivative?: boolean}",
       "table", "kp, ki and kd of a controller for a first-order lag with dead time"},
      {"tune", guarded<tune>,
       "model: any, design: {method: string, controller?: string, poles?: pl.Vector, lambda?: number, dead_time?: "
       "number, "
       "Q?: pl.Vector, R?: number}",
       "table",
       "kp, ki, kd (and K of the states) of a controller pi, pid or state_feedback for a linear model, from "
       "diagram:linearise or identified, by pole_placement, lambda_tuning, step_test or lqr"},
      {"step_test", guarded<step_test>, "time: pl.Vector, y: pl.Vector, options: {size: number, at?: number}", "table",
       "gain, time_constant and dead_time of the lag that answers a step as y did"},
  };
}

}  // namespace plantloop::lua
