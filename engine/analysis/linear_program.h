// A diagram compiled for its derivatives: with probes on the wires that are inputs, at an operating point.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/analysis/matrix.h"
#include "engine/graph/record.h"
#include "engine/run/diagram.h"

namespace plantloop {

// The instants of hits in one period of the whole, and the pieces of flow between them.
struct HitPattern {
  double period = 0;                // s; 0: no sampled blocks
  std::vector<Mask> sets;           // distinct sets of rates that have hits together
  std::vector<std::size_t> set_at;  // which set each instant has
  std::vector<double> after;        // s; from each instant to the next
};

// Derivatives in terms of states, discrete states, probes, held values and time, in this order.
struct Sensitivity {
  std::size_t states = 0, discretes = 0, probes = 0, held = 0;
  std::size_t first_discrete() const { return states; }
  std::size_t first_probe() const { return states + discretes; }
  std::size_t first_held() const { return states + discretes + probes; }
  std::size_t columns() const { return states + discretes + probes + held + 1; }
};

struct LinearProgram {
  std::shared_ptr<const Graph> graph;
  RecordedGraph recorded;
  std::shared_ptr<const Program> program;
  SimulationOptions options;
  std::vector<RecordedProbe> probes;
  std::vector<std::string> outputs;  // names of the first watches
  HitPattern pattern;
  std::unique_ptr<Frame> frame;
  Sensitivity size() const;
  // Runs from the initial values until a time, or takes the initial values.
  void go_to(std::optional<double> time);
  // The entries of a list at the frame's values.
  DenseMatrix evaluate(const Program::PartialList& list, std::size_t rows) const;
  double output(std::size_t index);  // its value, once evaluate_outputs() has run
  void evaluate_outputs();
};

// The signals of the record that a path means, elements apart: "plant.x", "xh.3". `what` begins the message when there
// is none, "the output"; then the result is empty.
std::vector<const RecordedSignal*> signals_at(const Graph& graph, const Record& record, const std::string& path,
                                              const char* what, Report& report);

// Null after reporting what is wrong.
std::unique_ptr<LinearProgram> make_linear_program(const std::shared_ptr<const Model>& model, const Overrides& set,
                                                   const std::vector<std::string>& inputs,
                                                   const std::vector<std::string>& open,
                                                   const std::vector<std::string>& outputs, Report& report);

}  // namespace plantloop
