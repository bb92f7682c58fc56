// Depth-first from the roots through the wires; what is rebuilt in that order is sorted, folded and shared.

#include "engine/program/resolve.h"

#include <algorithm>
#include <cassert>
#include <string_view>

#include "engine/program/loop_parts.h"
#include "engine/program/loops.h"

#include "engine/program/differentiate.h"

namespace plantloop {

namespace {

// Walks the record once for the run's operations, or once more for the initial ones, in which a state means its initial
// value.
class Resolver {
 public:
  // `loops` of the record, if it has some; none: those that are met stand in cycles().
  Resolver(const Record& record, OperationGraph& graph, bool initial, const std::vector<RecordedLoop>& loops)
      : record_(record),
        graph_(graph),
        initial_(initial),
        loops_(loops),
        status_(record.nodes.size() + loops.size(), Status::unseen),
        values_(record.nodes.size() + loops.size()) {
    if (loops.empty()) return;
    loop_of_.assign(record.nodes.size(), none);
    for (std::uint32_t k = 0; k < loops.size(); ++k) {
      for (const auto member : loops[k].members) loop_of_[member] = k;
    }
  }

  Value operator()(Value value) { return value.is_known() ? value : resolve(value.id()); }
  std::uint32_t id(Value value) { return graph_.id_of((*this)(value)); }
  // The same, sampled at the hits of a rate when it changes at other times too.
  std::uint32_t sampled(Value value, RateIndex rate) {
    const Value v = (*this)(value);
    if (rate == 0 || v.is_known() || graph_.mask_of(v) == 0 || graph_.mask_of(v) == rate_bit(rate))
      return graph_.id_of(v);
    graph_.rate = rate;
    graph_.activation = 0;
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

  // The record's values that a node needs first. A member of a loop needs the loop, which stands behind the nodes; a
  // loop needs what its members read from outside.
  void operands(std::uint32_t id, std::vector<Value>& into) const {
    const auto nodes = static_cast<std::uint32_t>(record_.nodes.size());
    if (loops_.empty() || (id < nodes && loop_of_[id] == none)) return operands_of(record_, id, initial_, into);
    into.clear();
    if (id < nodes) {
      into.push_back(Value::node(nodes + loop_of_[id]));
      return;
    }
    std::vector<Value> one;
    for (const auto member : loops_[id - nodes].members) {
      operands_of(record_, member, initial_, one);
      for (const Value v : one) {
        if (!v.is_known() && loop_of_[v.id()] != id - nodes) into.push_back(v);
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
        if (id >= record_.nodes.size()) {
          resolve_loop(id - static_cast<std::uint32_t>(record_.nodes.size()));
        } else if (loops_.empty() || loop_of_[id] == none) {
          values_[id] = rebuild(id);
        }
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
    // Initial values are asked for in any case, and a loop is solved as a whole: what is not active counts for nothing
    // there, since nobody who is active looks at it.
    graph_.activation = initial_ || is_in_loop(id) ? std::uint16_t{0} : node.activation;
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
      case Op::implicit:
        return of(record_.unknowns[node.a].residual);
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

  // --- loops ------------------------------------------------------------------------------------------------------

  // All members of a loop, once everything that they read from outside is there.
  void resolve_loop(std::uint32_t k) {
    const RecordedLoop& loop = loops_[k];
    const std::vector<std::uint32_t> order = members_in_order(k);
    const auto index = static_cast<std::uint32_t>(graph_.loops.size());
    graph_.loops.push_back(describe(loop));
    graph_.site = graph_.loops[index].site;
    const Value operation = graph_.loop(index, mask_of(loop));
    graph_.loops[index].operation = operation.id();
    const bool has_modes = !initial_ && (graph_.mask_of(operation) & continuous_bit) == 0;
    graph_.loop_with_modes = has_modes ? index : Loop::none;
    std::vector<Value> unknowns;
    for (std::uint32_t i = 0; i < loop.tears.size(); ++i) {
      unknowns.push_back(graph_.unknown(operation, i));
      graph_.loops[index].unknowns[i].operation = unknowns.back().id();
    }
    const std::vector<Value> residuals = rebuild_members(loop, order, unknowns);
    graph_.loop_with_modes = Loop::none;
    for (std::uint32_t i = 0; i < residuals.size(); ++i) {
      graph_.loops[index].unknowns[i].residual = graph_.id_of(residuals[i]);
    }
    complete_loop(graph_, index, loop.rate);
    if (is_solved_by_hand(loop, graph_.loops[index])) solve_by_hand(loop, order, index);
  }

  // The members without the tears, operands first.
  std::vector<std::uint32_t> members_in_order(std::uint32_t k) {
    std::vector<std::uint32_t> order, open;
    std::vector<Value> one;
    std::vector<std::uint8_t> seen(loops_[k].members.size(), 0);  // 1: open, 2: done
    const auto place = [&](std::uint32_t node) {
      const auto& members = loops_[k].members;
      return static_cast<std::size_t>(std::lower_bound(members.begin(), members.end(), node) - members.begin());
    };
    for (const auto tear : loops_[k].tears) seen[place(tear)] = 2;
    for (const auto member : loops_[k].members) {
      open.push_back(member);
      while (!open.empty()) {
        const std::uint32_t id = open.back();
        if (seen[place(id)] != 0) {
          if (seen[place(id)] == 1) order.push_back(id);
          seen[place(id)] = 2;
          open.pop_back();
          continue;
        }
        seen[place(id)] = 1;
        operands_of(record_, id, initial_, one);
        for (const Value v : one) {
          if (!v.is_known() && loop_of_[v.id()] == k && seen[place(v.id())] == 0) open.push_back(v.id());
        }
      }
    }
    return order;
  }

  // Gives every member its value when the tears have these, and returns what must be zero then.
  std::vector<Value> rebuild_members(const RecordedLoop& loop, const std::vector<std::uint32_t>& order,
                                     const std::vector<Value>& tears) {
    for (std::size_t i = 0; i < tears.size(); ++i) values_[loop.tears[i]] = tears[i];
    for (const auto id : order) values_[id] = rebuild(id);
    std::vector<Value> residuals;
    for (std::size_t i = 0; i < tears.size(); ++i) {
      const Value value = rebuild(loop.tears[i]);
      graph_.make_modes = false;
      const Value off = is_declared(loop.tears[i]) ? value : value - tears[i];
      const std::uint16_t activation = record_.nodes[loop.tears[i]].activation;
      // While the tear's block is not active, its unknown is 0 and needs no equation of the block.
      residuals.push_back(
          activation == 0 || initial_ ? off : where(Truth(of(record_.activations[activation])), off, tears[i]));
    }
    for (const auto member : loop.members) status_[member] = Status::done;
    return residuals;
  }

  bool is_in_loop(std::uint32_t node) const { return !loops_.empty() && loop_of_[node] != none; }
  bool is_declared(std::uint32_t node) const { return record_.nodes[node].op == Op::implicit; }

  Loop describe(const RecordedLoop& loop) {
    Loop described;
    described.initial = initial_;
    const auto sites = sites_along(record_, loop.cycle);
    described.path = closed_path(record_, sites);
    if (!sites.empty()) described.site = sites.front();
    for (const auto tear : loop.tears) {
      Loop::Unknown unknown;
      unknown.name = name_of_node(tear);
      if (is_declared(tear)) {
        const RecordedUnknown& declared = record_.unknowns[record_.nodes[tear].a];
        unknown.name = declared.name;
        unknown.lower = graph_.id_of(of(declared.lower));
        unknown.upper = graph_.id_of(of(declared.upper));
        unknown.guess = graph_.id_of(of(declared.guess));
        described.site = declared.site;
      }
      described.unknowns.push_back(std::move(unknown));
    }
    return described;
  }

  // Of the output that it is, else of its block.
  std::string name_of_node(std::uint32_t node) const {
    const std::string& path = record_.sites[record_.nodes[node].site].path;
    std::string name;
    for (const RecordedSignal& signal : record_.signals) {
      if (signal.value.is_known() || signal.value.id() != node) continue;
      if (name.empty() || (signal.name.starts_with(path) && !name.starts_with(path))) name = signal.name;
    }
    return name.empty() ? path : name;
  }

  // When the loop is solved. Without anything that changes it is solved once, with what is held at the start.
  Mask mask_of(const RecordedLoop& loop) {
    if (loop.rate != 0) return rate_bit(loop.rate);
    Mask mask = 0;
    std::vector<Value> one;
    for (const auto member : loop.members) {
      // A kernel has a past of its own.
      const RecordedNode& node = record_.nodes[member];
      if (node.op == Op::kernel) mask |= node.rate != 0 ? rate_bit(node.rate) : continuous_bit;
      operands_of(record_, member, initial_, one);
      for (const Value v : one) {
        if (!v.is_known() && status_[v.id()] == Status::done) mask |= graph_.mask_of(of(v));
      }
    }
    return (mask & continuous_bit) != 0 ? mask : mask | event_bit;
  }

  // One unknown, linear, with a slope that only parameters change: its value is an expression.
  bool is_solved_by_hand(const RecordedLoop& loop, const Loop& solved) const {
    if (loop.tears.size() != 1 || is_declared(loop.tears[0]) || !solved.constant || !solved.exact) return false;
    if (solved.jacobian.size() != 1 || initial_) return false;
    return std::none_of(loop.members.begin(), loop.members.end(), [this](std::uint32_t id) {
      const RecordedNode& node = record_.nodes[id];
      return is_compound(node.op) || makes_modes(node.op);
    });
  }

  void solve_by_hand(const RecordedLoop& loop, const std::vector<std::uint32_t>& order, std::uint32_t index) {
    const Value at_zero = rebuild_members(loop, order, {Value(0)})[0];
    const Value slope = value_of(graph_, graph_.loops[index].jacobian[0].value);
    graph_.site = graph_.loops[index].site;
    graph_.rate = loop.rate;
    rebuild_members(loop, order, {-(at_zero / slope)});
    graph_.loops[index].by_hand = true;
  }

  static constexpr std::uint32_t none = 0xffffffff;
  const Record& record_;
  OperationGraph& graph_;
  bool initial_;
  const std::vector<RecordedLoop>& loops_;
  std::vector<std::uint32_t> loop_of_;  // per node; empty without loops
  std::vector<Status> status_;
  std::vector<Value> values_;
  std::vector<std::uint32_t> stack_, path_;
  std::vector<Value> operands_;
  std::vector<std::vector<std::uint32_t>> cycles_;
};

// A loop that is refused, whatever the reason; each closed path once.
void refuse(const Record& record, const std::vector<std::vector<std::uint32_t>>& cycles, Report& report) {
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

void report_loops(const Record& record, const std::vector<RecordedLoop>& loops, bool loops_are_errors, Report& report) {
  for (const RecordedLoop& loop : loops) {
    const auto sites = sites_along(record, loop.cycle);
    const Mark mark = sites.empty() ? Mark{} : record.sites[sites.front()].mark;
    const std::string path = closed_path(record, sites);
    const auto error = [&](std::string_view why) -> Finding& {
      return report.error(mark, "algebraic loop: {}", path).named("algebraic-loop").hint(std::string(why));
    };
    const bool declared = std::all_of(loop.tears.begin(), loop.tears.end(),
                                      [&](auto tear) { return record.nodes[tear].op == Op::implicit; });
    switch (loop.problem) {
      case RecordedLoop::Problem::mixed_rates:
        error(
            "it joins sampled and continuous parts, or parts of two rates, that need each other's value at the same "
            "instant")
            .hint("put a unit_delay into the sampled part, or a lag into the continuous one");
        break;
      case RecordedLoop::Problem::no_number:
        error("only true and false go round in it: there is no number to solve for")
            .hint("put a unit_delay into it, or give the condition a hysteresis with a relay");
        break;
      case RecordedLoop::Problem::conditional:
        error("a part of it is triggered, or decides by its own value whether it runs")
            .hint("put a state or a unit_delay into the loop");
        break;
      case RecordedLoop::Problem::initial_values:
        break;
      case RecordedLoop::Problem::none:
        if (declared) break;
        if (loops_are_errors) {
          refuse(record, {loop.cycle}, report);
        } else {
          report.check("algebraic-loop", mark,
                       "algebraic loop: {}; its values are found by iteration whenever they are read", path);
        }
    }
  }
}

void report_initial_cycle(const Record& record, const std::vector<std::uint32_t>& cycle, Report& report) {
  const auto sites = sites_along(record, cycle);
  if (sites.empty()) return;
  report.error(record.sites[sites.front()].mark, "initial values depend on each other: {}", closed_path(record, sites))
      .named("initial-cycle")
      .hint("give one of them an `initial:` that uses parameters only");
}

// A loop whose equations leave a value open, whatever the parameters.
void report_open_unknowns(const Record& record, const OperationGraph& graph, Report& report) {
  for (const Loop& loop : graph.loops) {
    if (loop.initial || !loop.exact) continue;
    for (std::uint32_t i = 0; i < loop.unknowns.size(); ++i) {
      const auto reads = [&](const Loop::Entry& e) { return e.column == i; };
      if (std::any_of(loop.jacobian.begin(), loop.jacobian.end(), reads)) continue;
      report
          .error(record.sites[loop.site].mark,
                 "the equations of the algebraic loop {} hold for every '{}', or for none", loop.path,
                 loop.unknowns[i].name)
          .named("algebraic-loop")
          .hint("an equation for it must contain it");
      break;
    }
  }
}

// Everything that a run computes, but for the initial values.
void resolve_run(const Record& record, Resolver& run, const std::vector<Value>& watches,
                 const std::vector<Value>& numbers, Resolved& resolved) {
  for (const auto& state : record.states) resolved.derivatives.push_back(run.id(state.derivative));
  for (const auto& discrete : record.discretes) resolved.nexts.push_back(run.sampled(discrete.next, discrete.rate));
  for (const auto& jump : record.jumps) {
    const std::uint32_t function = run.sampled(jump.function, jump.rate);
    resolved.graph.activation = 0;
    Resolved::Jump result{
        jump.of_slope ? slope(resolved.graph, function, resolved.derivatives) : function, run.id(jump.enabled), {}};
    for (const auto& assignment : jump.assignments) result.values.push_back(run.id(assignment.value));
    resolved.jumps.push_back(std::move(result));
  }
  resolved.activations.push_back(0);
  for (std::size_t i = 1; i < record.activations.size(); ++i)
    resolved.activations.push_back(run.id(record.activations[i]));
  for (const RecordedHold& hold : record.holds) resolved.holds.emplace_back(run.id(hold.condition), run.id(hold.value));
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
}

void resolve_initial(const Record& record, bool has_loops, Resolved& resolved, Report& report) {
  OperationGraph& graph = resolved.graph;
  const SinkInCharge charge(graph);
  // Without loops in the run a closed path goes through the initial value of a state.
  const std::vector<RecordedLoop> loops = has_loops ? find_loops(record, true) : std::vector<RecordedLoop>{};
  bool closed = false;
  for (const RecordedLoop& loop : loops) {
    if (loop.problem != RecordedLoop::Problem::initial_values) continue;
    report_initial_cycle(record, loop.cycle, report);
    closed = true;
  }
  if (closed) return;
  Resolver initial(record, graph, true, loops);
  for (const auto& state : record.states) resolved.initial_states.push_back(initial.id(state.initial));
  for (const auto& discrete : record.discretes) resolved.initial_discretes.push_back(initial.id(discrete.initial));
  for (std::uint32_t i = 0; i < record.nodes.size(); ++i) {
    if (record.nodes[i].op == Op::kernel) resolved.initial_kernels.push_back(initial.kernel(i));
  }
  for (const auto& cycle : initial.cycles()) report_initial_cycle(record, cycle, report);
}

}  // namespace

Resolved resolve(const Record& record, const std::vector<Value>& watches, const std::vector<Value>& numbers,
                 bool loops_are_errors, Report& report) {
  const std::size_t errors = report.error_count();
  Resolved resolved;
  std::vector<RecordedLoop> loops;
  if (record.unknowns.empty()) {
    const SinkInCharge charge(resolved.graph);
    resolved.graph.operations.reserve(record.nodes.size());
    Resolver run(record, resolved.graph, false, loops);
    resolve_run(record, run, watches, numbers, resolved);
    if (!run.cycles().empty()) {
      if (loops_are_errors) {
        refuse(record, run.cycles(), report);
        return resolved;
      }
      loops = find_loops(record, false);
    }
  } else {
    loops = find_loops(record, false);
  }
  if (!loops.empty()) {  // once more, from the beginning
    report_loops(record, loops, loops_are_errors, report);
    if (report.error_count() > errors) return resolved;
    resolved = {};
    const SinkInCharge charge(resolved.graph);
    Resolver run(record, resolved.graph, false, loops);
    resolve_run(record, run, watches, numbers, resolved);
    report_open_unknowns(record, resolved.graph, report);
    if (report.error_count() > errors) return resolved;
  }
  resolve_initial(record, !loops.empty(), resolved, report);
  return resolved;
}

}  // namespace plantloop
