// Compiling with all signals watched keeps each one's operation, so that order and feedthrough can be read off.

#include "engine/analysis/explained.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>

#include "engine/analysis/explain.h"

namespace plantloop {

std::vector<std::uint32_t> Explained::operations_of(const GraphNet& net) const {
  std::vector<std::uint32_t> found;
  const std::string path = path_of(*graph, net);
  const auto take = [&](const std::string& name) {
    const auto at = signal_at.find(name);
    if (at != signal_at.end()) found.push_back(program->resolved->watches[at->second]);
  };
  const Shape& shape = net.shape;
  if (shape.is_scalar()) {
    take(path);
    return found;
  }
  for (int i = 0; i < shape.size(); ++i) {
    take(shape.rank == 1 ? fmt::format("{}.{}", path, i + 1)
                         : fmt::format("{}.{}.{}", path, i / shape.columns + 1, i % shape.columns + 1));
  }
  return found;
}

bool Explained::reaches(const std::vector<std::uint32_t>& from, const std::vector<std::uint32_t>& to) const {
  const OperationGraph& all = operations();
  std::unordered_set<std::uint32_t> seen;
  std::vector<std::uint32_t> open = to;
  while (!open.empty()) {
    const std::uint32_t id = open.back();
    open.pop_back();
    if (!seen.insert(id).second) continue;
    const Operation& o = all.operations[id];
    if (o.op == Op::constant || o.is_parameter_only()) continue;
    if (std::find(from.begin(), from.end(), id) != from.end()) return true;
    if (o.op == Op::kernel) {
      for (const auto i : all.kernels[o.a].inputs) open.push_back(i);
      continue;
    }
    if (o.op == Op::kernel_output) {
      open.push_back(o.a);
      continue;
    }
    if (is_leaf(o.op)) continue;
    const int arity = arity_of(o.op);
    if (arity > 0) open.push_back(o.a);
    if (arity > 1) open.push_back(o.b);
    if (arity > 2) open.push_back(o.c);
  }
  return false;
}

std::unique_ptr<const Explained> make_explained(std::shared_ptr<const Model> model, const Overrides& set,
                                                Report& report) {
  auto e = std::make_unique<Explained>();
  e->graph = elaborate(std::move(model), set, report);
  if (!e->graph || report.has_errors()) return nullptr;
  e->recorded = record(*e->graph);
  CompileOptions options;
  const auto& signals = e->recorded.record.signals;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    options.watches.push_back(signals[i].value);
    e->signal_at.emplace(signals[i].name, i);
  }
  e->program = compile(e->recorded.record, options, report);
  if (!e->program || report.has_errors()) return nullptr;
  return e;
}

