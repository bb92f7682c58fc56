// When the sampled blocks have their hits and when the sources have their edges: the next stop of a run.

#pragma once

#include <cstdint>
#include <vector>

#include "engine/run/frame.h"
#include "engine/run/grid.h"

namespace plantloop {

class Clockwork {
 public:
  // Reads the instants of the schedules from the frame's parameters. Throws RunError for a period that is not positive,
  // for instants out of order, and when hits cannot be counted exactly up to `stop`.
  Clockwork(Frame& frame, double start, double stop);

  double next() const { return next_; }  // s; infinity when nothing is left
  // Takes the hits and edges at time t (t is next() or earlier): counts them, and returns the bits of the rates that
  // have a hit, with event_bit when a source's segment changed.
  Mask advance(double t);
  // A hit of a triggered rate at the present instant; a second one there is the same.
  void trigger(RateIndex rate);
  void no_hits() { hit_rates_.clear(); }                                  // at an instant that is no hit of a clock
  const std::vector<RateIndex>& hit_rates() const { return hit_rates_; }  // of the present instant
  // Goes on from the frame's numbers of the next hits and instants, as a checkpoint restored them.
  void resume();

 private:
  double hit_time(std::size_t rate) const;
  double instant(std::size_t schedule) const;
  void find_next();

  Frame& frame_;
  double stop_;                                    // s
  std::vector<std::vector<double>> instants_;      // of the schedules that are lists
  std::vector<TimeGrid> grids_;                    // of the others
  std::vector<double> hit_times_, instant_times_;  // the next ones
  std::vector<RateIndex> hit_rates_;
  double next_ = 0;
};

}  // namespace plantloop
