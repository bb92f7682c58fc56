// Steps as long as the tolerance allows, by an embedded method.

#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include "engine/solve/stages.h"

namespace plantloop {

class Adaptive final : public Integrator {
 public:
  Adaptive(OdeSystem& system, const Tableau& tableau, const SolverOptions& options);
  void restart(double t) override;
  double step(double t_stop) override;
  void interpolate(double t, double* x) override { stages_.interpolate(t, x); }
  void limit_step(double longest) override { limit_ = longest; }
  const SolverStatistics& statistics() const override { return stages_.statistics; }

 private:
  double longest() const { return std::min(limit_, max_step_); }
  double least_step() const { return std::max(16 * std::numeric_limits<double>::epsilon() * std::abs(t_), smallest_); }
  double first_step(double room);
  double fit(double h, double room) const;
  double attempt(double t_end, double h);
  double error_norm(double h);
  [[noreturn]] void collapse(double h);

  Stages stages_;
  double order_;  // of the estimate, plus 1: the error falls with this power of h
  double rtol_, atol_, max_step_, first_step_, smallest_;
  double limit_;
  double t_;
  double h_ = 0;                // what the controller wants next; 0: choose
  double last_error_ = 0;       // of the last accepted step
  std::exception_ptr failure_;  // why the derivatives of the last attempt could not be computed
};

}  // namespace plantloop
