// Forward accumulation: operations in order, each with one tangent for each parameter, of the same rate and activation.
// So the tangent of what is held is held, and the tangent of what is sampled is sampled at the same hits.

#include "engine/program/sensitivities.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <tuple>

#include "engine/program/differentiate.h"
#include "engine/program/loop_parts.h"
#include "engine/program/resolve.h"

namespace plantloop {

namespace {

// The rate whose block made an operation; 0: it runs whenever what it reads changes.
RateIndex rate_of(Mask mask) {
  if (std::popcount(mask) != 1 || (mask & (continuous_bit | event_bit)) != 0) return 0;
  return static_cast<RateIndex>(std::countr_zero(mask));
}

class Tangents {
 public:
  Tangents(Resolved& resolved, std::size_t states, std::size_t discretes, const SensitivityRequest& request)
      : graph_(resolved.graph),
        states_(static_cast<std::uint32_t>(states)),
        discretes_(static_cast<std::uint32_t>(discretes)),
        request_(request),
        count_(static_cast<std::uint32_t>(graph_.operations.size())),
        charge_(graph_) {
    graph_.make_modes = false;
  }

  // Makes the tangents of these operations and of all that they read.
  void make(const std::vector<std::uint32_t>& roots) {
    std::vector<bool> needed(count_, false);
    std::vector<std::uint32_t> open = roots;
    const auto need = [&](std::uint32_t id) { open.push_back(id); };
    while (!open.empty()) {
      const std::uint32_t id = open.back();
      open.pop_back();
      if (needed[id]) continue;
      needed[id] = true;
      const Operation& o = graph_.operations[id];
      if (o.op == Op::loop) {
        for (const Loop::Unknown& unknown : graph_.loops[o.a].unknowns) need(unknown.operation);
        for (const auto leaf : seeds_of_loop(o.a)) need(leaf);
      } else if (is_compound(o.op)) {
        for (const auto operand : graph_.operands_of_compound(id)) need(operand);
      } else if (!is_leaf(o.op)) {
        need(o.a);
        if (arity_of(o.op) > 1) need(o.b);
        if (arity_of(o.op) > 2) need(o.c);
      }
    }
    tangents_.assign(request_.parameters.size(), std::vector<Value>(count_, Value(0)));
    for (std::uint32_t id = 0; id < count_; ++id) {
      if (!needed[id]) continue;
      const Operation o = graph_.operations[id];
      graph_.site = o.site;
      graph_.rate = rate_of(o.mask);
      graph_.activation = o.activation;
      for (std::uint32_t k = 0; k < request_.parameters.size(); ++k) tangents_[k][id] = held_like(o, tangent(id, o, k));
    }
    graph_.rate = 0;
    graph_.activation = 0;
  }

  Value of(std::uint32_t id, std::size_t parameter) const { return tangents_[parameter][id]; }
  std::uint32_t id_of(std::uint32_t id, std::size_t parameter) { return graph_.id_of(of(id, parameter)); }
  bool moves(std::uint32_t id) const {
    return std::any_of(tangents_.begin(), tangents_.end(), [id](const auto& t) { return !t[id].is(0); });
  }
  const std::set<std::uint32_t>& opaque() const { return opaque_; }  // sites

 private:
  Value operand(std::uint32_t id) const { return value_of(graph_, id); }

  // What is held from hit to hit has a tangent that is held.
  Value held_like(const Operation& o, Value tangent) {
    if (tangent.is_known() || o.is_continuous() || o.is_parameter_only()) return tangent;
    const Operation& made = graph_.operations[tangent.id()];
    if ((made.mask & ~o.mask) == 0 && made.activation == o.activation) return tangent;
    return graph_.operation(Op::copy, tangent, 0, 0);
  }

  Value tangent(std::uint32_t id, const Operation& o, std::uint32_t k) {
    switch (o.op) {
      case Op::parameter:
        return o.a == request_.parameters[k].index ? Value(request_.parameters[k].scale) : Value(0);
      case Op::state:
        return graph_.leaf(Op::state, states_ * (k + 1) + o.a, o.mask);
      case Op::discrete:
        return graph_.leaf(Op::discrete, discretes_ * (k + 1) + o.a, o.mask);
      case Op::kernel_output:
        return tangent_of_kernel(o, k);
      case Op::loop:
        solve_loop(id, o, k);
        return 0;
      case Op::unknown:
        return unknowns_.contains({o.a, o.b, k}) ? unknowns_.at({o.a, o.b, k}) : Value(0);
      case Op::kernel:
        return 0;
      case Op::copy:  // it latches: its tangent does, too
        return of(o.a, k).is_known() ? of(o.a, k) : graph_.operation(Op::copy, of(o.a, k), 0, 0);
      case Op::where:
        return where(Truth(operand(o.a)), of(o.b, k), of(o.c, k));
      default:
        break;
    }
    if (is_leaf(o.op)) return 0;
    const std::uint32_t operands[3] = {o.a, o.b, o.c};
    Value total = 0;
    for (int j = 0; j < std::min(arity_of(o.op), 3); ++j) {
      const Value t = of(operands[j], k);
      if (!t.is(0)) total = total + partial_of(graph_, o, Value::node(id), j) * t;
    }
    return total;
  }

