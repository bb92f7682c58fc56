// The grouped executor.
//
// Every kind of operation exists as a loop for each pattern of operands, as a function that hands its result on and
// calls the next one in tail position, and as a case of a switch; all three are made from the one table in operations.h
// and round alike.

#include "engine/program/execute.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <iterator>
#include <utility>

#include "engine/base/vectors.h"
#include "engine/program/program.h"
#include "engine/program/slots_read.h"
#include "engine/program/solve_loop.h"

namespace plantloop {

namespace {

template <Op op>
struct Function;
#define X(name, expression)                                                                                \
  template <>                                                                                              \
  struct Function<Op::name> {                                                                              \
    static double apply([[maybe_unused]] double a, [[maybe_unused]] double b, [[maybe_unused]] double c) { \
      return expression;                                                                                   \
    }                                                                                                      \
  };
PLANTLOOP_UNARY_OPERATIONS(X)
PLANTLOOP_BINARY_OPERATIONS(X)
PLANTLOOP_TERNARY_OPERATIONS(X)
#undef X

// An operand of a group: contiguous, the same for all, or gathered.
template <int pattern>
struct Operand {
  const double* base;
  const std::uint32_t* index;
  double value;
  Operand(double* arena, const std::uint32_t* gathers, std::uint32_t slot)
      : base(pattern == gathered ? arena : arena + slot),
        index(pattern == gathered ? gathers + slot : nullptr),
        value(pattern == constant ? arena[slot] : 0) {}
  double operator[](std::uint32_t i) const {
    if constexpr (pattern == contiguous) return base[i];
    if constexpr (pattern == constant) return value;
    return base[index[i]];
  }
};

using GroupFunction = void (*)(const GroupRun&, double*, const std::uint32_t*);

template <Op op, int pa, int pb, int pc>
[[gnu::always_inline]] inline void loop(const GroupRun& group, double* arena, const std::uint32_t* gathers) {
  // A group never writes what it reads: results have slots of their own.
  double* __restrict out = arena + group.out;
  const Operand<pa> a(arena, gathers, group.a);
  const Operand<pb> b(arena, gathers, group.b);
  const Operand<pc> c(arena, gathers, group.c);
  const std::uint32_t count = group.count;
  for (std::uint32_t i = 0; i < count; ++i) out[i] = Function<op>::apply(a[i], b[i], c[i]);
}

template <Op op, int pa, int pb, int pc>
void run_group(const GroupRun& group, double* arena, const std::uint32_t* gathers) {
  loop<op, pa, pb, pc>(group, arena, gathers);
}
template <Op op, int pa, int pb, int pc>
PLANTLOOP_WIDE void run_wide_group(const GroupRun& group, double* arena, const std::uint32_t* gathers) {
  loop<op, pa, pb, pc>(group, arena, gathers);
}

template <bool wide, Op op, int arity, std::size_t... p>
constexpr std::array<GroupFunction, 27> group_row(std::index_sequence<p...>) {
  // Operands that the operation does not have count as constant.
  if constexpr (wide) {
    return {run_wide_group < op, static_cast<int>(p % 3), (arity > 1) ? static_cast<int>(p / 3 % 3) : 1,
            (arity > 2) ? static_cast<int>(p / 9) : 1 > ...};
  } else {
    return {run_group < op, static_cast<int>(p % 3), (arity > 1) ? static_cast<int>(p / 3 % 3) : 1,
            (arity > 2) ? static_cast<int>(p / 9) : 1 > ...};
  }
}

template <bool wide>
constexpr auto make_group_table() {
  std::array<std::array<GroupFunction, 27>, 256> table{};
#define X(name, expression) \
  table[static_cast<std::size_t>(Op::name)] = group_row<wide, Op::name, 1>(std::make_index_sequence<3>());
  PLANTLOOP_UNARY_OPERATIONS(X)
#undef X
#define X(name, expression) \
  table[static_cast<std::size_t>(Op::name)] = group_row<wide, Op::name, 2>(std::make_index_sequence<9>());
  PLANTLOOP_BINARY_OPERATIONS(X)
#undef X
#define X(name, expression) \
  table[static_cast<std::size_t>(Op::name)] = group_row<wide, Op::name, 3>(std::make_index_sequence<27>());
  PLANTLOOP_TERNARY_OPERATIONS(X)
#undef X
  return table;
}
constexpr auto group_table = make_group_table<false>();
constexpr auto wide_group_table = make_group_table<true>();

void run_groups(const List& list, const Segment& segment, double* arena) {
  const auto& table = has_wide_vectors ? wide_group_table : group_table;
  for (std::uint32_t i = segment.first; i < segment.first + segment.count; ++i) {
    const GroupRun& group = list.groups[i];
    table[static_cast<std::size_t>(group.op)][group.pattern](group, arena, list.gathers.data());
  }
}

// One instruction, then the next one in tail position: the compiler makes a jump of it when it optimises.
template <Op op, int last_operand>
void step(const Instruction* i, double* arena, double last) {
  constexpr int arity = 3;
  const double a = last_operand == 1 ? last : arena[i->a];
  const double b = arity < 2 ? 0 : last_operand == 2 ? last : arena[i->b];
  const double c = arity < 3 ? 0 : last_operand == 3 ? last : arena[i->c];
  const double result = Function<op>::apply(a, b, c);
  arena[i->out] = result;
#if defined(__clang__)
  [[clang::musttail]] return (i + 1)->handler(i + 1, arena, result);
#else
  return (i + 1)->handler(i + 1, arena, result);
#endif
}

void stop(const Instruction*, double*, double) {}

using Handler = void (*)(const Instruction*, double*, double);

constexpr auto make_handler_table() {
  std::array<std::array<Handler, 4>, 256> table{};
#define X(name, expression)                                                                             \
  table[static_cast<std::size_t>(Op::name)] = {step<Op::name, 0>, step<Op::name, 1>, step<Op::name, 2>, \
                                               step<Op::name, 3>};
  PLANTLOOP_UNARY_OPERATIONS(X)
  PLANTLOOP_BINARY_OPERATIONS(X)
  PLANTLOOP_TERNARY_OPERATIONS(X)
#undef X
  return table;
}
constexpr auto handler_table = make_handler_table();

void switch_instructions(const List& list, const Segment& segment, double* arena) {
  for (std::uint32_t i = segment.first; i < segment.first + segment.count; ++i) {
    const Instruction& o = list.instructions[i];
    if (o.handler == stop) break;
    arena[o.out] = apply(o.op, arena[o.a], arena[o.b], arena[o.c]);
  }
}

void switch_groups(const List& list, const Segment& segment, double* arena) {
  for (std::uint32_t g = segment.first; g < segment.first + segment.count; ++g) {
    const GroupRun& group = list.groups[g];
    const auto slot = [&](std::uint32_t operand, int pattern, std::uint32_t i) {
      return pattern == contiguous ? operand + i : pattern == constant ? operand : list.gathers[operand + i];
    };
    for (std::uint32_t i = 0; i < group.count; ++i) {
      const int arity = arity_of(group.op);
      const double a = arena[slot(group.a, group.pattern % 3, i)];
      const double b = arity > 1 ? arena[slot(group.b, group.pattern / 3 % 3, i)] : 0;
      const double c = arity > 2 ? arena[slot(group.c, group.pattern / 9, i)] : 0;
      arena[group.out + i] = apply(group.op, a, b, c);
    }
  }
}

void run_kernels(const List& list, const Segment& segment, double* arena, KernelFrame* frame) {
  assert(frame != nullptr);
  for (std::uint32_t i = segment.first; i < segment.first + segment.count; ++i) {
    const KernelStep& step = list.kernels[i];
    const Program::KernelState& own = frame->program->kernels[step.kernel];
    double* in = frame->scratch;
    for (std::uint32_t j = 0; j < step.input_count + step.advance_count; ++j)
      in[j] = arena[list.gathers[step.inputs + j]];
    KernelCall call;
    call.time = arena[frame->program->time];
    call.in = in;
    call.out = arena + step.out;
    call.state = frame->states + own.first_state;
    call.scratch = in + step.input_count + step.advance_count;
    call.history = frame->histories + own.first_history;
    call.left = frame->left;
    if (step.initial) {
      if (own.kernel->starts_with_inputs()) call.in = in + step.input_count;
      own.kernel->initialise(call);
      call.in = in;
    }
    own.kernel->evaluate(call);
  }
}

void run_loops(const List& list, const Segment& segment, double* arena, KernelFrame* frame) {
  assert(frame != nullptr);
  for (std::uint32_t i = segment.first; i < segment.first + segment.count; ++i) {
    const LoopStep& step = list.loops[i];
    for (std::uint32_t j = 0; j < step.input_count; ++j) arena[step.to + j] = arena[list.gathers[step.inputs + j]];
    solve_loop(frame->program->loops[step.loop], arena, *frame);
  }
}

// `chained`: narrow parts by tail calls; `grouped`: wide parts by the loops of the table. Neither: operation by
// operation.
template <bool chained, bool grouped>
void run(const List& list, double* arena, KernelFrame* kernels, std::uint64_t bits) {
  for (const Segment& segment : list.segments) {
    if (segment.mask != 0 && (segment.mask & bits) == 0) continue;
    if (segment.gate != no_gate && arena[segment.gate] == 0) continue;
    switch (segment.kind) {
      case Segment::Kind::instructions:
        if constexpr (chained) {
          const Instruction* first = &list.instructions[segment.first];
          first->handler(first, arena, 0);
        } else {
          switch_instructions(list, segment, arena);
        }
        break;
      case Segment::Kind::groups:
        if constexpr (grouped) {
          run_groups(list, segment, arena);
        } else {
          switch_groups(list, segment, arena);
        }
        break;
      case Segment::Kind::kernels:
        run_kernels(list, segment, arena, kernels);
        break;
      case Segment::Kind::loops:
        run_loops(list, segment, arena, kernels);
        break;
    }
  }
}

}  // namespace

void execute(const List& list, double* arena, KernelFrame* kernels, std::uint64_t bits) {
#if defined(PLANTLOOP_TAIL_CALLS)
  run<true, true>(list, arena, kernels, bits);
#else
  run<false, true>(list, arena, kernels,
                   bits);  // without optimisation a tail call is a call, and a long part would fill the stack
#endif
}

void execute_by_switch(const List& list, double* arena, KernelFrame* kernels, std::uint64_t bits) {
  run<false, false>(list, arena, kernels, bits);
}

std::vector<std::uint32_t> slots_read(const List& list) {
  std::vector<std::uint32_t> read, written;
  for (const Instruction& i : list.instructions) {
    if (i.handler == stop) continue;
    const std::array<std::uint32_t, 3> operands{i.a, i.b, i.c};
    read.insert(read.end(), operands.begin(), operands.begin() + arity_of(i.op));
    written.push_back(i.out);
  }
  for (const GroupRun& group : list.groups) {
    const std::array<std::uint32_t, 3> operands{group.a, group.b, group.c};
    for (std::uint32_t i = 0; i < group.count; ++i) {
      int pattern = group.pattern;
      for (int k = 0; k < arity_of(group.op); ++k, pattern /= 3) {
        const std::uint32_t first = operands[static_cast<std::size_t>(k)];
        read.push_back(pattern % 3 == contiguous ? first + i
                       : pattern % 3 == constant ? first
                                                 : list.gathers[first + i]);
      }
      written.push_back(group.out + i);
    }
  }
  for (const KernelStep& step : list.kernels) {
    const auto from = list.gathers.begin() + step.inputs;
    read.insert(read.end(), from, from + step.input_count + step.advance_count);
    for (std::uint32_t i = 0; i < step.out_count; ++i) written.push_back(step.out + i);
  }
  for (const LoopStep& step : list.loops) {
    const auto from = list.gathers.begin() + step.inputs;
    read.insert(read.end(), from, from + step.input_count);
  }
  const auto sort = [](std::vector<std::uint32_t>& slots) {
    std::sort(slots.begin(), slots.end());
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  };
  sort(read);
  sort(written);
  std::vector<std::uint32_t> only_read;
  std::set_difference(read.begin(), read.end(), written.begin(), written.end(), std::back_inserter(only_read));
  return only_read;
}

void link_instructions(List& list) {
  for (Instruction& i : list.instructions) {
    i.handler = i.op == Op::constant ? stop : handler_table[static_cast<std::size_t>(i.op)][i.last];
  }
}

}  // namespace plantloop
