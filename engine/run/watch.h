// What is noticed while a run goes on, to be told at its end: chatter, steps that collapse, parts that never ran.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/run/frame.h"
#include "engine/run/simulation.h"

namespace plantloop {

class RunWatch {
 public:
  RunWatch(const Frame& frame, const SimulationOptions& options);

  // A guard fired at time t (s).
  void fired(std::size_t guard, double t);
  // A conditional part is active, or a trigger counted: the jump that stands for it.
  void active(std::size_t jump) { active_[jump] = 1; }
  // To be called before modes change: until t (s) they were as they stand in the arena.
  void modes_until(double t);
  // The rates of `bits` had a hit at time t (s), and all is computed: what controllers say of their search is counted,
  // and what is at its limit.
  void hit(double t, Mask bits);
  // To be called before each step, and after one whose length the integrator chose.
  void before_step(std::size_t states);
  void after_step(double before, double after, std::size_t states);

  // What may have made a run too long, for the message that ends it: "\n  ...", or nothing.
  std::string hint() const;
  // What there is to say at the end; `whole` is false for a run that went on from a checkpoint.
  void finish(double t, bool whole, RunStatistics& statistics);

 private:
  void tell_statuses();
  void limits_until(double t);
  void explain_short_steps(double t, double h);
  const Program::Guard& guard(std::size_t g) const { return program_.guards[g]; }
  std::string name_of(std::size_t g) const;
  std::uint32_t site_of(std::size_t g) const;

  const Frame& frame_;
  const Program& program_;
  const SimulationOptions& options_;
  double modes_since_, hit_since_;
  // s; of modes that say that a limit is reached, of sampled limits, and whether they were at it after the last hit.
  std::vector<double> mode_time_, limit_time_;
  std::vector<std::uint8_t> at_limit_;
  // Per guard: events in all, its last one (s), how many follow each other closely, and since when (s).
  std::vector<std::int64_t> events_;
  std::vector<double> last_event_, streak_start_;
  std::vector<int> streak_;
  std::vector<std::uint8_t> chatters_, active_;
  // Kernels that say how they fared: where they write it, and how often they said what.
  struct Status {
    std::uint32_t kernel;
    SlotIndex slot;
    std::vector<std::string> words;
    std::vector<std::int64_t> counts;
  };
  std::vector<Status> statuses_;
  int short_steps_ = 0;
  bool collapsed_ = false;
  std::vector<double> states_before_;
  std::vector<double> first_states_;
  std::string why_short_;  // the steps are, where it is no finding
  std::vector<RunFinding> findings_;
};

}  // namespace plantloop
