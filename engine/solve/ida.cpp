// The door to SUNDIALS' IDA: backward differences on the equations x' - f(t, x, z) = 0, g(t, x, z) = 0 as they are. The
// algebraic unknowns z are variables of the solver, so that a step solves for states and unknowns together.

#include "engine/solve/ida.h"

#include <fmt/format.h>
#include <ida/ida.h>

#include <algorithm>
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
  void operator()(void* memory) const { IDAFree(&memory); }
};

class Ida final : public Integrator {
 public:
  Ida(OdeSystem& system, const SolverOptions& options);
  void restart(double t) override;
  double step(double t_stop) override;
  void interpolate(double t, double* x) override;
  void limit_step(double longest) override { limit_ = longest; }
  const SolverStatistics& statistics() const override;

 private:
  static int residual(sunrealtype t, N_Vector y, N_Vector rate, N_Vector out, void* self);
  static int jacobian(sunrealtype t, sunrealtype scale, N_Vector y, N_Vector rate, N_Vector out, SUNMatrix matrix,
                      void* self, N_Vector, N_Vector, N_Vector);
  template <typename Body>
  int guarded(Body body);
  void check(int flag) const;
  void make_pattern();
  void make_linear_solver();
  void begin();
  void euler_to(double t_stop);
  [[noreturn]] void fail(int flag);
  double* y() { return N_VGetArrayPointer(y_.get()); }

  OdeSystem& system_;
  std::size_t n_, total_;  // states; with the unknowns
  double max_step_, first_step_;
  double limit_ = infinity;

  Owned<SUNContext, FreeContext> context_;
  Owned<N_Vector, FreeVector> y_, rate_, inside_;
  Owned<SUNMatrix, FreeMatrix> matrix_;
  Owned<SUNLinearSolver, FreeLinear> linear_;
  Owned<void*, FreeMemory> memory_;
  // The pattern of the equations with every diagonal entry of the states, and where each entry goes.
  std::vector<sunindextype> column_start_, row_;
  std::vector<std::size_t> place_, diagonal_;
  bool sparse_ = false;

  std::vector<double> before_;  // the states at t_before_
  double t_, t_before_;
  bool cold_ = true;
  bool by_euler_ = false;
  std::exception_ptr failure_;
  int not_finite_ = -1;  // the state whose equation was not finite
  mutable SolverStatistics statistics_;
  SolverStatistics earlier_;
};

Ida::Ida(OdeSystem& system, const SolverOptions& options)
    : system_(system),
      n_(static_cast<std::size_t>(system.size())),
      total_(n_ + static_cast<std::size_t>(system.algebraic_size())),
      max_step_(options.max_step > 0 ? options.max_step : infinity),
      first_step_(options.first_step),
      context_(make_context()),
      y_(N_VNew_Serial(static_cast<sunindextype>(total_), context_.get())),
      rate_(N_VNew_Serial(static_cast<sunindextype>(total_), context_.get())),
      inside_(N_VNew_Serial(static_cast<sunindextype>(total_), context_.get())),
      before_(n_),
      t_(options.start),
      t_before_(options.start) {
  if (!y_ || !rate_ || !inside_) throw std::bad_alloc();
  memory_.reset(IDACreate(context_.get()));
  if (!memory_) throw std::bad_alloc();
#if SUNDIALS_VERSION_MAJOR < 7
  check(IDASetErrHandlerFn(memory_.get(), ignore_error, nullptr));
#endif
  N_VConst(0, y_.get());
  std::copy_n(system_.state(), n_, y());
  N_VConst(0, rate_.get());
  check(IDAInit(memory_.get(), residual, t_, y_.get(), rate_.get()));
  check(IDASetUserData(memory_.get(), this));
  check(IDASStolerances(memory_.get(), options.rtol, options.atol));
  check(IDASetMaxNumSteps(memory_.get(), -1));
  make_linear_solver();
}

void Ida::make_pattern() {
  const SparsityPattern& given = *system_.equations_pattern();
  column_start_.push_back(0);
  for (std::size_t column = 0; column < total_; ++column) {
    bool has_diagonal = column >= n_;
    for (int at = given.column_start[column]; at < given.column_start[column + 1]; ++at) {
      const auto row = static_cast<std::size_t>(given.row[static_cast<std::size_t>(at)]);
      if (!has_diagonal && row >= column) {
        has_diagonal = true;
        diagonal_.push_back(row_.size());
        if (row > column) row_.push_back(static_cast<sunindextype>(column));
      }
      place_.push_back(row_.size());
      row_.push_back(static_cast<sunindextype>(row));
    }
    if (!has_diagonal) {
      diagonal_.push_back(row_.size());
      row_.push_back(static_cast<sunindextype>(column));
    }
    column_start_.push_back(static_cast<sunindextype>(row_.size()));
  }
}

