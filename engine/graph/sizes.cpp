// Sizes of all signals and states (S3): a worklist to a fixed point, then a pass that reports what does not fit.
//
// Every rule only ever turns "unknown" into a shape, and looks at nothing but shapes, so the answer does not depend on
// the order of visits. What is still unknown then stands in loops that no vector enters: these are scalars. They are
// decided loop by loop in the order of dependence, since a loop may feed a vector into the next one.

#include <algorithm>
#include <deque>
#include <utility>

#include "engine/graph/elaboration.h"
#include "engine/graph/static_instance.h"

namespace plantloop {

Readers find_readers(const Graph& graph) {
  const auto nets = static_cast<std::uint32_t>(graph.nets.size());
  Readers readers;
  readers.first.assign(nets + 1, 0);
  const auto for_each = [&](const auto& visit) {
    const auto references = [&](const BoundExpression& bound, std::uint32_t item) {
      if (!bound) return;
      for (std::size_t i = 0; i < bound.code->names.size(); ++i) {
        const Reference& r = graph.references[bound.first_reference + i];
        if (r.kind == Reference::Kind::net) visit(r.index, item);
      }
    };
    for (std::uint32_t i = 0; i < nets; ++i) {
      const GraphNet& net = graph.nets[i];
      references(net.driver, i);
      if (net.kind == GraphNet::Kind::block_input) visit(i, nets + net.owner);
    }
    for (const GraphParameter& p : graph.parameters) {
      if (p.reads_signals && !p.of_scope) references(p.expression, nets + p.owner);
    }
  };
  for_each([&](std::uint32_t net, std::uint32_t) { ++readers.first[net + 1]; });
  for (std::uint32_t i = 0; i < nets; ++i) readers.first[i + 1] += readers.first[i];
  readers.items.resize(readers.first[nets]);
  std::vector<std::uint32_t> at(readers.first.begin(), readers.first.end() - 1);
  for_each([&](std::uint32_t net, std::uint32_t item) { readers.items[at[net]++] = item; });
  return readers;
}

namespace {

bool fits(const Shape& shape, const Shape& wanted) {
  return shape == wanted || shape.is_scalar() || (shape.size() == 1 && wanted.size() == 1) ||
         (shape.rank == 1 && shape.size() == 1);
}

class SizeFinding final : public Sizing {
 public:
  explicit SizeFinding(Elaboration& e)
      : e_(e), g_(e.g), instance_(e.g), nets_(static_cast<std::uint32_t>(e.g.nets.size())) {}

  void run() {
    readers_ = find_readers(g_);
    queued_.assign(nets_ + g_.blocks.size(), 0);
    for (std::uint32_t i = 0; i < nets_; ++i) {
      if (g_.nets[i].driver) push(i);
    }
    for (std::uint32_t i = 0; i < g_.blocks.size(); ++i) {
      if (g_.blocks[i].type) push(nets_ + i);
    }
    work();
    spread_bad();
    settle_loops();
    verify();
  }