  Value tangent_of_kernel(const Operation& o, std::uint32_t k) {
    const auto inputs = graph_.operands_of_compound(o.a);
    if (std::any_of(inputs.begin(), inputs.end(), [&](std::uint32_t i) { return !of(i, k).is(0); }))
      opaque_.insert(o.site);
    return 0;
  }

  // What the equations of a loop read that may move: its inputs, its leaves and the parameters behind them.
  std::vector<std::uint32_t> seeds_of_loop(std::uint32_t index) {
    std::vector<std::uint32_t> seeds = graph_.loops[index].inputs;
    seeds.insert(seeds.end(), graph_.loops[index].leaves.begin(), graph_.loops[index].leaves.end());
    for (std::uint32_t id = 0; id < count_; ++id) {
      if (graph_.operations[id].op == Op::parameter) seeds.push_back(id);
    }
    return seeds;
  }

  // F(u, p) = 0 gives du = -(dF/du)^-1 dF/dp dp (implicit function theorem).
  void solve_loop(std::uint32_t id, const Operation& o, std::uint32_t k) {
    std::vector<std::uint32_t> residuals;
    for (const Loop::Unknown& unknown : graph_.loops[o.a].unknowns) residuals.push_back(unknown.residual);
    const std::size_t n = residuals.size();
    std::vector<std::uint32_t> seeds;
    std::vector<Value> moves;
    for (const auto seed : seeds_of_loop(o.a)) {
      const Operation leaf = graph_.operations[seed];  // it may stand behind the loop
      const Value moved = is_leaf(leaf.op) ? tangent(seed, leaf, k) : of(seed, k);
      if (moved.is(0)) continue;
      seeds.push_back(seed);
      moves.push_back(moved);
    }
    if (seeds.empty()) return;
    if (!graph_.loops[o.a].exact) {
      opaque_.insert(graph_.loops[o.a].site);
      return;
    }
    // The unknowns stand still: what they do about it is looked for.
    for (const Loop::Unknown& unknown : graph_.loops[o.a].unknowns) seeds.push_back(unknown.operation);
    std::vector<std::uint32_t> opaque;
    std::vector<Value> moved(n, Value(0));
    for (const Partial& p : differentiate_by(graph_, residuals, seeds, opaque)) {
      if (p.column < moves.size()) moved[p.row] = moved[p.row] + p.value * moves[p.column];
    }
    opaque_.insert(opaque.begin(), opaque.end());
    if (!inverses_.contains(o.a)) inverses_.emplace(o.a, inverse_jacobian(graph_, o.a));
    graph_.rate = rate_of(o.mask);
    graph_.activation = o.activation;
    graph_.make_modes = false;
    const std::vector<Value>& inverse = inverses_.at(o.a);
    for (std::uint32_t i = 0; i < n; ++i) {
      Value total = 0;
      for (std::size_t j = 0; j < n; ++j) total = total - inverse[i * n + j] * moved[j];
      unknowns_.insert_or_assign({id, i, k}, total);
    }
  }

