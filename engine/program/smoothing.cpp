// A search backwards in which passing an integrator costs one and everything else nothing.

#include "engine/program/smoothing.h"

#include <algorithm>
#include <deque>

namespace plantloop {

std::vector<Smoothed> histories_behind(const Resolved& resolved, std::uint32_t operation) {
  const OperationGraph& graph = resolved.graph;
  constexpr int unseen = -1;
  std::vector<int> distance(graph.operations.size(), unseen);
  std::vector<std::uint8_t> done(graph.operations.size());
  std::deque<std::uint32_t> open;
  std::vector<Smoothed> found;
  const auto reach = [&](std::uint32_t id, int steps, bool integrates) {
    if (distance[id] != unseen && distance[id] <= steps) return;
    distance[id] = steps;
    integrates ? open.push_back(id) : open.push_front(id);
  };
  reach(operation, 0, false);
  while (!open.empty()) {
    const std::uint32_t id = open.front();
    open.pop_front();
    if (done[id] != 0) continue;
    done[id] = 1;
    const Operation& o = graph.operations[id];
    const int here = distance[id];
    if (o.op == Op::state) {
      reach(resolved.derivatives[o.a], here + 1, true);
    } else if (o.op == Op::kernel) {
      const KernelUse& use = graph.kernels[o.a];
      if (use.kernel->histories() > 0) found.push_back({use.index, here});
      for (const auto input : use.inputs) reach(input, here, false);
    } else if (is_compound(o.op)) {
      for (const auto operand : graph.operands_of_compound(id)) reach(operand, here, false);
    } else if (is_result(o.op)) {
      reach(o.a, here, false);
    } else if (!is_leaf(o.op)) {
      const int arity = arity_of(o.op);
      if (arity > 0) reach(o.a, here, false);
      if (arity > 1) reach(o.b, here, false);
      if (arity > 2) reach(o.c, here, false);
    }
  }
  std::sort(found.begin(), found.end(), [](const Smoothed& a, const Smoothed& b) { return a.kernel < b.kernel; });
  return found;
}

}  // namespace plantloop
