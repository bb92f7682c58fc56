// An evaluator of recorded operations that shares nothing with the engine's executors: recursion over the nodes.

#include "tests/graph/helpers.h"

#include "engine/diagram/model.h"

namespace plantloop {

std::shared_ptr<const Graph> graph_of(const std::string& text, const Overrides& overrides) {
  Report report;
  const auto model = read_model_text(text, "diagram.yaml", report);
  const auto graph = model ? elaborate(model, overrides, report) : nullptr;
  EXPECT_TRUE(graph && !report.has_errors()) << to_text(report);
  return graph;
}

std::string errors_of(const std::string& text, const Overrides& overrides) {
  Report report;
  const auto model = read_model_text(text, "diagram.yaml", report);
  const auto graph = model ? elaborate(model, overrides, report) : nullptr;
  EXPECT_EQ(graph == nullptr, report.has_errors());
  std::string messages;
  for (const Finding& finding : report.findings()) {
    if (finding.severity != Severity::error) continue;
    messages += messages.empty() ? "" : "\n";
    messages += finding.message;
    for (const std::string& hint : finding.hints) messages += " | " + hint;
  }
  return messages;
}

double Evaluated::of(Value value) {
  if (value.is_known()) return value.number();
  const auto found = known_.find(value.id());
  if (found != known_.end()) return found->second;
  const RecordedNode& node = record_.nodes[value.id()];
  double result = 0;
  if (is_leaf(node.op)) {
    result = leaf(node);
  } else {
    const int arity = arity_of(node.op);
    result = apply(node.op, of(Value::node(node.a)), arity > 1 ? of(Value::node(node.b)) : 0,
                   arity > 2 ? of(Value::node(node.c)) : 0);
  }
  return known_[value.id()] = result;
}

double Evaluated::leaf(const RecordedNode& node) {
  switch (node.op) {
    case Op::constant:
      return record_.constants[node.a];
    case Op::parameter: {
      const auto set = parameters.find(record_.parameters[node.a].name);
      return set != parameters.end() ? set->second : record_.parameters[node.a].value;
    }
    case Op::time:
      return time_;
    case Op::state: {
      const auto set = states.find(record_.states[node.a].name);
      return set != states.end() ? set->second : of(record_.states[node.a].initial);
    }
    case Op::discrete: {
      const auto set = states.find(record_.discretes[node.a].name);
      return set != states.end() ? set->second : of(record_.discretes[node.a].initial);
    }
    case Op::segment: {
      double passed = 0;
      for (const Value& instant : record_.schedules[node.a].times) passed += of(instant) <= time_ ? 1 : 0;
      return passed;
    }
    case Op::wire:
      EXPECT_TRUE(record_.wire_bound[node.a]);
      return of(record_.wires[node.a]);
    default:
      ADD_FAILURE() << "no value for a " << name_of(node.op);
      return 0;
  }
}

double Evaluated::signal(const std::string& name) {
  for (const RecordedSignal& s : record_.signals) {
    if (s.name == name) return of(s.value);
  }
  ADD_FAILURE() << "there is no signal " << name;
  return 0;
}

double Evaluated::derivative(const std::string& state) {
  for (const RecordedState& s : record_.states) {
    if (s.name == state) return of(s.derivative);
  }
  ADD_FAILURE() << "there is no state " << state;
  return 0;
}

}  // namespace plantloop
