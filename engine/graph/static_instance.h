// A block's counts, words and texts while its sizes are found and its parameters are checked.

#pragma once

#include <cassert>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/block_instance.h"
#include "engine/graph/graph.h"

namespace plantloop {

class StaticInstance : public BlockInstance {
 public:
  explicit StaticInstance(const Graph& graph) : graph_(graph) {}
  void stand_for(const GraphBlock& block) { block_ = &block; }

  std::string_view path() override { return block_->path; }
  int count(int index) override {
    const GraphParameter& p = parameter(block_->type->block->numbers.size() + block_->type->block->tables.size() +
                                        static_cast<std::size_t>(index));
    return p.value.all_known() && p.shape.is_known() ? static_cast<int>(p.value[0].number()) : 0;
  }
  std::string_view choice(int index) override {
    return graph_.texts[block_->first_text + static_cast<std::size_t>(index)];
  }
  std::string text(int index) override {
    return graph_.texts[block_->first_text + block_->type->block->choices.size() + static_cast<std::size_t>(index)];
  }
  bool given_number(int index) override { return parameter(static_cast<std::size_t>(index)).is_set; }
  bool given_table(int index) override {
    return parameter(block_->type->block->numbers.size() + static_cast<std::size_t>(index)).is_set;
  }
  bool connected(int input) override {
    return graph_.nets[block_->first_input + static_cast<std::uint32_t>(input)].is_connected;
  }

  // Nothing has a value yet.
  Array input(int) override { return not_yet(); }
  std::vector<Array> list(int) override { return {}; }
  Array number(int) override { return not_yet(); }
  Array table(int) override { return not_yet(); }
  Array state(int) override { return not_yet(); }
  Array discrete(int) override { return not_yet(); }
  std::vector<Activity> activity(int) override { return {}; }
  Value hit() override { return 0; }
  Value period() override { return 0; }
  Meeting meeting(int) override { return Meeting::never; }
  Array earlier(int, const Array&, bool) override { return not_yet(); }
  std::vector<Value> kernel(std::shared_ptr<const Kernel>, std::vector<Value>, std::vector<Value>) override {
    return {};
  }
  void write(Written, int, const Array&) override { not_yet(); }
  int event(const Crossing&) override { return 0; }
  void jump(int, bool, int, const Array&) override { not_yet(); }

 protected:
  const GraphParameter& parameter(std::size_t slot) const { return graph_.parameters[block_->first_parameter + slot]; }
  static Array not_yet() {
    assert(!"a block reads values while its sizes are found");
    return {};
  }

  const Graph& graph_;
  const GraphBlock* block_ = nullptr;
};

}  // namespace plantloop
