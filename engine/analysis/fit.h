// Parameters of a diagram fitted to measured signals.
//
// With residuals r_i = w_i (y(t_i; p) - data_i) the sum of their squares, over all experiments, is made smallest by the
// method of Levenberg and Marquardt (J. More, The Levenberg-Marquardt algorithm, 1978), within bounds.

#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/analysis/matrix.h"
#include "engine/run/diagram.h"

namespace plantloop {

struct FitParameter {
  std::string path;             // a number of the diagram: "Q", "controller.K.2", "theta.initial"
  std::optional<double> start;  // nothing: the diagram's value
  double lower = -unbounded, upper = unbounded;
};

// What was measured. Values that are not a number are missing and do not count.
struct FitData {
  struct Column {
    std::string signal;          // the diagram's: "theta", "plant.y.2"
    std::vector<double> values;  // in the signal's unit, one for each time
    double weight = 1;           // 1/standard deviation of its noise
  };
  std::vector<double> time;  // s, ascending
  std::vector<Column> columns;
};

// One of several runs that share the fitted parameters: what it sets beside FitRequest::run, and what was measured.
struct FitExperiment {
  Overrides set;
  FitData data;
};

struct FitRequest {
  RunRequest run;  // set, solver and tolerances; rtol is 1e-10 where it is not given, atol 1e-13
  std::vector<FitParameter> parameters;
  std::vector<FitExperiment> experiments = std::vector<FitExperiment>(1);
  bool absolute = false;  // the weights are those of the true noise; else the residuals tell how strong it is
  double confidence = 0.95;
  std::size_t starts = 1;   // further ones are drawn evenly within the bounds, which must be finite then
  std::uint64_t seed = 1;   // of the draws: start i does not depend on how many there are
  std::size_t threads = 0;  // over the starts; 0: see thread_count()
  int most_iterations = 200;
  bool differences = false;  // never exact derivatives
};

struct FitResult {
  struct Estimate {
    std::string path;
    double start = 0, value = 0;
    double deviation = 0;         // standard deviation; NaN where it is on a bound or the data leave no freedom
    double lower = 0, upper = 0;  // confidence interval
    bool on_bound = false;
  };
  struct Column {
    std::string signal;
    std::size_t experiment = 0;  // of FitRequest::experiments
    std::size_t values = 0;      // that were not missing
    double rms = 0;              // of y - data, in the signal's unit
    std::vector<double> fitted;  // y at the times of the data
  };
  std::vector<Estimate> parameters;
  DenseMatrix covariance, correlation;  // of the parameters in their order; zero rows for those on a bound
  std::vector<Column> columns;          // by experiments
  std::size_t experiments = 1;
  double cost = 0;  // sum of the weighted squares
  std::size_t values = 0, degrees = 0;
  bool converged = false;
  int iterations = 0, runs = 0;
  std::string why;            // it ended
  std::string gradient;       // "exact", or "differences: ..." with the reason
  std::vector<double> costs;  // of all starts; NaN for those that failed
};

struct FitControl {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(int iteration, double cost)> progress;  // of the first start
};

// Derivatives are exact (forward sensitivities that run beside the states, through hits and events at fixed times).
// Where they are not known, as through events whose time depends on a parameter, they are differences, and `gradient`
// says so. Nothing after reporting what is wrong: unknown names, data that do not fit the diagram, parameters that
// change nothing or that the data cannot tell apart. Throws RunError when the first run fails, LimitError when
// cancelled.
std::optional<FitResult> fit(const std::shared_ptr<const Model>& model, const FitRequest& request, Report& report,
                             const FitControl& control = {});

// The result as a table for people.
std::string to_text(const FitResult& result, double confidence);

}  // namespace plantloop
