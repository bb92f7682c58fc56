// Controllers for linear models: pole placement, lambda tuning, step tests, linear-quadratic control.

#include "scripts/host/controller_design.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "scripts/host/identify_models.h"
#include "scripts/host/identify_objects.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using identify::ControllerPoint;

namespace {

MatrixXd eigen_of(const DenseMatrix& m) {
  MatrixXd result(static_cast<Index>(m.rows), static_cast<Index>(m.columns));
  for (Index i = 0; i < result.rows(); ++i) {
    for (Index j = 0; j < result.cols(); ++j)
      result(i, j) = m(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
  }
  return result;
}
DenseMatrix dense_of(const MatrixXd& m) {
  DenseMatrix result(static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols()));
  for (Index i = 0; i < m.rows(); ++i) {
    for (Index j = 0; j < m.cols(); ++j) result(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) = m(i, j);
  }
  return result;
}

// The model with the integral of the error -y as a last state.
struct WithIntegral {
  MatrixXd A;
  VectorXd B;
};
WithIntegral with_integral(const LinearModel& model) {
  const auto n = static_cast<Index>(model.A.rows);
  WithIntegral w{MatrixXd::Zero(n + 1, n + 1), VectorXd(n + 1)};
  w.A.topLeftCorner(n, n) = eigen_of(model.A);
  w.A.bottomLeftCorner(1, n) = -eigen_of(model.C);
  w.B << eigen_of(model.B).col(0), -model.D(0, 0);
  return w;
}

// u = ki (integral of e) - K x, from the gains of the whole state.
ControllerPoint state_feedback(const VectorXd& gains) {
  ControllerPoint c;
  c.ki = -gains[gains.size() - 1];
  c.K = gains.head(gains.size() - 1);
  return c;
}

// The denominator and numerator of a continuous model, descending powers, both with n + 1 coefficients (U. Leverrier).
struct Transfer {
  VectorXd num, den;
};
Transfer transfer_of(const LinearModel& model) {
  const MatrixXd A = eigen_of(model.A), B = eigen_of(model.B), C = eigen_of(model.C);
  const Index n = A.rows();
  Transfer t{VectorXd::Zero(n + 1), VectorXd::Zero(n + 1)};
  t.den[0] = 1;
  MatrixXd M = MatrixXd::Identity(n, n);
  for (Index k = 1; k <= n; ++k) {
    t.num[k] = (C * M * B)(0, 0);
    const MatrixXd AM = A * M;
    t.den[k] = -AM.trace() / static_cast<double>(k);
    M = AM + t.den[k] * MatrixXd::Identity(n, n);
  }
  t.num += model.D(0, 0) * t.den;
  return t;
}

// den s + num (kd s^2 + kp s + ki) = c polynomial, linear in the gains and c. Of a first-order model kd = 0.
ControllerPoint placed_pid(const Transfer& t, const VectorXd& polynomial, bool derivative) {
  const Index n = t.den.size() - 1, unknowns = derivative ? 4 : 3;
  // Coefficients of s^(n+2) ... s^0; one equation for each of them that is not always 0.
  MatrixXd M = MatrixXd::Zero(n + 3, unknowns);
  VectorXd right = VectorXd::Zero(n + 3);
  for (Index i = 0; i <= n; ++i) {
    M(i + 2, 0) = t.num[i];              // ki
    M(i + 1, 1) = t.num[i];              // kp s
    if (derivative) M(i, 2) = t.num[i];  // kd s^2
    right[i + 1] = -t.den[i];            // den s, to the right
  }
  for (Index i = 0; i < polynomial.size(); ++i) M(i + n + 3 - polynomial.size(), unknowns - 1) = -polynomial[i];
  const Eigen::FullPivLU<MatrixXd> factors(M);
  const VectorXd gains = factors.solve(right);
  const double size = std::max(1.0, right.cwiseAbs().maxCoeff());
  if (factors.rank() < unknowns || (M * gains - right).cwiseAbs().maxCoeff() > 1e-9 * size)
    throw ScriptError("this controller cannot place these poles for the model; use controller = \"state_feedback\"");
  ControllerPoint c;
  c.ki = gains[0], c.kp = gains[1];
  if (derivative) c.kd = gains[2];
  return c;
}

double gain_at_rest(const LinearModel& model) {
  const double gain = gains_at_rest(model).front();
  if (gain == 0 || !std::isfinite(gain))
    throw ScriptError(
        fmt::format("the model's gain at rest is {:g}, this design needs one that is finite and not 0", gain));
  return gain;
}

// Poles in rad/s, the slowest first.
std::vector<std::complex<double>> slow_poles(const LinearModel& model) {
  std::vector<std::complex<double>> p = poles(model);
  if (model.period > 0) {
    std::erase_if(p, [](std::complex<double> z) { return std::abs(z) < 1e-12; });  // delays of whole samples
    for (auto& z : p) z = std::log(z) / model.period;
  }
  for (const auto& s : p) {
    if (!(s.real() < 0))
      throw ScriptError("the model is not stable, so it has no step test; use pole_placement or lqr");
  }
  std::sort(p.begin(), p.end(), [](auto a, auto b) { return a.real() > b.real(); });
  if (p.empty()) throw ScriptError("the model has no poles, so there is nothing to be slow");
  return p;
}

// The slowest pole is cancelled, with derivative the two slowest; faster ones are left.
ControllerPoint cancelled(const LinearModel& model, double lambda, double dead_time, bool derivative) {
  const auto p = slow_poles(model);
  const double gain = gain_at_rest(model), over = gain * (lambda + dead_time);
  ControllerPoint c;
  c.ki = 1 / over;
  if (derivative && p.size() > 1) {
    // (s - p1)(s - p2)/(p1 p2): also of a pair.
    const std::complex<double> product = p[0] * p[1], sum = p[0] + p[1];
    if (std::abs(product.imag()) > 1e-9 * std::abs(product))
      throw ScriptError("the slowest poles are a real one and one of a pair, which a PID controller does not cancel");
    c.kp = -sum.real() / product.real() / over;
    c.kd = 1 / product.real() / over;
    return c;
  }
  if (std::abs(p[0].imag()) > 1e-9 * std::abs(p[0]))
    throw ScriptError("the slowest poles are a pair, which a PI controller does not cancel; use controller = \"pid\"");
  c.kp = -1 / p[0].real() / over;
  return c;
}

// The answer to a step that a linear model gives.
Lag stepped(const LinearModel& model) {
  const double end = -12 / slow_poles(model).front().real();
  const bool is_sampled = model.period > 0;
  const double dt = is_sampled ? model.period : end / 4000;
  const LinearModel m = is_sampled ? model : sampled(model, dt, 0, std::vector<double>(1, 0.0));
  const MatrixXd A = eigen_of(m.A), B = eigen_of(m.B), C = eigen_of(m.C);
  VectorXd x = VectorXd::Zero(A.rows());
  std::vector<double> time{0}, y{0};
  const auto count = static_cast<int>(std::min(1e6, std::ceil(end / dt)));
  for (int k = 0; k <= count; ++k) {
    if (k > 0) time.push_back(k * dt), y.push_back((C * x)(0) + m.D(0, 0));
    x = A * x + B.col(0);
  }
  return lag_of(time, y, 1, 0);
}

// The feedback that makes the integral of x'Q x + R u^2 least: from the stable directions of Hamilton's matrix (J.
// Potter 1966).
VectorXd quadratic(const MatrixXd& A, const VectorXd& B, const MatrixXd& Q, double R) {
  const Index n = A.rows();
  MatrixXd H(2 * n, 2 * n);
  H << A, -B * B.transpose() / R, -Q, -A.transpose();
  const Eigen::EigenSolver<MatrixXd> solver(H);
  Eigen::MatrixXcd stable(2 * n, n);
  Index found = 0;
  for (Index i = 0; i < 2 * n; ++i) {
    if (solver.eigenvalues()[i].real() < 0 && found < n) stable.col(found++) = solver.eigenvectors().col(i);
  }
  if (found < n)
    throw ScriptError(
        "the weights leave something unstable unseen, or the input does not reach it: no such controller");
  const Eigen::MatrixXcd P = stable.bottomRows(n) * stable.topRows(n).inverse();
  if (!P.allFinite()) throw ScriptError("the input does not reach all that is unstable: there is no such controller");
  return (B.transpose() * P.real()).transpose() / R;
}

double needed(const Options& options, const char* key) {
  const auto value = options.number(key);
  if (!value || !(*value > 0)) options.wrong(key, "a number greater than 0");
  return *value;
}

}  // namespace

