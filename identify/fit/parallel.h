// Independent pieces of work on several threads.

#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <utility>

#include "identify/fit_report.h"
#include "identify/random.h"

namespace plantloop::identify {

// Calls work(0), ..., work(count - 1), each once, on at most `threads` threads (0: as LP_NUM_THREADS says, or as many
// as the machine has). Each piece writes to a place of its own, so the result does not depend on the number of threads.
// Of several pieces that throw, the exception of the first one is passed on when all have ended; no further ones are
// begun then.
void parallel_for(int count, int threads, const std::function<void(int)>& work);

// The random numbers of start number 0, 1, ... of a fit.
inline Random random_of_start(std::uint64_t seed, int number) {
  return Random(seed + 0x9e3779b97f4a7c15ULL * static_cast<std::uint64_t>(number + 1));
}

// Progress of pieces that run at the same time, told from the thread that made it; any thread learns that the fit is
// cancelled, or that another piece has ended it.
class Watch {
 public:
  Watch(FitControl control, double total) : control_(std::move(control)), total_(total) {}
  // One of `total` steps is about to be done. Throws Cancelled.
  void step() {
    const long long done = ++done_;
    look();
    if (std::this_thread::get_id() != owner_) return;
    try {
      control_.step(std::min(1.0, static_cast<double>(done) / total_));
    } catch (...) {
      ended_ = true;  // the others need not go on
      throw;
    }
  }
  // Throws Cancelled when the fit is to end.
  void look() const {
    if (ended_.load(std::memory_order_relaxed)) throw Cancelled("the fit was stopped");
    control_.look();
  }
  // Steps that need not be done any more.
  void skip(int steps) { done_ += std::max(0, steps); }

 private:
  FitControl control_;
  double total_;
  std::atomic<long long> done_{0};
  std::atomic<bool> ended_{false};
  std::thread::id owner_ = std::this_thread::get_id();
};

// Lets the inside of a long step on this thread look at a watch, by look_up(), without handing it down to there.
class Watched {
 public:
  explicit Watched(const Watch& watch) : before_(current()) { current() = &watch; }
  ~Watched() { current() = before_; }
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;
  static const Watch*& current() {
    thread_local const Watch* watch = nullptr;
    return watch;
  }

 private:
  const Watch* before_;
};

// Throws Cancelled when the fit of which this is a part is to end; costs some 50 ns.
inline void look_up() {
  if (const Watch* watch = Watched::current()) watch->look();
}

}  // namespace plantloop::identify
