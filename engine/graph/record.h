// Graph -> Record: every block writes its equations once, in the order of the full paths, never in the file's order.

#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engine/graph/graph.h"
#include "engine/program/record.h"

namespace plantloop {

// A bound of a parameter: to be checked whenever tunable numbers are set.
struct RecordedBound {
  std::string name;  // "plant.tau", elements with a dot
  Value value;       // over parameters only; a known number has been checked already and is not listed
  double min = -unbounded, max = unbounded, above = -unbounded;
  Mark mark;  // where it was set
};

// What `record`, `figures` and `expect` show: one element each.
struct ShownColumn {
  std::string name;  // "theta", "blended.mu.1"; for an expression without column name its text
  Value value;
  std::string unit;
  RateIndex rate = 0;
  bool written = false;                 // named by `record:`; the others are logged only
  std::vector<std::string> names = {};  // of a state machine's state: what the numbers from 1 are called
};

// What must happen when a tunable number gets a new value; parallel to Record::parameters.
enum class ParameterUse : std::uint8_t {
  tunable,          // only its slot changes
  zero_structural,  // a new compilation when it becomes or leaves zero: it is an entry of a matrix whose zeros remove
                    // paths
  structural,       // a new compilation: a size, a period or a choice depends on it
};

struct RecordedGraph {
  Record record;
  std::vector<ParameterUse> uses;
  std::vector<RecordedBound> bounds;
  std::vector<ShownColumn> columns;  // first the written ones, in the order of `record:`
  // Which columns an expression of `record`, `figures` or `expect` became: {first, count}; more than one for a vector.
  struct Range {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  std::unordered_map<const Expression*, Range> shown;
  // What the expressions of `expect` and `figures` that are no signals are worth: numbers over parameters only.
  std::unordered_map<const Expression*, Value> numbers;
  // Whether an expression is all known numbers is no matter: its column then has a known Value.
  const Range* find(const ExpressionPtr& expression) const {
    const auto it = shown.find(expression.get());
    return it == shown.end() ? nullptr : &it->second;
  }
};

// A wire to which a number is added that can be set, 0 to begin with: an input of a linear model, the unknown of a
// trim.
struct Probe {
  std::uint32_t net = 0;
  bool open = false;  // what drives the wire is to count as constant there: `RecordedProbe::driver`
};
struct RecordedProbe {
  std::string name;             // of the element: "plant.u", "x.3"
  std::uint32_t parameter = 0;  // into Record::parameters
  Value driver;                 // what is read without the number; an operation of its own when `open`
};

// With `probes`, appends one RecordedProbe for each element of each net to `probed`.
RecordedGraph record(const Graph& graph, const std::vector<Probe>& probes = {},
                     std::vector<RecordedProbe>* probed = nullptr);

}  // namespace plantloop