  OperationGraph& graph_;
  std::uint32_t states_, discretes_;
  const SensitivityRequest& request_;
  std::uint32_t count_;  // the operations of the diagram itself
  SinkInCharge charge_;
  std::vector<std::vector<Value>> tangents_;  // by parameter
  std::set<std::uint32_t> opaque_;
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, Value> unknowns_;  // loop, number, parameter
  std::map<std::uint32_t, std::vector<Value>> inverses_;
};

std::string derivative_name(const std::string& of, const std::string& by) { return fmt::format("d {}/d {}", of, by); }

void append(std::vector<std::uint32_t>& roots, const std::vector<std::uint32_t>& more) {
  roots.insert(roots.end(), more.begin(), more.end());
}

}  // namespace

Record with_sensitivity_states(const Record& record, const SensitivityRequest& request) {
  Record larger = record;
  const std::size_t states = record.states.size(), discretes = record.discretes.size();
  for (std::uint32_t k = 0; k < request.parameters.size(); ++k) {
    const std::string& by = record.parameters[request.parameters[k].index].name;
    for (const RecordedState& state : record.states) {
      RecordedState s{derivative_name(state.name, by), state.site, Value(0), Value(0), {}};
      larger.states.push_back(std::move(s));
    }
    for (const RecordedDiscrete& discrete : record.discretes) {
      RecordedDiscrete d{derivative_name(discrete.name, by), discrete.site, discrete.rate, Value(0), Value(0), {}};
      larger.discretes.push_back(std::move(d));
    }
    for (std::size_t j = 0; j < record.jumps.size(); ++j) {
      for (const auto& assignment : record.jumps[j].assignments) {
        const std::size_t size = assignment.discrete ? discretes : states;
        larger.jumps[j].assignments.push_back(
            {assignment.discrete, static_cast<std::uint32_t>(size * (k + 1)) + assignment.index, Value(0)});
      }
    }
    for (const RecordedHold& hold : record.holds)
      larger.holds.push_back({hold.condition, Value(0), static_cast<std::uint32_t>(discretes * (k + 1)) + hold.index});
  }
  return larger;
}

void add_sensitivities(Resolved& resolved, const Record& record, std::size_t states, std::size_t discretes,
                       const SensitivityRequest& request, SensitivityLimits& limits) {
  const std::size_t watches = resolved.watches.size(), holds = resolved.holds.size() / (1 + request.parameters.size());
  Tangents tangents(resolved, states, discretes, request);
  std::vector<std::uint32_t> roots = resolved.watches;
  for (const auto* more : {&resolved.derivatives, &resolved.nexts, &resolved.initial_states,
                           &resolved.initial_discretes, &resolved.initial_kernels})
    append(roots, *more);
  for (const Resolved::Jump& jump : resolved.jumps) {
    roots.push_back(jump.guard);
    append(roots, jump.values);
  }
  for (const Mode& mode : resolved.graph.modes) append(roots, mode.guards);
  for (const auto& [condition, value] : resolved.holds) roots.push_back(value);
  for (const Resolved::Schedule& schedule : resolved.schedules) {
    append(roots, schedule.times);
    roots.push_back(schedule.first);
    roots.push_back(schedule.period);
  }
  for (const auto& inputs : resolved.advance_inputs) append(roots, inputs);
  tangents.make(roots);

  std::set<std::string> missing, moving;
  for (const auto site : tangents.opaque())
    missing.insert(fmt::format("the derivative of block '{}' is not known", record.sites[site].path));
  for (std::size_t s = 0; s < resolved.schedules.size(); ++s) {
    const Resolved::Schedule& schedule = resolved.schedules[s];
    bool moves = tangents.moves(schedule.first) || tangents.moves(schedule.period);
    for (const auto time : schedule.times) moves = moves || tangents.moves(time);
    if (moves)
      missing.insert(fmt::format("the times at which '{}' jumps move", record.sites[record.schedules[s].site].path));
  }
  for (std::size_t j = 0; j < resolved.jumps.size(); ++j) {
    if (tangents.moves(resolved.jumps[j].guard)) moving.insert(record.jumps[j].name);
  }
  for (const Mode& mode : resolved.graph.modes) {
    for (const auto guard : mode.guards) {
      if (tangents.moves(guard) && resolved.graph.operations[guard].is_continuous())
        moving.insert(record.sites[mode.site].path);
    }
  }
  limits.missing.assign(missing.begin(), missing.end());
  limits.moving_guards.assign(moving.begin(), moving.end());

  for (std::size_t k = 0; k < request.parameters.size(); ++k) {
    const auto put = [&](std::vector<std::uint32_t>& roots_of, std::size_t size) {
      for (std::size_t i = 0; i < size; ++i) roots_of[size * (k + 1) + i] = tangents.id_of(roots_of[i], k);
    };
    put(resolved.derivatives, states);
    put(resolved.initial_states, states);
    put(resolved.nexts, discretes);
    put(resolved.initial_discretes, discretes);
    for (std::size_t i = 0; i < holds; ++i)
      resolved.holds[holds * (k + 1) + i].second = tangents.id_of(resolved.holds[i].second, k);
    for (Resolved::Jump& jump : resolved.jumps) {
      const std::size_t size = jump.values.size() / (1 + request.parameters.size());
      for (std::size_t i = 0; i < size; ++i) jump.values[size * (k + 1) + i] = tangents.id_of(jump.values[i], k);
    }
    for (std::size_t w = 0; w < watches; ++w) resolved.watches.push_back(tangents.id_of(resolved.watches[w], k));
  }
}

}  // namespace plantloop
