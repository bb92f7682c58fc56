// The derivatives' operations written once more for each stage, with the stage's states in place of the states.

#include "engine/program/unroll.h"

#include <algorithm>

namespace plantloop {

namespace {

constexpr std::size_t most_operations = 600;  // of one stage; beyond, the longer arena costs more than the calls

// Each row of these methods has one entry, below the diagonal: stage i starts from x + h a[i] k[i-1].
struct Stages {
  std::string_view method;
  std::vector<double> a;
  std::vector<double> b;
};
const Stages methods[] = {
    {"euler", {0}, {1}},
    {"heun", {0, 1}, {1.0 / 2, 1.0 / 2}},
    {"rk4", {0, 1.0 / 2, 1.0 / 2, 1}, {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}},
};

class Copier {
 public:
  Copier(OperationGraph& graph, const std::vector<std::uint32_t>& roots) : graph_(graph), roots_(roots) {
    std::vector<bool> seen(graph.operations.size(), false);
    std::vector<std::uint32_t> stack(roots);
    while (!stack.empty()) {
      const std::uint32_t id = stack.back();
      stack.pop_back();
      const Operation& o = graph.operations[id];
      if (seen[id] || !o.is_continuous()) continue;
      seen[id] = true;
      order_.push_back(id);
      has_kernel_ = has_kernel_ || is_compound(o.op) || is_result(o.op);
      if (is_leaf(o.op) || is_compound(o.op)) continue;
      const int arity = arity_of(o.op);
      stack.push_back(o.a);
      if (arity > 1) stack.push_back(o.b);
      if (arity > 2) stack.push_back(o.c);
    }
    std::sort(order_.begin(), order_.end());
    copies_.resize(graph.operations.size());
  }

  bool fits() const { return !has_kernel_ && order_.size() <= most_operations; }

  std::vector<Value> derivatives(const std::vector<Value>& states, Value time) {
    for (const auto id : order_) {
      const Operation o = graph_.operations[id];
      graph_.site = o.site;
      graph_.activation = o.activation;
      if (o.op == Op::state) {
        copies_[id] = states[o.a];
      } else if (o.op == Op::time) {
        copies_[id] = time;
      } else {
        const int arity = arity_of(o.op);
        copies_[id] = record(o.op, of(o.a), arity > 1 ? of(o.b) : Value(0), arity > 2 ? of(o.c) : Value(0));
      }
    }
    graph_.activation = 0;
    std::vector<Value> result;
    for (const auto root : roots_) result.push_back(of(root));
    return result;
  }

 private:
  Value of(std::uint32_t id) const {
    const Operation& o = graph_.operations[id];
    if (o.op == Op::constant) return Value(graph_.constant(id));
    return o.is_continuous() ? copies_[id] : Value::node(id);
  }

  OperationGraph& graph_;
  const std::vector<std::uint32_t>& roots_;
  std::vector<std::uint32_t> order_;
  std::vector<Value> copies_;
  bool has_kernel_ = false;
};

}  // namespace

std::vector<std::uint32_t> unroll(OperationGraph& graph, const std::vector<std::uint32_t>& derivatives,
                                  std::string_view method, double h) {
  const auto* stages =
      std::find_if(std::begin(methods), std::end(methods), [&](const Stages& s) { return s.method == method; });
  if (stages == std::end(methods) || derivatives.empty()) return {};
  Copier copier(graph, derivatives);
  if (!copier.fits()) return {};
  const SinkInCharge charge(graph);
  graph.make_modes = false;
  graph.rate = 0;
  std::vector<Value> start;
  for (std::uint32_t i = 0; i < derivatives.size(); ++i) start.push_back(graph.leaf(Op::state, i, continuous_bit));
  const Value time = graph.leaf(Op::time, 0, continuous_bit);
  std::vector<Value> end = start;
  std::vector<Value> k;
  for (std::size_t stage = 0; stage < stages->a.size(); ++stage) {
    std::vector<Value> at = start;
    const double a = stages->a[stage] * h;
    if (stage > 0) {
      for (std::size_t i = 0; i < at.size(); ++i) at[i] = start[i] + a * k[i];
    }
    k = copier.derivatives(at, time + a);
    for (std::size_t i = 0; i < end.size(); ++i) end[i] = end[i] + (stages->b[stage] * h) * k[i];
  }
  std::vector<std::uint32_t> result;
  for (const Value& v : end) result.push_back(graph.id_of(v));
  return result;
}

}  // namespace plantloop
