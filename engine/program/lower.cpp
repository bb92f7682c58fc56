// One list: the operations below its roots, fused, in levels, in groups whose operands stand side by side.

#include "engine/program/lower.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <span>
#include <tuple>

namespace plantloop {

namespace {

constexpr std::uint32_t none = 0xffffffff;
// Below these widths a chain of small functions is faster than a loop (measured: 5-6 contiguous, 10-12 gathered).
constexpr std::uint32_t least_contiguous_run = 6;
constexpr std::uint32_t least_gathered_run = 12;
// A shorter stretch of contiguous operands inside a gathered group is not worth a cut.
constexpr std::uint32_t least_cut = 16;

// An operand: an operation of this list (local), or one from outside.
struct Reference {
  std::uint32_t index = none;
  bool local = false;
};

struct LocalOperation {
  Op op;
  std::uint8_t arity = 0;
  std::uint32_t source = none;  // in the graph; none for a copy made here
  Reference operands[3];
  std::uint32_t uses = 0;
  std::uint32_t level = 0;
  std::uint32_t key = none;  // the place of its first reader, last group first
  std::uint32_t slot = none;
  std::uint64_t mask = 0;
  std::uint16_t activation = 0;
  Reference gate;  // where activation is not 0
  bool is_root = false;
  bool gone = false;  // fused into its reader
  std::vector<Reference> kernel_inputs;
};

using Members = std::vector<std::uint32_t>;

class ListBuilder {
 public:
  ListBuilder(const OperationGraph& graph, Lowering& slots, const Lowering::Request& request)
      : graph_(graph), slots_(slots), request_(request) {}

  List build() {
    given_.insert(request_.given.begin(), request_.given.end());
    collect();
    pin_roots();
    if (request_.by_mask) spread_masks();
    if (request_.fuse) fuse();
    give_levels();
    make_groups();
    order_groups();
    give_slots();
    emit();
    give_roots();
    link_instructions(list_);
    return std::move(list_);
  }

 private:
  bool is_external(std::uint32_t id) const {
    const Operation& o = graph_.operations[id];
    if (is_leaf(o.op) || given_.contains(id)) return true;
    if (o.is_continuous()) return false;
    return o.is_parameter_only() ? request_.parameter_only_is_external : request_.held_is_external;
  }

  Reference reference(std::uint32_t id) const {
    if (is_external(id)) return {id, false};
    return {local_of_[id], true};
  }

  // The operations below the roots, operands first.
  void collect() {
    local_of_.assign(graph_.operations.size(), none);
    std::vector<std::uint32_t> needed, stack;
    std::vector<bool> seen(graph_.operations.size(), false);
    for (const auto root : request_.roots) stack.push_back(root);
    while (!stack.empty()) {
      const std::uint32_t id = stack.back();
      stack.pop_back();
      if (seen[id] || is_external(id)) continue;
      seen[id] = true;
      needed.push_back(id);
      const Operation& o = graph_.operations[id];
      if (o.activation != 0) stack.push_back(slots_.gate(o.activation));
      if (is_compound(o.op)) {
        for (const auto i : inputs_of(o)) stack.push_back(i);
        continue;
      }
      const int arity = arity_of(o.op);
      if (arity > 0) stack.push_back(o.a);
      if (arity > 1) stack.push_back(o.b);
      if (arity > 2) stack.push_back(o.c);
    }
    std::sort(needed.begin(), needed.end());
    operations_.reserve(needed.size() + request_.roots.size());
    for (const auto id : needed) {
      local_of_[id] = static_cast<std::uint32_t>(operations_.size());
      const Operation& o = graph_.operations[id];
      LocalOperation local;
      local.op = o.op;
      local.source = id;
      local.mask = o.mask;
      local.activation = o.activation;
      if (o.activation != 0) local.gate = reference(slots_.gate(o.activation));
      local.arity = static_cast<std::uint8_t>(arity_of(o.op));
      if (local.arity > 0) local.operands[0] = reference(o.a);
      if (local.arity > 1) local.operands[1] = reference(o.b);
      if (local.arity > 2) local.operands[2] = reference(o.c);
      if (is_compound(o.op)) {
        for (const auto i : inputs_of(o)) local.kernel_inputs.push_back(reference(i));
      }
      operations_.push_back(std::move(local));
    }
    for (LocalOperation& o : operations_)
      for_operands(o, [&](Reference r) {
        if (r.local) ++operations_[r.index].uses;
      });
  }

