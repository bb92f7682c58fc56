// A diagram file, ready to run any number of times: what the command line and Lua work with.
//
//   Report report;
//   auto diagram = Diagram::load("car.yaml", report);           // null when the file cannot be read
//   auto run = diagram->run({.set = {{"controller.ki", "20"}}}, report);   // nothing when the diagram is wrong

#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/report.h"
#include "engine/graph/graph.h"
#include "engine/graph/record.h"
#include "engine/run/simulation.h"

namespace plantloop {

// What a run changes about its diagram; what is not given is as the file says.
struct RunRequest {
  Overrides set;
  std::optional<double> start, stop, step, rtol, atol, max_step, output_interval;
  std::optional<std::string> solver;
  std::vector<double> save_at;       // s; save points, see engine/run/checkpoint.h
  bool save_at_end = false;          // the stop is one, too
  bool partial = false;              // go on from a checkpoint of another structure: values of equal paths
  std::optional<double> max_memory;  // bytes that the recording may take
};

// The answer to one entry of `expect:`.
struct Verdict {
  std::string text;  // the entry as written
  bool met = false;
  std::string measured;  // "0.864921, wanted 0.864941 within 0.001"
  Mark mark;
  const ExpectDecl* entry = nullptr;                  // of the diagram's model
  std::size_t column = static_cast<std::size_t>(-1);  // of the recording that decided; none for events
};

struct RunTiming {
  double compile = 0, simulate = 0;  // s
};

struct DiagramRun {
  Recording recording;
  RunStatistics statistics;
  SimulationOptions options;
  std::vector<Verdict> verdicts;
  RunTiming timing;
  // The numbers of the figures' and expectations' expressions in this run.
  std::map<const Expression*, double> numbers;
  // The columns that an expression of `record`, `figures` or `expect` became.
  std::unordered_map<const Expression*, RecordedGraph::Range> shown;
};

// One structure of a diagram: everything up to the Program. Immutable, shared by runs and threads.
struct CompiledDiagram {
  std::shared_ptr<const Graph> graph;
  RecordedGraph recorded;
  std::shared_ptr<const Program> program;
  SimulationOptions options;                                       // of `simulation:`
  std::vector<std::pair<const Expression*, std::size_t>> numbers;  // which of Program::numbers
  std::size_t first_bound = 0;                                     // in Program::numbers
  double compile_time = 0;                                         // s
};

// What one run needs.
struct PreparedRun {
  std::shared_ptr<const CompiledDiagram> compiled;
  SimulationOptions options;
  std::unique_ptr<Frame> frame;  // with the parameters set
  std::vector<RecordedColumn> columns;
};

// The settings of `simulation:`, after reporting what is wrong about them.
SimulationOptions read_settings(const Model& model, const Graph& graph, Report& report);

class Diagram {
 public:
  // Reads the file and what it imports; null when it cannot be read as a diagram at all (the report says why).
  // `plots`: the plot types that its figures may use.
  static std::shared_ptr<Diagram> load(const std::string& path, Report& report, const PlotWords& plots = no_plots());
  static std::shared_ptr<Diagram> from_text(const std::string& text, const std::string& path, Report& report,
                                            const PlotWords& plots = no_plots());

  const Model& model() const { return *model_; }
  const std::shared_ptr<const Model>& model_pointer() const { return model_; }
  double read_time() const { return read_time_; }  // s
  // Everything but running.
  void check(const Overrides& set, Report& report);
  // Runs the diagram. A new value of a tunable parameter does not compile again; a structural change does, once for
  // each structure. Nothing when the diagram or the request is wrong (see the report); throws RunError and LimitError
  // from the run, and then `partial` (when given) has what was recorded until then.
  std::optional<DiagramRun> run(const RunRequest& request, Report& report, const RunControl& control = {},
                                DiagramRun* partial = nullptr);
  // A run up to its start; null when the diagram or the request is wrong (see the report).
  std::optional<PreparedRun> prepare(const RunRequest& request, Report& report);
  // The figures' and expectations' numbers and columns of a recording that was made before, by the names of its
  // columns, with verdicts; nothing when the diagram or the settings are wrong.
  std::optional<DiagramRun> replay(Recording recording, const Overrides& set, Report& report);

 private:
  Diagram() = default;
  std::shared_ptr<const CompiledDiagram> compiled(const Overrides& set, const std::string& unroll_method,
                                                  double unroll_step, Report& report);
  std::shared_ptr<const CompiledDiagram> build(const Overrides& set, const std::string& unroll_method,
                                               double unroll_step, Report& report) const;

  std::shared_ptr<const Model> model_;
  double read_time_ = 0;
  std::map<std::string, std::shared_ptr<const CompiledDiagram>> cache_;  // by structure
};

}  // namespace plantloop
