// The door to SUNDIALS' CVODE: its Adams and BDF methods, one step at a time.

#include "engine/solve/cvode.h"

#include <cvode/cvode.h>
#include <fmt/format.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <new>
#include <stdexcept>

#include "engine/solve/passes.h"
#include "engine/solve/sundials_integrator.h"

namespace plantloop {
namespace {

struct FreeMemory {
  void operator()(void* memory) const { CVodeFree(&memory); }
};

struct FreeNonlinear {
  void operator()(SUNNonlinearSolver solver) const { SUNNonlinSolFree(solver); }
};

void check(int flag) { check_sundials(flag, CV_MEM_FAIL); }

class Cvode final : public SundialsIntegrator {
 public:
  Cvode(OdeSystem& system, const SolverOptions& options);

 private:
  void begin(double first_step) override;
  double advance(double t_stop) override;
  void inside(double t, double* x) override;
  SolverStatistics counted() const override;
  const double* slopes() override;
  static int evaluate(sunrealtype t, N_Vector x, N_Vector rate, void* self);
  static int jacobian(sunrealtype t, N_Vector x, N_Vector rate, SUNMatrix out, void* self, N_Vector, N_Vector,
                      N_Vector);
  [[noreturn]] void fail_with(int flag);

  const bool stiff_;
  Owned<SUNNonlinearSolver, FreeNonlinear> nonlinear_;
  Owned<void*, FreeMemory> memory_;
};

Cvode::Cvode(OdeSystem& system, const SolverOptions& options)
    : SundialsIntegrator(system, options, static_cast<std::size_t>(system.size())), stiff_(options.solver == "bdf") {
  memory_.reset(CVodeCreate(stiff_ ? CV_BDF : CV_ADAMS, context_.get()));
  if (!memory_) throw std::bad_alloc();
#if SUNDIALS_VERSION_MAJOR < 7
  check(CVodeSetErrHandlerFn(memory_.get(), ignore_error, nullptr));
#endif
  check(CVodeInit(memory_.get(), evaluate, time(), vector_.get()));
  check(CVodeSetUserData(memory_.get(), this));
  check(CVodeSStolerances(memory_.get(), rtol_, atol_));
  check(CVodeSetMaxNumSteps(memory_.get(), -1));
  check(CVodeSetMaxHnilWarns(memory_.get(), -1));
  if (stiff_) {
    make_linear_solver(system_.pattern());
    check(CVodeSetLinearSolver(memory_.get(), linear_.get(), matrix_.get()));
    if (system_.pattern()) check(CVodeSetJacFn(memory_.get(), jacobian));
    nonlinear_.reset(SUNNonlinSol_Newton(vector_.get(), context_.get()));
  } else {
    nonlinear_.reset(SUNNonlinSol_FixedPoint(vector_.get(), 0, context_.get()));
  }
  if (!nonlinear_) throw std::bad_alloc();
  check(CVodeSetNonlinearSolver(memory_.get(), nonlinear_.get()));
}

int Cvode::evaluate(sunrealtype t, N_Vector x, N_Vector rate, void* user) {
  auto& self = *static_cast<Cvode*>(user);
  return self.guarded([&] {
    std::copy_n(N_VGetArrayPointer(x), self.n_, self.system_.state());
    const double* const f = self.system_.derivatives(t);
    self.count_evaluation();
    std::copy_n(f, self.n_, N_VGetArrayPointer(rate));
    if (all_finite(self.n_, f)) return 0;
    self.blame(first_not_finite(self.n_, f));
    return 1;
  });
}

int Cvode::jacobian(sunrealtype t, N_Vector x, N_Vector, SUNMatrix out, void* user, N_Vector, N_Vector, N_Vector) {
  auto& self = *static_cast<Cvode*>(user);
  return self.guarded([&] {
    std::copy_n(N_VGetArrayPointer(x), self.n_, self.system_.state());
    const double* const entries = self.system_.jacobian(t);
    self.fill(out, 0, [&](std::size_t i, sunindextype) { return entries[i]; });
    return 0;
  });
}

void Cvode::begin(double first_step) {
  check(CVodeReInit(memory_.get(), time(), vector_.get()));
  check(CVodeSetInitStep(memory_.get(), first_step));
}

double Cvode::advance(double t_stop) {
  check(CVodeSetStopTime(memory_.get(), t_stop));
  sunrealtype reached = time();
  const auto one_step = [&] { return CVode(memory_.get(), t_stop, vector_.get(), &reached, CV_ONE_STEP); };
  const int flag = step_until_progress(one_step, reached, CV_SUCCESS);
  if (flag < 0) fail_with(flag);
  if (flag == CV_TSTOP_RETURN) return t_stop;
  if (is_no_progress(reached)) fail_with(CV_ERR_FAILURE);
  return reached;
}

void Cvode::inside(double t, double* x) {
  const Owned<N_Vector, FreeVector> out(N_VMake_Serial(static_cast<sunindextype>(n_), x, context_.get()));
  check(CVodeGetDky(memory_.get(), t, 0, out.get()));
}

SolverStatistics Cvode::counted() const {
  long steps = 0, error_failures = 0, convergence_failures = 0, jacobians = 0;
  CVodeGetNumSteps(memory_.get(), &steps);
  CVodeGetNumErrTestFails(memory_.get(), &error_failures);
  CVodeGetNumNonlinSolvConvFails(memory_.get(), &convergence_failures);
  if (stiff_) CVodeGetNumJacEvals(memory_.get(), &jacobians);
  return {.steps = steps, .rejected = error_failures + convergence_failures, .jacobians = jacobians};
}

const double* Cvode::slopes() {
  std::copy_n(x(), n_, system_.state());
  count_evaluation();
  return system_.derivatives(time());
}

void Cvode::fail_with(int flag) {
  switch (flag) {
    case CV_ERR_FAILURE:
      fail(Failure::collapse, flag);
    case CV_TOO_MUCH_ACC:
      fail(Failure::accuracy, flag);
    case CV_CONV_FAILURE:
      fail(Failure::equations, flag, stiff_ ? "" : "; for a stiff diagram use 'bdf'");
    case CV_LSETUP_FAIL:
    case CV_LSOLVE_FAIL:
      fail(Failure::linear_equations, flag);
    default:
      fail(Failure::other, flag);
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