  // Of a kernel or a loop: what is handed over to it.
  std::vector<std::uint32_t> inputs_of(const Operation& o) const {
    if (o.op == Op::loop) return graph_.loops[o.a].inputs;
    std::vector<std::uint32_t> inputs = graph_.kernels[o.a].inputs;
    const auto& advance = graph_.kernels[o.a].advance_inputs;
    inputs.insert(inputs.end(), advance.begin(), advance.end());
    return inputs;
  }

  template <typename F>
  static void for_operands(const LocalOperation& o, F&& f) {
    if (o.activation != 0) f(o.gate);
    if (is_compound(o.op)) {
      for (const Reference r : o.kernel_inputs) f(r);
      return;
    }
    for (int i = 0; i < o.arity; ++i) f(o.operands[i]);
  }

  // Roots that must stand side by side are computed there; what is computed elsewhere, or twice a root, is copied.
  void pin_roots() {
    for (std::size_t i = 0; i < request_.roots.size(); ++i) {
      const Reference r = reference(request_.roots[i]);
      if (request_.pinned == no_slot) {
        roots_.push_back(r);
        if (!r.local) continue;
        LocalOperation& o = operations_[r.index];
        o.is_root = true;
        ++o.uses;
        if (o.key == none) o.key = static_cast<std::uint32_t>(i);
        continue;
      }
      const auto slot = request_.pinned + static_cast<std::uint32_t>(i);
      if (r.local && operations_[r.index].slot == none && !is_result(operations_[r.index].op)) {
        LocalOperation& o = operations_[r.index];
        o.slot = slot;
        o.is_root = true;
        ++o.uses;
        roots_.push_back(r);
        continue;
      }
      LocalOperation copy;
      copy.op = Op::copy;
      copy.arity = 1;
      copy.operands[0] = r;
      copy.is_root = true;
      copy.uses = 1;
      copy.slot = slot;
      copy.mask = r.local ? operations_[r.index].mask : 0;  // not gated: a root exists in any case
      if (r.local) ++operations_[r.index].uses;
      operations_.push_back(std::move(copy));
      roots_.push_back({static_cast<std::uint32_t>(operations_.size() - 1), true});
    }
  }

  // Inside the held list a continuous operation runs whenever one of its readers does, and results keep their shared
  // slots.
  void spread_masks() {
    std::vector<std::uint64_t> wanted(operations_.size(), 0);
    for (std::size_t i = operations_.size(); i-- > 0;) {
      LocalOperation& o = operations_[i];
      const bool held = o.source != none && !graph_.operations[o.source].is_continuous();
      if (!held) o.mask = wanted[i];
      for_operands(o, [&](Reference r) {
        if (r.local) wanted[r.index] |= o.mask;
      });
    }
    for (LocalOperation& o : operations_) {
      const bool held = o.source != none && !graph_.operations[o.source].is_continuous();
      if (!held || is_compound(o.op) || is_result(o.op) || !slots_.has_slot(o.source)) continue;
      o.slot = slots_.slot(o.source);
      o.is_root = true;  // it must exist by itself: others read it
      ++o.uses;
    }
  }

  bool fusible(Reference r, Op op, const LocalOperation& reader) const {
    if (!r.local) return false;
    const LocalOperation& o = operations_[r.index];
    return o.op == op && o.uses == 1 && !o.is_root && !o.gone && o.mask == reader.mask &&
           o.activation == reader.activation;
  }

  // A product used once by a sum, a sum used once by a product; both roundings stay.
  void fuse() {
    for (LocalOperation& o : operations_) {
      const auto take = [&](int operand, Op fused) {
        LocalOperation& inner = operations_[o.operands[operand].index];
        const Reference other = o.operands[1 - operand];
        o.op = fused;
        o.arity = 3;
        o.operands[0] = inner.operands[0];
        o.operands[1] = inner.operands[1];
        o.operands[2] = other;
        inner.gone = true;
      };
      if (o.op == Op::add) {
        if (fusible(o.operands[0], Op::mul, o))
          take(0, Op::mul_add);
        else if (fusible(o.operands[1], Op::mul, o))
          take(1, Op::mul_add);
      } else if (o.op == Op::sub) {
        if (fusible(o.operands[0], Op::mul, o))
          take(0, Op::mul_sub);
        else if (fusible(o.operands[1], Op::mul, o))
          take(1, Op::sub_mul);
      } else if (o.op == Op::mul) {
        if (fusible(o.operands[0], Op::sub, o))
          take(0, Op::sub_scale);
        else if (fusible(o.operands[1], Op::sub, o))
          take(1, Op::sub_scale);
        else if (fusible(o.operands[0], Op::add, o))
          take(0, Op::add_scale);
        else if (fusible(o.operands[1], Op::add, o))
          take(1, Op::add_scale);
      }
    }
  }

