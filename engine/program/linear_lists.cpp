// What is held is cut out of the operations and stands beside the states as a variable of its own.

#include "engine/program/linear_lists.h"

#include <algorithm>

namespace plantloop {

namespace {

// Held from hit to hit. What changes at events only, as a source's segment, is computed from what is there.
bool is_held(const Operation& o) {
  const bool sampled = (o.mask & ~(continuous_bit | event_bit)) != 0;
  return !is_leaf(o.op) && !o.is_continuous() && sampled;
}

// What an operation reads at the same instant.
std::vector<std::uint32_t> operands(const OperationGraph& graph, std::uint32_t id) {
  const Operation& o = graph.operations[id];
  if (is_leaf(o.op)) return {};
  if (is_compound(o.op)) return graph.operands_of_compound(id);
  if (is_result(o.op)) return {o.a};
  switch (arity_of(o.op)) {
    case 1:
      return {o.a};
    case 2:
      return {o.a, o.b};
    default:
      return {o.a, o.b, o.c};
  }
}

// Held operations that something reads which runs at other times, and those that are watched.
std::vector<std::uint32_t> held_boundary(const Resolved& resolved) {
  const OperationGraph& graph = resolved.graph;
  std::vector<bool> seen(graph.operations.size(), false), found(graph.operations.size(), false);
  std::vector<std::uint32_t> open;
  for (const auto* roots : {&resolved.derivatives, &resolved.nexts, &resolved.watches})
    open.insert(open.end(), roots->begin(), roots->end());
  for (const auto* roots : {&resolved.derivatives, &resolved.watches}) {
    for (const auto root : *roots) found[root] = found[root] || is_held(graph.operations[root]);
  }
  while (!open.empty()) {
    const std::uint32_t id = open.back();
    open.pop_back();
    if (seen[id]) continue;
    seen[id] = true;
    for (const auto operand : operands(graph, id)) {
      const Operation& read = graph.operations[operand];
      if (is_held(read) && read.mask != graph.operations[id].mask) found[operand] = true;
      open.push_back(operand);
    }
  }
  std::vector<std::uint32_t> held;
  for (std::uint32_t id = 0; id < found.size(); ++id) {
    if (found[id]) held.push_back(id);
  }
  return held;
}

}  // namespace

LinearPartials linear_partials(Resolved& resolved, std::size_t states, std::size_t discretes,
                               const LinearRequest& request) {
  const std::vector<std::uint32_t>& by = request.by;
  OperationGraph& graph = resolved.graph;
  LinearPartials result;
  result.held = held_boundary(resolved);
  const auto first_parameter = static_cast<std::uint32_t>(states + discretes);
  const auto first_held = first_parameter + static_cast<std::uint32_t>(by.size());
  const auto time = first_held + static_cast<std::uint32_t>(result.held.size());
  std::vector<std::uint32_t> leaves, columns;  // operations and what they are called
  for (std::uint32_t id = 0; id < graph.operations.size(); ++id) {
    const Operation& o = graph.operations[id];
    if (o.op == Op::state) leaves.push_back(id), columns.push_back(o.a);
    if (o.op == Op::discrete) leaves.push_back(id), columns.push_back(static_cast<std::uint32_t>(states) + o.a);
    if (o.op == Op::time) leaves.push_back(id), columns.push_back(time);
    const auto wanted = o.op == Op::parameter ? std::find(by.begin(), by.end(), o.a) : by.end();
    if (wanted != by.end()) {
      leaves.push_back(id);
      columns.push_back(first_parameter + static_cast<std::uint32_t>(wanted - by.begin()));
    }
  }
  const std::uint32_t ignored = time + 1;
  for (const auto watch : request.open) leaves.push_back(resolved.watches[watch]), columns.push_back(ignored);
  const auto partials = [&](const std::vector<std::uint32_t>& roots, Mask recomputed) {
    std::vector<std::uint32_t> cut = leaves, names = columns;
    for (std::uint32_t h = 0; h < result.held.size(); ++h) {
      if ((graph.operations[result.held[h]].mask & recomputed) != 0) continue;
      cut.push_back(result.held[h]);
      names.push_back(first_held + h);
    }
    graph.rate = 0;
    std::vector<Partial> entries = differentiate_by(graph, roots, cut, result.opaque);
    for (Partial& entry : entries) entry.column = names[entry.column];
    entries.erase(std::remove_if(entries.begin(), entries.end(), [&](const Partial& p) { return p.column == ignored; }),
                  entries.end());
    return entries;
  };
  std::vector<std::uint32_t> roots = resolved.derivatives;
  roots.insert(roots.end(), resolved.watches.begin(), resolved.watches.end());
  result.flow = partials(roots, 0);
  for (const Mask bits : request.hits) {
    roots = result.held;
    roots.insert(roots.end(), resolved.nexts.begin(), resolved.nexts.end());
    roots.insert(roots.end(), resolved.watches.begin(), resolved.watches.end());
    std::vector<Partial> entries = partials(roots, bits);
    const auto unchanged = [&](const Partial& p) {
      return p.row < result.held.size() && (graph.operations[result.held[p.row]].mask & bits) == 0;
    };
    entries.erase(std::remove_if(entries.begin(), entries.end(), unchanged), entries.end());
    result.hits.push_back(std::move(entries));
  }
  return result;
}

}  // namespace plantloop
