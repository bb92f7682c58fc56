// From operations to lists that run: fuse, level, group, give slots, cut into runs, schedule the narrow parts.

#pragma once

#include <cstdint>
#include <functional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/program/execute.h"
#include "engine/program/operation_graph.h"

namespace plantloop {

inline constexpr std::uint32_t no_slot = 0xffffffff;

// Gives out the slots of one arena and lowers lists onto them. What a list reads but does not compute (leaves and
// operations of other lists) gets its slot when the first list asks for it, in the order in which that list reads it:
// so the list that runs most is lowered first and finds its operands side by side.
class Lowering {
 public:
  // `gates` are the operations behind the activations, by number.
  Lowering(const OperationGraph& graph, const std::vector<std::uint32_t>& gates)
      : graph_(graph), gates_(gates), slots_(graph.operations.size(), no_slot) {}

  struct Request {
    std::vector<std::uint32_t> roots;  // operations; their slots become List::roots
    std::uint32_t pinned = no_slot;  // the roots stand side by side from here, copied where they are not computed there
    bool parameter_only_is_external = true;  // false: this list computes them
    bool held_is_external = true;
    bool by_mask = false;  // parts run by mask, and results stand in their shared slots
    bool fuse = true;
    // Operations that stand in slots of their own when this list begins: what the inside of a loop is given.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> given;
  };
  List lower(const Request& request);

  std::uint32_t allocate(std::uint32_t count, std::uint32_t alignment = 1);
  // The shared slot of an operation, given out now if it had none.
  std::uint32_t slot(std::uint32_t operation);
  std::uint32_t gate(std::uint16_t activation) const { return gates_[activation]; }
  bool has_slot(std::uint32_t operation) const { return slots_[operation] != no_slot; }
  void set_slot(std::uint32_t operation, std::uint32_t slot) { slots_[operation] = slot; }
  // Where an operation will stand once somebody asks for its slot: the unknowns of a loop stand side by side.
  void set_home(std::uint32_t operation, std::uint32_t slot) { homes_[operation] = slot; }
  std::uint32_t home(std::uint32_t operation) const { return homes_.at(operation); }
  // The slots to which a list copies what it computes for a loop.
  void set_loop_inputs(std::uint32_t loop, std::uint32_t first) { loop_inputs_[loop] = first; }
  std::uint32_t loop_inputs(std::uint32_t loop) const { return loop_inputs_.at(loop); }
  void grow() { slots_.resize(graph_.operations.size(), no_slot); }  // after operations were added to the graph
  std::uint32_t size() const { return next_; }

 private:
  const OperationGraph& graph_;
  const std::vector<std::uint32_t>& gates_;
  std::vector<std::uint32_t> slots_;  // shared ones
  std::unordered_map<std::uint32_t, std::uint32_t> homes_, loop_inputs_;
  std::uint32_t next_ = 0;
};

}  // namespace plantloop
