// What is no equation: an opaque operation with state of its own in the Frame.

#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace plantloop {

// Samples of a signal over time that a kernel keeps, in order of time; an event gives two samples of equal time, left
// first. Recording doubles the room between steps, so that stepping does not allocate.
struct History {
  std::vector<double> time;  // s
  std::vector<double> value;
  std::vector<double> order;  // of each sample: the lowest derivative that jumps there, or one of the two below
  static constexpr double inside_step = 1000, end_of_step = 999;
};

// An instant (s) at which a signal is not smooth, and the lowest of its derivatives that jumps there; 0: its value.
struct Break {
  double time = std::numeric_limits<double>::infinity();
  int order = 0;
  static constexpr int smooth = 100;  // as an order: nothing jumps
};

// What a kernel sees of a run at one instant.
struct KernelCall {
  double time = 0;             // s
  const double* in = nullptr;  // the inputs that evaluate (or advance) reads
  double* out = nullptr;       // the outputs, written by evaluate
  double* state = nullptr;     // state_size() doubles; evaluate must not change them
  double* scratch = nullptr;   // scratch_size() doubles without meaning between calls
  History* history = nullptr;  // histories() of them; evaluate must not change them
  bool left = false;           // the values just before an event are wanted
  bool inside = false;         // advance: at an instant inside an accepted step
  int order = Break::smooth;   // advance: the lowest derivative of a signal that may jump here, as far as it matters
  bool* end = nullptr;         // advance may set it: the run ends here, as if this were its stop time
};

// Immutable and shared by threads; all that changes lives in the Frame. `evaluate` is pure and may be called in minor
// steps any number of times; `advance` is called at hits (discrete rate) or accepted steps and events (continuous)
// only.
// A kernel with histories is also advanced at a few instants inside each accepted step, before its end.
class Kernel {
 public:
  virtual ~Kernel() = default;
  virtual std::string name() const = 0;
  virtual int outputs() const = 0;
  // Whether another kernel gives the same outputs for the same inputs, so that one call serves both; false where it has
  // a state or histories.
  virtual bool is_same(const Kernel& other) const {
    (void)other;
    return false;
  }
  virtual int state_size() const { return 0; }
  virtual int scratch_size() const { return 0; }
  virtual int histories() const { return 0; }
  // Whether `initialise` reads the inputs of `advance`; if not, a loop through this kernel has a defined start.
  virtual bool starts_with_inputs() const { return true; }
  // Sets the state at the start; `call.in` are the inputs of `advance` at the start time, or of `evaluate` when it does
  // not start with inputs.
  virtual void initialise(const KernelCall& call) const { (void)call; }
  virtual void evaluate(const KernelCall& call) const = 0;
  virtual void advance(const KernelCall& call) const { (void)call; }
  // d out[i] / d in[j], row by row (outputs() x inputs), into `jacobian`; false: not known, it is differenced and
  // reported.
  virtual bool derivative(const KernelCall& call, double* jacobian) const {
    (void)call, (void)jacobian;
    return false;
  }
  // The longest step in s that keeps `evaluate` inside what `advance` has seen; infinity: any.
  virtual double longest_step(const double* in) const {
    (void)in;
    return 1e300;
  }
  // The next instant at which what `evaluate` gives is not smooth; the solver stops there. Until then a call with
  // `left`, as all in minor steps are, gives what holds before, also a little beyond; a call without gives what holds
  // from there on. `advance` at that instant, without `left`, goes over to it. `call.in` are the inputs of `advance`.
  // A kernel that knows such instants only when they have come tells the time of the call.
  virtual Break next_break(const KernelCall& call) const {
    (void)call;
    return {};
  }
};

// Two instants that mean the same one: they were computed in different ways. Never is no instant.
inline bool is_same_instant(double a, double b) {
  constexpr double rounding = 16 * std::numeric_limits<double>::epsilon();
  return std::fabs(a - b) <= rounding * std::fmax(1.0, std::fmin(std::fabs(a), std::fabs(b)));
}

// A kernel's use inside a record: which nodes feed `evaluate` and which only `advance`.
struct KernelUse {
  std::shared_ptr<const Kernel> kernel;
  std::vector<std::uint32_t> inputs;          // nodes read by evaluate, at the same instant
  std::vector<std::uint32_t> advance_inputs;  // nodes read by advance
  std::uint32_t site = 0;
  bool continuous = true;   // advanced at accepted steps, else at the hits of its rate
  std::uint32_t index = 0;  // which kernel state of the Frame is its own
  bool initial = false;     // of the initial list: sets the state first
};

}  // namespace plantloop
