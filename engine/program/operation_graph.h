// The operations of a diagram in order, each one once: what the passes work on between a Record and a Program.
//
// Invariant: the operands of an operation stand before it. Operations are made by arithmetic on Values while an
// OperationGraph is the sink in charge; it folds, shares, works out when an operation must run, and turns what a
// continuous signal compares into modes.

#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/program/record.h"

namespace plantloop {

// When an operation runs: a set of bits. No bit: it depends on parameters only.
using Mask = std::uint64_t;
inline constexpr Mask continuous_bit = Mask{1} << 63;
inline constexpr Mask event_bit = Mask{1} << 62;  // a mode, a segment or a state changed at an event
// Rates from 1 have a bit each; compile() refuses more, since what samples at a shared bit would sample too often.
inline constexpr RateIndex most_rates = 61;
inline Mask rate_bit(RateIndex rate) { return Mask{1} << (rate < most_rates ? rate : most_rates); }

struct Operation {
  Op op = Op::constant;
  std::uint16_t activation = 0;
  std::uint32_t a = 0, b = 0, c = 0;  // as in RecordedNode
  std::uint32_t site = 0;
  Mask mask = 0;
  bool is_continuous() const { return (mask & continuous_bit) != 0; }
  bool is_parameter_only() const { return mask == 0; }
};

// An integer that is frozen while integrating and changes only at events, and the functions whose zeros are those
// events.
struct Mode {
  std::uint32_t update;               // its value by comparing the present values
  std::vector<std::uint32_t> guards;  // they cross zero where the value changes
  std::uint32_t site;
  bool of_loop = false;         // frozen only while the sampled loop that it belongs to is solved; no guards
  std::uint32_t operation = 0;  // of a loop's: Op::mode
  bool of_limit = false;        // not 0 where the output of a block is at a limit that parameters alone give
};

// Unknowns that equations determine together: an algebraic loop that was torn, or declared constraints.
struct Loop {
  static constexpr std::uint32_t none = 0xffffffff;
  struct Unknown {
    std::string name;                                        // of the signal that it is
    std::uint32_t lower = none, upper = none, guess = none;  // operations over parameters only
    std::uint32_t operation = none;                          // Op::unknown
    std::uint32_t residual = none;                           // zero at the solution
  };
  struct Entry {
    std::uint32_t row, column, value;
  };
  std::vector<Unknown> unknowns;
  std::vector<Entry> jacobian;       // d residual[row] / d unknown[column]
  bool exact = true;                 // the jacobian is complete: no kernel without derivative takes part
  bool affine = false;               // the jacobian depends on no unknown
  bool constant = false;             // it depends on parameters only
  bool initial = false;              // of the initial list
  bool by_hand = false;              // its one unknown became an expression: nothing reads the loop itself
  std::vector<std::uint32_t> modes;  // of a sampled loop: frozen while it is solved, then looked at again
  // What is computed before and read inside, without parameters; and what changes by itself and is read inside.
  std::vector<std::uint32_t> inputs, leaves;
  std::string path;  // "a -> b -> a", for messages
  std::uint32_t operation = none;
  std::uint32_t site = 0;
};

class OperationGraph final : public OperationSink {
 public:
  OperationGraph() = default;

  std::vector<Operation> operations;
  std::vector<KernelUse> kernels;  // inputs are operations of this graph
  std::vector<Mode> modes;
  std::vector<Loop> loops;

  // Stamped on operations made from now on: where they come from and the rate of their block (0: continuous).
  std::uint32_t site = 0;
  RateIndex rate = 0;
  std::uint16_t activation = 0;
  bool make_modes = true;  // false: comparisons stay plain
  // The sampled loop whose members are being made: what they compare are modes of it.
  std::uint32_t loop_with_modes = Loop::none;

  Value operation(Op op, Value a, Value b, Value c) override;
  Value leaf(Op op, std::uint32_t index, Mask mask);
  Value kernel(KernelUse use, std::uint64_t key);  // the kernel operation; equal keys are one use
  Value kernel_output(Value kernel, std::uint32_t index);
  Value loop(std::uint32_t index, Mask mask);  // the operation that solves loops[index]
  Value unknown(Value loop, std::uint32_t index);
  // What a compound operation reads, leaves included.
  std::vector<std::uint32_t> operands_of_compound(std::uint32_t id) const;
  std::uint32_t id_of(Value value);  // a known number becomes a constant
  Mask mask_of(Value value) const { return value.is_known() ? 0 : operations[value.id()].mask; }
  // The number of a constant, whose bits stand in b and c.
  double constant(std::uint32_t id) const {
    const Operation& o = operations[id];
    return std::bit_cast<double>(o.b | (std::uint64_t{o.c} << 32));
  }

 private:
  struct Key {
    std::uint64_t first, second, third;
    bool operator==(const Key&) const = default;
  };
  Value add(Operation operation);  // shares
  Value plain(Op op, Value a, Value b = 0, Value c = 0);
  Value as_mode(Op op, Value a, Value b);
  Value mode(Op op, Value a, Value b);
  Value chosen(Op op, Value a, Value b);
  Value mode_of_loop(Value update);
  std::uint32_t find(const Operation& operation) const;
  void grow_table();
  std::vector<std::uint32_t> table_;  // open addressing, load at most a half
  bool is_same_kernel(const Operation& o, const KernelUse& use) const;
  std::unordered_map<std::uint64_t, std::uint32_t> kernel_ids_;
  std::unordered_map<std::uint32_t, std::uint32_t> mode_of_update_;
};

// Whether an operation on a continuous signal becomes one with modes.
bool makes_modes(Op op);
// An operation as an operand; a constant is a known number.
inline Value value_of(const OperationGraph& graph, std::uint32_t id) {
  return graph.operations[id].op == Op::constant ? Value(graph.constant(id)) : Value::node(id);
}

}  // namespace plantloop
