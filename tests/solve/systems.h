// Differential equations with known solutions, written by hand: what the integrators are tested against.

#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "engine/solve/integrator.h"

namespace plantloop::testing {

// x' = f(t, x) from a function that writes the derivatives.
class HandWritten : public OdeSystem {
 public:
  using Right = std::function<void(double t, const std::vector<double>& x, std::vector<double>& rate)>;
  HandWritten(std::vector<double> initial, Right right)
      : x(std::move(initial)), rate_(x.size()), right_(std::move(right)) {}
  int size() const override { return static_cast<int>(x.size()); }
  double* state() override { return x.data(); }
  const double* derivatives(double t) override {
    right_(t, x, rate_);
    return rate_.data();
  }

  std::vector<double> x;

 private:
  std::vector<double> rate_;
  Right right_;
};

// x' = -x y, y' = ... the logistic equation beside a driven one: nonlinear, not autonomous, both with closed forms.
//   u' = u (1 - u)            u = 1 / (1 + 9 exp(-t)),   u(0) = 0.1
//   v' = -2 t v^2             v = 1 / (1 + t^2),         v(0) = 1
inline HandWritten logistic_and_bell() {
  return HandWritten({0.1, 1}, [](double t, const std::vector<double>& x, std::vector<double>& rate) {
    rate[0] = x[0] * (1 - x[0]);
    rate[1] = -2 * t * x[1] * x[1];
  });
}
inline std::vector<double> logistic_and_bell_at(double t) { return {1 / (1 + 9 * std::exp(-t)), 1 / (1 + t * t)}; }

// A chain of first-order lags x_i' = (x_(i-1) - x_i) / tau, x_0 = 1, from rest, with its exact sparse Jacobian.
//   x_n(t) = 1 - exp(-t / tau) sum_(k < n) (t / tau)^k / k!
class Chain final : public OdeSystem {
 public:
  explicit Chain(int n, double tau = 1, bool with_pattern = true)
      : x(static_cast<std::size_t>(n)), tau_(tau), rate_(x.size()), with_pattern_(with_pattern) {
    pattern_.size = n;
    for (int i = 0; i < n; ++i) {
      pattern_.column_start.push_back(static_cast<int>(pattern_.row.size()));
      pattern_.row.push_back(i);
      values_.push_back(-1 / tau);
      if (i + 1 < n) {
        pattern_.row.push_back(i + 1);
        values_.push_back(1 / tau);
      }
    }
    pattern_.column_start.push_back(static_cast<int>(pattern_.row.size()));
  }
  int size() const override { return static_cast<int>(x.size()); }
  double* state() override { return x.data(); }
  const double* derivatives(double) override {
    rate_[0] = (1 - x[0]) / tau_;
    for (std::size_t i = 1; i < x.size(); ++i) rate_[i] = (x[i - 1] - x[i]) / tau_;
    return rate_.data();
  }
  const SparsityPattern* pattern() const override { return with_pattern_ ? &pattern_ : nullptr; }
  const double* jacobian(double) override {
    ++jacobians;
    return values_.data();
  }
  double exact(std::size_t n, double t) const {
    double term = 1, sum = 0;
    for (std::size_t k = 0; k < n; ++k) {
      sum += term;
      term *= t / tau_ / static_cast<double>(k + 1);
    }
    return 1 - std::exp(-t / tau_) * sum;
  }

  std::vector<double> x;
  int jacobians = 0;

 private:
  double tau_;
  std::vector<double> rate_, values_;
  SparsityPattern pattern_;
  bool with_pattern_;
};

// Steps to `stop`; the largest error of the states at the steps' ends against the closed form.
template <typename Exact>
double run_to(Integrator& integrator, OdeSystem& system, double stop, Exact exact) {
  double worst = 0;
  for (double t = -std::numeric_limits<double>::infinity(); t < stop;) {
    t = integrator.step(stop);
    const std::vector<double> x = exact(t);
    for (std::size_t i = 0; i < x.size(); ++i) worst = std::max(worst, std::abs(system.state()[i] - x[i]));
  }
  return worst;
}

}  // namespace plantloop::testing
