// The one small interface behind which every integration method stands, ours and SUNDIALS'.

#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/error.h"

namespace plantloop {

// The pattern of a sparse matrix by columns (compressed, rows ascending).
struct SparsityPattern {
  int size = 0;
  std::vector<int> column_start;  // size + 1
  std::vector<int> row;
};

// x' = f(t, x) with modes and held values frozen. The solver writes the state in place, so that nothing is copied.
class OdeSystem {
 public:
  virtual ~OdeSystem() = default;
  virtual int size() const = 0;
  // Where x stands, always the same place: the solver writes here before each call, and x(t) is here after a step.
  virtual double* state() = 0;
  virtual const double* derivatives(double t) = 0;  // f(t, state()); valid until the next call
  // df/dx at (t, state()); null pattern: not available, the solver differences f itself.
  virtual const SparsityPattern* pattern() const { return nullptr; }
  virtual const double* jacobian(double t) {  // the pattern's entries; valid until the next call
    (void)t;
    return nullptr;
  }
  // The system as equations x' = f(t, x, z), 0 = g(t, x, z), where z are unknowns that `derivatives` finds by itself.
  // How many there are; the values that satisfy g as last accepted; and those of an accepted step, to begin at.
  virtual int algebraic_size() const { return 0; }
  virtual const double* algebraic() { return nullptr; }
  virtual void take_algebraic(const double* z) { (void)z; }
  // f, then g, at (t, state(), z); valid until the next call.
  virtual const double* equations(double t, const double* z) {
    (void)z;
    return derivatives(t);
  }
  // d(f, g)/d(x, z) at (t, state(), z); null: not available, the solver differences.
  virtual const SparsityPattern* equations_pattern() const { return pattern(); }
  virtual const double* equations_jacobian(double t, const double* z) {
    (void)z;
    return jacobian(t);
  }
  // A whole fixed step of the named method from (t, state()) with size h, recorded as one Program: true when it was
  // done, and then state() holds x(t + h). `derivatives` need not have been called.
  virtual bool fixed_step(std::string_view method, double t, double h) {
    (void)method, (void)t, (void)h;
    return false;
  }
};

struct SolverOptions {
  std::string solver = "dopri5";  // euler, heun, rk4, bogacki_shampine, dopri5, adams, bdf, ida
  double start = 0, stop = 1;     // s; fixed-step methods use the grid start + k step
  double step = 0;                // > 0: fixed step (explicit methods); 0: adaptive
  double rtol = 1e-6, atol = 1e-9;
  double max_step = 0;    // 0: no limit
  double first_step = 0;  // 0: chosen
};

struct SolverStatistics {
  std::int64_t steps = 0, rejected = 0, evaluations = 0, jacobians = 0, cold_restarts = 0, hot_restarts = 0;
};

// One state is to blame: its derivative is not finite, or it forces the step size to nothing. The message names it by
// its number; the caller knows its name.
class StateError : public RunError {
 public:
  StateError(const std::string& message, double time, int state) : RunError(message, time), state_(state) {}
  int state() const { return state_; }  // index into OdeSystem::state()

 private:
  int state_;
};

// Advances the state of one system. Not copyable; `clone state` comes with checkpoints.
class Integrator {
 public:
  virtual ~Integrator() = default;
  // The state of the system was set or changed at time t: forget the past.
  virtual void restart(double t) = 0;
  // One accepted step that does not pass t_stop; returns the time reached, which is exactly t_stop if the step ends
  // there. The state of the system is x(time). Throws StateError when the step size collapses or a derivative is not
  // finite, RunError when the method fails; then the state of the system is x at the start of the step.
  virtual double step(double t_stop) = 0;
  // x inside the last step, t in [time before, time after], to the order of the method's dense output; exact at both
  // ends. `x` may be the system's state(): the next step() puts x(time after) back. Derivatives are evaluated where
  // they are missing, so modes and held values must still be those of the step.
  virtual void interpolate(double t, double* x) = 0;
  // Tells the longest step allowed from now on (delays); infinity: none.
  virtual void limit_step(double longest) = 0;
  virtual const SolverStatistics& statistics() const = 0;
};

// Names and one line each, for `--help`, schema and errors.
struct SolverInfo {
  std::string_view name;
  std::string_view summary;
  int order = 0;
  bool fixed = false;     // can run with `step`
  bool adaptive = false;  // can control its error
};
const std::vector<SolverInfo>& solvers();

// Throws std::invalid_argument for a solver that solvers() does not list (elaboration has checked the name).
std::unique_ptr<Integrator> make_integrator(OdeSystem& system, const SolverOptions& options);

}  // namespace plantloop
