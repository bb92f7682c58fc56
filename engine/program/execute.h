// A list of operations made ready to run: wide groups as loops over contiguous slots, narrow parts as a chain of small
// functions.

#pragma once

#include <cstdint>
#include <vector>

#include "engine/program/kernel.h"
#include "engine/program/operations.h"

namespace plantloop {

// A run of `count` operations of one kind. An operand is contiguous (slot, slot + 1, ...), constant (one slot) or
// gathered (`a` is the place of its slots in List::gathers); `pattern` counts in base 3: a + 3 b + 9 c.
struct GroupRun {
  Op op;
  std::uint8_t pattern;
  std::uint32_t count, out, a, b, c;
};
enum OperandPattern : std::uint8_t { contiguous = 0, constant = 1, gathered = 2 };

// One operation of a narrow part. `last` is 1, 2 or 3 when that operand is the result of the instruction before; 0
// else.
struct Instruction {
  void (*handler)(const Instruction*, double*, double);
  std::uint32_t out, a, b, c;
  Op op;
  std::uint8_t last;
};

// A call of a kernel: the slots of its inputs stand in List::gathers.
struct KernelStep {
  std::uint32_t kernel;  // index into Program::kernels
  std::uint32_t inputs, input_count, advance_count;
  std::uint32_t out, out_count;  // contiguous
  bool initial;                  // initialise its state from the advance inputs first
};

// Solves a loop: the slots of what it is given stand in List::gathers and are copied to `to`.
struct LoopStep {
  std::uint32_t loop;  // index into Program::loops
  std::uint32_t inputs, input_count, to;
};

struct Segment {
  enum class Kind : std::uint8_t { instructions, groups, kernels, loops };
  Kind kind;
  std::uint32_t first, count;
  std::uint64_t mask;  // run when it shares a bit with the bits asked for
  std::uint32_t gate;  // and when this slot is not 0; no_gate: in any case
};
inline constexpr std::uint32_t no_gate = 0xffffffff;

struct List {
  std::vector<Segment> segments;
  std::vector<Instruction> instructions;  // each part ends with an instruction that returns
  std::vector<GroupRun> groups;
  std::vector<KernelStep> kernels;
  std::vector<LoopStep> loops;
  std::vector<std::uint32_t> gathers;
  std::vector<std::uint32_t> roots;  // slots of the results
  std::size_t operation_count = 0;
  bool empty() const { return segments.empty(); }
};

// What kernels and loops need beside the arena; null where a list has none.
struct KernelFrame {
  const struct Program* program = nullptr;
  double* states = nullptr;
  double* scratch = nullptr;
  History* histories = nullptr;   // those of all kernels, in order
  double* loop_values = nullptr;  // the last accepted values of all loops' unknowns: where the search begins
  double* loop_room = nullptr;    // without meaning between runs
  bool left = false;
};

inline constexpr std::uint64_t every_bit = ~std::uint64_t{0};

// Runs the parts of the list that share a bit with `bits` (or have none). Throws LoopError when a loop has no solution.
void execute(const List& list, double* arena, KernelFrame* kernels = nullptr, std::uint64_t bits = every_bit);
// The same by one switch, operation by operation: the reference in tests, and what sanitizer builds run.
void execute_by_switch(const List& list, double* arena, KernelFrame* kernels = nullptr, std::uint64_t bits = every_bit);

// Fills in the handlers once operations, slots and `last` are set.
void link_instructions(List& list);

}  // namespace plantloop
