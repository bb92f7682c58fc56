// The door to SUNDIALS' CVODE: its Adams and BDF methods, one step at a time.

#include "engine/solve/cvode.h"

#include <cvode/cvode.h>
#include <fmt/format.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <cassert>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>

#include "engine/solve/passes.h"
#include "engine/solve/sundials.h"

namespace plantloop {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double epsilon = std::numeric_limits<double>::epsilon();

struct FreeMemory {
  void operator()(void* memory) const { CVodeFree(&memory); }
};
// The pattern with every diagonal entry, as I - gamma J has it, and where each entry of the system's pattern goes.
struct Pattern {
  std::vector<sunindextype> column_start, row;
  std::vector<std::size_t> place;
};

Pattern with_diagonal(const SparsityPattern& given) {
  Pattern full;
  full.column_start.push_back(0);
  for (int column = 0; column < given.size; ++column) {
    const auto index = static_cast<std::size_t>(column);
    bool has_diagonal = false;
    for (int at = given.column_start[index]; at < given.column_start[index + 1]; ++at) {
      const int row = given.row[static_cast<std::size_t>(at)];
      if (row > column && !has_diagonal) {
        full.row.push_back(column);
        has_diagonal = true;
      }
      has_diagonal = has_diagonal || row == column;
      full.place.push_back(full.row.size());
      full.row.push_back(row);
    }
    if (!has_diagonal) full.row.push_back(column);
    full.column_start.push_back(static_cast<sunindextype>(full.row.size()));
  }
  return full;
}

class Cvode final : public Integrator {
 public:
  Cvode(OdeSystem& system, const SolverOptions& options);
  void restart(double t) override;
  double step(double t_stop) override;
  void interpolate(double t, double* x) override;
  void limit_step(double longest) override;
  const SolverStatistics& statistics() const override;

 private:
  static int evaluate(sunrealtype t, N_Vector x, N_Vector rate, void* self);
  static int dense_jacobian(sunrealtype t, N_Vector x, N_Vector rate, SUNMatrix out, void* self, N_Vector, N_Vector,
                            N_Vector);
  static int sparse_jacobian(sunrealtype t, N_Vector x, N_Vector rate, SUNMatrix out, void* self, N_Vector, N_Vector,
                             N_Vector);
  template <typename Body>
  int guarded(Body body);
  void check(int flag) const;
  void make_linear_solver();
  void euler_to(double t_stop);
  const double* derivatives_here();
  int fastest_state();
  [[noreturn]] void fail(int flag);

  OdeSystem& system_;
  std::size_t n_;
  bool stiff_;
  double rtol_, atol_, max_step_, first_step_;
  double limit_ = infinity;

  Owned<SUNContext, FreeContext> context_;
  Owned<N_Vector, FreeVector> vector_;
  Owned<SUNMatrix, FreeMatrix> matrix_;
  Owned<SUNLinearSolver, FreeLinear> linear_;
  Owned<SUNNonlinearSolver, FreeNonlinear> nonlinear_;
  Owned<void*, FreeMemory> memory_;
  Pattern pattern_;

