// The door to SUNDIALS' IDA: backward differences on the equations x' - f(t, x, z) = 0, g(t, x, z) = 0 as they are. The
// algebraic unknowns z are variables of the solver, so that a step solves for states and unknowns together.

#include "engine/solve/ida.h"

#include <fmt/format.h>
#include <ida/ida.h>

#include <algorithm>
#include <new>
#include <stdexcept>

#include "engine/solve/passes.h"
#include "engine/solve/sundials_integrator.h"

namespace plantloop {
namespace {

struct FreeMemory {
  void operator()(void* memory) const { IDAFree(&memory); }
};

void check(int flag) { check_sundials(flag, IDA_MEM_FAIL); }

class Ida final : public SundialsIntegrator {
 public:
  Ida(OdeSystem& system, const SolverOptions& options);

 private:
  void begin(double first_step) override;
  double advance(double t_stop) override;
  void inside(double t, double* x) override;
  SolverStatistics counted() const override;
  const double* slopes() override;
  static int residual(sunrealtype t, N_Vector y, N_Vector rate, N_Vector out, void* self);
  static int jacobian(sunrealtype t, sunrealtype scale, N_Vector y, N_Vector rate, N_Vector out, SUNMatrix matrix,
                      void* self, N_Vector, N_Vector, N_Vector);
  [[noreturn]] void fail_with(int flag);