  // Sizing, for the block in hand.
  Shape of(const Input& port) const override {
    return input_shape(block_->first_input + static_cast<std::uint32_t>(port.index));
  }
  std::vector<Shape> of(const Inputs&) const override {
    std::vector<Shape> shapes;
    for (std::uint32_t i = 0; i < block_->inputs; ++i) shapes.push_back(input_shape(block_->first_input + i));
    return shapes;
  }
  Shape of(const Table& t) const override {
    return parameter_shape(block_->first_parameter + static_cast<std::uint32_t>(block_->type->block->numbers.size()) +
                           static_cast<std::uint32_t>(t.index));
  }
  Shape of(const Number& n) const override {
    return parameter_shape(block_->first_parameter + static_cast<std::uint32_t>(n.index));
  }
  Shape of(const Output& port) const override {
    return g_.nets[block_->first_output + static_cast<std::uint32_t>(port.index)].shape;
  }
  Shape of(const State& state) const override {
    return g_.state_shapes[block_->first_shape + static_cast<std::uint32_t>(state.index)];
  }
  std::vector<double> numbers(const Table& t) const override {
    const GraphParameter& p = g_.parameters[block_->first_parameter + block_->type->block->numbers.size() +
                                            static_cast<std::size_t>(t.index)];
    std::vector<double> numbers;
    if (!p.is_set || p.bad || p.reads_signals || !p.shape.is_known()) return numbers;
    for (const Value& v : p.value.values()) numbers.push_back(v.number());
    return numbers;
  }
  void set(const Output& port, Shape shape) override { set_output(static_cast<std::uint32_t>(port.index), shape); }
  void set(const State& state, Shape shape) override { set_state(static_cast<std::uint32_t>(state.index), shape); }
  void set(const Discrete& state, Shape shape) override {
    set_state(static_cast<std::uint32_t>(block_->type->block->states.size()) + static_cast<std::uint32_t>(state.index),
              shape);
  }
  void expect(const Input& port, Shape shape) override {
    if (!reporting_ || !shape.is_known()) return;
    expect_input(block_->first_input + static_cast<std::uint32_t>(port.index), port.name, shape);
  }
  void problem(const Declared& declared, const std::string& text) override {
    if (!reporting_) return;
    Mark mark = block_->declaration->mark;
    const Block& kind = *block_->type->block;
    for (std::size_t i = 0; i < kind.numbers.size() + kind.tables.size() + kind.counts.size(); ++i) {
      const GraphParameter& p = g_.parameters[block_->first_parameter + i];
      if (p.name == declared.name) mark = p.mark;
    }
    for (const FieldDecl& field : block_->declaration->fields) {
      if (field.name == declared.name) mark = field.mark;
    }
    for (const Input* input : kind.inputs) {
      if (input->name == declared.name)
        mark = g_.nets[block_->first_input + static_cast<std::uint32_t>(input->index)].mark;
    }
    e_.findings.error(mark, "{}: {}", title_of(g_, *block_), text).named("sizes");
  }

 private:
  void push(std::uint32_t item) {
    if (queued_[item]) return;
    queued_[item] = 1;
    queue_.push_back(item);
  }

  void work() {
    while (!queue_.empty()) {
      const std::uint32_t item = queue_.front();
      queue_.pop_front();
      queued_[item] = 0;
      if (item < nets_) {
        size_net(item);
      } else {
        size_block(item - nets_);
      }
    }
  }

  void set_net(std::uint32_t index, const Shape& shape) {
    GraphNet& net = g_.nets[index];
    if (!shape.is_known() || net.shape.is_known()) return;
    net.shape = shape;
    for (const std::uint32_t reader : readers_.of(index)) push(reader);
  }

  Shape net_shape(const GraphNet& net, Findings* findings) {
    if (net.by_parameter) return g_.parameters[net.parameter].shape;
    BoundNames names(g_, net.driver);
    return shape_of(*net.driver.code, names, findings);
  }

  void size_net(std::uint32_t index) {
    GraphNet& net = g_.nets[index];
    if (net.shape.is_known() || net.bad) return;
    Shape shape = net_shape(net, nullptr);
    if (const std::optional<int> declared = declared_size(net)) shape = Shape::vector(*declared);
    set_net(index, shape);
  }

  std::optional<int> declared_size(const GraphNet& net) const {
    if (net.kind != GraphNet::Kind::scope_input) return {};
    return g_.scopes[net.owner].type->inputs[net.port].size;
  }

  Shape input_shape(std::uint32_t index) const { return g_.nets[index].shape; }
  Shape parameter_shape(std::uint32_t index) const {
    const GraphParameter& p = g_.parameters[index];
    if (!p.is_set || p.bad) return Shape::unknown();
    if (!p.reads_signals) return p.shape;
    BoundNames names(g_, p.expression);
    return shape_of(*p.expression.code, names, nullptr);
  }

