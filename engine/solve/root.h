// Where the first of several functions of time changes its sign: state events.
//
// A function fires on (t0, t1] when its sign at t1 differs from its last nonzero sign before (zero counts as changed)
// and the change goes in its direction. Zero counts as the sign that it is told to count as, else as changed. A
// function that stays at zero does not fire again. The change is located in time, never by the size of the function.
// Two changes of one function inside one interval cancel and are not seen; `look_halfway` sees those that the middle
// shows.

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace plantloop {

enum class Direction : std::int8_t { down = -1, both = 0, up = 1 };

// How near in time two events are the same: max(event_tol, 10 * 128 * eps * max(1, |t|)) s.
double event_tolerance(double t, double event_tol);

class RootFinder {
 public:
  // Writes the value of every function at time t.
  using Functions = std::function<void(double t, double* values)>;

  // `at_zero`: the sign that zero counts as, for each function; 0: whatever it crosses to. Empty: 0 for all.
  explicit RootFinder(std::vector<Direction> directions, double event_tol = 0, std::vector<std::int8_t> at_zero = {});

  std::size_t size() const { return directions_.size(); }

  // The interval in which functions fired: `before` (none has) < `time` (all of `fired` have), as near as the
  // tolerance. The values are those at `time`.
  struct Crossing {
    double before = 0;
    double time = 0;
    std::span<const int> fired;      // ascending; valid until the next call
    std::span<const double> values;  // the same
  };

  // The first crossing on (t0, t1]; nothing when no function fires. Does not change the memory of signs.
  // Evaluates at t1, when asked halfway, and then only inside an interval that holds a crossing.
  std::optional<Crossing> first(double t0, double t1, const Functions& evaluate, bool look_halfway = false);

  // Takes the signs of these values into memory; a zero leaves a function's last sign as it was, a NaN all that is
  // known about it. To be called at the start, after each interval without crossing (with values()), and after an event
  // with the values that its actions left.
  void remember(std::span<const double> values);
  // The same for functions that fired: a zero counts as the other side, so that leaving it there does not fire again.
  void remember_fired(std::span<const int> fired, std::span<const double> values);
  // Whether function i fires when it comes to this value from what is remembered.
  bool fires(std::size_t i, double value) const;
  // The values at t1 of the last first() that found nothing.
  std::span<const double> values() const { return right_; }
  // The last nonzero signs, -1 or 1; 0 while a function was only zero.
  std::vector<std::int8_t>& signs() { return signs_; }
  // All that is remembered, for checkpoints.
  struct Memory {
    std::vector<std::int8_t> signs;
    std::vector<bool> at_zero;
  };
  Memory memory() const { return {signs_, at_zero_}; }
  void set_memory(const Memory& memory) {
    signs_ = memory.signs;
    at_zero_ = memory.at_zero;
  }

 private:
  std::int8_t sign_of(std::size_t i, double value) const;
  bool crosses_inside(std::size_t i, double value) const;
  bool collect(const std::vector<double>& values);
  double estimate(double a, double b) const;

  std::vector<Direction> directions_;
  double event_tol_;
  std::vector<std::int8_t> sign_at_zero_;
  std::vector<std::int8_t> signs_;
  std::vector<bool> at_zero_;  // when last remembered
  std::vector<double> left_, middle_, right_;
  std::vector<int> fired_;
};

}  // namespace plantloop
