// One step at a time with a library of SUNDIALS.

#include "engine/solve/sundials_integrator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <new>

#include "engine/solve/passes.h"

namespace plantloop {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double epsilon = std::numeric_limits<double>::epsilon();

}  // namespace

SundialsPattern::SundialsPattern(const SparsityPattern& given, std::size_t diagonal) {
  const auto columns = static_cast<std::size_t>(given.size);
  column_start_.push_back(0);
  for (std::size_t column = 0; column < columns; ++column) {
    bool has_diagonal = column >= diagonal;
    const auto add_diagonal = [&] {
      has_diagonal = true;
      diagonal_.push_back(row_.size());
    };
    for (int at = given.column_start[column]; at < given.column_start[column + 1]; ++at) {
      const auto row = static_cast<std::size_t>(given.row[static_cast<std::size_t>(at)]);
      if (!has_diagonal && row >= column) {
        add_diagonal();
        if (row > column) row_.push_back(static_cast<sunindextype>(column));
      }
      place_.push_back(row_.size());
      row_.push_back(static_cast<sunindextype>(row));
    }
    if (!has_diagonal) {
      add_diagonal();
      row_.push_back(static_cast<sunindextype>(column));
    }
    column_start_.push_back(static_cast<sunindextype>(row_.size()));
  }
}

SundialsIntegrator::SundialsIntegrator(OdeSystem& system, const SolverOptions& options, std::size_t unknowns)
    : system_(system),
      n_(static_cast<std::size_t>(system.size())),
      unknowns_(unknowns),
      rtol_(options.rtol),
      atol_(options.atol),
      context_(make_context()),
      vector_(N_VNew_Serial(static_cast<sunindextype>(unknowns), context_.get())),
      method_(options.solver),
      max_step_(options.max_step > 0 ? options.max_step : infinity),
      first_step_(options.first_step),
      limit_(infinity),
      before_(n_),
      t_(options.start),
      t_before_(options.start) {
  if (!vector_) throw std::bad_alloc();
  N_VConst(0, vector_.get());
  std::copy_n(system.state(), n_, x());
}

void SundialsIntegrator::make_linear_solver(const SparsityPattern* given) {
  const auto n = static_cast<sunindextype>(unknowns_);
  if (given) pattern_ = SundialsPattern(*given, n_);
  const std::size_t entries = pattern_.entries();
  sparse_ = given && unknowns_ > widest_dense && entries < unknowns_ * unknowns_ / 4;  // else KLU has nothing to save
  matrix_.reset(sparse_ ? SUNSparseMatrix(n, n, static_cast<sunindextype>(entries), CSC_MAT, context_.get())
                        : SUNDenseMatrix(n, n, context_.get()));
  if (!matrix_) throw std::bad_alloc();
  linear_.reset(sparse_ ? SUNLinSol_KLU(vector_.get(), matrix_.get(), context_.get())
                        : SUNLinSol_Dense(vector_.get(), matrix_.get(), context_.get()));
  if (!linear_) throw std::bad_alloc();
}

void SundialsIntegrator::restart(double t) {
  earlier_ = statistics();
  ++earlier_.cold_restarts;
  std::copy_n(system_.state(), n_, x());
  t_ = t_before_ = t;
  cold_ = true;
}

bool SundialsIntegrator::is_no_progress(double reached) const { return reached - t_ < 4 * epsilon * std::abs(t_); }

// One step of Euler's method, for a way so short that the library cannot tell its ends apart.
void SundialsIntegrator::euler_to(double t_stop) {
  const double* const f = slopes();
  for (std::size_t i = 0; i < n_; ++i) x()[i] += (t_stop - t_) * f[i];
  earlier_ = statistics();
  ++earlier_.steps;
  cold_ = by_euler_ = true;
  t_ = t_stop;
}

double SundialsIntegrator::step(double t_stop) {
  assert(t_stop > t_);
  t_before_ = t_;
  std::copy_n(x(), n_, before_.data());
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
      begin(std::min(first_step_, t_stop - t_));
      cold_ = false;
    }
    t_ = advance(t_stop);
  }
  std::copy_n(x(), n_, system_.state());
  return t_;
}

void SundialsIntegrator::interpolate(double t, double* out) {
  if (t >= t_) {
    std::copy_n(x(), n_, out);
  } else if (t <= t_before_) {
    std::copy_n(before_.data(), n_, out);
  } else if (by_euler_) {
    const double s = (t - t_before_) / (t_ - t_before_);
    for (std::size_t i = 0; i < n_; ++i) out[i] = before_[i] + s * (x()[i] - before_[i]);
  } else {
    inside(t, out);
  }
}

const SolverStatistics& SundialsIntegrator::statistics() const {
  statistics_ = earlier_;
  statistics_.evaluations = evaluations_;
  if (cold_) return statistics_;
  const SolverStatistics now = counted();
  statistics_.steps += now.steps;
  statistics_.rejected += now.rejected;
  statistics_.jacobians += now.jacobians;
  return statistics_;
}

// The state that changes most in units of its tolerance; 0 when that cannot be told.
int SundialsIntegrator::fastest_state() {
  std::size_t fastest = 0;
  try {
    const double* const f = slopes();
    double most = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      const double rate = std::abs(f[i]) / (atol_ + rtol_ * std::abs(x()[i]));
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

void SundialsIntegrator::fail(Failure failure, int flag, std::string_view remedy) {
  earlier_ = statistics();
  std::copy_n(before_.data(), n_, x());
  std::copy_n(before_.data(), n_, system_.state());
  cold_ = true;
  if (failure_) std::rethrow_exception(failure_);
  if (not_finite_ >= 0) {
    throw StateError(fmt::format("the derivative of state {} is not finite near t = {} s", not_finite_, t_), t_,
                     not_finite_);
  }
  switch (failure) {
    case Failure::collapse: {
      const int state = fastest_state();
      throw StateError(fmt::format("the step size collapsed at t = {} s: state {} changes too fast there", t_, state),
                       t_, state);
    }
    case Failure::accuracy:
      throw RunError(fmt::format("at t = {} s the tolerances ask for more accuracy than double precision has", t_), t_);
    case Failure::equations:
      throw RunError(fmt::format("solver '{}' cannot solve the equations of a step at t = {} s, however short it is{}",
                                 method_, t_, remedy),
                     t_);
    case Failure::linear_equations:
      throw RunError(fmt::format("the linear equations of a step at t = {} s have no solution{}", t_, remedy), t_);
    case Failure::other:
      break;
  }
  throw RunError(fmt::format("solver '{}' failed at t = {} s (code {})", method_, t_, flag), t_);
}

void check_sundials(int flag, int out_of_memory) {
  if (flag == out_of_memory) throw std::bad_alloc();
  assert(flag >= 0);
  (void)flag;
}

}  // namespace plantloop
