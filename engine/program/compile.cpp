// All passes in order: resolve, differentiate, order the states, lower every list, lay out the arena.

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <set>
#include <tuple>

#include "engine/base/report.h"
#include "engine/program/differentiate.h"
#include "engine/program/linear_lists.h"
#include "engine/program/lower.h"
#include "engine/program/program.h"
#include "engine/program/resolve.h"
#include "engine/program/sensitivities.h"
#include "engine/program/solve_loop.h"
#include "engine/program/unroll.h"

namespace plantloop {

namespace {

// The first few states that a derivative reads.
std::vector<std::uint32_t> states_read(const OperationGraph& graph, std::uint32_t root) {
  constexpr std::size_t most_states = 4;
  constexpr std::size_t most_operations = 64;
  std::vector<std::uint32_t> states, stack{root}, seen;
  while (!stack.empty() && states.size() < most_states && seen.size() < most_operations) {
    const std::uint32_t id = stack.back();
    stack.pop_back();
    if (std::find(seen.begin(), seen.end(), id) != seen.end()) continue;
    seen.push_back(id);
    const Operation& o = graph.operations[id];
    if (o.op == Op::state) {
      states.push_back(o.a);
      continue;
    }
    if (!o.is_continuous() || is_leaf(o.op) || is_compound(o.op)) continue;
    const int arity = arity_of(o.op);
    if (arity > 2) stack.push_back(o.c);
    if (arity > 1) stack.push_back(o.b);
    if (arity > 0) stack.push_back(o.a);
  }
  return states;
}

// The order of the states in the arena: along chains of "derivative i reads state j", so that neighbours in the
// equations are neighbours in memory; then by the kind of the derivative's last operation, so that one loop computes
// many of them.
std::vector<std::uint32_t> order_states(const Resolved& resolved) {
  const auto n = static_cast<std::uint32_t>(resolved.derivatives.size());
  std::vector<std::vector<std::uint32_t>> reads(n);
  std::vector<bool> is_read(n, false);
  for (std::uint32_t i = 0; i < n; ++i) {
    reads[i] = states_read(resolved.graph, resolved.derivatives[i]);
    for (const auto j : reads[i]) {
      if (j != i) is_read[j] = true;
    }
  }
  std::vector<std::uint32_t> order, stack;
  std::vector<bool> placed(n, false);
  const auto walk = [&](std::uint32_t start) {
    stack.push_back(start);
    while (!stack.empty()) {
      const std::uint32_t i = stack.back();
      stack.pop_back();
      if (placed[i]) continue;
      placed[i] = true;
      order.push_back(i);
      for (auto j = reads[i].rbegin(); j != reads[i].rend(); ++j) {
        if (!placed[*j]) stack.push_back(*j);
      }
    }
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!is_read[i]) walk(i);
  }
  for (std::uint32_t i = 0; i < n; ++i) walk(i);
  std::reverse(order.begin(), order.end());

  // Depth among the continuous operations: operations of one kind and depth run as one group.
  std::vector<std::uint32_t> depth(resolved.graph.operations.size(), 0);
  for (std::uint32_t id = 0; id < depth.size(); ++id) {
    const Operation& o = resolved.graph.operations[id];
    if (!o.is_continuous() || is_leaf(o.op)) continue;
    std::uint32_t below = 0;
    if (is_compound(o.op)) {
      for (const auto i : resolved.graph.operands_of_compound(id)) below = std::max(below, depth[i]);
    } else {
      const int arity = arity_of(o.op);
      below = depth[o.a];
      if (arity > 1) below = std::max(below, depth[o.b]);
      if (arity > 2) below = std::max(below, depth[o.c]);
    }
    depth[id] = below + 1;
  }
  std::stable_sort(order.begin(), order.end(), [&](auto x, auto y) {
    const std::uint32_t p = resolved.derivatives[x];
    const std::uint32_t q = resolved.derivatives[y];
    return std::tuple(depth[p], resolved.graph.operations[p].op) <
           std::tuple(depth[q], resolved.graph.operations[q].op);
  });
  return order;
}

class Compiler {
 public:
  // `loops`: how many of the loops are the diagram's own; those that follow belong to derivatives.
  Compiler(const Record& record, const CompileOptions& options, std::shared_ptr<Resolved> resolved, std::size_t loops)
      : record_(record),
        options_(options),
        resolved_(std::move(resolved)),
        graph_(resolved_->graph),
        recorded_loops_(loops) {}

