// A compiled diagram with every signal watched: what explanations look things up in.

#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/graph/graph.h"
#include "engine/graph/record.h"
#include "engine/program/program.h"
#include "engine/program/resolve.h"

namespace plantloop {

struct Explained {
  std::shared_ptr<const Graph> graph;
  RecordedGraph recorded;
  std::shared_ptr<const Program> program;
  // Which element of Record::signals a name is.
  std::unordered_map<std::string, std::size_t> signal_at;

  const OperationGraph& operations() const { return program->resolved->graph; }
  // The operations of all elements of a net.
  std::vector<std::uint32_t> operations_of(const GraphNet& net) const;
  // Whether an operation of `to` reads one of `from` at the same instant.
  bool reaches(const std::vector<std::uint32_t>& from, const std::vector<std::uint32_t>& to) const;
};

// Null when the diagram is wrong.
std::unique_ptr<const Explained> make_explained(std::shared_ptr<const Model> model, const Overrides& set,
                                                Report& report);

// "2 blocks", "1 block"
std::string counted(std::size_t count, const std::string& noun);
// "scalar", "vector of 3", "matrix of 2 x 3"
std::string in_words(const Shape& shape);
// "constant", "continuous", "sampled every 0.1 s, first at 0.02 s"
std::string in_words(const Graph& graph, const GraphRate& rate);
// Nets that an expression reads.
std::vector<std::uint32_t> nets_read(const Graph& graph, const BoundExpression& expression);
// Why a block has its rate, with the chain down to where it is stated: one line each, indented.
std::string rate_reasons(const Graph& graph, std::uint32_t block, const std::string& indent);
// The text that drives a net, "" for an output of a block.
std::string driver_text(const GraphNet& net);

std::string explain_diagram(const Explained& e);
// "" when there is no such name.
std::string explain_name(const Explained& e, const std::string& name);

}  // namespace plantloop
