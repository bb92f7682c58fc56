// Depth-first from the roots through the wires; what is rebuilt in that order is sorted, folded and shared.

#include "engine/program/resolve.h"

#include <algorithm>
#include <cassert>
#include <span>

#include "engine/program/differentiate.h"

namespace plantloop {

namespace {

// Walks the record once for the run's operations, or once more for the initial ones, in which a state means its initial
// value.
class Resolver {
 public:
  Resolver(const Record& record, OperationGraph& graph, bool initial)
      : record_(record),
        graph_(graph),
        initial_(initial),
        status_(record.nodes.size(), Status::unseen),
        values_(record.nodes.size()) {}

  Value operator()(Value value) { return value.is_known() ? value : resolve(value.id()); }
  std::uint32_t id(Value value) { return graph_.id_of((*this)(value)); }
  // The same, sampled at the hits of a rate when it changes at other times too.
  std::uint32_t sampled(Value value, RateIndex rate) {
    const Value v = (*this)(value);
    if (rate == 0 || v.is_known() || graph_.mask_of(v) == 0 || graph_.mask_of(v) == rate_bit(rate))
      return graph_.id_of(v);
    graph_.rate = rate;
    graph_.make_modes = false;
    return graph_.operation(Op::copy, v, 0, 0).id();
  }
  // The nodes of every closed path met, in order.
  const std::vector<std::vector<std::uint32_t>>& cycles() const { return cycles_; }
  // The operation of a kernel.
  std::uint32_t kernel(std::uint32_t node) {
    resolve(node);
    return values_[node].id();
  }

 private:
  enum class Status : std::uint8_t { unseen, open, done };

  // The record's values that a node needs first.
  void operands(std::uint32_t id, std::vector<Value>& into) const {
    const RecordedNode& node = record_.nodes[id];
    into.clear();
    switch (node.op) {
      case Op::wire:
        into.push_back(record_.wires[node.a]);
        return;
      case Op::state:
        if (initial_) into.push_back(record_.states[node.a].initial);
        return;
      case Op::discrete:
        if (initial_) into.push_back(record_.discretes[node.a].initial);
        return;
      case Op::kernel: {
        const KernelUse& use = record_.kernels[node.a];
        for (const auto i : use.inputs) into.push_back(Value::node(i));
        if (initial_ && use.kernel->starts_with_inputs()) {
          for (const auto i : use.advance_inputs) into.push_back(Value::node(i));
        }
        return;
      }
      case Op::kernel_output:
        into.push_back(Value::node(node.a));
        return;
      default: {
        const int arity = arity_of(node.op);
        if (arity > 0) into.push_back(Value::node(node.a));
        if (arity > 1) into.push_back(Value::node(node.b));
        if (arity > 2) into.push_back(Value::node(node.c));
      }
    }
  }

  Value resolve(std::uint32_t root) {
    if (status_[root] == Status::done) return values_[root];
    stack_.clear();
    stack_.push_back(root);
    while (!stack_.empty()) {
      const std::uint32_t id = stack_.back();
      if (status_[id] == Status::done) {
        stack_.pop_back();
        continue;
      }
      operands(id, operands_);
      if (status_[id] == Status::open) {  // its operands are done
        values_[id] = rebuild(id);
        status_[id] = Status::done;
        path_.pop_back();
        stack_.pop_back();
        continue;
      }
      status_[id] = Status::open;
      path_.push_back(id);
      for (auto v = operands_.rbegin(); v != operands_.rend(); ++v) {
        if (v->is_known() || status_[v->id()] == Status::done) continue;
        if (status_[v->id()] == Status::open) {
          const auto start = std::find(path_.begin(), path_.end(), v->id());
          cycles_.emplace_back(start, path_.end());
          continue;
        }
        stack_.push_back(v->id());
      }
    }
    return values_[root];
  }

  Value of(Value v) const { return v.is_known() ? v : values_[v.id()]; }
  Value of(std::uint32_t id) const { return values_[id]; }

  Value rebuild(std::uint32_t id) {
    const RecordedNode& node = record_.nodes[id];
    graph_.site = node.site;
    graph_.rate = node.rate;
    graph_.activation = node.activation;
    graph_.make_modes = !initial_ && !node.plain;
    switch (node.op) {
      case Op::constant:
        return Value(record_.constants[node.a]);
      case Op::parameter:
        return graph_.leaf(Op::parameter, node.a, 0);
      case Op::time:
      case Op::state:
        if (node.op == Op::state && initial_) return of(record_.states[node.a].initial);
        return graph_.leaf(node.op, node.a, continuous_bit);
      case Op::discrete:
        if (initial_) return of(record_.discretes[node.a].initial);
        // Of a continuous block: it changes at events only.
        return graph_.leaf(node.op, node.a, node.rate == 0 ? event_bit : rate_bit(node.rate));
      case Op::hit:
        return graph_.leaf(node.op, node.a, rate_bit(node.rate));
      case Op::segment:
        return graph_.leaf(node.op, node.a, event_bit);
      case Op::wire:
        return of(record_.wires[node.a]);
      case Op::kernel: {
        KernelUse use = record_.kernels[node.a];
        use.index = node.a;
        use.initial = initial_;
        for (auto& i : use.inputs) i = graph_.id_of(of(i));
        if (initial_ && use.kernel->starts_with_inputs()) {
          for (auto& i : use.advance_inputs) i = graph_.id_of(of(i));
        } else {
          use.advance_inputs.clear();  // they are roots of their own
        }
        return graph_.kernel(std::move(use), 2 * std::uint64_t{node.a} + (initial_ ? 1 : 0));
      }
      case Op::kernel_output:
        if (of(node.a).is_known()) return 0;  // in a closed path, which is reported
        return graph_.kernel_output(of(node.a), node.b);
      case Op::copy:
        // A copy in a discrete block samples or latches; elsewhere it is the value itself.
        if (initial_ || node.rate == 0 || of(node.a).is_known()) return of(node.a);
        return graph_.operation(Op::copy, of(node.a), 0, 0);
      default: {
        const int arity = arity_of(node.op);
        return plantloop::record(node.op, of(node.a), arity > 1 ? of(node.b) : Value(0),
                                 arity > 2 ? of(node.c) : Value(0));
      }
    }
  }

