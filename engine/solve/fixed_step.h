// Steps on the grid start + k step, without error control.

#pragma once

#include <cstdint>

#include "engine/solve/stages.h"

namespace plantloop {

class FixedStep final : public Integrator {
 public:
  FixedStep(OdeSystem& system, const Tableau& tableau, const SolverOptions& options);
  void restart(double t) override;
  double step(double t_stop) override;
  void interpolate(double t, double* x) override { stages_.interpolate(t, x); }
  void limit_step(double longest) override { limit_ = longest; }
  const SolverStatistics& statistics() const override { return stages_.statistics; }

 private:
  double grid(std::int64_t k) const { return start_ + static_cast<double>(k) * step_; }
  void find_next();
  void check_finite(double t);

  Stages stages_;
  double start_, step_, max_step_;
  double limit_;
  double t_;
  double tolerance_ = 0;   // two times this near are one
  bool on_grid_ = false;   // t_ is the grid point before next_
  std::int64_t next_ = 1;  // the first grid point after t_
};

}  // namespace plantloop