  std::shared_ptr<const Program> compile() {
    program_ = std::make_shared<Program>();
    collect_guards();
    describe_kernels();
    const std::vector<Partial> jacobian = options_.jacobian ? make_jacobian() : std::vector<Partial>{};
    make_states();
    const std::vector<std::uint32_t> step_roots = unrolled_step();
    if (options_.dae) make_dae();
    if (options_.linear) make_linear();

    Lowering slots(graph_, resolved_->activations);
    place_loops(slots);
    lower_continuous(slots, jacobian, step_roots);
    lower_held(slots);
    lower_loops(slots);
    give_gates(slots);
    lower_parameters(slots);
    finish_arena(slots);
    describe();
    program_->resolved = resolved_;
    return program_;
  }

 private:
  void collect_guards() {
    for (std::uint32_t m = 0; m < graph_.modes.size(); ++m) {
      for (const auto guard : graph_.modes[m].guards) {
        program_->guards.push_back({false, m, 0, graph_.operations[guard].is_continuous(), 0, no_gate});
        guard_roots_.push_back(guard);
      }
    }
    for (std::uint32_t j = 0; j < record_.jumps.size(); ++j) {
      const std::uint32_t guard = resolved_->jumps[j].guard;
      program_->guards.push_back({true, j, record_.jumps[j].direction, graph_.operations[guard].is_continuous(),
                                  record_.jumps[j].at_zero, no_gate});
      guard_roots_.push_back(guard);
    }
  }

  void describe_kernels() {
    for (const KernelUse& use : record_.kernels) {
      Program::KernelState state;
      state.kernel = use.kernel;
      state.continuous = use.continuous;
      state.site = use.site;
      state.first_state = program_->kernel_state_size;
      state.first_history = program_->history_count;
      program_->kernel_state_size += static_cast<std::uint32_t>(use.kernel->state_size());
      program_->history_count += static_cast<std::uint32_t>(use.kernel->histories());
      const auto inputs = use.inputs.size() + use.advance_inputs.size();
      program_->scratch_size = std::max(
          program_->scratch_size, static_cast<std::uint32_t>(inputs + static_cast<std::size_t>(use.kernel->outputs()) +
                                                             static_cast<std::size_t>(use.kernel->scratch_size())));
      state.mask = continuous_bit;
      program_->kernels.push_back(std::move(state));
    }
    std::size_t k = 0;
    for (const RecordedNode& node : record_.nodes) {
      if (node.op != Op::kernel) continue;
      if (node.rate != 0) program_->kernels[node.a].mask = rate_bit(node.rate);
      kernel_activations_.resize(record_.kernels.size(), 0);
      kernel_activations_[node.a] = node.activation;
      advance_order_.push_back(node.a);
      ++k;
    }
  }

  std::vector<Partial> make_jacobian() {
    std::vector<std::uint32_t> opaque;
    std::vector<Partial> entries = differentiate(graph_, resolved_->derivatives, Op::state, opaque);
    program_->jacobian_is_exact = opaque.empty();
    for (const auto site : opaque) program_->differenced.push_back(record_.sites[site].path);
    return entries;
  }

  // Sites of kernels that answer later to what they are given now, as delays do, and that something reads: derivatives
  // at one instant do not tell of them.
  std::set<std::uint32_t> late_kernels() const {
    std::vector<std::uint32_t> open = resolved_->derivatives;
    open.insert(open.end(), resolved_->watches.begin(), resolved_->watches.end());
    open.insert(open.end(), resolved_->nexts.begin(), resolved_->nexts.end());
    std::vector<bool> seen(graph_.operations.size());
    std::set<std::uint32_t> sites;
    while (!open.empty()) {
      const std::uint32_t id = open.back();
      open.pop_back();
      if (seen[id]) continue;
      seen[id] = true;
      const Operation& o = graph_.operations[id];
      if (is_compound(o.op)) {
        if (o.op == Op::kernel && !record_.kernels[graph_.kernels[o.a].index].advance_inputs.empty())
          sites.insert(o.site);
        const auto operands = graph_.operands_of_compound(id);
        open.insert(open.end(), operands.begin(), operands.end());
      } else if (!is_leaf(o.op)) {
        const std::uint32_t operands[] = {o.a, o.b, o.c};
        open.insert(open.end(), operands, operands + std::min(arity_of(o.op), 3));
      }
    }
    return sites;
  }

