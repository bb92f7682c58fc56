// Controllers from linear models and from step tests.

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "scripts/host/api.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void set_number(lua_State* L, const char* key, double value) {
  lua_pushnumber(L, value);
  lua_setfield(L, -2, key);
}

// The polynomial with the poles as its roots, descending powers; a vector of real ones or rows of real and imaginary
// parts.
VectorXd polynomial_of(const Array& poles) {
  const auto n = length(poles);
  Eigen::VectorXcd product = Eigen::VectorXcd::Zero(n + 1);
  product[0] = 1;
  for (std::int64_t k = 0; k < n; ++k) {
    const std::complex<double> pole(poles.data()[k], poles.is_matrix ? poles.data()[k + poles.rows] : 0.0);
    for (std::int64_t i = k + 1; i > 0; --i) product[i] -= pole * product[i - 1];
  }
  const double size = product.cwiseAbs().maxCoeff();
  if (product.imag().cwiseAbs().maxCoeff() > 1e-9 * size)
    throw ScriptError("complex poles come in pairs: with -1 + 2i stands -1 - 2i");
  return product.real();
}

// J. Ackermann 1972: K = [0 ... 0 1] [B, A B, ...]^-1 p(A), for one input.
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
  const auto n = a.rows;
  constexpr std::int64_t most = 30;
  if (n > most) throw ScriptError(fmt::format("this method is for up to {} states", most));
  const MatrixXd A = matrix_view(a);
  const VectorXd p = polynomial_of(poles);
  MatrixXd reach(n, n), value = MatrixXd::Zero(n, n);
  VectorXd column = VectorXd::Map(b.data(), n);
  for (std::int64_t i = 0; i < n; ++i, column = A * column) reach.col(i) = column;
  for (std::int64_t i = 0; i <= n; ++i) value = value * A + p[i] * MatrixXd::Identity(n, n);
  const Eigen::FullPivLU<MatrixXd> factors(reach);
  if (factors.rank() < n)
    throw ScriptError(fmt::format(
        "the input reaches only {} of the {} states' directions, so not all poles can be moved", factors.rank(), n));
  const VectorXd last = factors.inverse().row(n - 1).transpose();
  Array& gains = push_vector(L, n);
  VectorXd::Map(gains.data(), n) = value.transpose() * last;
  return 1;
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

// Lambda tuning (E. B. Dahlin 1968; with derivative D. E. Rivera, M. Morari and S. Skogestad 1986) of the plant
// K exp(-theta s)/(T s + 1): the closed loop answers a set point with the time constant lambda.
int lambda_tuning(lua_State* L) {
  const Options options(L, 1, "the options of lambda_tuning",
                        {"gain", "time_constant", "dead_time", "lambda", "derivative"});
  const double gain = not_zero(options, "gain"), T = positive(options, "time_constant"),
               lambda = positive(options, "lambda");
  const double theta = options.number("dead_time").value_or(0);
  if (theta < 0) options.wrong("dead_time", "a number of at least 0");
  double kp = T / (gain * (lambda + theta)), ti = T, td = 0;
  if (options.flag("derivative")) {
    ti = T + theta / 2;
    td = T * theta / (2 * T + theta);
    kp = ti / (gain * (lambda + theta / 2));
  }
  lua_newtable(L);
  set_number(L, "kp", kp);
  set_number(L, "ki", kp / ti);
  set_number(L, "kd", td == 0 ? 0 : kp * td);
  return 1;
}

// A first-order lag with dead time from a recorded answer to a step, by the times at which it has done 28.3 % and
// 63.2 % of its way (C. L. Smith 1972).
int step_test(lua_State* L) {
  const Array& time = vector_argument(L, 1, "time");
  const Array& y = vector_argument(L, 2, "y");
  const Options options(L, 3, "the options of step_test", {"size", "at"});
  if (time.size() != y.size() || time.size() < 3)
    throw ScriptError(
        fmt::format("time and y are of one length of at least 3, they have {} and {} numbers", time.size(), y.size()));
  const double size = not_zero(options, "size");  // by how much the input was changed
  const double at = options.number("at").value_or(time.data()[0]);
  double before = y.data()[0];
  for (std::int64_t i = 0; i < time.size() && time.data()[i] <= at; ++i) before = y.data()[i];
  const double way = y.data()[y.size() - 1] - before;
  if (way == 0 || !std::isfinite(way)) throw ScriptError("y ends where it began, so the step moved nothing");
  // The first time at which that part of the way is done, on a straight line between samples.
  const auto when = [&](double part) {
    for (std::int64_t i = 1; i < time.size(); ++i) {
      if (time.data()[i] <= at) continue;
      const double a = (y.data()[i - 1] - before) / way, b = (y.data()[i] - before) / way;
      if (b < part) continue;
      const double from = std::max(time.data()[i - 1], at);
      return b > a && a < part ? from + (part - a) / (b - a) * (time.data()[i] - from) : time.data()[i];
    }
    return time.data()[time.size() - 1];
  };
  const double early = when(1 - std::exp(-1.0 / 3)) - at, late = when(1 - std::exp(-1.0)) - at;
  const double T = 1.5 * (late - early);
  lua_newtable(L);
  set_number(L, "gain", way / size);
  set_number(L, "time_constant", T);
  set_number(L, "dead_time", std::max(0.0, late - T));
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
      {"step_test", guarded<step_test>, "time: pl.Vector, y: pl.Vector, options: {size: number, at?: number}", "table",
       "gain, time_constant and dead_time of the lag that answers a step as y did"},
  };
}

}  // namespace plantloop::lua