  void give_levels() {
    for (LocalOperation& o : operations_) {
      if (o.gone) continue;
      std::uint32_t level = 0;
      for_operands(o, [&](Reference r) {
        if (r.local) level = std::max(level, operations_[r.index].level + 1);
      });
      o.level = level;
    }
  }

  void make_groups() {
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < operations_.size(); ++i) {
      if (!operations_[i].gone) order.push_back(i);
    }
    const auto key = [&](std::uint32_t i) {
      const LocalOperation& o = operations_[i];
      return std::tuple(o.level, o.op, o.mask, o.activation, i);
    };
    std::sort(order.begin(), order.end(), [&](auto x, auto y) { return key(x) < key(y); });
    for (const auto i : order) {
      const LocalOperation& o = operations_[i];
      if (!groups_.empty()) {
        const LocalOperation& first = operations_[groups_.back().front()];
        if (first.level == o.level && first.op == o.op && first.mask == o.mask && first.activation == o.activation &&
            !is_compound(o.op)) {
          groups_.back().push_back(i);
          continue;
        }
      }
      groups_.push_back({i});
    }
  }

  // Last group first: members stand in the order in which they are read, and so do the things that they read.
  void order_groups() {
    std::vector<std::uint32_t> external_key(graph_.operations.size(), none);
    std::uint32_t next = static_cast<std::uint32_t>(request_.roots.size());
    for (auto group = groups_.rbegin(); group != groups_.rend(); ++group) {
      std::stable_sort(group->begin(), group->end(), [&](auto x, auto y) {
        const LocalOperation& p = operations_[x];
        const LocalOperation& q = operations_[y];
        return std::pair(p.slot, p.key) < std::pair(q.slot, q.key);
      });
      for (int operand = 0; operand < 3; ++operand) {
        for (const auto i : *group) {
          const LocalOperation& o = operations_[i];
          if (is_compound(o.op)) {
            if (operand == 0) {
              for (const Reference r : o.kernel_inputs) touch(r, next, external_key);
            }
            continue;
          }
          if (operand < o.arity) touch(o.operands[operand], next, external_key);
        }
      }
    }
    for (const Reference r : roots_) touch(r, next, external_key);
    for (const LocalOperation& o : operations_) {
      if (o.activation != 0 && !o.gone) touch(o.gate, next, external_key);
    }
  }

  void touch(Reference r, std::uint32_t& next, std::vector<std::uint32_t>& external_key) {
    if (r.local) {
      if (operations_[r.index].key == none) operations_[r.index].key = next++;
    } else if (external_key[r.index] == none) {
      external_key[r.index] = next++;
      externals_.push_back(r.index);
    }
  }

  void give_slots() {
    for (const Members& group : groups_) {
      if (group.size() >= 8) slots_.allocate(0, 8);
      for (const auto i : group) {
        LocalOperation& o = operations_[i];
        if (o.op == Op::kernel) {
          // Its outputs stand side by side; kernel_output operations are names for them.
          o.slot = slots_.allocate(
              static_cast<std::uint32_t>(graph_.kernels[graph_.operations[o.source].a].kernel->outputs()));
        } else if (o.op == Op::unknown) {
          o.slot = slots_.home(o.source);  // the loop writes them there
        } else if (o.op == Op::loop || o.op == Op::kernel_output) {
          o.slot = none;
        } else if (o.slot == none) {
          o.slot = slots_.allocate(1);
        }
      }
    }
    slots_.allocate(0, 8);
    for (const auto id : externals_) {
      if (!given_.contains(id) && !slots_.has_slot(id)) slots_.slot(id);
    }
  }

  std::uint32_t slot_of(Reference r) {
    if (!r.local) {
      const auto given = given_.find(r.index);
      return given != given_.end() ? given->second : slots_.slot(r.index);
    }
    LocalOperation& o = operations_[r.index];
    if (o.op == Op::kernel_output && o.slot == none) {
      o.slot = operations_[o.operands[0].index].slot + graph_.operations[o.source].b;
    }
    return o.slot;
  }