  void make_linear() {
    linear_ = linear_partials(*resolved_, record_.states.size(), record_.discretes.size(),
                              {options_.linear_by, options_.linear_open, options_.linear_hits});
    std::set<std::uint32_t> missing = late_kernels();
    missing.insert(linear_.opaque.begin(), linear_.opaque.end());
    for (const auto site : missing) program_->linear.missing.push_back(record_.sites[site].path);
    for (const auto id : linear_.held) {
      program_->linear.held_masks.push_back(graph_.operations[id].mask);
      program_->linear.held_names.push_back(record_.sites[graph_.operations[id].site].path);
    }
  }

  Program::PartialList lower_partials(Lowering& slots, const std::vector<Partial>& entries, bool rows_are_states) {
    const auto states = static_cast<std::uint32_t>(record_.states.size());
    Program::PartialList partials;
    Lowering::Request request;
    for (const Partial& p : entries) {
      partials.row.push_back(rows_are_states && p.row < states ? program_->place_of_state[p.row] : p.row);
      partials.column.push_back(p.column < states ? program_->place_of_state[p.column] : p.column);
      request.roots.push_back(graph_.id_of(p.value));
    }
    slots.grow();
    if (!request.roots.empty()) partials.list = slots.lower(request);
    return partials;
  }

  void lower_linear(Lowering& slots) {
    program_->linear.flow = lower_partials(slots, linear_.flow, true);
    for (const std::vector<Partial>& entries : linear_.hits)
      program_->linear.hits.push_back(lower_partials(slots, entries, false));
  }

  void make_states() {
    program_->state_at = order_states(*resolved_);
    program_->place_of_state.resize(program_->state_at.size());
    for (std::uint32_t place = 0; place < program_->state_at.size(); ++place)
      program_->place_of_state[program_->state_at[place]] = place;
  }

  std::vector<std::uint32_t> unrolled_step() {
    if (options_.unroll_method.empty() || options_.unroll_step <= 0) return {};
    return unroll(graph_, resolved_->derivatives, options_.unroll_method, options_.unroll_step);
  }

  std::vector<std::uint32_t> by_place(const std::vector<std::uint32_t>& per_state) const {
    std::vector<std::uint32_t> result;
    for (const auto state : program_->state_at) result.push_back(per_state[state]);
    return result;
  }

