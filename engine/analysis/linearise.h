// A diagram as a linear model around an operating point, by its exact derivatives with modes frozen (S16).

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/analysis/linear_model.h"
#include "engine/graph/graph.h"
#include "engine/run/diagram.h"

namespace plantloop {

// Inputs and outputs are paths of signals: "plant.u", "y", "x.2"; a vector stands for all its elements. An input is a
// number added to that wire. What drives a wire of `open` counts as constant, so that a loop can be cut there; the
// operating point stays that of the closed loop.
struct LineariseRequest {
  Overrides set;
  std::vector<std::string> inputs, outputs, open;
  std::optional<double> at;  // s; run until then. Not given: the initial values
  bool trim = false;         // first look for a rest near there, with the inputs as they are
  bool hold = false;         // sampled values stay as they are: the continuous part alone, also where there are rates
};

// With sampled blocks the model is sampled, with the least common multiple of all periods: its states are those just
// before the hit that all periods begin with, its inputs are held over the period, and its outputs are those at that
// hit. Held values that outlive a period are states, too. Nothing when the diagram or the request is wrong (see the
// report, which warns of blocks that have no derivative); throws RunError when the run to `at` fails.
std::optional<LinearModel> linearise(const std::shared_ptr<const Model>& model, const LineariseRequest& request,
                                     Report& report);

// What a trim may change and what it must reach.
struct TrimRequest {
  Overrides set;
  // Inputs: wires, to which a number is added until all is at rest; with bounds of the wire's value.
  struct Free {
    std::string path;
    double lower = -unbounded, upper = unbounded;
  };
  std::vector<Free> inputs;
  std::vector<std::pair<std::string, double>> outputs;  // signals and the values that they must have
  std::vector<std::pair<std::string, double>> fixed;    // states and the values that they keep
  std::vector<Free> states;                             // bounds of states
  std::optional<double> at;                             // s; begin there instead of at the initial values
};

struct Trim {
  struct Entry {
    std::string path;
    double value = 0;
    double residual = 0;  // states: the derivative, or next - present; outputs: value - wanted; inputs: 0
  };
  std::vector<Entry> states, inputs, outputs;
  double largest_residual = 0;  // relative to 1 + |value|
  bool converged = false;
  int iterations = 0;
  std::string why;  // it ended: "at rest to rounding", "the equations have no solution here: ..."
};

// A rest: all derivatives are zero and sampled states repeat themselves, by Newton's method with exact derivatives,
// damped (Levenberg-Marquardt) and projected into the bounds. With fewer equations than unknowns the point nearest to
// the start is found.
std::optional<Trim> trim(const std::shared_ptr<const Model>& model, const TrimRequest& request, Report& report);

}  // namespace plantloop
