// Everything inside a loop was made after its operation; what is older is given.

#include "engine/program/loop_parts.h"

#include <algorithm>
#include <unordered_set>

#include "engine/program/differentiate.h"

namespace plantloop {

namespace {

void push_operands(const OperationGraph& graph, std::uint32_t id, std::vector<std::uint32_t>& stack) {
  const Operation& o = graph.operations[id];
  if (is_compound(o.op)) {
    for (const auto operand : graph.operands_of_compound(id)) stack.push_back(operand);
    return;
  }
  const int arity = arity_of(o.op);
  if (arity > 0) stack.push_back(o.a);
  if (arity > 1) stack.push_back(o.b);
  if (arity > 2) stack.push_back(o.c);
}

// What residuals and Jacobian read, and whether the Jacobian reads unknowns.
void look_outside(OperationGraph& graph, std::uint32_t index) {
  Loop& loop = graph.loops[index];
  const auto walk = [&](std::vector<std::uint32_t> stack, bool& reads_unknowns) {
    std::unordered_set<std::uint32_t> seen;
    while (!stack.empty()) {
      const std::uint32_t id = stack.back();
      stack.pop_back();
      const Operation& o = graph.operations[id];
      if (o.is_parameter_only() || !seen.insert(id).second) continue;
      if (o.op == Op::unknown && o.a == loop.operation) {
        reads_unknowns = true;
      } else if (is_leaf(o.op)) {
        loop.leaves.push_back(id);
      } else if (id < loop.operation) {
        loop.inputs.push_back(id);
      } else {
        push_operands(graph, id, stack);
      }
    }
  };
  std::vector<std::uint32_t> residuals, entries;
  for (const Loop::Unknown& unknown : loop.unknowns) residuals.push_back(unknown.residual);
  for (const Loop::Entry& entry : loop.jacobian) entries.push_back(entry.value);
  std::vector<std::uint32_t> updates;
  for (const std::uint32_t mode : loop.modes) updates.push_back(graph.modes[mode].update);
  bool by_residual = false, by_jacobian = false;
  walk(residuals, by_residual);
  walk(updates, by_residual);
  walk(entries, by_jacobian);
  for (auto* list : {&loop.inputs, &loop.leaves}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  loop.affine = loop.exact && !by_jacobian;
  loop.constant = loop.exact && std::all_of(entries.begin(), entries.end(),
                                            [&](std::uint32_t id) { return graph.operations[id].is_parameter_only(); });
}

}  // namespace

void complete_loop(OperationGraph& graph, std::uint32_t index, RateIndex rate) {
  graph.make_modes = false;
  graph.rate = rate;
  std::vector<std::uint32_t> residuals, unknowns, opaque;
  for (const Loop::Unknown& unknown : graph.loops[index].unknowns) {
    residuals.push_back(unknown.residual);
    unknowns.push_back(unknown.operation);
  }
  const std::vector<Partial> partials = differentiate_by(graph, residuals, unknowns, opaque);
  for (const Partial& p : partials) {
    if (p.value.is(0)) continue;  // what goes in comes out
    const std::uint32_t value = graph.id_of(p.value);
    graph.loops[index].jacobian.push_back({p.row, p.column, value});
  }
  graph.loops[index].exact = opaque.empty();
  look_outside(graph, index);
}

std::vector<Value> inverse_jacobian(OperationGraph& graph, std::uint32_t index) {
  const auto n = static_cast<std::uint32_t>(graph.loops[index].unknowns.size());
  std::vector<Value> matrix(n * n, Value(0));
  for (const Loop::Entry& e : graph.loops[index].jacobian) matrix[e.row * n + e.column] = value_of(graph, e.value);
  if (n == 1) return {1.0 / matrix[0]};
  const Mask mask = graph.operations[graph.loops[index].operation].mask;
  std::vector<Value> inverse(n * n);
  for (std::uint32_t column = 0; column < n; ++column) {  // J x = e
    const auto added = static_cast<std::uint32_t>(graph.loops.size());
    Loop loop;
    loop.path = graph.loops[index].path;
    loop.site = graph.loops[index].site;
    loop.unknowns.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) loop.unknowns[i].name = graph.loops[index].unknowns[i].name;
    graph.loops.push_back(std::move(loop));
    const Value operation = graph.loop(added, mask);
    graph.loops[added].operation = operation.id();
    for (std::uint32_t i = 0; i < n; ++i) {
      inverse[i * n + column] = graph.unknown(operation, i);
      graph.loops[added].unknowns[i].operation = inverse[i * n + column].id();
    }
    for (std::uint32_t row = 0; row < n; ++row) {
      Value residual = row == column ? -1.0 : 0.0;
      for (std::uint32_t i = 0; i < n; ++i) residual = residual + matrix[row * n + i] * inverse[i * n + column];
      graph.loops[added].unknowns[row].residual = graph.id_of(residual);
      for (std::uint32_t i = 0; i < n; ++i) {
        if (matrix[row * n + i].is(0)) continue;
        const std::uint32_t value = graph.id_of(matrix[row * n + i]);
        graph.loops[added].jacobian.push_back({row, i, value});
      }
    }
    look_outside(graph, added);
  }
  return inverse;
}

}  // namespace plantloop