  void lower_continuous(Lowering& slots, const std::vector<Partial>& jacobian,
                        const std::vector<std::uint32_t>& step_roots) {
    const auto n = static_cast<std::uint32_t>(program_->state_at.size());
    program_->states = slots.allocate(n, 8);
    for (std::uint32_t id = 0; id < graph_.operations.size(); ++id) {
      const Operation& o = graph_.operations[id];
      if (o.op == Op::state) slots.set_slot(id, program_->states + program_->place_of_state[o.a]);
    }
    // The list that runs most comes first: what it reads is laid out in the order in which it reads.
    if (!step_roots.empty()) {
      Lowering::Request step;
      step.roots = by_place(step_roots);
      step.pinned = slots.allocate(n, 8);
      program_->step_list = slots.lower(step);
    }
    Lowering::Request derivatives;
    derivatives.roots = by_place(resolved_->derivatives);
    derivatives.pinned = slots.allocate(n, 8);
    program_->derivative_list = slots.lower(derivatives);
    if (n == 0) program_->derivative_list = {};
    for (const Loop& loop : graph_.loops) {  // their leaves are read by the derivatives too
      if (loop.initial || loop.by_hand || !is_continuous(loop)) continue;
      for (const auto leaf : loop.leaves) slots.slot(leaf);
    }
    for (std::uint32_t id = 0; id < graph_.operations.size(); ++id) {
      const Operation& o = graph_.operations[id];
      if (slots.has_slot(id) && !o.is_continuous() && !o.is_parameter_only()) {
        program_->held_in_derivatives.push_back(slots.slot(id));
      }
    }
    const auto plain = [&](std::vector<std::uint32_t> roots) {
      Lowering::Request request;
      request.roots = std::move(roots);
      return request.roots.empty() ? List{} : slots.lower(request);
    };
    program_->guard_list = plain(guard_roots_);
    program_->watch_list = plain(resolved_->watches);
    std::vector<std::uint32_t> updates, jumps, advances;
    for (const Mode& mode : graph_.modes) updates.push_back(mode.of_loop ? mode.operation : mode.update);
    program_->mode_list = plain(updates);
    for (std::uint32_t j = 0; j < record_.jumps.size(); ++j) {
      for (const auto value : resolved_->jumps[j].values) jumps.push_back(value);
    }
    program_->jump_list = plain(jumps);
    for (std::size_t k = 0; k < advance_order_.size(); ++k) {
      if (!program_->kernels[advance_order_[k]].continuous) continue;
      advances.insert(advances.end(), resolved_->advance_inputs[k].begin(), resolved_->advance_inputs[k].end());
    }
    program_->advance_list = plain(advances);
    for (std::size_t k = 0; k < advance_order_.size(); ++k) {
      Program::KernelState& kernel = program_->kernels[advance_order_[k]];
      if (kernel.continuous && kernel.kernel->histories() > 0)
        kernel.sources = histories_behind(*resolved_, resolved_->advance_inputs[k].front());
    }
    std::vector<std::uint32_t> unknowns;
    for (std::size_t k = 0; k < recorded_loops_; ++k) {
      const Loop& loop = graph_.loops[k];
      if (!loop.initial && !loop.by_hand && is_continuous(loop)) unknowns.push_back(loop.unknowns[0].operation);
    }
    program_->loop_list = plain(unknowns);
    std::vector<std::uint32_t> holds;
    for (const auto& [condition, value] : resolved_->holds) {
      holds.push_back(condition);
      holds.push_back(value);
    }
    program_->hold_list = plain(holds);
    // What is asked between lists stands in a slot of its own.
    for (std::size_t i = 1; i < resolved_->activations.size(); ++i) slots.slot(resolved_->activations[i]);
    for (std::size_t j = 0; j < record_.jumps.size(); ++j) {
      if (record_.jumps[j].triggers != 0) slots.slot(resolved_->jumps[j].enabled);
    }
    lower_jacobian(slots, jacobian);
    if (options_.dae) lower_dae(slots);
    if (options_.linear) lower_linear(slots);

    Lowering::Request initial;
    initial.roots = by_place(resolved_->initial_states);
    initial.roots.insert(initial.roots.end(), resolved_->initial_discretes.begin(), resolved_->initial_discretes.end());
    initial.roots.insert(initial.roots.end(), resolved_->initial_kernels.begin(), resolved_->initial_kernels.end());
    initial.held_is_external = false;
    if (!initial.roots.empty()) program_->initial_list = slots.lower(initial);
  }

  void lower_jacobian(Lowering& slots, std::vector<Partial> entries) {
    if (!options_.jacobian) return;
    for (Partial& p : entries) {
      p.row = program_->place_of_state[p.row];
      p.column = program_->place_of_state[p.column];
    }
    std::sort(entries.begin(), entries.end(), [](const Partial& x, const Partial& y) {
      return std::pair(x.column, x.row) < std::pair(y.column, y.row);
    });
    program_->jacobian_column_start.assign(program_->state_at.size() + 1, 0);
    Lowering::Request request;
    for (const Partial& p : entries) {
      ++program_->jacobian_column_start[p.column + 1];
      program_->jacobian_row.push_back(static_cast<int>(p.row));
      request.roots.push_back(graph_.id_of(p.value));
    }
    slots.grow();
    std::partial_sum(program_->jacobian_column_start.begin(), program_->jacobian_column_start.end(),
                     program_->jacobian_column_start.begin());
    if (!request.roots.empty()) program_->jacobian_list = slots.lower(request);
  }

