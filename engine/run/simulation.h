// One run of a Program: major steps at hits and events, integration in between, rows into a Recording.

#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/run/frame.h"
#include "engine/run/recording.h"
#include "engine/solve/integrator.h"

namespace plantloop {

struct SimulationOptions {
  double start = 0, stop = 1;  // s
  double span = 0;  // s; stop - start as the file says, 0: as above. Events are searched by it, so that a run in pieces
                    // finds the same
  std::string solver = "dopri5";
  double step = 0;  // s; > 0: fixed step
  double rtol = 1e-6, atol = 1e-9;
  double max_step = 0;         // s; 0: no limit (without states: (stop - start)/500)
  double output_interval = 0;  // s; > 0: rows on this grid only
  double event_tol = 0;        // s; 0: 10 * 128 * eps * max(1, |t|)
  std::string zeno = "error";  // error, hold or ignore: when events of one function follow each other without end
  std::int64_t max_steps = 100'000'000;
  std::int64_t max_rows = 100'000'000;
  std::vector<double> sample_times;  // s; Recording::samples has all columns there, beside the rows
  double max_memory = 16e9;          // bytes that the recording may take
  std::vector<double> save_times;    // s; save points: stops at which the solver starts anew
  bool only_start = false;           // end after the initial values, events and row of the start
};

// How the outside takes part in a run; called between steps, never inside one.
struct RunControl {
  const std::atomic<bool>* cancel = nullptr;           // set from anywhere: the run ends with a LimitError
  double time_limit = 0;                               // s of processor clock; 0: none
  std::function<void(double fraction)> progress;       // of the simulated time, at most some ten times a second
  std::function<void(const struct Checkpoint&)> save;  // called at each save point
  // Where to go on from: options.start is that of the first run. A checkpoint of another structure gives the values of
  // equal paths at its time, and all else starts anew there.
  std::shared_ptr<const struct Checkpoint> from;
  struct RunStatistics* until_failure = nullptr;  // when the run throws: what was counted and noticed until then
};

// Something that was noticed during a run; `check` is one of checks().
struct RunFinding {
  std::string check, text;
  std::uint32_t site = 0;  // into Program::sites
};

// Of the run's time, how much an element of a block's output was at a limit; counted at hits where it is sampled.
struct LimitShare {
  double share;
  std::uint32_t site = 0;  // into Program::sites
};

struct RunStatistics {
  SolverStatistics solver;
  std::int64_t rows = 0, hits = 0, events = 0, mode_changes = 0;
  std::string ended_by;               // path of the block that ended the run before its stop time; "": none did
  std::vector<std::string> warnings;  // what the run went on in spite of
  std::vector<RunFinding> findings;
  std::vector<LimitShare> limits;
};

// Runs from the initial values to the stop time. `columns` name the Program's watches, in their order; rates index
// Program::rates. Throws RunError when the mathematics fails and LimitError when a limit is reached or the run is
// cancelled; what was recorded until then stays in `recording`.
RunStatistics simulate(Frame& frame, const SimulationOptions& options, std::vector<RecordedColumn> columns,
                       Recording& recording, const RunControl& control = {});

}  // namespace plantloop
