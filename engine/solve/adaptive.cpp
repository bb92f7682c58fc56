// Error control: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4 (norm, starting step) and
// Hairer, Wanner II, IV.2 (PI controller).

#include "engine/solve/adaptive.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <limits>

#include "engine/solve/passes.h"

namespace plantloop {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double safety = 0.9;
constexpr double most_shrink = 0.2;
constexpr double most_growth = 10;

}  // namespace

Adaptive::Adaptive(OdeSystem& system, const Tableau& tableau, const SolverOptions& options)
    : stages_(system, tableau),
      order_(tableau.error_order + 1),
      rtol_(options.rtol),
      atol_(options.atol),
      max_step_(options.max_step > 0 ? options.max_step : infinity),
      first_step_(options.first_step),
      smallest_(1e-3 * epsilon * (options.stop - options.start)),
      limit_(infinity),
      t_(options.start) {}

void Adaptive::restart(double t) {
  stages_.forget();
  ++stages_.statistics.cold_restarts;
  t_ = t;
  h_ = 0;
}

double Adaptive::step(double t_stop) {
  assert(t_stop > t_);
  stages_.begin();
  stages_.prepare(t_);
  if (h_ <= 0) h_ = first_step(t_stop - t_);
  // A step cut by a near stop says nothing about how short the next one must be.
  h_ = std::max(h_, 2 * least_step());
  const double alpha = 1 / order_;
  const double beta = 0.2 * alpha;
  const double wanted = std::min(h_, longest());
  double h = fit(wanted, t_stop - t_);
  for (bool rejected = false;; rejected = true) {
    if (h < least_step() && h < t_stop - t_) collapse(h);
    const double t_end = h == t_stop - t_ ? t_stop : t_ + h;
    const double error = attempt(t_end, h);
    if (error <= 1) {
      double factor = most_growth;
      if (error > 0) {
        factor = safety * std::pow(error, -(alpha - 0.75 * beta)) * std::pow(std::max(last_error_, 1e-4), beta);
        factor = std::clamp(factor, most_shrink, rejected ? 1.0 : most_growth);
      }
      // A step that was cut by a stop says nothing against the length wanted before.
      h_ = factor >= 1 && !rejected ? std::max(wanted, h * factor) : h * factor;
      last_error_ = error;
      stages_.finish(t_, t_end, h);
      ++stages_.statistics.steps;
      return t_ = t_end;
    }
    ++stages_.statistics.rejected;
    const double factor = std::isfinite(error) ? safety * std::pow(error, -alpha) : most_shrink;
    h = fit(h * std::clamp(factor, most_shrink, safety), t_stop - t_);
  }
}

// The starting step of Hairer, Norsett, Wanner II.4, at most `room`. Also starts the controller anew, so that a run
// continued from a saved state takes the same steps.
double Adaptive::first_step(double room) {
  const std::size_t n = stages_.size();
  const double* const x = stages_.before();
  const double* const f = stages_.start_derivative();
  if (!all_finite(n, f)) {
    const std::size_t state = first_not_finite(n, f);
    throw StateError(fmt::format("the derivative of state {} is not finite at t = {} s", state, t_), t_,
                     static_cast<int>(state));
  }
  last_error_ = 1e-4;
  room = std::min(room, longest());
  if (first_step_ > 0) return std::min(first_step_, room);
  const auto scale = [=, this](std::size_t i) { return atol_ + rtol_ * std::abs(x[i]); };
  const double d0 = root_mean_square(n, [=](std::size_t i) { return x[i] / scale(i); });
  const double d1 = root_mean_square(n, [=](std::size_t i) { return f[i] / scale(i); });
  const double h0 = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
  if (h0 >= room) return room;
  double d2 = infinity;
  try {
    double* const ahead = stages_.state();
    for_each_state(n, [=](std::size_t i) { ahead[i] = x[i] + h0 * f[i]; });
    const double* const g = stages_.derivatives(t_ + h0);
    d2 = root_mean_square(n, [=](std::size_t i) { return (g[i] - f[i]) / scale(i); }) / h0;
  } catch (const LimitError&) {
    stages_.revert();
    throw;
  } catch (const RunError&) {
    d2 = infinity;
  }
  stages_.revert();
  if (!std::isfinite(d2)) return h0;
  const double steepest = std::max(d1, d2);
  const double h1 = steepest <= 1e-15 ? std::max(1e-6, h0 * 1e-3) : std::pow(0.01 / steepest, 1 / order_);
  return std::min({100 * h0, h1, room});
}

// Ends on the stop when it is near, and goes halfway when one full step would leave a stub.
double Adaptive::fit(double h, double room) const {
  if (h >= room || (1.1 * h >= room && room <= longest())) return room;
  return 2 * h > room ? 0.5 * room : h;
}

// The error of the step in units of the tolerance; infinite when the derivatives cannot be computed there.
double Adaptive::attempt(double t_end, double h) {
  failure_ = nullptr;
  try {
    stages_.attempt(t_, t_end, h);
  } catch (const LimitError&) {
    stages_.revert();
    throw;
  } catch (const RunError&) {
    failure_ = std::current_exception();
    stages_.revert();
    return infinity;
  } catch (...) {
    stages_.revert();
    throw;
  }
  const double error = error_norm(h);
  if (error <= 1 && all_finite(stages_.size(), stages_.state())) return error;
  return error > 1 ? error : infinity;
}

double Adaptive::error_norm(double h) {
  const std::size_t n = stages_.size();
  const double* const x0 = stages_.before();
  const double* const x1 = stages_.state();
  double norm = 0;
  with_terms(stages_.error_terms(h), [&](auto sum) {
    norm = root_mean_square(n, [=, rtol = rtol_, atol = atol_](std::size_t i) {
      return sum(i, 0.0) / (atol + rtol * std::max(std::abs(x0[i]), std::abs(x1[i])));
    });
  });
  return norm;
}

// The step size has come to nothing: names the state that allows the shortest step.
void Adaptive::collapse(double h) {
  const std::size_t n = stages_.size();
  const double* const x0 = stages_.before();
  std::size_t worst = 0;
  if (!failure_) {
    double most = -1;
    const double* const x1 = stages_.state();
    with_terms(stages_.error_terms(h), [&](auto sum) {
      for (std::size_t i = 0; i < n; ++i) {
        const double error = std::abs(sum(i, 0.0)) / (atol_ + rtol_ * std::max(std::abs(x0[i]), std::abs(x1[i])));
        if (!(error <= most)) {
          worst = i;
          most = std::isnan(error) ? infinity : error;
        }
      }
    });
  }
  stages_.revert();
  if (failure_) std::rethrow_exception(failure_);
  throw StateError(
      fmt::format("the step size collapsed to {:.3g} s at t = {} s: state {} changes too fast there", h, t_, worst), t_,
      static_cast<int>(worst));
}

}  // namespace plantloop