  double* x_ = nullptr;         // vector_'s entries: the state at t_
  std::vector<double> before_;  // the state at t_before_
  double t_, t_before_;
  bool cold_ = true;            // CVODE must be told the state anew
  bool by_euler_ = false;       // the last step was too short for CVODE
  std::exception_ptr failure_;  // the last in this step; CVODE tried a shorter one
  int not_finite_ = -1;         // the state whose derivative was not finite, likewise
  mutable SolverStatistics statistics_;
  SolverStatistics earlier_;  // of CVODE's counters before the last restart
};

Cvode::Cvode(OdeSystem& system, const SolverOptions& options)
    : system_(system),
      n_(static_cast<std::size_t>(system.size())),
      stiff_(options.solver == "bdf"),
      rtol_(options.rtol),
      atol_(options.atol),
      max_step_(options.max_step > 0 ? options.max_step : infinity),
      first_step_(options.first_step),
      context_(make_context()),
      vector_(N_VNew_Serial(static_cast<sunindextype>(system.size()), context_.get())),
      before_(n_),
      t_(options.start),
      t_before_(options.start) {
  if (!vector_) throw std::bad_alloc();
  x_ = N_VGetArrayPointer(vector_.get());
  std::copy_n(system.state(), n_, x_);
  memory_.reset(CVodeCreate(stiff_ ? CV_BDF : CV_ADAMS, context_.get()));
  if (!memory_) throw std::bad_alloc();
#if SUNDIALS_VERSION_MAJOR < 7
  check(CVodeSetErrHandlerFn(memory_.get(), ignore_error, nullptr));
#endif
  check(CVodeInit(memory_.get(), evaluate, t_, vector_.get()));
  check(CVodeSetUserData(memory_.get(), this));
  check(CVodeSStolerances(memory_.get(), options.rtol, options.atol));
  check(CVodeSetMaxNumSteps(memory_.get(), -1));
  check(CVodeSetMaxHnilWarns(memory_.get(), -1));
  if (stiff_) {
    make_linear_solver();
    nonlinear_.reset(SUNNonlinSol_Newton(vector_.get(), context_.get()));
  } else {
    nonlinear_.reset(SUNNonlinSol_FixedPoint(vector_.get(), 0, context_.get()));
  }
  if (!nonlinear_) throw std::bad_alloc();
  check(CVodeSetNonlinearSolver(memory_.get(), nonlinear_.get()));
}

// Exact Jacobians by a dense or a sparse solver; differenced ones by a dense solver.
void Cvode::make_linear_solver() {
  const auto n = static_cast<sunindextype>(n_);
  const SparsityPattern* const given = system_.pattern();
  const bool sparse =
      given && n_ > widest_dense && given->row.size() + n_ < n_ * n_ / 4;  // else KLU has nothing to save
  if (sparse) {
    pattern_ = with_diagonal(*given);
    matrix_.reset(SUNSparseMatrix(n, n, static_cast<sunindextype>(pattern_.row.size()), CSC_MAT, context_.get()));
    if (!matrix_) throw std::bad_alloc();
    linear_.reset(SUNLinSol_KLU(vector_.get(), matrix_.get(), context_.get()));
  } else {
    matrix_.reset(SUNDenseMatrix(n, n, context_.get()));
    if (!matrix_) throw std::bad_alloc();
    linear_.reset(SUNLinSol_Dense(vector_.get(), matrix_.get(), context_.get()));
  }
  if (!linear_) throw std::bad_alloc();
  check(CVodeSetLinearSolver(memory_.get(), linear_.get(), matrix_.get()));
  if (given) check(CVodeSetJacFn(memory_.get(), sparse ? sparse_jacobian : dense_jacobian));
}

// Runs a callback's body: 0 done, 1 try a shorter step, -1 stop. No exception may cross SUNDIALS.
template <typename Body>
int Cvode::guarded(Body body) {
  try {
    return body();
  } catch (const LimitError&) {
    failure_ = std::current_exception();
    return -1;
  } catch (const RunError&) {
    failure_ = std::current_exception();
    return 1;
  } catch (...) {
    failure_ = std::current_exception();
    return -1;
  }
}

int Cvode::evaluate(sunrealtype t, N_Vector x, N_Vector rate, void* user) {
  auto& self = *static_cast<Cvode*>(user);
  return self.guarded([&] {
    std::copy_n(N_VGetArrayPointer(x), self.n_, self.system_.state());
    const double* const f = self.system_.derivatives(t);
    ++self.statistics_.evaluations;
    std::copy_n(f, self.n_, N_VGetArrayPointer(rate));
    if (all_finite(self.n_, f)) return 0;
    self.not_finite_ = static_cast<int>(first_not_finite(self.n_, f));
    return 1;
  });
}

int Cvode::dense_jacobian(sunrealtype t, N_Vector x, N_Vector, SUNMatrix out, void* user, N_Vector, N_Vector,
                          N_Vector) {
  auto& self = *static_cast<Cvode*>(user);
  return self.guarded([&] {
    std::copy_n(N_VGetArrayPointer(x), self.n_, self.system_.state());
    const SparsityPattern& pattern = *self.system_.pattern();
    const double* value = self.system_.jacobian(t);
    SUNMatZero(out);
    for (int column = 0; column < pattern.size; ++column) {
      sunrealtype* const to = SM_COLUMN_D(out, column);
      const auto index = static_cast<std::size_t>(column);
      for (int at = pattern.column_start[index]; at < pattern.column_start[index + 1]; ++at) {
        to[pattern.row[static_cast<std::size_t>(at)]] = *value++;
      }
    }
    return 0;
  });
}

int Cvode::sparse_jacobian(sunrealtype t, N_Vector x, N_Vector, SUNMatrix out, void* user, N_Vector, N_Vector,
                           N_Vector) {
  auto& self = *static_cast<Cvode*>(user);
  return self.guarded([&] {
    std::copy_n(N_VGetArrayPointer(x), self.n_, self.system_.state());
    const double* const value = self.system_.jacobian(t);
    const Pattern& pattern = self.pattern_;
    std::copy(pattern.column_start.begin(), pattern.column_start.end(), SUNSparseMatrix_IndexPointers(out));
    std::copy(pattern.row.begin(), pattern.row.end(), SUNSparseMatrix_IndexValues(out));
    sunrealtype* const to = SUNSparseMatrix_Data(out);
    std::fill_n(to, pattern.row.size(), 0.0);
    for (std::size_t i = 0; i < pattern.place.size(); ++i) to[pattern.place[i]] = value[i];
    return 0;
  });
}

void Cvode::restart(double t) {
  earlier_ = statistics();
  ++earlier_.cold_restarts;
  std::copy_n(system_.state(), n_, x_);
  t_ = t_before_ = t;
  cold_ = true;
}

void Cvode::limit_step(double longest) { limit_ = longest; }

// One step of Euler's method, for a way so short that CVODE cannot tell its ends apart.
void Cvode::euler_to(double t_stop) {
  const double* const f = derivatives_here();
  for (std::size_t i = 0; i < n_; ++i) x_[i] += (t_stop - t_) * f[i];
  earlier_ = statistics();
  ++earlier_.steps;
  cold_ = by_euler_ = true;
  t_ = t_stop;
}

double Cvode::step(double t_stop) {
  assert(t_stop > t_);
  t_before_ = t_;
  std::copy_n(x_, n_, before_.data());
  failure_ = nullptr;
  not_finite_ = -1;
  const double longest = std::min(limit_, max_step_);
  if (t_stop - t_ > longest) t_stop = t_ + longest;
  by_euler_ = false;
  if (cold_ && t_stop - t_ < 100 * epsilon * std::max(std::abs(t_), std::abs(t_stop))) {
    euler_to(t_stop);
  } else {
    if (cold_) {
      earlier_ = statistics();
      check(CVodeReInit(memory_.get(), t_, vector_.get()));
      check(CVodeSetInitStep(memory_.get(), std::min(first_step_, t_stop - t_)));
      cold_ = false;
    }
    check(CVodeSetStopTime(memory_.get(), t_stop));
    sunrealtype reached = t_;
    const auto no_progress = [&] { return reached - t_ < 4 * epsilon * std::abs(t_); };
    int flag = CVode(memory_.get(), t_stop, vector_.get(), &reached, CV_ONE_STEP);
    // CVODE goes on with steps too short to change the time, and only warns. It starts with such steps where a state is
    // near 0 and changes fast, and then leaves them soon.
    constexpr int most_short_steps = 20;
    for (int i = 0; flag == CV_SUCCESS && no_progress() && i < most_short_steps; ++i)
      flag = CVode(memory_.get(), t_stop, vector_.get(), &reached, CV_ONE_STEP);
    if (flag < 0) fail(flag);
    if (flag != CV_TSTOP_RETURN && no_progress()) fail(CV_ERR_FAILURE);
    t_ = flag == CV_TSTOP_RETURN ? t_stop : reached;
  }
  std::copy_n(x_, n_, system_.state());
  return t_;
}

void Cvode::interpolate(double t, double* x) {
  if (t >= t_) {
    std::copy_n(x_, n_, x);
  } else if (t <= t_before_) {
    std::copy_n(before_.data(), n_, x);
  } else if (by_euler_) {
    const double s = (t - t_before_) / (t_ - t_before_);
    for (std::size_t i = 0; i < n_; ++i) x[i] = before_[i] + s * (x_[i] - before_[i]);
  } else {
    const Owned<N_Vector, FreeVector> out(N_VMake_Serial(static_cast<sunindextype>(n_), x, context_.get()));
    check(CVodeGetDky(memory_.get(), t, 0, out.get()));
  }
}

const SolverStatistics& Cvode::statistics() const {
  const std::int64_t evaluations = statistics_.evaluations;
  statistics_ = earlier_;
  statistics_.evaluations = evaluations;
  if (cold_) return statistics_;
  long steps = 0, error_failures = 0, convergence_failures = 0, jacobians = 0;
  CVodeGetNumSteps(memory_.get(), &steps);
  CVodeGetNumErrTestFails(memory_.get(), &error_failures);
  CVodeGetNumNonlinSolvConvFails(memory_.get(), &convergence_failures);
  if (stiff_) CVodeGetNumJacEvals(memory_.get(), &jacobians);
  statistics_.steps += steps;
  statistics_.rejected += error_failures + convergence_failures;
  statistics_.jacobians += jacobians;
  return statistics_;
}

// A call that cannot fail but for our own mistakes and for want of memory.
void Cvode::check(int flag) const {
  if (flag == CV_MEM_FAIL) throw std::bad_alloc();
  assert(flag >= 0);
  (void)flag;
}

// The state that changes most in units of its tolerance; 0 when that cannot be told.
int Cvode::fastest_state() {
  std::size_t fastest = 0;
  try {
    const double* const f = derivatives_here();
    double most = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      const double rate = std::abs(f[i]) / (atol_ + rtol_ * std::abs(x_[i]));
      if (rate > most) {
        most = rate;
        fastest = i;
      }
    }
  } catch (const RunError&) {
    return 0;
  }
  return static_cast<int>(fastest);
}