  void lower_held(Lowering& slots) {
    Lowering::Request held;
    held.by_mask = true;
    held.held_is_external = false;
    for (std::uint32_t id = 0; id < graph_.operations.size(); ++id) {
      const Operation& o = graph_.operations[id];
      if (is_leaf(o.op) || o.is_continuous() || o.is_parameter_only()) continue;
      if ((o.op == Op::min || o.op == Op::max) && graph_.operations[o.b].is_parameter_only())
        program_->limits.push_back({slots.slot(id), slots.slot(o.b), o.site});
      if (slots.has_slot(id)) held.roots.push_back(id);
    }
    const std::size_t demanded = held.roots.size();
    held.roots.insert(held.roots.end(), resolved_->nexts.begin(), resolved_->nexts.end());
    for (std::size_t k = 0; k < advance_order_.size(); ++k) {
      if (program_->kernels[advance_order_[k]].continuous) continue;
      held.roots.insert(held.roots.end(), resolved_->advance_inputs[k].begin(), resolved_->advance_inputs[k].end());
    }
    if (held.roots.empty()) return;
    program_->held_list = slots.lower(held);
    std::size_t next = demanded;
    for (std::size_t i = 0; i < resolved_->nexts.size(); ++i)
      program_->nexts.push_back(program_->held_list.roots[next++]);
    std::size_t advance = 0;
    for (std::size_t k = 0; k < advance_order_.size(); ++k) {
      Program::KernelState& kernel = program_->kernels[advance_order_[k]];
      for (std::size_t i = 0; i < resolved_->advance_inputs[k].size(); ++i) {
        kernel.advance_inputs.push_back(kernel.continuous ? program_->advance_list.roots[advance++]
                                                          : program_->held_list.roots[next++]);
      }
    }
    has_advance_inputs_ = true;
  }

  // The equations with the unknowns of loops as variables, and their Jacobian.
  void make_dae() {
    dae_roots_ = by_place(resolved_->derivatives);
    std::vector<std::uint32_t> leaves;
    std::vector<std::uint32_t> column;
    const SinkInCharge charge(graph_);
    for (const auto state : program_->state_at) leaves.push_back(graph_.leaf(Op::state, state, continuous_bit).id());
    for (std::uint32_t k = 0; k < recorded_loops_; ++k) {
      const Loop& loop = graph_.loops[k];
      if (loop.initial || loop.by_hand || !is_continuous(loop)) continue;
      program_->dae_loops.push_back(k);
      for (const Loop::Unknown& unknown : loop.unknowns) {
        dae_roots_.push_back(unknown.residual);
        leaves.push_back(unknown.operation);
        dae_unknowns_.push_back(unknown.operation);
      }
    }
    graph_.rate = 0;
    std::vector<std::uint32_t> opaque;
    dae_jacobian_ = differentiate_by(graph_, dae_roots_, leaves, opaque, true);
    if (!opaque.empty()) dae_jacobian_.clear();
    dae_is_exact_ = opaque.empty();
    for (const Partial& p : dae_jacobian_) graph_.id_of(p.value);
  }

  void lower_dae(Lowering& slots) {
    const auto n = static_cast<std::uint32_t>(dae_roots_.size());
    Lowering::Request request;
    request.roots = dae_roots_;
    request.pinned = slots.allocate(n, 8);
    for (const auto unknown : dae_unknowns_) request.given.emplace_back(unknown, slots.home(unknown));
    if (n > 0) program_->dae_list = slots.lower(request);
    if (!dae_is_exact_) return;
    std::sort(dae_jacobian_.begin(), dae_jacobian_.end(), [](const Partial& x, const Partial& y) {
      return std::pair(x.column, x.row) < std::pair(y.column, y.row);
    });
    program_->dae_column_start.assign(n + 1, 0);
    request.roots.clear();
    request.pinned = no_slot;
    for (const Partial& p : dae_jacobian_) {
      ++program_->dae_column_start[p.column + 1];
      program_->dae_row.push_back(static_cast<int>(p.row));
      request.roots.push_back(graph_.id_of(p.value));
    }
    std::partial_sum(program_->dae_column_start.begin(), program_->dae_column_start.end(),
                     program_->dae_column_start.begin());
    if (!request.roots.empty()) program_->dae_jacobian_list = slots.lower(request);
  }