  Owned<N_Vector, FreeVector> rate_, inside_;
  Owned<void*, FreeMemory> memory_;
};

Ida::Ida(OdeSystem& system, const SolverOptions& options)
    : SundialsIntegrator(system, options, static_cast<std::size_t>(system.size() + system.algebraic_size())),
      rate_(N_VClone(vector_.get())),
      inside_(N_VClone(vector_.get())) {
  if (!rate_ || !inside_) throw std::bad_alloc();
  memory_.reset(IDACreate(context_.get()));
  if (!memory_) throw std::bad_alloc();
#if SUNDIALS_VERSION_MAJOR < 7
  check(IDASetErrHandlerFn(memory_.get(), ignore_error, nullptr));
#endif
  N_VConst(0, rate_.get());
  check(IDAInit(memory_.get(), residual, time(), vector_.get(), rate_.get()));
  check(IDASetUserData(memory_.get(), this));
  // The unknowns take no part in the error test, see below: what they amplify is met by closer tolerances of the
  // states.
  const double share = unknowns_ > n_ ? 0.1 : 1;
  check(IDASStolerances(memory_.get(), share * rtol_, share * atol_));
  check(IDASetMaxNumSteps(memory_.get(), -1));
  // What is recorded of the unknowns solves their equations at the states: their own errors in a step do not matter. At
  // tight tolerances they are noise that would make the steps collapse, and so is an iteration that ends too early.
  N_VConst(1, inside_.get());
  std::fill_n(N_VGetArrayPointer(inside_.get()) + n_, unknowns_ - n_, 0.0);
  check(IDASetId(memory_.get(), inside_.get()));
  if (unknowns_ > n_) check(IDASetSuppressAlg(memory_.get(), SUNTRUE));
  check(IDASetNonlinConvCoef(memory_.get(), 0.1));
  make_linear_solver(system_.equations_pattern());
  check(IDASetLinearSolver(memory_.get(), linear_.get(), matrix_.get()));
  if (system_.equations_pattern()) check(IDASetJacFn(memory_.get(), jacobian));
}

int Ida::residual(sunrealtype t, N_Vector y, N_Vector rate, N_Vector out, void* user) {
  auto& self = *static_cast<Ida*>(user);
  return self.guarded([&] {
    const double* const values = N_VGetArrayPointer(y);
    const double* const slopes = N_VGetArrayPointer(rate);
    double* const into = N_VGetArrayPointer(out);
    std::copy_n(values, self.n_, self.system_.state());
    const double* const f = self.system_.equations(t, values + self.n_);
    self.count_evaluation();
    for (std::size_t i = 0; i < self.n_; ++i) into[i] = slopes[i] - f[i];
    for (std::size_t i = self.n_; i < self.unknowns_; ++i) into[i] = f[i];
    if (all_finite(self.unknowns_, into)) return 0;
    self.blame(std::min(first_not_finite(self.unknowns_, into), self.n_ - 1));
    return 1;
  });
}

int Ida::jacobian(sunrealtype t, sunrealtype scale, N_Vector y, N_Vector, N_Vector, SUNMatrix out, void* user, N_Vector,
                  N_Vector, N_Vector) {
  auto& self = *static_cast<Ida*>(user);
  return self.guarded([&] {
    const double* const values = N_VGetArrayPointer(y);
    std::copy_n(values, self.n_, self.system_.state());
    const double* const entries = self.system_.equations_jacobian(t, values + self.n_);
    const auto states = static_cast<sunindextype>(self.n_);
    self.fill(out, scale, [&](std::size_t i, sunindextype row) { return row < states ? -entries[i] : entries[i]; });
    return 0;
  });
}

// The derivatives at (t, y), where the unknowns are those that satisfy their equations there.
const double* Ida::slopes() {
  std::copy_n(x(), n_, system_.state());
  std::copy_n(system_.algebraic(), unknowns_ - n_, x() + n_);
  count_evaluation();
  return system_.equations(time(), x() + n_);
}

void Ida::begin(double first_step) {
  const double* const f = slopes();
  if (!all_finite(n_, f)) {
    const std::size_t state = first_not_finite(n_, f);
    throw StateError(fmt::format("the derivative of state {} is not finite at t = {} s", state, time()), time(),
                     static_cast<int>(state));
  }
  N_VConst(0, rate_.get());
  std::copy_n(f, n_, N_VGetArrayPointer(rate_.get()));
  check(IDAReInit(memory_.get(), time(), vector_.get(), rate_.get()));
  check(IDASetInitStep(memory_.get(), first_step));
}

double Ida::advance(double t_stop) {
  check(IDASetStopTime(memory_.get(), t_stop));
  sunrealtype reached = time();
  const auto one_step = [&] {
    return IDASolve(memory_.get(), t_stop, &reached, vector_.get(), rate_.get(), IDA_ONE_STEP);
  };
  const int flag = step_until_progress(one_step, reached, IDA_SUCCESS);
  if (flag < 0) fail_with(flag);
  if (flag != IDA_TSTOP_RETURN && is_no_progress(reached)) fail_with(IDA_ERR_FAIL);
  system_.take_algebraic(x() + n_);
  return flag == IDA_TSTOP_RETURN ? t_stop : reached;
}

void Ida::inside(double t, double* x) {
  check(IDAGetDky(memory_.get(), t, 0, inside_.get()));
  std::copy_n(N_VGetArrayPointer(inside_.get()), n_, x);
}

SolverStatistics Ida::counted() const {
  long steps = 0, error_failures = 0, convergence_failures = 0, jacobians = 0;
  IDAGetNumSteps(memory_.get(), &steps);
  IDAGetNumErrTestFails(memory_.get(), &error_failures);
  IDAGetNumNonlinSolvConvFails(memory_.get(), &convergence_failures);
  IDAGetNumJacEvals(memory_.get(), &jacobians);
  return {.steps = steps, .rejected = error_failures + convergence_failures, .jacobians = jacobians};
}

void Ida::fail_with(int flag) {
  switch (flag) {
    case IDA_ERR_FAIL:
      fail(Failure::collapse, flag);
    case IDA_TOO_MUCH_ACC:
      fail(Failure::accuracy, flag);
    case IDA_CONV_FAIL:
      fail(Failure::equations, flag, "; where a constraint has no more solution nearby, none of them has");
    case IDA_LSETUP_FAIL:
    case IDA_LSOLVE_FAIL:
      fail(Failure::linear_equations, flag, ": the constraints do not determine their unknowns there");
    default:
      fail(Failure::other, flag);
  }
}

}  // namespace

const SolverInfo& ida_solver() {
  static const SolverInfo info{"ida",
                               "IDA's backward differences, orders 1 to 5, with algebraic unknowns as variables of the "
                               "solver; for stiff diagrams with loops and constraints",
                               5, false, true};
  return info;
}

std::unique_ptr<Integrator> make_ida(OdeSystem& system, const SolverOptions& options) {
  if (options.step > 0) throw std::invalid_argument("solver 'ida' takes no fixed step");
  return std::make_unique<Ida>(system, options);
}

}  // namespace plantloop