  const Record& record_;
  OperationGraph& graph_;
  bool initial_;
  std::vector<Status> status_;
  std::vector<Value> values_;
  std::vector<std::uint32_t> stack_, path_;
  std::vector<Value> operands_;
  std::vector<std::vector<std::uint32_t>> cycles_;
};

// The blocks along a closed path, each once in a row.
std::vector<std::uint32_t> sites_along(const Record& record, const std::vector<std::uint32_t>& cycle) {
  std::vector<std::uint32_t> sites;
  for (const auto id : cycle) {
    const std::uint32_t site = record.nodes[id].site;
    if (site == 0 || record.nodes[id].op == Op::wire) continue;  // a forward reference was made by its reader
    if (!sites.empty() && record.sites[sites.back()].path == record.sites[site].path) continue;
    sites.push_back(site);
  }
  while (sites.size() > 1 && record.sites[sites.front()].path == record.sites[sites.back()].path) sites.pop_back();
  // The walk went from readers to drivers; signals flow the other way.
  std::reverse(sites.begin(), sites.end());
  const auto first = std::min_element(sites.begin(), sites.end(),
                                      [&](auto a, auto b) { return record.sites[a].path < record.sites[b].path; });
  std::rotate(sites.begin(), first, sites.end());
  return sites;
}

std::string closed_path(const Record& record, const std::vector<std::uint32_t>& sites) {
  std::string text;
  for (const auto s : sites) text += record.sites[s].path + " -> ";
  return sites.empty() ? text : text + record.sites[sites.front()].path;
}

void report_loops(const Record& record, const std::vector<std::vector<std::uint32_t>>& cycles, Report& report) {
  std::vector<std::string> seen;
  for (const auto& cycle : cycles) {
    const auto sites = sites_along(record, cycle);
    const std::string path = closed_path(record, sites);
    if (sites.empty() || std::find(seen.begin(), seen.end(), path) != seen.end()) continue;
    seen.push_back(path);
    Finding& finding =
        report.error(record.sites[sites.front()].mark, "algebraic loop: {}", path).named("algebraic-loop");
    finding.hint("each of these needs the other's value at the same instant");
    finding.hint(
        "put a state into the loop: the physical lag or integrator that is there, or, in sampled parts, a unit_delay");
  }
}

void report_initial_cycles(const Record& record, const std::vector<std::vector<std::uint32_t>>& cycles,
                           Report& report) {
  for (const auto& cycle : cycles) {
    const auto sites = sites_along(record, cycle);
    if (sites.empty()) continue;
    report
        .error(record.sites[sites.front()].mark, "initial values depend on each other: {}", closed_path(record, sites))
        .named("initial-cycle")
        .hint("give one of them an `initial:` that uses parameters only");
  }
}

}  // namespace

Resolved resolve(const Record& record, const std::vector<Value>& watches, const std::vector<Value>& numbers,
                 Report& report) {
  Resolved resolved;
  OperationGraph& graph = resolved.graph;
  const SinkInCharge charge(graph);
  graph.operations.reserve(record.nodes.size());
  Resolver run(record, graph, false);
  for (const auto& state : record.states) resolved.derivatives.push_back(run.id(state.derivative));
  for (const auto& discrete : record.discretes) resolved.nexts.push_back(run.sampled(discrete.next, discrete.rate));
  for (const auto& jump : record.jumps) {
    const std::uint32_t function = run.sampled(jump.function, jump.rate);
    Resolved::Jump result{jump.of_slope ? slope(graph, function, resolved.derivatives) : function, {}};
    for (const auto& assignment : jump.assignments) result.values.push_back(run.id(assignment.value));
    resolved.jumps.push_back(std::move(result));
  }
  for (const auto& schedule : record.schedules) {
    Resolved::Schedule result;
    for (const Value& t : schedule.times) result.times.push_back(run.id(t));
    result.first = run.id(schedule.first);
    result.period = run.id(schedule.period);
    resolved.schedules.push_back(std::move(result));
  }
  for (std::uint32_t i = 0; i < record.nodes.size(); ++i) {
    if (record.nodes[i].op != Op::kernel) continue;
    std::vector<std::uint32_t> inputs;
    for (const auto a : record.kernels[record.nodes[i].a].advance_inputs)
      inputs.push_back(run.sampled(Value::node(a), record.nodes[i].rate));
    resolved.advance_inputs.push_back(std::move(inputs));
  }
  for (const Value& watch : watches) resolved.watches.push_back(run.id(watch));
  for (const Value& number : numbers) resolved.numbers.push_back(run.id(number));
  for (const auto& signal : record.signals) run(signal.value);  // loops are errors even where nobody looks
  report_loops(record, run.cycles(), report);

  Resolver initial(record, graph, true);
  for (const auto& state : record.states) resolved.initial_states.push_back(initial.id(state.initial));
  for (const auto& discrete : record.discretes) resolved.initial_discretes.push_back(initial.id(discrete.initial));
  for (std::uint32_t i = 0; i < record.nodes.size(); ++i) {
    if (record.nodes[i].op == Op::kernel) resolved.initial_kernels.push_back(initial.kernel(i));
  }
  if (run.cycles().empty()) report_initial_cycles(record, initial.cycles(), report);
  return resolved;
}

}  // namespace plantloop
