// Folding, sharing, masks and modes.

#include "engine/program/operation_graph.h"

#include <bit>
#include <cassert>
#include <cmath>
#include <utility>

namespace plantloop {

namespace {

constexpr std::uint32_t none = 0xffffffff;

std::uint64_t mix(std::uint64_t h, std::uint64_t v) {
  h ^= v + 0x9e3779b97f4a7c15ULL + (h << 6) + (h >> 2);
  h *= 0xff51afd7ed558ccdULL;
  return h ^ (h >> 29);
}

std::uint64_t hash_of(const Operation& o) {
  std::uint64_t h = mix(static_cast<std::uint64_t>(o.op) | (std::uint64_t{o.activation} << 8), o.a);
  h = mix(h, o.b | (std::uint64_t{o.c} << 32));
  return mix(h, o.mask);
}

bool same(const Operation& x, const Operation& y) {
  return x.op == y.op && x.a == y.a && x.b == y.b && x.c == y.c && x.mask == y.mask && x.activation == y.activation;
}

bool is_commutative(Op op) {
  return op == Op::add || op == Op::mul || op == Op::equal || op == Op::logical_and || op == Op::logical_or;
}

}  // namespace

bool makes_modes(Op op) {
  switch (op) {
    case Op::less:
    case Op::less_equal:
    case Op::equal:
    case Op::abs:
    case Op::min:
    case Op::max:
    case Op::sign:
    case Op::floor:
    case Op::ceil:
    case Op::round:
    case Op::trunc:
    case Op::mod:
      return true;
    default:
      return false;
  }
}

void OperationGraph::grow_table() {
  table_.assign(std::max<std::size_t>(64, std::bit_ceil(operations.size() * 4 + 4)), none);
  const std::size_t wrap = table_.size() - 1;
  for (std::uint32_t i = 0; i < operations.size(); ++i) {
    if (is_compound(operations[i].op)) continue;
    std::size_t at = hash_of(operations[i]) & wrap;
    while (table_[at] != none) at = (at + 1) & wrap;
    table_[at] = i;
  }
}

std::uint32_t OperationGraph::find(const Operation& operation) const {
  const std::size_t wrap = table_.size() - 1;
  for (std::size_t at = hash_of(operation) & wrap; table_[at] != none; at = (at + 1) & wrap) {
    if (same(operations[table_[at]], operation)) return table_[at];
  }
  return none;
}

Value OperationGraph::add(Operation operation) {
  if (2 * (operations.size() + 1) > table_.size()) grow_table();
  std::uint32_t known = find(operation);
  if (known == none && is_commutative(operation.op)) {
    // The author's order is kept (it makes rows of a matrix alike); a turned twin is still the same value.
    Operation turned = operation;
    std::swap(turned.a, turned.b);
    known = find(turned);
  }
  if (known != none) return Value::node(known);
  const std::size_t wrap = table_.size() - 1;
  std::size_t at = hash_of(operation) & wrap;
  while (table_[at] != none) at = (at + 1) & wrap;
  table_[at] = static_cast<std::uint32_t>(operations.size());
  operations.push_back(operation);
  return Value::node(table_[at]);
}

Value OperationGraph::leaf(Op op, std::uint32_t index, Mask mask) {
  Operation o;
  o.op = op;
  o.a = index;
  o.site = site;
  o.mask = mask;
  return add(o);
}

std::uint32_t OperationGraph::id_of(Value value) {
  if (!value.is_known()) return value.id();
  const auto bits = std::bit_cast<std::uint64_t>(value.number());
  // Constants are shared by their bits, which stand in b and c.
  Operation o;
  o.op = Op::constant;
  o.b = static_cast<std::uint32_t>(bits);
  o.c = static_cast<std::uint32_t>(bits >> 32);
  return add(o).id();
}

// Whether both uses always give the same outputs.
bool OperationGraph::is_same_kernel(const Operation& o, const KernelUse& use) const {
  const KernelUse& other = kernels[o.a];
  return o.activation == activation && o.mask == (rate != 0 ? rate_bit(rate) : continuous_bit) &&
         other.initial == use.initial && other.inputs == use.inputs && other.advance_inputs.empty() &&
         use.advance_inputs.empty() && use.kernel->is_same(*other.kernel);
}

Value OperationGraph::kernel(KernelUse use, std::uint64_t key) {
  const auto known = kernel_ids_.find(key);
  if (known != kernel_ids_.end()) return Value::node(known->second);
  for (const auto& [other_key, id] : kernel_ids_) {
    if (!is_same_kernel(operations[id], use)) continue;
    kernel_ids_.emplace(key, id);
    return Value::node(id);
  }
  Operation o;
  o.op = Op::kernel;
  o.a = static_cast<std::uint32_t>(kernels.size());
  o.site = use.site;
  o.activation = activation;
  o.mask = rate != 0 ? rate_bit(rate) : continuous_bit;
  kernels.push_back(std::move(use));
  operations.push_back(o);
  const auto id = static_cast<std::uint32_t>(operations.size() - 1);
  kernel_ids_.emplace(key, id);
  return Value::node(id);
}

Value OperationGraph::kernel_output(Value kernel, std::uint32_t index) {
  Operation o;
  o.op = Op::kernel_output;
  o.a = kernel.id();
  o.b = index;
  o.site = operations[kernel.id()].site;
  o.mask = operations[kernel.id()].mask;
  o.activation = operations[kernel.id()].activation;
  return add(o);
}

Value OperationGraph::loop(std::uint32_t index, Mask mask) {
  Operation o;
  o.op = Op::loop;
  o.a = index;
  o.site = site;
  o.mask = mask;
  operations.push_back(o);
  return Value::node(static_cast<std::uint32_t>(operations.size() - 1));
}

Value OperationGraph::unknown(Value loop, std::uint32_t index) {
  Operation o;
  o.op = Op::unknown;
  o.a = loop.id();
  o.b = index;
  o.site = operations[loop.id()].site;
  o.mask = operations[loop.id()].mask;
  return add(o);
}

std::vector<std::uint32_t> OperationGraph::operands_of_compound(std::uint32_t id) const {
  const Operation& o = operations[id];
  if (o.op == Op::loop) {
    std::vector<std::uint32_t> all = loops[o.a].inputs;
    all.insert(all.end(), loops[o.a].leaves.begin(), loops[o.a].leaves.end());
    return all;
  }
  std::vector<std::uint32_t> all = kernels[o.a].inputs;
  all.insert(all.end(), kernels[o.a].advance_inputs.begin(), kernels[o.a].advance_inputs.end());
  return all;
}

Value OperationGraph::plain(Op op, Value a, Value b, Value c) {
  const bool before = std::exchange(make_modes, false);
  const Value result = record(op, a, b, c);
  make_modes = before;
  return result;
}

// The mode whose value is `op` of the operands; made once.
Value OperationGraph::mode(Op op, Value a, Value b) {
  const Value update = plain(op, a, b);
  if (update.is_known()) return update;
  if (loop_with_modes != none) return mode_of_loop(update);
  const auto known = mode_of_update_.find(update.id());
  if (known != mode_of_update_.end()) return leaf(Op::mode, known->second, event_bit);
  const auto index = static_cast<std::uint32_t>(modes.size());
  mode_of_update_.emplace(update.id(), index);
  modes.push_back({update.id(), {}, site});
  const Value self = leaf(Op::mode, index, event_bit);
  std::vector<std::uint32_t> guards;
  const auto guard = [&](Value g) { guards.push_back(id_of(g)); };
  if (op == Op::floor) {
    guard(a - self);
    guard(a - (self + 1.0));
  } else if (op == Op::round) {
    guard(a - (self - 0.5));
    guard(a - (self + 0.5));
  } else {
    guard(a - b);
  }
  modes[index].guards = std::move(guards);
  return self;
}

Value OperationGraph::mode_of_loop(Value update) {
  std::vector<std::uint32_t>& own = loops[loop_with_modes].modes;
  for (const std::uint32_t m : own) {
    if (modes[m].update == update.id()) return Value::node(modes[m].operation);
  }
  const auto index = static_cast<std::uint32_t>(modes.size());
  const Value self = leaf(Op::mode, index, operations[loops[loop_with_modes].operation].mask);
  modes.push_back({update.id(), {}, site, true, self.id()});
  own.push_back(index);
  return self;
}

// min or max; b counts as a limit where a block's arithmetic gives it by parameters alone.
Value OperationGraph::chosen(Op op, Value a, Value b) {
  const Value takes_b = op == Op::min ? mode(Op::less, b, a) : mode(Op::less, a, b);
  if (!takes_b.is_known() && mask_of(b) == 0) {
    const Operation& o = operations[takes_b.id()];
    if (o.op == Op::mode) modes[o.a].of_limit = true;
  }
  return where(Truth(takes_b), b, a);
}

Value OperationGraph::as_mode(Op op, Value a, Value b) {
  switch (op) {
    case Op::less:
    case Op::less_equal:
    case Op::equal:
      return mode(op, a, b);
    case Op::abs:
      return where(Truth(mode(Op::less, a, 0.0)), -a, a);
    case Op::min:
    case Op::max:
      return chosen(op, a, b);
    case Op::sign: {
      const Value positive = mode(Op::less, 0.0, a);
      return where(Truth(positive), Value(1.0), where(Truth(mode(Op::less, a, 0.0)), Value(-1.0), Value(0.0)));
    }
    case Op::floor:
    case Op::round:
      return mode(op, a, 0.0);
    case Op::ceil:
      return -mode(Op::floor, -a, 0.0);
    case Op::trunc:
      return where(Truth(mode(Op::less, a, 0.0)), -mode(Op::floor, -a, 0.0), mode(Op::floor, a, 0.0));
    case Op::mod:
      return a - b * mode(Op::floor, a / b, 0.0);
    default:
      assert(false);
      return a;
  }
}

Value OperationGraph::operation(Op op, Value a, Value b, Value c) {
  const int arity = arity_of(op);
  Mask mask = mask_of(a);
  if (arity > 1) mask |= mask_of(b);
  if (arity > 2) mask |= mask_of(c);
  if (rate != 0 && mask != 0) mask = rate_bit(rate);
  const bool may_change = (mask & continuous_bit) != 0 || (loop_with_modes != none && mask != 0);
  if (make_modes && may_change && makes_modes(op)) return as_mode(op, a, b);
  Operation o;
  o.op = op;
  o.activation = mask == 0 ? std::uint16_t{0} : activation;
  o.site = site;
  o.mask = mask;
  o.a = id_of(a);
  if (arity > 1) o.b = id_of(b);
  if (arity > 2) o.c = id_of(c);
  return add(o);
}

}  // namespace plantloop