  void emit() {
    std::vector<std::uint32_t> pending;  // narrow operations not written yet
    std::size_t g = 0;
    while (g < groups_.size()) {
      const std::uint32_t level = operations_[groups_[g].front()].level;
      std::vector<std::uint32_t> narrow;
      bool flushed = false;
      const auto before_wide = [&] {
        if (!flushed) emit_instructions(pending);
        flushed = true;
      };
      for (; g < groups_.size() && operations_[groups_[g].front()].level == level; ++g) {
        const LocalOperation& first = operations_[groups_[g].front()];
        if (first.op == Op::kernel) {
          before_wide();
          emit_kernel(groups_[g].front());
        } else if (first.op == Op::loop) {
          before_wide();
          emit_loop(groups_[g].front());
        } else if (first.op == Op::unknown) {
          continue;  // it stands in its slot
        } else if (first.op == Op::kernel_output) {
          for (const auto i : groups_[g]) emit_kernel_output(i, narrow);
        } else {
          emit_group(groups_[g], narrow, before_wide);
        }
      }
      pending.insert(pending.end(), narrow.begin(), narrow.end());
    }
    emit_instructions(pending);
  }

  // A held kernel output is read by other lists through its shared slot: copy it there.
  void emit_kernel_output(std::uint32_t i, std::vector<std::uint32_t>& narrow) {
    const LocalOperation& o = operations_[i];
    if (!request_.by_mask || !slots_.has_slot(o.source)) return;
    LocalOperation copy;
    copy.op = Op::copy;
    copy.arity = 1;
    copy.operands[0] = {i, true};
    copy.mask = o.mask;
    copy.activation = o.activation;
    copy.gate = o.gate;
    copy.slot = slots_.slot(o.source);
    const auto own = operations_[o.operands[0].index].slot + graph_.operations[o.source].b;
    operations_[i].slot = own;
    slots_.set_slot(o.source, copy.slot);
    operations_.push_back(copy);
    narrow.push_back(static_cast<std::uint32_t>(operations_.size() - 1));
  }

  void segment(Segment::Kind kind, std::uint32_t first, std::uint32_t count, const LocalOperation& o) {
    const std::uint64_t own = request_.by_mask ? o.mask : 0;
    const std::uint32_t gate = o.activation != 0 ? slot_of(o.gate) : no_gate;
    if (!list_.segments.empty() && kind != Segment::Kind::instructions) {
      Segment& last = list_.segments.back();
      if (last.kind == kind && last.mask == own && last.gate == gate && last.first + last.count == first) {
        last.count += count;
        return;
      }
    }
    list_.segments.push_back({kind, first, count, own, gate});
  }

  void emit_kernel(std::uint32_t i) {
    const LocalOperation& o = operations_[i];
    const KernelUse& use = graph_.kernels[graph_.operations[o.source].a];
    KernelStep step{};
    step.kernel = use.index;
    step.inputs = static_cast<std::uint32_t>(list_.gathers.size());
    step.input_count = static_cast<std::uint32_t>(use.inputs.size());
    step.advance_count = static_cast<std::uint32_t>(use.advance_inputs.size());
    for (const Reference r : o.kernel_inputs) list_.gathers.push_back(slot_of(r));
    step.out = o.slot;
    step.out_count = static_cast<std::uint32_t>(use.kernel->outputs());
    step.initial = use.initial;
    list_.kernels.push_back(step);
    ++list_.operation_count;
    segment(Segment::Kind::kernels, static_cast<std::uint32_t>(list_.kernels.size() - 1), 1, o);
  }

  void emit_loop(std::uint32_t i) {
    const LocalOperation& o = operations_[i];
    LoopStep step{};
    step.loop = graph_.operations[o.source].a;
    step.inputs = static_cast<std::uint32_t>(list_.gathers.size());
    step.input_count = static_cast<std::uint32_t>(o.kernel_inputs.size());
    step.to = slots_.loop_inputs(step.loop);
    for (const Reference r : o.kernel_inputs) list_.gathers.push_back(slot_of(r));
    list_.loops.push_back(step);
    ++list_.operation_count;
    segment(Segment::Kind::loops, static_cast<std::uint32_t>(list_.loops.size() - 1), 1, o);
  }

  // How operand `k` goes on from member i to i + 1: contiguous, constant, or neither.
  static int pattern_between(std::uint32_t now, std::uint32_t next) {
    return next == now + 1 ? contiguous : next == now ? constant : gathered;
  }