Lag lag_of(std::span<const double> time, std::span<const double> y, double size, double at) {
  double before = y[0];
  for (std::size_t i = 0; i < time.size() && time[i] <= at; ++i) before = y[i];
  const double way = y.back() - before;
  if (way == 0 || !std::isfinite(way)) throw ScriptError("y ends where it began, so the step moved nothing");
  // The first time at which that part of the way is done, on a straight line between samples.
  const auto when = [&](double part) {
    for (std::size_t i = 1; i < time.size(); ++i) {
      if (time[i] <= at) continue;
      const double a = (y[i - 1] - before) / way, b = (y[i] - before) / way;
      if (b < part) continue;
      const double from = std::max(time[i - 1], at);
      return b > a && a < part ? from + (part - a) / (b - a) * (time[i] - from) : time[i];
    }
    return time.back();
  };
  const double early = when(1 - std::exp(-1.0 / 3)) - at, late = when(1 - std::exp(-1.0)) - at;
  const double T = 1.5 * (late - early);
  return {way / size, T, std::max(0.0, late - T)};
}

ControllerPoint lambda_tuned(const Lag& lag, double lambda, bool derivative) {
  const auto& [gain, T, theta] = lag;
  double kp = T / (gain * (lambda + theta)), ti = T, td = 0;
  if (derivative) {
    ti = T + theta / 2;
    td = T * theta / (2 * T + theta);
    kp = ti / (gain * (lambda + theta / 2));
  }
  ControllerPoint c;
  c.kp = kp, c.ki = kp / ti, c.kd = td == 0 ? 0 : kp * td;
  return c;
}