  // One thing that is declared elementwise, and where it was written.
  struct Part {
    std::string name;
    Shape shape;
    Mark mark;
    bool bad;
  };
  std::vector<Part> elementwise_parts(const GraphBlock& block) const {
    std::vector<Part> parts;
    const Block& kind = *block.type->block;
    for (std::size_t i = 0; i < kind.inputs.size(); ++i) {
      if (kind.inputs[i]->spec.size.kind != Size::Kind::elementwise) continue;
      const GraphNet& net = g_.nets[block.first_input + i];
      parts.push_back({std::string(kind.inputs[i]->name), net.shape, net.mark, net.bad});
    }
    if (!kind.lists.empty() && !block.reduces && kind.lists[0]->spec.size.kind == Size::Kind::elementwise) {
      for (std::uint32_t i = 0; i < block.inputs; ++i) {
        const GraphNet& net = g_.nets[block.first_input + i];
        parts.push_back({fmt::format("{}.{}", kind.lists[0]->name, i + 1), net.shape, net.mark, net.bad});
      }
    }
    for (std::size_t i = 0; i < kind.numbers.size(); ++i) {
      const GraphParameter& p = g_.parameters[block.first_parameter + i];
      if (!p.is_set || kind.numbers[i]->spec.size.kind != Size::Kind::elementwise) continue;
      parts.push_back({std::string(kind.numbers[i]->name),
                       parameter_shape(block.first_parameter + static_cast<std::uint32_t>(i)), p.mark, p.bad});
    }
    return parts;
  }

  Shape common_shape(const GraphBlock& block) const {
    bool unknown = false;
    const Block& kind = *block.type->block;
    Shape found = Shape::scalar();
    const auto meet = [&](const Shape& shape) {
      if (!shape.is_known()) {
        unknown = true;
      } else if (found.size() == 1 && shape.size() != 1) {
        found = shape;
      }
    };
    for (std::size_t i = 0; i < kind.inputs.size(); ++i) {
      if (kind.inputs[i]->spec.size.kind == Size::Kind::elementwise) meet(g_.nets[block.first_input + i].shape);
    }
    if (!kind.lists.empty() && !block.reduces && kind.lists[0]->spec.size.kind == Size::Kind::elementwise) {
      for (std::uint32_t i = 0; i < block.inputs; ++i) meet(g_.nets[block.first_input + i].shape);
    }
    for (std::size_t i = 0; i < kind.numbers.size(); ++i) {
      const auto index = block.first_parameter + static_cast<std::uint32_t>(i);
      if (!g_.parameters[index].is_set || kind.numbers[i]->spec.size.kind != Size::Kind::elementwise) continue;
      meet(g_.parameters[index].reads_signals ? parameter_shape(index) : g_.parameters[index].shape);
    }
    return found.size() == 1 && unknown ? Shape::unknown() : found;
  }

  Shape declared_shape(const Size& size) {
    switch (size.kind) {
      case Size::Kind::elementwise:
        return block_->common;
      case Size::Kind::scalar:
        return Shape::scalar();
      case Size::Kind::fixed:
        return Shape::vector(size.fixed);
      case Size::Kind::count:
        return Shape::vector(size.count->value());
      case Size::Kind::any:
        break;
    }
    return Shape::unknown();
  }

  void size_block(std::uint32_t index) {
    GraphBlock& block = g_.blocks[index];
    if (block.bad) return;
    block_ = &block;
    instance_.stand_for(block);
    if (!block.common.is_known()) block.common = common_shape(block);
    const Block& kind = *block.type->block;
    for (std::uint32_t i = 0; i < kind.outputs_declared.size(); ++i) {
      set_net(block.first_output + i, declared_shape(kind.outputs_declared[i]->spec.size));
    }
    std::uint32_t at = block.first_shape;
    const auto state = [&](const Size& size) {
      Shape& shape = g_.state_shapes[at++];
      if (!shape.is_known()) shape = declared_shape(size);
    };
    for (const State* s : kind.states) state(s->spec.size);
    for (const Discrete* s : kind.discretes) state(s->spec.size);
    kind.sizes(*this);
  }