  bool is_continuous(const Loop& loop) const { return graph_.operations[loop.operation].is_continuous(); }

  // Where the unknowns of each loop stand, and what is copied for it.
  void place_loops(Lowering& slots) {
    for (std::uint32_t k = 0; k < graph_.loops.size(); ++k) {
      const Loop& loop = graph_.loops[k];
      const auto n = static_cast<std::uint32_t>(loop.unknowns.size());
      Program::Loop placed;
      placed.path = loop.path;
      placed.site = loop.site;
      placed.initial = loop.initial;
      placed.exact = loop.exact;
      placed.affine = loop.affine;
      placed.constant = loop.constant;
      placed.mask = graph_.operations[loop.operation].mask;
      placed.unknowns = slots.allocate(n);
      for (std::uint32_t i = 0; i < n; ++i) {
        placed.names.push_back(loop.unknowns[i].name);
        slots.set_home(loop.unknowns[i].operation, placed.unknowns + i);
      }
      slots.set_loop_inputs(k, slots.allocate(static_cast<std::uint32_t>(loop.inputs.size())));
      placed.first_value = program_->loop_value_count;
      program_->loop_value_count += n;
      placed.first_room = program_->loop_room_size;
      program_->loop_room_size += static_cast<std::uint32_t>(loop_room(n));
      program_->loops.push_back(std::move(placed));
    }
  }

  // The insides of the loops: what depends on the unknowns, and what the Jacobian adds.
  void lower_loops(Lowering& slots) {
    for (std::uint32_t k = 0; k < graph_.loops.size(); ++k) {
      const Loop& loop = graph_.loops[k];
      Program::Loop& placed = program_->loops[k];
      if (loop.by_hand) {
        program_->pivots.push_back({slots.slot(loop.jacobian[0].value), loop.path, loop.site});
        continue;
      }
      Lowering::Request request;
      request.held_is_external = false;
      for (std::uint32_t i = 0; i < loop.unknowns.size(); ++i) {
        const Loop::Unknown& unknown = loop.unknowns[i];
        request.roots.push_back(unknown.residual);
        request.given.emplace_back(unknown.operation, placed.unknowns + i);
        const auto bound = [&](std::uint32_t id) { return id == Loop::none ? no_slot : slots.slot(id); };
        placed.lower.push_back(bound(unknown.lower));
        placed.upper.push_back(bound(unknown.upper));
        placed.guess.push_back(bound(unknown.guess));
      }
      for (std::uint32_t i = 0; i < loop.inputs.size(); ++i)
        request.given.emplace_back(loop.inputs[i], slots.loop_inputs(k) + i);
      placed.residual_list = slots.lower(request);
      request.roots.clear();
      for (const Loop::Entry& entry : loop.jacobian) {
        request.roots.push_back(entry.value);
        placed.row.push_back(entry.row);
        placed.column.push_back(entry.column);
      }
      if (!request.roots.empty()) placed.jacobian_list = slots.lower(request);
      request.roots.clear();
      for (const std::uint32_t mode : loop.modes) {
        request.roots.push_back(graph_.modes[mode].update);
        placed.modes.push_back(slots.slot(graph_.modes[mode].operation));
        placed.mode_sites.push_back(graph_.modes[mode].site);
      }
      if (!request.roots.empty()) placed.mode_list = slots.lower(request);
    }
  }