VectorXd polynomial_of_poles(lua_State* L, int index) {
  const Array& poles = array_argument(L, index, "poles");
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

VectorXd placed(const MatrixXd& A, const VectorXd& B, const VectorXd& polynomial) {
  const Index n = A.rows();
  constexpr Index most = 30;
  if (n > most) throw ScriptError(fmt::format("this method is for up to {} states", most));
  MatrixXd reach(n, n), value = MatrixXd::Zero(n, n);
  VectorXd column = B;
  for (Index i = 0; i < n; ++i, column = A * column) reach.col(i) = column;
  for (Index i = 0; i <= n; ++i) value = value * A + polynomial[i] * MatrixXd::Identity(n, n);
  const Eigen::FullPivLU<MatrixXd> factors(reach);
  if (factors.rank() < n)
    throw ScriptError(fmt::format(
        "the input reaches only {} of the {} states' directions, so not all poles can be moved", factors.rank(), n));
  const VectorXd last = factors.inverse().row(n - 1).transpose();
  return value.transpose() * last;
}

std::vector<std::string> design_options() { return {"method", "controller", "poles", "lambda", "dead_time", "Q", "R"}; }

ControllerPoint designed(lua_State* L, const Options& options, const LinearModel& model) {
  if (model.B.columns != 1 || model.C.rows != 1)
    throw ScriptError(fmt::format("a controller is designed for one input and one output, the model has {} and {}",
                                  model.B.columns, model.C.rows));
  const std::string method = options.text("method"), controller = options.text("controller", "pi");
  const bool derivative = controller == "pid", feeds_back = controller == "state_feedback";
  if (!derivative && !feeds_back && controller != "pi")
    throw ScriptError(fmt::format("'controller' is pi, pid or state_feedback, it is '{}'", controller));
  const bool is_quadratic = method == "lqr";
  if (method == "lambda_tuning" || method == "step_test") {
    if (feeds_back) throw ScriptError(fmt::format("{} gives a pi or pid controller", method));
    const double lambda = needed(options, "lambda"), dead_time = options.number("dead_time").value_or(0);
    if (method == "lambda_tuning") return cancelled(model, lambda, dead_time, derivative);
    Lag lag = stepped(model);
    lag.dead_time += dead_time;
    return lambda_tuned(lag, lambda, derivative);
  }
  if (method != "pole_placement" && !is_quadratic)
    throw ScriptError(fmt::format("'method' is pole_placement, lambda_tuning, step_test or lqr, it is '{}'", method));
  if (model.period > 0)
    throw ScriptError(
        fmt::format("the model is sampled and the controller is not; for it use lambda_tuning or step_test"));
  const auto n = static_cast<Index>(model.A.rows);
  const WithIntegral whole = with_integral(model);
  if (is_quadratic) {
    MatrixXd Q = MatrixXd::Identity(n + 1, n + 1);
    if (options.push("Q")) {
      const Array& given = array_argument(L, -1, "Q");
      if (length(given) != n + 1 || (given.is_matrix && given.columns != n + 1))
        throw ScriptError(
            fmt::format("'Q' has {} weights, of each state and of the error's integral, or is a matrix of "
                        "that size",
                        n + 1));
      Q = given.is_matrix ? MatrixXd(matrix_view(given)) : MatrixXd(VectorXd::Map(given.data(), n + 1).asDiagonal());
      lua_pop(L, 1);
    }
    return state_feedback(quadratic(whole.A, whole.B, Q, options.has("R") ? needed(options, "R") : 1.0));
  }
  const Index count = feeds_back ? n + 1 : derivative ? 3 : 2;
  if (!options.push("poles")) throw ScriptError("'poles' are the poles of the closed loop, as in poles = {-1, -2}");
  const VectorXd polynomial = polynomial_of_poles(L, -1);
  lua_pop(L, 1);
  if (polynomial.size() != count + 1)
    throw ScriptError(
        fmt::format("the loop with this controller has {} poles, here are {}", count, polynomial.size() - 1));
  if (feeds_back) return state_feedback(placed(whole.A, whole.B, polynomial));
  if (n != count - 1)
    throw ScriptError(
        fmt::format("a {} controller places the poles of a model of order {}, this one has {}; use "
                    "controller = \"state_feedback\"",
                    controller, count - 1, n));
  return placed_pid(transfer_of(model), polynomial, derivative);
}

LinearModel linear_model_argument(lua_State* L, int index) {
  LinearModel model;
  const auto take = [&](const identify::StateSpaceModel& m) {
    model.A = dense_of(m.A), model.B = dense_of(m.B), model.C = dense_of(m.C), model.D = dense_of(m.D);
    model.period = m.Ts;
  };
  if (const auto* polynomial = test_object<Held<identify::PolynomialModel>>(L, index, linear_kind)) {
    take(identify::to_state_space(*polynomial->value));
    return model;
  }
  if (const auto* matrices = test_object<Held<identify::StateSpaceModel>>(L, index, state_space_kind)) {
    take(*matrices->value);
    return model;
  }
  if (!lua_istable(L, index))
    throw ScriptError(fmt::format("the model is what diagram:linearise gives, or an identified linear model; it is {}",
                                  describe(L, index)));
  const auto matrix = [&](const char* key) {
    lua_getfield(L, index, key);
    const MatrixXd m = matrix_view(array_argument(L, -1, key));
    lua_pop(L, 1);
    return m;
  };
  const MatrixXd A = matrix("A"), B = matrix("B"), C = matrix("C"), D = matrix("D");
  if (A.rows() != A.cols() || B.rows() != A.rows() || C.cols() != A.cols() || D.rows() != C.rows() ||
      D.cols() != B.cols())
    throw ScriptError("the matrices A, B, C and D of the model do not fit each other");
  model.A = dense_of(A), model.B = dense_of(B), model.C = dense_of(C), model.D = dense_of(D);
  lua_getfield(L, index, "period");
  model.period = lua_isnumber(L, -1) ? lua_tonumber(L, -1) : 0;
  lua_pop(L, 1);
  return model;
}

}  // namespace plantloop::lua
