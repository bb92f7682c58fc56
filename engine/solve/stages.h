// One step of an explicit Runge-Kutta method, and the dense output of the last one: what the fixed-step and the
// adaptive integrator share.

#pragma once

#include <cstdint>
#include <vector>

#include "engine/solve/integrator.h"
#include "engine/solve/passes.h"
#include "engine/solve/tableau.h"

namespace plantloop {

class Stages {
 public:
  Stages(OdeSystem& system, const Tableau& tableau);
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;

  // The state was set anew: no derivative is known, there is no last step.
  void forget() { has_start_ = has_stages_ = has_end_ = has_after_ = dense_ = false; }
  // To be called before each step: the state is x(time) again, and the derivative at the end of the last step becomes
  // the one at the start of this.
  void begin() {
    if (has_after_) copy(x1_.data(), state());
    has_start_ = has_end_;
    if (has_end_) std::swap(k_.front(), k_.back());
    has_stages_ = has_end_ = has_after_ = dense_ = false;
  }

  // From (t, state()) to t_end = t + h, by the method or, when the system can, by its own fixed_step().
  void fixed(double t, double t_end, double h) {
    if (!try_program_ || !by_program(t, h)) by_method(t, t_end, h);
  }

  // For error control: keeps x(t) in before() and its derivative (computing it where it is not known) ...
  void prepare(double t);
  // ... tries the step, any number of times: state() is x(t_end) and end_derivative() is f there ...
  void attempt(double t, double t_end, double h);
  // ... and gives x(t) back.
  void revert();
  // The step is over: what interpolate() speaks of.
  void finish(double t, double t_end, double h) { t0_ = t, t1_ = t_end, h_ = h; }

  // x(t) inside the last step; at its ends exactly.
  void interpolate(double t, double* x);

  std::size_t size() const { return n_; }
  double* state() { return state_; }
  const double* before() const { return x0_.data(); }
  const double* start_derivative() const { return k_.front(); }
  const double* end_derivative() const { return k_.back(); }
  // h times the weights of the error estimate, ready for a pass.
  Terms error_terms(double h) const;
  // f(t, state()), counted.
  const double* derivatives(double t);

  SolverStatistics statistics;

 private:
  // On small models everything beside the step itself counts, so this is all in line.
  bool by_program(double t, double h) {
    copy(state_, x0_.data());
    try {
      if (!system_.fixed_step(tableau_.name, t, h)) return try_program_ = false;
    } catch (...) {
      revert();
      throw;
    }
    statistics.evaluations += stage_count_;
    return true;
  }
  void by_method(double t, double t_end, double h);
  void copy(const double* from, double* to) const {
    for_each_state(n_, [from, to](std::size_t i) { to[i] = from[i]; });
  }
  void low_storage(double t, double t_end, double h, const double* first);
  void general(double t, double t_end, double h, const double* first);
  void make_dense();

  OdeSystem& system_;
  const Tableau& tableau_;
  std::size_t n_;
  std::int64_t stage_count_;
  double* state_;  // of the system
  bool low_storage_;
  // The table's numbers for low_storage(): weight in the result, in the next stage's state, and time of each stage.
  struct Stage {
    double b = 0, next = 0, c = 0;
  };
  std::vector<Stage> table_;
  bool try_program_ = true;  // the system has not yet said that it has no fixed_step()

  std::vector<double> room_;  // all arrays below stand in here
  std::vector<double*> k_;    // k_1 ... k_s and the derivative at the end
  std::vector<double> x0_, x1_, accumulated_;
  std::vector<double> d1_, d2_, d3_, d4_;  // coefficients of the dense output
  bool has_start_ = false;                 // k_.front() is the derivative at the start of the step
  bool has_stages_ = false;                // k_ holds all stages of the last step
  bool has_end_ = false;                   // k_.back() is the derivative at its end
  bool has_after_ = false;                 // x1_ is the state at its end
  bool dense_ = false;                     // d1_ ... d4_ belong to it
  double t0_ = 0, t1_ = 0, h_ = 0;
};

}  // namespace plantloop
