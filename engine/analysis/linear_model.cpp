// Poles, zeros and frequency response of a linear model; margins by bisection between the points of a fine grid.

#include "engine/analysis/linear_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plantloop {

namespace {

using Complex = std::complex<double>;
constexpr double degrees = 180 / std::numbers::pi;

Complex loop_gain(const LinearModel& model, double omega) { return response(model, omega).front(); }

// Where a function of the frequency changes its sign between two frequencies.
template <typename Function>
double bisect(double low, double high, Function f) {
  const bool rising = f(high) > 0;
  for (int i = 0; i < 200; ++i) {
    const double middle = std::sqrt(low * high);
    if (!(middle > low && middle < high)) break;
    ((f(middle) > 0) == rising ? high : low) = middle;
  }
  return std::sqrt(low * high);
}

// The frequency of a pole or zero, in rad/s.
double speed_of(Complex root, double period) {
  if (period <= 0) return std::abs(root);
  return std::abs(root) > 0 ? std::abs(std::log(root)) / period : 0;
}

// exp(A t) and the integral of exp(A s) B over s from 0 to t: both stand in exp([A, B; 0, 0] t) (C. Van Loan 1978).
struct Held {
  DenseMatrix states, inputs;
};
Held held(const LinearModel& model, double t) {
  const std::size_t n = model.A.rows, m = model.B.columns;
  DenseMatrix both(n + m, n + m);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) both(i, j) = model.A(i, j);
    for (std::size_t j = 0; j < m; ++j) both(i, n + j) = model.B(i, j);
  }
  const DenseMatrix whole = exponential(both, t);
  return {whole.block(0, 0, n, n), whole.block(0, n, n, m)};
}

void put(DenseMatrix& into, std::size_t row, std::size_t column, const DenseMatrix& part) {
  for (std::size_t i = 0; i < part.rows; ++i) {
    for (std::size_t j = 0; j < part.columns; ++j) into(row + i, column + j) += part(i, j);
  }
}

}  // namespace

LinearModel sampled(const LinearModel& model, double period, double dead_time, const std::vector<double>& u) {
  const std::size_t n = model.A.rows, m = model.B.columns;
  // u(k) reaches the model `whole` samples and `part` seconds later. Quotients off a whole number by rounding are it.
  const double whole = std::floor(dead_time / period + 1e-9);
  const double rest = dead_time - whole * period, part = rest > 1e-9 * period ? rest : 0;
  const auto d = static_cast<std::size_t>(whole), late = d + (part > 0 ? 1 : 0), total = n + late * m;
  const Held over = held(model, period), first = held(model, part), second = held(model, period - part);
  LinearModel result = model;
  result.period = period;
  result.A = DenseMatrix(total, total);
  result.B = DenseMatrix(total, m);
  result.C = DenseMatrix(model.C.rows, total);
  result.D = DenseMatrix(model.C.rows, m);
  // The matrix and the column at which u(k - lag) stands.
  const auto add = [&](DenseMatrix& by_state, DenseMatrix& by_input, std::size_t row, std::size_t lag,
                       const DenseMatrix& gain) {
    if (lag == 0) {
      put(by_input, row, 0, gain);
    } else {
      put(by_state, row, n + (lag - 1) * m, gain);
    }
  };
  put(result.A, 0, 0, over.states);
  add(result.A, result.B, 0, d, second.inputs);
  if (part > 0) add(result.A, result.B, 0, d + 1, product(second.states, first.inputs));
  for (std::size_t lag = 1; lag <= late; ++lag)
    add(result.A, result.B, n + (lag - 1) * m, lag - 1, DenseMatrix::identity(m));
  put(result.C, 0, 0, model.C);
  add(result.C, result.D, 0, late, model.D);
  for (std::size_t lag = 1; lag <= late; ++lag) {
    for (std::size_t j = 0; j < m; ++j) {
      result.states.push_back(model.inputs[j] + " " + std::to_string(lag) + " late");
      result.x.push_back(u[j]);
    }
  }
  return result;
}

std::vector<Complex> poles(const LinearModel& model) { return eigenvalues(model.A); }

