// Steps on the grid start + k step: a stop between two grid points is reached by a shortened step, and the next step
// ends on the grid again. Grid times are computed from k, never accumulated.

#include "engine/solve/fixed_step.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <limits>

#include "engine/solve/passes.h"

namespace plantloop {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

FixedStep::FixedStep(OdeSystem& system, const Tableau& tableau, const SolverOptions& options)
    : stages_(system, tableau),
      start_(options.start),
      step_(options.step),
      max_step_(options.max_step > 0 ? options.max_step : infinity),
      limit_(infinity),
      t_(options.start) {
  find_next();
}

void FixedStep::restart(double t) {
  stages_.forget();
  ++stages_.statistics.cold_restarts;
  t_ = t;
  find_next();
}

// Sets next_, on_grid_ and tolerance_ for t_. A stop that misses a grid point by rounding only is that grid point.
void FixedStep::find_next() {
  tolerance_ = std::max(1e-10 * step_, 4 * epsilon * std::max(std::abs(t_), std::abs(start_)));
  next_ = static_cast<std::int64_t>(std::floor((t_ - start_) / step_));
  while (grid(next_) <= t_ + tolerance_) ++next_;
  on_grid_ = std::abs(t_ - grid(next_ - 1)) <= tolerance_;
}

double FixedStep::step(double t_stop) {
  assert(t_stop > t_);
  stages_.begin();
  const double t = t_;
  double end = grid(next_);
  double h = on_grid_ ? step_ : end - t;
  bool reaches_grid = true;
  if (end > t_stop + tolerance_) {
    end = t_stop;
    h = end - t;
    reaches_grid = false;
  } else if (end >= t_stop - tolerance_) {
    end = t_stop;
  }
  if (const double longest = std::min(limit_, max_step_); h > longest * (1 + 4 * epsilon)) {
    h /= std::ceil(h / longest * (1 - 4 * epsilon));
    end = t + h;
    reaches_grid = false;
  }
  stages_.fixed(t, end, h);
  stages_.finish(t, end, h);
  check_finite(end);
  ++stages_.statistics.steps;
  t_ = end;
  if (reaches_grid) {
    ++next_;
    on_grid_ = true;
  } else {
    find_next();
  }
  return end;
}

void FixedStep::check_finite(double t) {
  const double* const x = stages_.state();
  if (all_finite(stages_.size(), x)) return;
  const std::size_t state = first_not_finite(stages_.size(), x);
  stages_.revert();
  throw StateError(fmt::format("state {} is not finite at t = {} s; the step of {} s may be too long", state, t, step_),
                   t, static_cast<int>(state));
}

}  // namespace plantloop