void Ida::make_linear_solver() {
  const auto n = static_cast<sunindextype>(total_);
  const bool exact = system_.equations_pattern() != nullptr;
  if (exact) make_pattern();
  sparse_ = exact && total_ > widest_dense && row_.size() < total_ * total_ / 4;
  if (sparse_) {
    matrix_.reset(SUNSparseMatrix(n, n, static_cast<sunindextype>(row_.size()), CSC_MAT, context_.get()));
    if (!matrix_) throw std::bad_alloc();
    linear_.reset(SUNLinSol_KLU(y_.get(), matrix_.get(), context_.get()));
  } else {
    matrix_.reset(SUNDenseMatrix(n, n, context_.get()));
    if (!matrix_) throw std::bad_alloc();
    linear_.reset(SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get()));
  }
  if (!linear_) throw std::bad_alloc();
  check(IDASetLinearSolver(memory_.get(), linear_.get(), matrix_.get()));
  if (exact) check(IDASetJacFn(memory_.get(), jacobian));
}

// Runs a callback's body: 0 done, 1 try a shorter step, -1 stop. No exception may cross SUNDIALS.
template <typename Body>
int Ida::guarded(Body body) {
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

int Ida::residual(sunrealtype t, N_Vector y, N_Vector rate, N_Vector out, void* user) {
  auto& self = *static_cast<Ida*>(user);
  return self.guarded([&] {
    const double* const values = N_VGetArrayPointer(y);
    const double* const slopes = N_VGetArrayPointer(rate);
    double* const into = N_VGetArrayPointer(out);
    std::copy_n(values, self.n_, self.system_.state());
    const double* const f = self.system_.equations(t, values + self.n_);
    ++self.statistics_.evaluations;
    for (std::size_t i = 0; i < self.n_; ++i) into[i] = slopes[i] - f[i];
    for (std::size_t i = self.n_; i < self.total_; ++i) into[i] = f[i];
    if (all_finite(self.total_, into)) return 0;
    self.not_finite_ = static_cast<int>(std::min(first_not_finite(self.total_, into), self.n_ - 1));
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
    const auto sign = [&](std::size_t place) { return self.row_[place] < states ? -1.0 : 1.0; };
    if (self.sparse_) {
      std::copy(self.column_start_.begin(), self.column_start_.end(), SUNSparseMatrix_IndexPointers(out));
      std::copy(self.row_.begin(), self.row_.end(), SUNSparseMatrix_IndexValues(out));
      sunrealtype* const to = SUNSparseMatrix_Data(out);
      std::fill_n(to, self.row_.size(), 0.0);
      for (std::size_t i = 0; i < self.place_.size(); ++i) to[self.place_[i]] = sign(self.place_[i]) * entries[i];
      for (const auto place : self.diagonal_) to[place] += scale;
      return 0;
    }
    SUNMatZero(out);
    std::size_t next = 0;
    for (std::size_t column = 0; column < self.total_; ++column) {
      sunrealtype* const to = SM_COLUMN_D(out, static_cast<sunindextype>(column));
      const auto end = static_cast<std::size_t>(self.column_start_[column + 1]);
      for (; next < self.place_.size() && self.place_[next] < end; ++next)
        to[self.row_[self.place_[next]]] = sign(self.place_[next]) * entries[next];
      if (column < self.n_) to[column] += scale;
    }
    return 0;
  });
}

void Ida::restart(double t) {
  earlier_ = statistics();
  ++earlier_.cold_restarts;
  std::copy_n(system_.state(), n_, y());
  t_ = t_before_ = t;
  cold_ = true;
}

// Consistent values: the unknowns satisfy their equations at the states, the slopes are the derivatives there.
void Ida::begin() {
  std::copy_n(y(), n_, system_.state());
  std::copy_n(system_.algebraic(), total_ - n_, y() + n_);
  const double* const f = system_.equations(t_, y() + n_);
  ++statistics_.evaluations;
  if (!all_finite(n_, f)) {
    const std::size_t state = first_not_finite(n_, f);
    throw StateError(fmt::format("the derivative of state {} is not finite at t = {} s", state, t_), t_,
                     static_cast<int>(state));
  }
  N_VConst(0, rate_.get());
  std::copy_n(f, n_, N_VGetArrayPointer(rate_.get()));
}

// One step of Euler's method, for a way so short that IDA cannot tell its ends apart.
void Ida::euler_to(double t_stop) {
  begin();
  const double* const f = N_VGetArrayPointer(rate_.get());
  for (std::size_t i = 0; i < n_; ++i) y()[i] += (t_stop - t_) * f[i];
  earlier_ = statistics();
  ++earlier_.steps;
  cold_ = by_euler_ = true;
  t_ = t_stop;
}

double Ida::step(double t_stop) {
  assert(t_stop > t_);
  t_before_ = t_;
  std::copy_n(y(), n_, before_.data());
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
      begin();
      check(IDAReInit(memory_.get(), t_, y_.get(), rate_.get()));
      check(IDASetInitStep(memory_.get(), std::min(first_step_, t_stop - t_)));
      cold_ = false;
    }
    check(IDASetStopTime(memory_.get(), t_stop));
    sunrealtype reached = t_;
    const int flag = IDASolve(memory_.get(), t_stop, &reached, y_.get(), rate_.get(), IDA_ONE_STEP);
    if (flag < 0) fail(flag);
    if (flag != IDA_TSTOP_RETURN && reached - t_ < 4 * epsilon * std::abs(t_)) fail(IDA_ERR_FAIL);
    t_ = flag == IDA_TSTOP_RETURN ? t_stop : reached;
    system_.take_algebraic(y() + n_);
  }
  std::copy_n(y(), n_, system_.state());
  return t_;
}