  template <typename BeforeWide>
  void emit_group(const Members& members, std::vector<std::uint32_t>& narrow, const BeforeWide& before_wide) {
    const auto n = static_cast<std::uint32_t>(members.size());
    const LocalOperation& first = operations_[members.front()];
    const int arity = first.arity;
    if (n < least_contiguous_run) {
      narrow.insert(narrow.end(), members.begin(), members.end());
      return;
    }
    slots_of_members_.assign(static_cast<std::size_t>(n) * 3, 0);
    for (std::uint32_t i = 0; i < n; ++i) {
      for (int k = 0; k < arity; ++k)
        slots_of_members_[i * 3 + static_cast<unsigned>(k)] = slot_of(operations_[members[i]].operands[k]);
    }
    const auto out = [&](std::uint32_t i) { return operations_[members[i]].slot; };
    const auto operand = [&](std::uint32_t i, int k) { return slots_of_members_[i * 3 + static_cast<unsigned>(k)]; };
    // The longest run from i with contiguous results and no gathered operand.
    const auto regular_end = [&](std::uint32_t i) {
      if (i + 1 >= n) return n;
      int pattern[3] = {};
      std::uint32_t j = i + 1;
      for (; j < n && out(j) == out(j - 1) + 1; ++j) {
        bool fits = true;
        for (int k = 0; k < arity && fits; ++k) {
          const int p = pattern_between(operand(j - 1, k), operand(j, k));
          if (j == i + 1) pattern[k] = p;
          fits = p != gathered && p == pattern[k];
        }
        if (!fits) break;
      }
      return j;
    };
    std::uint32_t i = 0;
    while (i < n) {
      std::uint32_t end = regular_end(i);
      const bool regular = end - i >= std::min(least_cut, n - i) || end - i >= least_cut;
      if (!regular) {
        // Gathered, as far as results are contiguous and no long regular run begins.
        end = i + 1;
        while (end < n && out(end) == out(end - 1) + 1 && regular_end(end) - end < least_cut) ++end;
      }
      int patterns[3] = {constant, constant, constant};
      bool any_gathered = false;
      for (int k = 0; k < arity; ++k) {
        int p = end - i > 1 ? pattern_between(operand(i, k), operand(i + 1, k)) : static_cast<int>(constant);
        for (std::uint32_t j = i + 1; j < end && p != gathered; ++j) {
          if (pattern_between(operand(j - 1, k), operand(j, k)) != p) p = gathered;
        }
        patterns[k] = p;
        any_gathered = any_gathered || p == gathered;
      }
      if (end - i < (any_gathered ? least_gathered_run : least_contiguous_run)) {
        narrow.insert(narrow.end(), members.begin() + i, members.begin() + end);
      } else {
        before_wide();
        GroupRun run{};
        run.op = first.op;
        run.count = end - i;
        run.out = out(i);
        run.pattern = static_cast<std::uint8_t>(patterns[0] + (arity > 1 ? 3 * patterns[1] : 0) +
                                                (arity > 2 ? 9 * patterns[2] : 0));
        std::uint32_t* const fields[3] = {&run.a, &run.b, &run.c};
        for (int k = 0; k < arity; ++k) {
          if (patterns[k] == gathered) {
            *fields[k] = static_cast<std::uint32_t>(list_.gathers.size());
            for (std::uint32_t j = i; j < end; ++j) list_.gathers.push_back(operand(j, k));
          } else {
            *fields[k] = operand(i, k);
          }
        }
        list_.groups.push_back(run);
        list_.operation_count += run.count;
        segment(Segment::Kind::groups, static_cast<std::uint32_t>(list_.groups.size() - 1), 1, first);
      }
      i = end;
    }
  }

  // Narrow operations, each followed by a reader of its result where one is ready; parts of equal mask.
  void emit_instructions(std::vector<std::uint32_t>& pending) {
    std::size_t from = 0;
    while (from < pending.size()) {
      std::size_t until = from + 1;
      const LocalOperation& first = operations_[pending[from]];
      while (until < pending.size() && operations_[pending[until]].activation == first.activation &&
             (!request_.by_mask || operations_[pending[until]].mask == first.mask))
        ++until;
      emit_part(std::span<const std::uint32_t>(pending).subspan(from, until - from));
      from = until;
    }
    pending.clear();
  }