std::string counted(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string in_words(const Shape& shape) {
  if (shape.is_scalar()) return "scalar";
  return shape.rank == 1 ? fmt::format("vector of {}", shape.size())
                         : fmt::format("matrix of {} x {}", shape.size() / shape.columns, shape.columns);
}

std::string in_words(const Graph& graph, const GraphRate& rate) {
  if (rate.kind == GraphRate::Kind::constant) return "constant";
  if (rate.kind == GraphRate::Kind::continuous) return "continuous";
  const ClockRate& clock = graph.rates[rate.index];
  if (clock.trigger != 0)
    return fmt::format("triggered by {} ('{}')", to_string(*graph.activations[clock.trigger].trigger_when.code->tree),
                       graph.activations[clock.trigger].path);
  std::string text = fmt::format("sampled every {} s", clock.period.to_double());
  if (!clock.offset.is_zero()) text += fmt::format(", first at {} s", clock.offset.to_double());
  return text;
}

std::vector<std::uint32_t> nets_read(const Graph& graph, const BoundExpression& expression) {
  std::vector<std::uint32_t> nets;
  for (std::size_t i = 0; expression && i < expression.code->names.size(); ++i) {
    const Reference& r = graph.references[expression.first_reference + i];
    if (r.kind == Reference::Kind::net && std::find(nets.begin(), nets.end(), r.index) == nets.end())
      nets.push_back(r.index);
  }
  return nets;
}

std::string driver_text(const GraphNet& net) {
  if (net.by_parameter || !net.driver) return {};
  return to_string(*net.driver.code->tree);
}

namespace {

// The block whose output a net is, through subsystem borders and plain names; nowhere when an expression mixes several.
std::uint32_t block_behind(const Graph& graph, std::uint32_t net) {
  for (int depth = 0; depth < 100; ++depth) {
    const GraphNet& n = graph.nets[net];
    if (n.kind == GraphNet::Kind::output || n.kind == GraphNet::Kind::expression) return n.owner;
    const auto read = nets_read(graph, n.driver);
    if (read.size() != 1) return nowhere;
    net = read[0];
  }
  return nowhere;
}

}  // namespace

std::string rate_reasons(const Graph& graph, std::uint32_t index, const std::string& indent) {
  std::string text;
  std::vector<std::uint32_t> seen;
  while (index != nowhere && std::find(seen.begin(), seen.end(), index) == seen.end()) {
    seen.push_back(index);
    const GraphBlock& block = graph.blocks[index];
    const bool expression = block.type == nullptr;
    const GraphRate rate = expression ? graph.nets[block.first_output].rate : block.rate;
    std::string reason(block.rate_reason);
    if (expression && reason.empty()) reason = "from its inputs";
    if (reason == "stated") {
      text += fmt::format("{}'{}' is {}: 'rate:' says so ({})\n", indent, block.path, in_words(graph, rate),
                          to_string(block.declaration->rate_mark));
      break;
    }
    if (reason.empty()) {
      reason = rate.kind == GraphRate::Kind::continuous ? "it has continuous states" : "nothing that it reads changes";
      if (block.type && block.type->block->states.empty() && rate.kind == GraphRate::Kind::continuous)
        reason = "its type is";
    }
    std::uint32_t next = nowhere;
    std::string because;
    if (reason == "from its inputs") {
      std::vector<std::uint32_t> inputs;
      if (expression) {
        inputs = nets_read(graph, graph.nets[block.first_output].driver);
      } else {
        for (std::uint32_t i = 0; i < block.inputs; ++i) {
          const auto read = nets_read(graph, graph.nets[block.first_input + i].driver);
          inputs.insert(inputs.end(), read.begin(), read.end());
        }
      }
      for (const auto net : inputs) {
        if (!(graph.nets[net].rate == rate)) continue;
        because = path_of(graph, graph.nets[net]);
        next = block_behind(graph, net);
        break;
      }
      if (because.empty() && rate.kind == GraphRate::Kind::continuous) reason = "it reads the time, or mixes rates";
    }
    text += fmt::format("{}'{}' is {}: {}\n", indent, block.path, in_words(graph, rate),
                        because.empty() ? reason : fmt::format("it follows '{}'", because));
    index = next;
  }
  return text;
}

std::optional<std::string> explain(std::shared_ptr<const Model> model, const Overrides& set, const std::string& name,
                                   Report& report) {
  const auto e = make_explained(std::move(model), set, report);
  if (!e) return std::nullopt;
  if (name.empty()) return explain_diagram(*e);
  std::string text = explain_name(*e, name);
  if (!text.empty()) return text;
  std::vector<std::string> names;
  for (const GraphBlock& block : e->graph->blocks) names.push_back(block.path);
  for (const RecordedSignal& signal : e->recorded.record.signals) names.push_back(signal.name);
  for (const RecordedParameter& parameter : e->recorded.record.parameters) names.push_back(parameter.name);
  const std::string near = nearest(name, names);
  Finding& finding = report.error({}, "the diagram has nothing named '{}'", name);
  if (!near.empty()) finding.hint(fmt::format("did you mean '{}'?", near));
  return std::nullopt;
}

}  // namespace plantloop