std::vector<Complex> zeros(const LinearModel& model) { return invariant_zeros(model.A, model.B, model.C, model.D); }

std::vector<Complex> response(const LinearModel& model, double omega) {
  const Complex s = model.period > 0 ? std::polar(1.0, omega * model.period) : Complex(0, omega);
  return transfer(model.A, model.B, model.C, model.D, s);
}

std::vector<double> gains_at_rest(const LinearModel& model) {
  std::vector<double> gains;
  bool singular = false;
  for (const Complex g : transfer(model.A, model.B, model.C, model.D, model.period > 0 ? 1.0 : 0.0)) {
    gains.push_back(g.real());
    singular = singular || !std::isfinite(g.real());
  }
  if (!singular) return gains;
  // A pole at rest may be cancelled by a zero: then the response has a limit, g + a omega^2 + ..., which two slow
  // frequencies tell (L. F. Richardson).
  const double slow = 1e-2 * frequencies_for(model, 1).front();
  const std::vector<Complex> here = response(model, slow), nearer = response(model, slow / 2);
  for (std::size_t i = 0; i < gains.size(); ++i) {
    const double limit = (4 * nearer[i].real() - here[i].real()) / 3;
    if (!std::isfinite(gains[i]) && std::abs(nearer[i] - here[i]) <= 1e-3 * std::abs(limit)) gains[i] = limit;
  }
  return gains;
}

std::vector<double> frequencies_for(const LinearModel& model, std::size_t count) {
  double slowest = INFINITY, fastest = 0;
  std::vector<Complex> roots = poles(model);
  for (const Complex zero : zeros(model)) roots.push_back(zero);
  for (const Complex root : roots) {
    const double speed = speed_of(root, model.period);
    if (!(speed > 1e-9) || !std::isfinite(speed)) continue;
    slowest = std::min(slowest, speed);
    fastest = std::max(fastest, speed);
  }
  if (fastest == 0) slowest = fastest = 1;
  double low = slowest / 10, high = fastest * 10;
  if (model.period > 0) {  // beyond half the sampling frequency it repeats
    high = std::numbers::pi / model.period;
    low = std::min(low, high / 100);
  }
  std::vector<double> frequencies;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0;
    frequencies.push_back(low * std::pow(high / low, share));
  }
  return frequencies;
}

Margins margins(const LinearModel& model) {
  constexpr std::size_t points = 4000;
  Margins found;
  const std::vector<double> grid = frequencies_for(model, points);
  const auto log_magnitude = [&](double w) { return std::log(std::abs(loop_gain(model, w))); };
  const auto imaginary = [&](double w) { return loop_gain(model, w).imag(); };
  Complex before = loop_gain(model, grid[0]);
  for (std::size_t i = 1; i < grid.size(); ++i) {
    const Complex here = loop_gain(model, grid[i]);
    if ((std::abs(before) > 1) != (std::abs(here) > 1)) {
      const double w = bisect(grid[i - 1], grid[i], log_magnitude);
      double phase = 180 + std::arg(loop_gain(model, w)) * degrees;
      if (phase > 180) phase -= 360;
      if (!found.phase || std::fabs(phase) < std::fabs(*found.phase)) {
        found.phase = phase;
        found.gain_crossover = w;
        found.delay = (phase > 0 ? phase : phase + 360) / degrees / w;
      }
    }
    const bool crosses = (before.imag() > 0) != (here.imag() > 0) && before.real() < 0 && here.real() < 0;
    if (crosses) {
      const double w = bisect(grid[i - 1], grid[i], imaginary);
      const double gain = 1 / std::abs(loop_gain(model, w));
      if (!found.gain || std::fabs(std::log(gain)) < std::fabs(std::log(*found.gain))) {
        found.gain = gain;
        found.phase_crossover = w;
      }
    }
    before = here;
  }
  // A sampled loop ends at half the sampling frequency, where its gain is real.
  if (model.period > 0 && before.real() < 0) {
    const double gain = 1 / std::abs(before.real());
    if (!found.gain || std::fabs(std::log(gain)) < std::fabs(std::log(*found.gain))) {
      found.gain = gain;
      found.phase_crossover = grid.back();
    }
  }
  return found;
}

}  // namespace plantloop