  void set_output(std::uint32_t port, const Shape& shape) {
    const std::uint32_t index = block_->first_output + port;
    if (!shape.is_known()) return;
    const GraphNet& net = g_.nets[index];
    if (net.shape.is_known() && net.shape != shape && reporting_) {
      e_.findings.error(block_->declaration->mark, "the output '{}' of {} would be {} and {}",
                        block_->type->block->outputs_declared[port]->name, title_of(g_, *block_), to_string(net.shape),
                        to_string(shape));
    }
    set_net(index, shape);
  }
  void set_state(std::uint32_t number, const Shape& shape) {
    Shape& held = g_.state_shapes[block_->first_shape + number];
    if (!held.is_known()) held = shape;
  }

  // What depends on something that has been reported is left alone.
  void spread_bad() {
    const auto spoil = [this](std::uint32_t index) {
      if (g_.nets[index].bad || g_.nets[index].shape.is_known()) return;
      g_.nets[index].bad = true;
      queue_.push_back(index);
    };
    for (std::uint32_t i = 0; i < nets_; ++i) {
      const GraphNet& net = g_.nets[i];
      if (net.bad || (net.by_parameter && g_.parameters[net.parameter].bad)) queue_.push_back(i);
    }
    const auto spoil_outputs = [&](GraphBlock& block) {
      for (std::uint32_t i = 0; i < block.outputs; ++i) spoil(block.first_output + i);
    };
    for (GraphBlock& block : g_.blocks) {
      if (block.bad) spoil_outputs(block);
    }
    while (!queue_.empty()) {
      const std::uint32_t index = queue_.front();
      queue_.pop_front();
      g_.nets[index].bad = true;
      for (const std::uint32_t reader : readers_.of(index)) {
        if (reader < nets_) {
          spoil(reader);
        } else {
          spoil_outputs(g_.blocks[reader - nets_]);
        }
      }
    }
  }

  // ---- loops without a vector

  bool is_open(std::uint32_t item) const {
    if (item < nets_) return !g_.nets[item].shape.is_known() && !g_.nets[item].bad;
    const GraphBlock& block = g_.blocks[item - nets_];
    if (!block.type || block.bad) return false;
    if (!block.common.is_known()) return true;
    for (std::uint32_t i = 0; i < block.outputs; ++i) {
      if (!g_.nets[block.first_output + i].shape.is_known()) return true;
    }
    return false;
  }

  // Who waits for an item: the readers of a net, the outputs of a block.
  std::uint32_t successor_count(std::uint32_t item) const {
    return item < nets_ ? static_cast<std::uint32_t>(readers_.of(item).size()) : g_.blocks[item - nets_].outputs;
  }
  std::uint32_t successor(std::uint32_t item, std::uint32_t i) const {
    return item < nets_ ? readers_.of(item)[i] : g_.blocks[item - nets_].first_output + i;
  }

  void settle_loops() {
    for (const std::vector<std::uint32_t>& loop : loops()) {
      bool open = false;
      for (const std::uint32_t item : loop) {
        if (!is_open(item)) continue;
        open = true;
        if (item >= nets_ && !g_.blocks[item - nets_].common.is_known() && is_undecided(g_.blocks[item - nets_])) {
          g_.blocks[item - nets_].common = Shape::scalar();
          push(item);
        }
      }
      work();
      if (!open) continue;
      // A loop of expressions only.
      for (const std::uint32_t item : loop) {
        if (item < nets_ && is_open(item) && g_.nets[item].driver) {
          set_net(item, Shape::scalar());
          work();
        }
      }
    }
  }

  // Whether nothing but unknown or bad things keeps the class of a block open: then it is a scalar, or its cause has
  // been reported.
  bool is_undecided(const GraphBlock& block) const {
    for (std::uint32_t i = 0; i < block.inputs; ++i) {
      if (g_.nets[block.first_input + i].bad) return false;
    }
    return true;
  }

