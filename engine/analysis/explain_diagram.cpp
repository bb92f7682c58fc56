// A diagram as a whole: how much there is, at which rates, in which order, and what makes the solver start anew.

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "engine/analysis/explained.h"

namespace plantloop {

namespace {

constexpr std::size_t most_listed = 12;  // names in one line

std::string list(std::vector<std::string> names) {
  const std::size_t count = names.size();
  if (count > most_listed) names.resize(most_listed);
  std::string text = fmt::format("{}", fmt::join(names, ", "));
  if (count > most_listed) text += fmt::format(" and {} more", count - most_listed);
  return text;
}

std::string amounts(const Explained& e) {
  const Program& p = *e.program;
  std::string text =
      fmt::format("{} in {}, {} and {}\n", counted(e.graph->blocks.size(), "block"),
                  counted(e.graph->scopes.size() - 1, "subsystem"), counted(p.state_names.size(), "continuous state"),
                  counted(p.discrete_names.size(), "sampled state"));
  text += fmt::format("{} in one evaluation of the derivatives, {} of which a new value needs no new compilation\n",
                      counted(p.derivative_list.operation_count, "operation"), counted(p.parameters.size(), "number"));
  if (!p.state_names.empty()) {
    text += fmt::format("Jacobian: {} of {} entries are not zero by structure{}\n", p.jacobian_row.size(),
                        p.state_names.size() * p.state_names.size(), p.jacobian_is_exact ? "" : ", differenced");
    if (!p.differenced.empty()) text += fmt::format("  without derivatives of their own: {}\n", list(p.differenced));
  }
  return text;
}

GraphRate rate_of(const Graph& graph, const GraphBlock& block) {
  return block.type ? block.rate : graph.nets[block.first_output].rate;
}

std::string rates(const Graph& graph) {
  std::map<std::pair<int, int>, std::vector<std::string>> by_rate;
  for (const auto b : graph.order) {
    const GraphRate rate = rate_of(graph, graph.blocks[b]);
    by_rate[{static_cast<int>(rate.kind), rate.index}].push_back(graph.blocks[b].path);
  }
  std::string text = "\nrates\n";
  for (const auto& [key, names] : by_rate) {
    const GraphRate rate{static_cast<GraphRate::Kind>(key.first), static_cast<std::uint16_t>(key.second)};
    text += fmt::format("  {}: {}\n", in_words(graph, rate), list(names));
  }
  return text;
}

// Reads of a signal of one rate at another one, without a block that says with which latency.
std::string reads_across_rates(const Graph& graph) {
  std::set<std::string> lines;
  const auto add = [&](const GraphBlock& reader, const GraphRate& own, const GraphNet& signal) {
    if (own.kind != GraphRate::Kind::discrete || signal.rate.kind != GraphRate::Kind::discrete) return;
    if (own.index == signal.rate.index) return;
    const ClockRate &of_reader = graph.rates[own.index], &of_signal = graph.rates[signal.rate.index];
    const bool clocks = of_reader.trigger == 0 && of_signal.trigger == 0;
    const int order = clocks ? compare(of_reader.period, of_signal.period) : 0;
    lines.insert(fmt::format("  {} {} {}\n", reader.path,
                             order > 0   ? "samples"
                             : order < 0 ? "holds"
                                         : "reads",
                             path_of(graph, signal)));
  };
  for (const GraphBlock& block : graph.blocks) {
    if (block.type && block.type->name == "rate_transition") continue;
    const std::uint32_t first = block.type ? block.first_input : block.first_output;
    const std::uint32_t count = block.type ? block.inputs : 1;
    for (std::uint32_t i = 0; i < count; ++i) {
      const BoundExpression& driver = graph.nets[first + i].driver;
      for (std::size_t k = 0; driver && k < driver.code->names.size(); ++k) {
        const Reference& r = graph.references[driver.first_reference + k];
        if (r.kind == Reference::Kind::net) add(block, rate_of(graph, block), graph.nets[r.index]);
      }
    }
  }
  if (lines.empty()) return {};
  return fmt::format("\nacross rates, always the present value (a rate_transition defines a latency)\n{}",
                     fmt::join(lines, ""));
}

// When a block's outputs are known: after the last of their operations.
std::uint32_t place_of(const Explained& e, const GraphBlock& block) {
  std::uint32_t last = 0;
  for (std::uint32_t i = 0; i < block.outputs; ++i) {
    for (const auto id : e.operations_of(e.graph->nets[block.first_output + i])) last = std::max(last, id);
  }
  return last;
}

std::string order(const Explained& e) {
  const Graph& graph = *e.graph;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> places;
  for (const auto b : graph.order) places.emplace_back(place_of(e, graph.blocks[b]), b);
  std::stable_sort(places.begin(), places.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  std::size_t width = 0;
  for (const GraphBlock& block : graph.blocks) width = std::max(width, block.path.size());
  std::string text = "\norder: each block's outputs are known after those above it\n";
  for (const auto& [place, b] : places) {
    const GraphBlock& block = graph.blocks[b];
    std::string what = block.type ? std::string(block.type->name) : "expression";
    if (!block.declaration->zero_crossing) what += ", zero_crossing: off";
    std::string size;
    if (block.outputs > 0) {
      const Shape& shape = graph.nets[block.first_output].shape;
      if (!shape.is_scalar()) size = ", " + in_words(shape);
    }
    text += fmt::format("  {:<{}}  {}, {}{}\n", block.path, width, what, in_words(graph, rate_of(graph, block)), size);
  }
  return text;
}

std::string events(const Explained& e) {
  const Program& p = *e.program;
  std::vector<std::string> jumps, modes, pasts;
  for (const Program::Jump& jump : p.jumps) {
    if (jump.of_kernel) {
      pasts.push_back(p.sites[jump.site].path);
    } else {
      jumps.push_back(jump.name);
    }
  }
  for (const Mode& mode : e.operations().modes) {
    if (!mode.of_loop) modes.push_back(p.sites[mode.site].path);
  }
  std::sort(modes.begin(), modes.end());
  modes.erase(std::unique(modes.begin(), modes.end()), modes.end());
  pasts.erase(std::unique(pasts.begin(), pasts.end()), pasts.end());
  std::string text = "\nevents\n";
  if (jumps.empty() && modes.empty() && pasts.empty()) return text + "  none\n";
  if (!jumps.empty()) text += fmt::format("  states jump at: {}\n", list(jumps));
  if (!modes.empty()) text += fmt::format("  modes change in: {}\n", list(modes));
  if (!pasts.empty())
    text += fmt::format("  jumps and kinks come out, at instants that are located: {}\n", list(pasts));
  return text;
}

// Which states' derivatives read a held value: sampled at a rate, or a segment of a source.
class Restarts {
 public:
  explicit Restarts(const Explained& e) : e_(e), graph_(e.operations()) {
    for (const GraphBlock& block : e.graph->blocks) {
      for (std::uint32_t i = 0; i < block.outputs; ++i) {
        const GraphNet& net = e.graph->nets[block.first_output + i];
        for (const auto id : e.operations_of(net)) name_of_.emplace(id, path_of(*e.graph, net));
      }
    }
  }

  std::string text() {
    for (std::uint32_t s = 0; s < e_.program->resolved->derivatives.size(); ++s) {
      seen_.assign(graph_.operations.size(), false);
      look(e_.program->resolved->derivatives[s], e_.recorded.record.states[s].name);
    }
    std::string text = "\nrestarts: where the solver starts anew because a derivative may have changed\n";
    for (const auto& [cause, states] : causes_) {
      text += fmt::format("  {}, in the derivative of {}\n", cause, list({states.begin(), states.end()}));
    }
    for (const Program::Jump& jump : e_.program->jumps) {
      if (!jump.of_kernel) text += fmt::format("  event '{}': states jump\n", jump.name);
    }
    if (!graph_.modes.empty()) text += "  events of modes, as listed above\n";
    if (causes_.empty() && e_.program->jumps.empty() && graph_.modes.empty()) text += "  none\n";
    return text;
  }

 private:
  void look(std::uint32_t root, const std::string& state) {
    std::vector<std::uint32_t> open{root};
    while (!open.empty()) {
      const std::uint32_t id = open.back();
      open.pop_back();
      if (seen_[id]) continue;
      seen_[id] = true;
      const Operation& o = graph_.operations[id];
      if (o.is_parameter_only() || o.op == Op::state || o.op == Op::time || o.op == Op::mode) continue;
      if (!o.is_continuous()) {
        add(id, state);
        continue;
      }
      if (o.op == Op::kernel) {
        for (const auto i : graph_.kernels[o.a].inputs) open.push_back(i);
      } else if (o.op == Op::kernel_output) {
        open.push_back(o.a);
      } else if (!is_leaf(o.op)) {
        const int arity = arity_of(o.op);
        if (arity > 0) open.push_back(o.a);
        if (arity > 1) open.push_back(o.b);
        if (arity > 2) open.push_back(o.c);
      }
    }
  }

  // A held operation is called by the signals that it is made of.
  void add(std::uint32_t id, const std::string& state) {
    const Operation& o = graph_.operations[id];
    const std::string names = list(signals_in(id));
    if ((o.mask & event_bit) != 0) causes_[fmt::format("at edges {} changes", names)].insert(state);
    for (std::size_t r = 1; r < e_.program->rates.size(); ++r) {
      if ((o.mask & rate_bit(static_cast<RateIndex>(r))) == 0) continue;
      causes_[fmt::format("every {} s {} changes", e_.program->rates[r].period.to_double(), names)].insert(state);
    }
  }

  std::vector<std::string> signals_in(std::uint32_t id) const {
    std::set<std::string> names;
    std::vector<std::uint32_t> open{id};
    while (!open.empty()) {
      const std::uint32_t at = open.back();
      open.pop_back();
      const auto known = name_of_.find(at);
      const Operation& o = graph_.operations[at];
      if (known != name_of_.end()) {
        names.insert(known->second);
      } else if (o.op == Op::segment) {
        names.insert(e_.program->sites[e_.program->schedules[o.a].site].path);
      } else if (o.op == Op::kernel_output || is_leaf(o.op)) {
        if (!o.is_parameter_only()) names.insert(e_.program->sites[o.site].path);
      } else {
        const int arity = arity_of(o.op);
        if (arity > 0) open.push_back(o.a);
        if (arity > 1) open.push_back(o.b);
        if (arity > 2) open.push_back(o.c);
      }
    }
    return {names.begin(), names.end()};
  }

  const Explained& e_;
  const OperationGraph& graph_;
  std::map<std::uint32_t, std::string> name_of_;  // of the operations that are signals
  std::vector<bool> seen_;
  std::map<std::string, std::set<std::string>> causes_;
};

// Closed paths whose values are found together, machines, and what does not always run.
std::string loops(const Explained& e) {
  std::string text;
  std::set<std::string> seen;
  for (const Loop& loop : e.operations().loops) {
    if (loop.initial || !seen.insert(loop.path).second) continue;  // what follows from a loop's derivative has its path
    std::vector<std::string> tears;
    for (const Loop::Unknown& unknown : loop.unknowns) tears.push_back(unknown.name);
    const char* how = loop.by_hand    ? "linear, solved as an expression"
                      : loop.constant ? "linear with constant coefficients, factored once"
                      : loop.affine   ? "linear, factored at each evaluation"
                      : loop.exact    ? "nonlinear, Newton's method on exact derivatives"
                                      : "nonlinear, Newton's method on differences";
    text += fmt::format("  {}\n    cut at {}; {}\n", loop.path, list(tears), how);
  }
  return text.empty() ? text : "\nalgebraic loops\n" + text;
}

std::string machines(const Graph& graph) {
  std::string text;
  for (const auto s : graph.scope_order) {
    const GraphScope& scope = graph.scopes[s];
    if (!scope.type->machine) continue;
    std::vector<std::string> states;
    for (const StateMachineDecl::State& state : scope.type->machine->states) states.push_back(state.name);
    text += fmt::format("  {}: {}; {}, begins in {}\n", scope.path, list(states),
                        counted(scope.type->machine->transitions.size(), "transition"),
                        states[scope.type->machine->initial]);
  }
  return text.empty() ? text : "\nstate machines\n" + text;
}

std::string conditional_parts(const Graph& graph) {
  std::vector<std::string> lines;
  for (std::size_t a = 1; a < graph.activations.size(); ++a) {
    const GraphActivation& activation = graph.activations[a];
    std::string line = "  " + activation.path + ":";
    if (activation.enable_when) {
      line +=
          fmt::format(" active while {} > 0, states {}, outputs {}", to_string(*activation.enable_when.code->tree),
                      activation.resets_states() ? "reset" : "held", activation.resets_outputs() ? "reset" : "held");
    }
    if (activation.trigger_when) {
      line += fmt::format("{} triggered by {} ({})", activation.enable_when ? ";" : "",
                          to_string(*activation.trigger_when.code->tree), activation.declaration->trigger->edge);
    }
    lines.push_back(line + "\n");
  }
  std::sort(lines.begin(), lines.end());
  return lines.empty() ? "" : fmt::format("\nconditional parts\n{}", fmt::join(lines, ""));
}

std::string structure(const Explained& e) {
  std::vector<std::string> structural, zeros;
  for (std::size_t i = 0; i < e.recorded.uses.size(); ++i) {
    const std::string& name = e.recorded.record.parameters[i].name;
    if (e.recorded.uses[i] == ParameterUse::structural) structural.push_back(name);
    if (e.recorded.uses[i] == ParameterUse::zero_structural) zeros.push_back(name);
  }
  std::string text;
  if (!structural.empty()) text += fmt::format("  a new value compiles again: {}\n", list(structural));
  if (!zeros.empty()) text += fmt::format("  becoming or leaving zero compiles again: {}\n", list(zeros));
  return text.empty() ? "" : "\nstructure\n" + text;
}

}  // namespace

std::string explain_diagram(const Explained& e) {
  const Model& model = *e.graph->model;
  std::string text = model.title.empty() ? model.path + "\n" : fmt::format("{}: {}\n", model.path, model.title);
  return text + amounts(e) + rates(*e.graph) + reads_across_rates(*e.graph) + order(e) + loops(e) + machines(*e.graph) +
         conditional_parts(*e.graph) + events(e) + Restarts(e).text() + structure(e);
}

}  // namespace plantloop
