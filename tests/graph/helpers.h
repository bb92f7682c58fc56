// Diagrams in a test: text -> Graph -> Record, and what the recorded operations are worth.

#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/graph/record.h"

namespace plantloop {

// The graph of a diagram's text; fails the test, with the findings, when it has any error.
std::shared_ptr<const Graph> graph_of(const std::string& text, const Overrides& overrides = {});
// What is wrong with a text: the messages, one a line, without places.
std::string errors_of(const std::string& text, const Overrides& overrides = {});

// The recorded operations with values for the leaves, evaluated one by one.
class Evaluated {
 public:
  explicit Evaluated(const RecordedGraph& recorded, double time = 0) : record_(recorded.record), time_(time) {}
  std::map<std::string, double> states;      // by name; others have their initial values
  std::map<std::string, double> parameters;  // likewise
  double of(Value value);
  double signal(const std::string& name);
  double derivative(const std::string& state);

 private:
  double leaf(const RecordedNode& node);
  const Record& record_;
  double time_;
  std::map<std::uint32_t, double> known_;
};

}  // namespace plantloop
