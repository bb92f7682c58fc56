// What a predictive controller asks of a model: its signals over a horizon, and how they depend on the inputs.

#pragma once

#include <cstddef>

namespace plantloop {

// Hands out parts of one array; without an array it only counts them.
class Room {
 public:
  explicit Room(double* begin = nullptr) : begin_(begin) {}
  double* take(std::size_t count) {
    double* const part = begin_ == nullptr ? nullptr : begin_ + taken_;
    taken_ += count;
    return part;
  }
  double* take(int count) { return take(static_cast<std::size_t>(count)); }
  std::size_t taken() const { return taken_; }

 private:
  double* begin_;
  std::size_t taken_ = 0;
};

// Immutable and shared by threads; what changes lives in the caller's room. Arrays run with time: of a horizon of P
// samples the inputs u(k), ..., u(k+P-1) are P x inputs() numbers, the signals of k+1, ..., k+P are P x signals().
// The outputs at a sample do not depend on the inputs at the same one.
class Predictor {
 public:
  virtual ~Predictor() = default;
  virtual int inputs() const = 0;
  virtual int outputs() const = 0;
  // Signals behind the outputs that can be limited: states, or variances of the outputs.
  virtual int extras() const = 0;
  virtual bool has_variances() const { return false; }  // extras are those
  int signals() const { return outputs() + extras(); }
  // Numbers that say where the model is at a sample, before its input is known.
  virtual int state_size() const = 0;
  // Numbers of `state` below: a state that is not made of outputs is followed by what is added to it at each sample of
  // a prediction, a constant disturbance.
  int prediction_size() const { return is_made_of_outputs() ? state_size() : 2 * state_size(); }
  // Whether the signals are affine in the inputs.
  virtual bool is_linear() const = 0;
  // How many of the first samples of a signal no input can reach, by dead time.
  virtual int dead_samples(int signal) const = 0;
  // Doubles that the calls below may use, for a horizon and a number of variables that the inputs depend on.
  virtual std::size_t room(int horizon, int variables) const = 0;

  // The outputs at the sample itself, of state_size() numbers.
  virtual void output(const double* state, double* y, double* room) const = 0;
  // From prediction_size() numbers. `with_extras`: otherwise their places are left as they are.
  virtual void predict(const double* state, const double* u, int horizon, bool with_extras, double* signals,
                       double* room) const = 0;
  // Along the prediction that was made last in this room, with these arguments: by_variables is how the inputs depend
  // on the variables, P inputs() x variables; the result is P signals() x variables, exact.
  virtual void sensitivities(const double* u, int horizon, bool with_extras, const double* by_variables, int variables,
                             double* result, double* room) const = 0;
  // The state at the next sample, of state_size() numbers.
  virtual void advance(const double* state, const double* u, double* next, double* room) const = 0;
  // The state when nothing has moved since long ago, as far as inputs and outputs tell it.
  virtual void start(const double* u, const double* y, double* state) const = 0;
  // Whether the state consists of past outputs and inputs; then `measure` puts measured outputs of this sample into it.
  virtual bool is_made_of_outputs() const = 0;
  virtual void measure(const double* y, double* state) const { (void)y, (void)state; }
};

}  // namespace plantloop
