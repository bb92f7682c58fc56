// Many runs of one diagram, each with other parameters, on threads.

#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/run/diagram.h"

namespace plantloop {

// The points of a sweep: every combination of the grid's values, with each of them every row of the list, with each of
// those every draw. The last one changes fastest.
struct SweepPlan {
  struct Values {
    std::string path;                // as for Override
    std::vector<std::string> texts;  // expressions
  };
  struct Random {
    std::string path;
    std::string distribution;  // see distributions()
    double a = 0, b = 1;
  };
  std::vector<Values> grid;
  std::vector<Values> list;  // all of one length: row i has the i-th value of each
  std::vector<Random> random;
  std::size_t draws = 1;
  std::uint64_t seed = 1;
};

// uniform(a, b): evenly between them. log_uniform(a, b): its logarithm is, 0 < a. normal(a, b): mean and standard
// deviation.
struct DistributionInfo {
  std::string_view name, arguments;
};
const std::vector<DistributionInfo>& distributions();

// Draw number i of a parameter is a function of the seed, its path and i alone: it does not change when others come or
// go, nor with the number of draws. Nothing after reporting what is wrong with the plan.
std::optional<std::vector<Overrides>> sweep_points(const SweepPlan& plan, Report& report);

struct SweepPoint {
  Overrides set;                  // of this point
  std::optional<DiagramRun> run;  // nothing when it failed
  std::string failure;            // what the run or the findings say
};

struct SweepRequest {
  RunRequest run;                 // the same for all; its `set` comes before that of the points
  std::vector<Overrides> points;  // see sweep_points()
  std::size_t threads = 0;        // 0: see thread_count()
  // Called after each run on the thread that did it, several at once: what is needed may be taken from the point, and
  // the run be dropped.
  std::function<void(std::size_t index, SweepPoint& point)> finished;
};

struct SweepControl {
  const std::atomic<bool>* cancel = nullptr;                        // ends all runs with a LimitError
  double time_limit = 0;                                            // s, for all together; 0: none
  std::function<void(std::size_t done, std::size_t all)> progress;  // from any thread, one at a time
};

// The points in order, identical for any number of threads. One that fails says why and leaves the others alone.
// Nothing when no point can run for what its findings say: those of the first are reported. Throws LimitError when
// cancelled.
std::optional<std::vector<SweepPoint>> sweep(Diagram& diagram, const SweepRequest& request, Report& report,
                                             const SweepControl& control = {});

}  // namespace plantloop