const double* Cvode::derivatives_here() {
  std::copy_n(x_, n_, system_.state());
  ++statistics_.evaluations;
  return system_.derivatives(t_);
}

void Cvode::fail(int flag) {
  std::copy_n(before_.data(), n_, x_);
  std::copy_n(before_.data(), n_, system_.state());
  earlier_ = statistics();
  cold_ = true;
  if (failure_) std::rethrow_exception(failure_);
  if (not_finite_ >= 0) {
    throw StateError(fmt::format("the derivative of state {} is not finite near t = {} s", not_finite_, t_), t_,
                     not_finite_);
  }
  const char* const method = stiff_ ? "bdf" : "adams";
  switch (flag) {
    case CV_ERR_FAILURE: {
      const int state = fastest_state();
      throw StateError(fmt::format("the step size collapsed at t = {} s: state {} changes too fast there", t_, state),
                       t_, state);
    }
    case CV_TOO_MUCH_ACC:
      throw RunError(fmt::format("at t = {} s the tolerances ask for more accuracy than double precision has", t_), t_);
    case CV_CONV_FAILURE:
      throw RunError(fmt::format("solver '{}' cannot solve the equations of a step at t = {} s, however short it is{}",
                                 method, t_, stiff_ ? "" : "; for a stiff diagram use 'bdf'"),
                     t_);
    case CV_LSETUP_FAIL:
    case CV_LSOLVE_FAIL:
      throw RunError(fmt::format("the linear equations of a step at t = {} s have no solution", t_), t_);
    default:
      throw RunError(fmt::format("solver '{}' failed at t = {} s (code {})", method, t_, flag), t_);
  }
}

}  // namespace

const std::vector<SolverInfo>& cvode_solvers() {
  static const std::vector<SolverInfo> list{
      {"adams", "CVODE's Adams methods, orders 1 to 12; for smooth diagrams and tight tolerances", 12, false, true},
      {"bdf", "CVODE's backward differences, orders 1 to 5, with exact Jacobians; for stiff diagrams", 5, false, true},
  };
  return list;
}

std::unique_ptr<Integrator> make_cvode(OdeSystem& system, const SolverOptions& options) {
  for (const SolverInfo& info : cvode_solvers()) {
    if (options.solver != info.name) continue;
    if (options.step > 0) throw std::invalid_argument(fmt::format("solver '{}' takes no fixed step", options.solver));
    return std::make_unique<Cvode>(system, options);
  }
  throw std::invalid_argument(fmt::format("there is no solver '{}'", options.solver));
}

}  // namespace plantloop
