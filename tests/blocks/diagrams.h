// Diagrams written in a test, checked and run.

#pragma once

#include <string>
#include <vector>

#include "engine/run/diagram.h"

namespace plantloop::testing_diagrams {

// What a run recorded, by column name.
class Signals {
 public:
  explicit Signals(DiagramRun run) : run_(std::move(run)) {}
  const DiagramRun& whole() const { return run_; }
  const Recording& recording() const { return run_.recording; }
  // The value of a column at time t; at a jump the right side unless `left`. Exact only where a row stands.
  double at(const std::string& column, double t, bool left = false) const;
  // The value at one of the times that `expect:` asks about: computed there, not read between rows.
  double sampled(const std::string& column, double t) const;
  double last(const std::string& column) const;
  std::vector<double> column(const std::string& name) const;
  // Its samples at the hits of its rate, or at all rows when it is continuous.
  std::vector<double> samples(const std::string& name) const;
  // The greatest absolute value over all rows.
  double greatest(const std::string& name) const;

 private:
  std::size_t index(const std::string& name) const;
  DiagramRun run_;
};

// Runs a diagram; `text` is all of the file but its first line, `plantloop: 1`. Throws std::runtime_error with the
// findings when the diagram is wrong.
Signals run(const std::string& text, const RunRequest& request = {});
// The findings on a diagram as a user would read them; "" when there are none.
std::string findings(const std::string& text);

}  // namespace plantloop::testing_diagrams