void Ida::interpolate(double t, double* x) {
  if (t >= t_) {
    std::copy_n(y(), n_, x);
  } else if (t <= t_before_) {
    std::copy_n(before_.data(), n_, x);
  } else if (by_euler_) {
    const double s = (t - t_before_) / (t_ - t_before_);
    for (std::size_t i = 0; i < n_; ++i) x[i] = before_[i] + s * (y()[i] - before_[i]);
  } else {
    check(IDAGetDky(memory_.get(), t, 0, inside_.get()));
    std::copy_n(N_VGetArrayPointer(inside_.get()), n_, x);
  }
}

const SolverStatistics& Ida::statistics() const {
  const std::int64_t evaluations = statistics_.evaluations;
  statistics_ = earlier_;
  statistics_.evaluations = evaluations;
  if (cold_) return statistics_;
  long steps = 0, error_failures = 0, convergence_failures = 0, jacobians = 0;
  IDAGetNumSteps(memory_.get(), &steps);
  IDAGetNumErrTestFails(memory_.get(), &error_failures);
  IDAGetNumNonlinSolvConvFails(memory_.get(), &convergence_failures);
  IDAGetNumJacEvals(memory_.get(), &jacobians);
  statistics_.steps += steps;
  statistics_.rejected += error_failures + convergence_failures;
  statistics_.jacobians += jacobians;
  return statistics_;
}

// A call that cannot fail but for our own mistakes and for want of memory.
void Ida::check(int flag) const {
  if (flag == IDA_MEM_FAIL) throw std::bad_alloc();
  assert(flag >= 0);
  (void)flag;
}

void Ida::fail(int flag) {
  earlier_ = statistics();
  std::copy_n(before_.data(), n_, y());
  std::copy_n(before_.data(), n_, system_.state());
  cold_ = true;
  if (failure_) std::rethrow_exception(failure_);
  if (not_finite_ >= 0) {
    throw StateError(fmt::format("the derivative of state {} is not finite near t = {} s", not_finite_, t_), t_,
                     not_finite_);
  }
  switch (flag) {
    case IDA_ERR_FAIL:
      throw RunError(fmt::format("the step size of solver 'ida' collapsed at t = {} s", t_), t_);
    case IDA_TOO_MUCH_ACC:
      throw RunError(fmt::format("at t = {} s the tolerances ask for more accuracy than double precision has", t_), t_);
    case IDA_CONV_FAIL:
      throw RunError(fmt::format("solver 'ida' cannot solve the equations of a step at t = {} s, however short it is; "
                                 "where a constraint has no more solution nearby, none of them has",
                                 t_),
                     t_);
    case IDA_LSETUP_FAIL:
    case IDA_LSOLVE_FAIL:
      throw RunError(fmt::format("the linear equations of a step at t = {} s have no solution: the constraints do not "
                                 "determine their unknowns there",
                                 t_),
                     t_);
    default:
      throw RunError(fmt::format("solver 'ida' failed at t = {} s (code {})", t_, flag), t_);
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
