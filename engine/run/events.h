// State events: functions that change their sign, the jumps and modes that follow, until all is settled (S10).

#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "engine/run/checkpoint.h"
#include "engine/run/kernel_advance.h"
#include "engine/run/rows.h"
#include "engine/run/run_state.h"
#include "engine/solve/root.h"

namespace plantloop {

// The last events of one function, and where they accumulate if their intervals shrink as they did.
class Accumulation {
 public:
  // An event at time t (s); a limit further away than `most` (s) is none yet.
  void add(double t, double most);
  // The time (s) at which the events accumulate; infinite when the intervals do not shrink. Events that come near the
  // limit are so close that rounding decides about them: they do not move it.
  double limit() const { return limit_; }
  // How many there were of those.
  int beyond() const { return beyond_; }

 private:
  double remaining() const;
  double back(std::size_t n) const { return times_[(count_ - 1 - n) % times_.size()]; }

  std::array<double, 17> times_{};  // s
  std::size_t count_ = 0;
  double limit_ = std::numeric_limits<double>::infinity();
  int beyond_ = 0;
  double width_ = 0;  // s; how far away the limit was when it was first found
};

// Every function throws RunError when events do not settle or follow each other without end.
class Events {
 public:
  Events(RunState& run, KernelAdvance& kernels, Rows& rows);

  bool none() const { return program_.guards.empty(); }
  // Where (s) the next step should end; not after the run's time: nowhere.
  double wanted_stop() const;
  // Forgets the steps before, as a run that goes on from a save point does.
  void forget_steps();
  // Handles the first event on (before, after], if there is one: true, and the run's time is that of the event. A long
  // step is looked at in parts as short as the gaps between rows of the whole run, so that a function that changes its
  // sign twice is seen.
  bool crossing_between(double before, double after);
  // Runs the held operations of these bits, and takes modes by the present values until they stay.
  void settle(Mask bits);
  // The same with the jumps that follow. `fired` are guards that are known to have crossed; further ones are found by
  // their signs. Gives the bits with those of the rates that were triggered.
  Mask settle_events(std::vector<int> fired, Mask bits);
  // Keeps what is held from here on, should its condition end: to be called before anything changes at a stop.
  void take_holds(double before);
  // Takes the signs of the guards into memory, as at the start of a run. Gives those that fire because their functions
  // are positive there.
  std::vector<int> remember_guards();
  // Something else happens: what a Zeno policy holds may move again.
  void release();
  // What is known of the past, for checkpoints.
  void save(Checkpoint& checkpoint) const;
  void restore(const Checkpoint& checkpoint);

 private:
  void guards_at(double t, double* values);
  bool step_again(double before, double at);
  bool in_wrong_mode(double before, double after);
  void wake();
  bool is_muted(std::size_t guard) const { return quiet_until_[guard] > run_.t; }
  bool is_frozen(std::size_t mode) const;
  void watch_for_zeno(double at);
  void end_zeno(std::size_t guard, double at, std::int8_t sign);
  void take_limit(const Program::Jump& jump);
  bool ends_zeno_after(double before, double after);
  std::vector<std::uint8_t> turned_back(double t, double tolerance);
  void note_left_true(const std::vector<int>& fired);
  // Whether a function that was not looked at before fires at once.
  bool is_due(const Program::Guard& guard, double value) const;
  bool a_jump_fired() const;
  bool only_kernels_fired(const std::vector<int>& fired) const;
  bool is_near(double a, double b) const;
  std::string names_of_fired() const;
  std::string name_of(const Program::Guard& guard) const;
  std::string mode_name(std::size_t mode) const;
  void event(bool located);
  bool jump(const std::vector<int>& fired);
  Mask trigger(const std::vector<int>& fired);
  bool is_open(SlotIndex gate) const { return gate == no_gate || frame_.arena[gate] != 0; }
  std::vector<int> guards_fired_by_now(const std::vector<int>& just_fired);
  bool modes_differ();
  std::string name_of_differing_mode() const;
  void take_modes();

  RunState& run_;
  Frame& frame_;
  const Program& program_;
  const SimulationOptions& options_;
  KernelAdvance& kernels_;
  Rows& rows_;
  RootFinder roots_;
  std::vector<double> guard_values_;
  std::vector<std::uint8_t> was_open_;  // the gates of the guards when their signs were remembered
  std::vector<int> fired_;
  double before_event_ = 0;  // s; none of fired_ has crossed there
  double wanted_stop_ = -std::numeric_limits<double>::infinity();
  double retried_at_ = std::numeric_limits<double>::quiet_NaN();
  // Per guard: its last event (s), how many came close together before it, and until when (s) it is not looked at.
  std::vector<double> last_event_, quiet_until_;
  std::vector<int> in_a_row_;
  std::vector<std::int8_t> sign_when_muted_;
  bool any_muted_ = false;
  std::vector<double> woken_at_;    // s
  std::vector<std::uint8_t> told_;  // guards whose endless events were told
  // Per guard: whether its condition held still after its action, so that it must cease to hold before it can fire
  // again. That may be too short to be seen.
  enum LeftTrue : std::uint8_t { no, yes, by_zeno, is_turned };
  std::vector<std::uint8_t> left_true_;
  bool any_left_true_ = false;
  std::vector<double> left_since_, left_value_;  // s, and the function's absolute value then
  std::vector<double> seen_;  // s; inside a step, where conditions that held at its start are seen not to hold
  std::vector<Accumulation> accumulations_;  // per guard
};

}  // namespace plantloop