  void give_gates(Lowering& slots) {
    const auto gate = [&](std::uint16_t activation) {
      return activation == 0 ? no_gate : slots.slot(resolved_->activations[activation]);
    };
    for (Program::Guard& guard : program_->guards) {
      if (guard.is_jump) guard.gate = gate(record_.jumps[guard.index].activation);
    }
    for (std::size_t k = 0; k < kernel_activations_.size(); ++k)
      program_->kernels[k].gate = gate(kernel_activations_[k]);
    enabled_.assign(record_.jumps.size(), no_gate);
    for (std::size_t j = 0; j < record_.jumps.size(); ++j) {
      if (record_.jumps[j].triggers != 0) enabled_[j] = slots.slot(resolved_->jumps[j].enabled);
    }
  }

  void lower_parameters(Lowering& slots) {
    if (!has_advance_inputs_) {  // no held list: continuous kernels only
      std::size_t advance = 0;
      for (std::size_t k = 0; k < advance_order_.size(); ++k) {
        for (std::size_t i = 0; i < resolved_->advance_inputs[k].size(); ++i) {
          program_->kernels[advance_order_[k]].advance_inputs.push_back(program_->advance_list.roots[advance++]);
        }
      }
    }
    for (std::size_t s = 0; s < record_.schedules.size(); ++s) {
      Program::Schedule schedule;
      for (const auto t : resolved_->schedules[s].times) schedule.times.push_back(slots.slot(t));
      schedule.first = slots.slot(resolved_->schedules[s].first);
      schedule.period = slots.slot(resolved_->schedules[s].period);
      schedule.periodic = record_.schedules[s].periodic;
      schedule.site = record_.schedules[s].site;
      program_->schedules.push_back(std::move(schedule));
    }
    for (const auto number : resolved_->numbers) program_->numbers.push_back(slots.slot(number));
    Lowering::Request parameters;
    parameters.parameter_only_is_external = false;
    parameters.by_mask = true;  // results stand in their shared slots
    parameters.fuse = false;
    for (std::uint32_t id = 0; id < graph_.operations.size(); ++id) {
      const Operation& o = graph_.operations[id];
      if (!is_leaf(o.op) && o.is_parameter_only() && slots.has_slot(id)) parameters.roots.push_back(id);
    }
    if (!parameters.roots.empty()) program_->parameter_list = slots.lower(parameters);
  }

  void finish_arena(Lowering& slots) {
    program_->time = no_slot;
    program_->parameters.assign(record_.parameters.size(), no_slot);
    program_->discretes.assign(record_.discretes.size(), no_slot);
    program_->modes.assign(graph_.modes.size(), no_slot);
    program_->segments.assign(record_.schedules.size(), no_slot);
    program_->hits.assign(record_.rates.size(), no_slot);
    std::vector<std::pair<SlotIndex, double>> numbers;
    for (std::uint32_t id = 0; id < graph_.operations.size(); ++id) {
      const Operation& o = graph_.operations[id];
      if (!is_leaf(o.op) || !slots.has_slot(id)) continue;
      const SlotIndex slot = slots.slot(id);
      if (o.op == Op::constant) numbers.emplace_back(slot, graph_.constant(id));
      if (o.op == Op::time) program_->time = slot;
      if (o.op == Op::parameter) program_->parameters[o.a] = slot;
      if (o.op == Op::discrete) program_->discretes[o.a] = slot;
      if (o.op == Op::mode) program_->modes[o.a] = slot;
      if (o.op == Op::segment) program_->segments[o.a] = slot;
      if (o.op == Op::hit) program_->hits[o.a] = slot;
    }
    const auto complete = [&](SlotIndex& slot) {
      if (slot == no_slot) slot = slots.allocate(1);
    };
    complete(program_->time);
    for (auto* list :
         {&program_->parameters, &program_->discretes, &program_->modes, &program_->segments, &program_->hits}) {
      for (SlotIndex& slot : *list) complete(slot);
    }
    program_->arena.assign(std::max<std::size_t>(slots.size(), 1) + 8, 0.0);
    for (const auto& [slot, number] : numbers) program_->arena[slot] = number;
    for (std::size_t p = 0; p < record_.parameters.size(); ++p)
      program_->arena[program_->parameters[p]] = record_.parameters[p].value;
  }