  void emit_part(std::span<const std::uint32_t> part) {
    const std::size_t n = part.size();
    if (place_.size() < operations_.size()) place_.resize(operations_.size(), none);
    for (std::uint32_t p = 0; p < n; ++p) place_[part[p]] = p;
    std::vector<std::uint32_t> waiting(n, 0), reader_start(n + 1, 0), readers;
    const auto inside = [&](Reference r) { return r.local && place_[r.index] != none; };
    for (std::uint32_t p = 0; p < n; ++p) {
      for_operands(operations_[part[p]], [&](Reference r) {
        if (!inside(r)) return;
        ++waiting[p];
        ++reader_start[place_[r.index] + 1];
      });
    }
    std::partial_sum(reader_start.begin(), reader_start.end(), reader_start.begin());
    readers.resize(reader_start[n]);
    std::vector<std::uint32_t> fill(reader_start.begin(), reader_start.end() - 1);
    for (std::uint32_t p = 0; p < n; ++p) {
      for_operands(operations_[part[p]], [&](Reference r) {
        if (inside(r)) readers[fill[place_[r.index]]++] = p;
      });
    }
    const auto first = static_cast<std::uint32_t>(list_.instructions.size());
    std::vector<bool> done(n, false);
    std::size_t next = 0;
    std::uint32_t now = none;
    std::uint32_t last_slot = none;
    for (std::size_t written = 0; written < n; ++written) {
      std::uint32_t chosen = none;
      if (now != none) {
        for (std::uint32_t r = reader_start[now]; r < reader_start[now + 1]; ++r) {
          if (!done[readers[r]] && waiting[readers[r]] == 0) {
            chosen = readers[r];
            break;
          }
        }
      }
      if (chosen == none) {
        while (done[next]) ++next;
        std::size_t candidate = next;
        while (done[candidate] || waiting[candidate] != 0) ++candidate;
        chosen = static_cast<std::uint32_t>(candidate);
      }
      done[chosen] = true;
      for (std::uint32_t r = reader_start[chosen]; r < reader_start[chosen + 1]; ++r) --waiting[readers[r]];
      last_slot = write_instruction(part[chosen], last_slot);
      now = chosen;
    }
    Instruction end{};
    end.op = Op::constant;  // linked to a function that returns
    list_.instructions.push_back(end);
    segment(Segment::Kind::instructions, first, static_cast<std::uint32_t>(list_.instructions.size()) - first,
            operations_[part[0]]);
    for (const auto i : part) place_[i] = none;
  }

  std::uint32_t write_instruction(std::uint32_t index, std::uint32_t last_slot) {
    const LocalOperation& o = operations_[index];
    Instruction i{};
    i.op = o.op;
    std::uint32_t* const fields[3] = {&i.a, &i.b, &i.c};
    assert(o.arity <= 3);
    for (int k = 0; k < o.arity; ++k) {
      *fields[k] = slot_of(o.operands[k]);
      if (i.last == 0 && last_slot != none && *fields[k] == last_slot) i.last = static_cast<std::uint8_t>(k + 1);
    }
    i.out = operations_[index].slot;
    list_.instructions.push_back(i);
    ++list_.operation_count;
    return i.out;
  }

  void give_roots() {
    for (const Reference r : roots_) list_.roots.push_back(slot_of(r));
  }

  const OperationGraph& graph_;
  Lowering& slots_;
  const Lowering::Request& request_;
  std::unordered_map<std::uint32_t, std::uint32_t> given_;
  std::vector<std::uint32_t> local_of_;
  std::vector<LocalOperation> operations_;
  std::vector<Reference> roots_;
  std::vector<Members> groups_;
  std::vector<std::uint32_t> externals_;
  std::vector<std::uint32_t> slots_of_members_;
  std::vector<std::uint32_t> place_;
  List list_;
};

}  // namespace

std::uint32_t Lowering::allocate(std::uint32_t count, std::uint32_t alignment) {
  next_ = (next_ + alignment - 1) / alignment * alignment;
  const std::uint32_t first = next_;
  next_ += count;
  return first;
}

std::uint32_t Lowering::slot(std::uint32_t operation) {
  if (slots_[operation] == no_slot) {
    const auto home = homes_.find(operation);
    slots_[operation] = home != homes_.end() ? home->second : allocate(1);
  }
  return slots_[operation];
}

List Lowering::lower(const Request& request) { return ListBuilder(graph_, *this, request).build(); }

}  // namespace plantloop
