// What the doors to CVODE and IDA do alike: one step at a time between restarts, dense output, counters that go on over
// restarts, exceptions that do not cross the library, and the words for its failures.

#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "engine/solve/integrator.h"
#include "engine/solve/sundials.h"

namespace plantloop {

// A pattern with the diagonal entries that a method adds to, and where each entry of the given pattern goes.
class SundialsPattern {
 public:
  SundialsPattern() = default;
  // `diagonal`: how many columns, from the first on, have a diagonal entry.
  SundialsPattern(const SparsityPattern& given, std::size_t diagonal);
  std::size_t entries() const { return row_.size(); }
  // Writes the matrix: value(i, row) of the given pattern's entry i, and `scale` added on the diagonal.
  template <typename Value>
  void fill(SUNMatrix out, bool sparse, double scale, Value value) const {
    if (sparse) {
      std::copy(column_start_.begin(), column_start_.end(), SUNSparseMatrix_IndexPointers(out));
      std::copy(row_.begin(), row_.end(), SUNSparseMatrix_IndexValues(out));
      sunrealtype* const to = SUNSparseMatrix_Data(out);
      std::fill_n(to, row_.size(), 0.0);
      for (std::size_t i = 0; i < place_.size(); ++i) to[place_[i]] = value(i, row_[place_[i]]);
      for (const auto place : diagonal_) to[place] += scale;
      return;
    }
    SUNMatZero(out);
    std::size_t next = 0;
    for (std::size_t column = 0; column + 1 < column_start_.size(); ++column) {
      sunrealtype* const to = SM_COLUMN_D(out, static_cast<sunindextype>(column));
      const auto end = static_cast<std::size_t>(column_start_[column + 1]);
      for (; next < place_.size() && place_[next] < end; ++next)
        to[row_[place_[next]]] = value(next, row_[place_[next]]);
      if (column < diagonal_.size()) to[column] += scale;
    }
  }

 private:
  std::vector<sunindextype> column_start_, row_;
  std::vector<std::size_t> place_, diagonal_;
};

class SundialsIntegrator : public Integrator {
 public:
  void restart(double t) final;
  double step(double t_stop) final;
  void interpolate(double t, double* x) final;
  void limit_step(double longest) final { limit_ = longest; }
  const SolverStatistics& statistics() const final;

 protected:
  // `unknowns` of the solver, of which the first are the states; x() is at first the system's state, then 0.
  SundialsIntegrator(OdeSystem& system, const SolverOptions& options, std::size_t unknowns);

  // The library's part. Its flags below 0 are failures, which go to fail().
  virtual void begin(double first_step) = 0;     // anew at (t, x()); 0: it chooses its first step
  virtual double advance(double t_stop) = 0;     // one step of x(), to the time that is returned
  virtual void inside(double t, double* x) = 0;  // the states at a time inside the last step
  virtual SolverStatistics counted() const = 0;  // since begin(), but for evaluations and restarts
  virtual const double* slopes() = 0;            // the derivatives of the states at (t, x())

  enum class Failure { collapse, accuracy, equations, linear_equations, other };
  // Puts everything back to the step's begin and throws: an exception that a callback has left, or what the failure is
  // called. `remedy` follows the words on equations.
  [[noreturn]] void fail(Failure failure, int flag, std::string_view remedy = {});

  // Runs a callback's body: 0 done, 1 try a shorter step, -1 stop.
  template <typename Body>
  int guarded(Body body) {
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
  void blame(std::size_t state) { not_finite_ = static_cast<int>(state); }
  void count_evaluation() { ++evaluations_; }
  // The matrix of an exact Jacobian, sparse where that pays, and its linear solver; without a pattern a dense one.
  void make_linear_solver(const SparsityPattern* given);
  template <typename Value>
  void fill(SUNMatrix out, double scale, Value value) const {
    pattern_.fill(out, sparse_, scale, value);
  }
  // A step as short as this does not change the time.
  bool is_no_progress(double reached) const;
  // Calls one_step(), which sets `reached` and gives a flag, until the time has changed. The libraries start with
  // steps too short for that, where a state is near 0 and changes fast or a stop is near, and then leave them soon;
  // they also go on with such steps for ever where there is no way on. `success` is the flag of an ordinary
  // step.
  template <typename Step>
  int step_until_progress(const Step& one_step, const double& reached, int success) const {
    constexpr int most_short_steps = 20;
    int flag = one_step();
    for (int i = 0; flag == success && is_no_progress(reached) && i < most_short_steps; ++i) flag = one_step();
    return flag;
  }

  double* x() { return N_VGetArrayPointer(vector_.get()); }
  double time() const { return t_; }
  const std::string& method() const { return method_; }

  OdeSystem& system_;
  const std::size_t n_, unknowns_;
  const double rtol_, atol_;
  Owned<SUNContext, FreeContext> context_;
  Owned<N_Vector, FreeVector> vector_;  // x()
  Owned<SUNMatrix, FreeMatrix> matrix_;
  Owned<SUNLinearSolver, FreeLinear> linear_;

 private:
  void euler_to(double t_stop);
  int fastest_state();

  const std::string method_;
  const double max_step_, first_step_;
  double limit_;
  bool sparse_ = false;
  SundialsPattern pattern_;
  std::vector<double> before_;  // the states at t_before_
  double t_, t_before_;
  bool cold_ = true;            // the library must be told the state anew
  bool by_euler_ = false;       // the last step was too short for the library
  std::exception_ptr failure_;  // the last in this step; the library tried a shorter one
  int not_finite_ = -1;         // the state whose derivative was not finite, likewise
  std::int64_t evaluations_ = 0;
  mutable SolverStatistics statistics_;
  SolverStatistics earlier_;  // before the last restart
};

// A call that cannot fail but for our own mistakes and for want of memory.
void check_sundials(int flag, int out_of_memory);

}  // namespace plantloop