  // Tarjan's components of the open items, those first that others depend on.
  std::vector<std::vector<std::uint32_t>> loops() const {
    const auto count = static_cast<std::uint32_t>(nets_ + g_.blocks.size());
    std::vector<std::uint32_t> number(count, 0), low(count, 0), stack;
    std::vector<std::uint8_t> on_stack(count, 0);
    struct Open {
      std::uint32_t item;
      std::uint32_t next = 0;
    };
    std::vector<Open> open;
    std::vector<std::vector<std::uint32_t>> found;
    std::uint32_t numbered = 0;
    const auto enter = [&](std::uint32_t item) {
      number[item] = low[item] = ++numbered;
      stack.push_back(item);
      on_stack[item] = 1;
      open.push_back({item});
    };
    for (std::uint32_t start = 0; start < count; ++start) {
      if (number[start] != 0 || !is_open(start)) continue;
      enter(start);
      while (!open.empty()) {
        const std::uint32_t item = open.back().item;
        if (open.back().next < successor_count(item)) {
          const std::uint32_t next = successor(item, open.back().next++);
          if (number[next] == 0) {
            if (is_open(next)) enter(next);
          } else if (on_stack[next]) {
            low[item] = std::min(low[item], number[next]);
          }
          continue;
        }
        open.pop_back();
        if (!open.empty()) low[open.back().item] = std::min(low[open.back().item], low[item]);
        if (low[item] != number[item]) continue;
        std::vector<std::uint32_t>& loop = found.emplace_back();
        for (bool last = false; !last;) {
          last = stack.back() == item;
          on_stack[stack.back()] = 0;
          loop.push_back(stack.back());
          stack.pop_back();
        }
      }
    }
    std::reverse(found.begin(), found.end());
    return found;
  }

  // ---- what does not fit

  void verify() {
    reporting_ = true;
    for (std::uint32_t i = 0; i < nets_; ++i) verify_net(i);
    for (GraphParameter& p : g_.parameters) {
      if (!p.reads_signals || p.bad) continue;
      check_elements(p.expression);
      BoundNames names(g_, p.expression);
      p.shape = shape_of(*p.expression.code, names, &e_.findings);
    }
    for (GraphBlock& block : g_.blocks) {
      if (block.type && !block.bad) verify_block(block);
    }
    const auto condition = [this](const BoundExpression& bound) {
      if (!bound || !check_elements(bound)) return;
      BoundNames names(g_, bound);
      shape_of(*bound.code, names, &e_.findings);
    };
    for (const GraphBlock& block : g_.blocks) condition(block.reset_when), condition(block.reset_to);
    for (const GraphScope& scope : g_.scopes) condition(scope.reset_when), condition(scope.reset_to);
    for (const GraphActivation& activation : g_.activations) {
      condition(activation.enable_when), condition(activation.trigger_when);
      for (const BoundExpression& initial : activation.initials) condition(initial);
    }
  }

  bool check_elements(const BoundExpression& bound) {
    bool sound = true;
    for (std::size_t i = 0; i < bound.code->names.size(); ++i) {
      const Reference& r = g_.references[bound.first_reference + i];
      if (r.kind == Reference::Kind::missing) sound = false;
      if (r.whole) continue;
      const Shape shape = r.kind == Reference::Kind::net         ? g_.nets[r.index].shape
                          : r.kind == Reference::Kind::parameter ? g_.parameters[r.index].shape
                                                                 : Shape::unknown();
      if (shape.is_known()) sound &= element_exists(e_.findings, *bound.code->names[i], r, shape);
    }
    return sound;
  }

  void verify_net(std::uint32_t index) {
    GraphNet& net = g_.nets[index];
    if (net.bad || !net.driver) return;
    if (net.by_parameter) {
      if (g_.parameters[net.parameter].bad) net.bad = true;
    } else if (!check_elements(net.driver)) {
      net.bad = true;
      return;
    }
    const Shape shape = net_shape(net, &e_.findings);
    if (!shape.is_known()) {
      net.bad = true;
      return;
    }
    if (!fits(shape, net.shape)) {
      e_.findings
          .error(net.driver.mark, "'{}' is {} and must be {}", path_of(g_, net), to_string(shape), to_string(net.shape))
          .named("sizes");
      net.bad = true;
    }
  }

  void expect_input(std::uint32_t index, std::string_view name, const Shape& wanted) {
    const GraphNet& net = g_.nets[index];
    if (net.bad || !net.shape.is_known() || fits(net.shape, wanted)) return;
    e_.findings
        .error(net.mark, "the input '{}' of {} must be {}, got {}", name, title_of(g_, *block_), to_string(wanted),
               to_string(net.shape))
        .named("sizes");
  }