  void describe() {
    std::uint32_t first_value = 0;
    for (std::uint32_t j = 0; j < record_.jumps.size(); ++j) {
      Program::Jump jump;
      jump.name = record_.jumps[j].name;
      jump.site = record_.jumps[j].site;
      jump.first_value = first_value;
      jump.triggers = record_.jumps[j].triggers;
      jump.of_kernel = record_.jumps[j].of_kernel;
      jump.enabled = enabled_[j];
      jump.level = record_.jumps[j].level;
      for (const auto& assignment : record_.jumps[j].assignments) {
        jump.targets.push_back(
            {assignment.discrete, assignment.discrete ? program_->discretes[assignment.index]
                                                      : program_->states + program_->place_of_state[assignment.index]});
        ++first_value;
      }
      program_->jumps.push_back(std::move(jump));
    }
    for (const RecordedHold& hold : record_.holds) program_->holds.push_back(program_->discretes[hold.index]);
    program_->rates = record_.rates;
    program_->parameter_info = record_.parameters;
    program_->sites = record_.sites;
    for (const auto state : program_->state_at) {
      program_->state_names.push_back(record_.states[state].name);
      program_->state_sites.push_back(record_.states[state].site);
    }
    for (const auto& discrete : record_.discretes) {
      program_->discrete_names.push_back(discrete.name);
      program_->discrete_rates.push_back(discrete.rate);
    }
    for (const auto watch : resolved_->watches) {
      program_->watch_masks.push_back(graph_.operations[watch].mask);
      program_->watch_sites.push_back(graph_.operations[watch].site);
    }
  }

  const Record& record_;
  const CompileOptions& options_;
  std::shared_ptr<Resolved> resolved_;
  OperationGraph& graph_;
  std::size_t recorded_loops_;  // those that follow belong to the Jacobian
  std::shared_ptr<Program> program_;
  std::vector<std::uint32_t> dae_roots_, dae_unknowns_;
  std::vector<Partial> dae_jacobian_;
  bool dae_is_exact_ = true;
  LinearPartials linear_;
  std::vector<std::uint32_t> guard_roots_;
  std::vector<std::uint16_t> kernel_activations_;
  std::vector<SlotIndex> enabled_;            // per jump
  std::vector<std::uint32_t> advance_order_;  // kernels of the Record in the order of resolved_->advance_inputs
  bool has_advance_inputs_ = false;
};

}  // namespace

namespace {

// Null after reporting.
std::shared_ptr<Resolved> resolve_all(const Record& record, const CompileOptions& options, Report& report) {
  const std::size_t errors = report.error_count();
  if (record.rates.size() > most_rates + 1u) {
    report.error({}, "the diagram has {} different rates; at most {} can be kept apart", record.rates.size() - 1,
                 most_rates);
    return nullptr;
  }
  auto resolved =
      std::make_shared<Resolved>(resolve(record, options.watches, options.numbers, options.loops_are_errors, report));
  return report.error_count() > errors ? nullptr : resolved;
}

std::shared_ptr<const Program> compile_resolved(const Record& record, const CompileOptions& options,
                                                std::shared_ptr<Resolved> resolved, std::size_t loops) {
  const SinkInCharge charge(resolved->graph);
  resolved->graph.make_modes = false;
  resolved->graph.activation = 0;
  resolved->graph.rate = 0;
  return Compiler(record, options, std::move(resolved), loops).compile();
}

}  // namespace

std::shared_ptr<const Program> compile(const Record& record, const CompileOptions& options, Report& report) {
  auto resolved = resolve_all(record, options, report);
  if (!resolved) return nullptr;
  const std::size_t loops = resolved->graph.loops.size();
  return compile_resolved(record, options, std::move(resolved), loops);
}

std::shared_ptr<const Program> compile_with_sensitivities(const Record& record, const CompileOptions& options,
                                                          const SensitivityRequest& request, SensitivityLimits& limits,
                                                          Report& report) {
  const Record larger = with_sensitivity_states(record, request);
  auto resolved = resolve_all(larger, options, report);
  if (!resolved) return nullptr;
  const std::size_t loops = resolved->graph.loops.size();
  add_sensitivities(*resolved, record, record.states.size(), record.discretes.size(), request, limits);
  return compile_resolved(larger, options, std::move(resolved), loops);
}

}  // namespace plantloop