  void verify_block(GraphBlock& block) {
    block_ = &block;
    instance_.stand_for(block);
    const Block& kind = *block.type->block;
    for (std::size_t i = 0; i < kind.inputs.size(); ++i) {
      const Size& size = kind.inputs[i]->spec.size;
      if (size.kind == Size::Kind::elementwise || size.kind == Size::Kind::any) continue;
      const std::uint32_t index = block.first_input + static_cast<std::uint32_t>(i);
      const Shape wanted = declared_shape(size);
      expect_input(index, kind.inputs[i]->name, wanted);
    }
    for (std::size_t i = 0; i < kind.numbers.size(); ++i) {
      const Size& size = kind.numbers[i]->spec.size;
      const GraphParameter& p = g_.parameters[block.first_parameter + i];
      if (!p.is_set || p.bad || size.kind == Size::Kind::elementwise || size.kind == Size::Kind::any) continue;
      const Shape wanted = declared_shape(size);
      if (!p.shape.is_known() || fits(p.shape, wanted)) continue;
      e_.findings
          .error(p.mark, "'{}' of {} must be {}, got {}", p.name, title_of(g_, block), to_string(wanted),
                 to_string(p.shape))
          .named("sizes");
    }
    verify_common(block);
    kind.sizes(*this);
    if (block.bad) return;
    for (std::uint32_t i = 0; i < block.outputs; ++i) {
      const GraphNet& net = g_.nets[block.first_output + i];
      if (!net.shape.is_known() && !has_bad_input(block) && !e_.findings.failed()) {
        e_.findings.error(block.declaration->mark, "the size of '{}' cannot be found", path_of(g_, net)).named("sizes");
      }
    }
  }

  bool has_bad_input(const GraphBlock& block) const {
    for (std::uint32_t i = 0; i < block.inputs; ++i) {
      if (g_.nets[block.first_input + i].bad || !g_.nets[block.first_input + i].shape.is_known()) return true;
    }
    return false;
  }

  void verify_common(GraphBlock& block) {
    if (!block.common.is_known() || !needs_verifying(block)) return;
    const Part* first = nullptr;
    const std::vector<Part> parts = elementwise_parts(block);
    for (const Part& part : parts) {
      if (part.bad || !part.shape.is_known() || part.shape.size() == 1) continue;
      if (part.shape == block.common) {
        if (!first) first = &part;
        continue;
      }
      if (first) {
        e_.findings
            .error(part.mark, "{}: '{}' is {}, but '{}' is {}", title_of(g_, block), part.name, to_string(part.shape),
                   first->name, to_string(first->shape))
            .also(first->mark, fmt::format("'{}'", first->name))
            .hint("both need one size, or one of them is a scalar")
            .named("sizes");
      } else {
        e_.findings
            .error(part.mark, "{}: '{}' is {}, but the block works on {}", title_of(g_, block), part.name,
                   to_string(part.shape), to_string(block.common))
            .hint("a loop through this block would need another size on every turn")
            .named("sizes");
      }
      return;
    }
  }

  // Spares the common case, in which all are scalars, its list of parts.
  bool needs_verifying(const GraphBlock& block) const {
    for (std::uint32_t i = 0; i < block.inputs; ++i) {
      if (g_.nets[block.first_input + i].shape.size() != 1) return true;
    }
    const Block& kind = *block.type->block;
    for (std::size_t i = 0; i < kind.numbers.size(); ++i) {
      if (g_.parameters[block.first_parameter + i].is_set && g_.parameters[block.first_parameter + i].shape.size() != 1)
        return true;
    }
    return false;
  }

  Elaboration& e_;
  Graph& g_;
  StaticInstance instance_;
  std::uint32_t nets_;
  Readers readers_;
  std::vector<std::uint8_t> queued_;
  std::deque<std::uint32_t> queue_;
  GraphBlock* block_ = nullptr;
  bool reporting_ = false;
};

}  // namespace

void find_sizes(Elaboration& e) { SizeFinding(e).run(); }

}  // namespace plantloop
