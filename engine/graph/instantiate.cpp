// Declarations -> scopes, blocks, nets and parameters.
//
// Scopes are opened in the order of a queue, so that nothing recurses, and the children of a scope stand next to each
// other.

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "engine/base/files.h"
#include "engine/graph/elaboration.h"
#include "engine/graph/familiar.h"

namespace plantloop {
namespace {

constexpr std::uint32_t deepest = 100;
constexpr std::size_t most_instances = 2000000;

std::string join_path(const std::string& scope, const std::string& name) {
  return scope.empty() ? name : scope + "." + name;
}

bool all_digits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// An input as `in:` sees it, of a block type or of a subsystem type.
struct Port {
  std::string_view name;
  bool has_default = false;
};

class Instantiation {
 public:
  explicit Instantiation(Elaboration& elaboration) : e_(elaboration), g_(elaboration.g) {}

  void run() {
    open_diagram(*e_.model.top);
    // Grows while it is walked.
    for (std::uint32_t s = 0; s < g_.scopes.size(); ++s) fill(s);
  }

  void run_alone(const TypeDecl& diagram, std::span<const TypeDecl* const> types) {
    open_diagram(diagram);
    for (const TypeDecl* type : types) {
      BlockDecl& decl = e_.made_up.emplace_back();
      decl.name = decl.type = type->name;
      decl.mark = decl.type_mark = type->mark;
      add_scope(0, decl, *type);
    }
    for (std::uint32_t s = 1; s < g_.scopes.size(); ++s) fill(s);
  }

 private:
  void open_diagram(const TypeDecl& diagram) {
    GraphScope& top = g_.scopes.emplace_back();
    top.type = &diagram;
    e_.scope_overrides.push_back(e_.overrides.children.empty() ? nullptr : &e_.overrides);
    check_type(*top.type);
    top.first_parameter = static_cast<std::uint32_t>(g_.parameters.size());
    for (const ParameterDecl& p : top.type->parameters) add_scope_parameter(0, p, nullptr, 0, p.mark);
    top.first_input = top.first_output = static_cast<std::uint32_t>(g_.nets.size());
  }

  // The blocks of a scope.
  void fill(std::uint32_t s) {
    const TypeDecl& type = *g_.scopes[s].type;
    if (s == 0) {
      g_.blocks.reserve(type.blocks.size());
      g_.nets.reserve(type.blocks.size() * 3);
      g_.parameters.reserve(type.parameters.size() + type.blocks.size() * 3);
    }
    const auto first = static_cast<std::uint32_t>(g_.children.size());
    g_.scopes[s].first_child = first;
    g_.children.resize(first + type.blocks.size());
    for (std::size_t i = 0; i < type.blocks.size(); ++i) {
      const GraphChild child = add_child(s, type.blocks[i]);
      g_.children[first + i] = child;
    }
  }

  GraphChild add_child(std::uint32_t s, const BlockDecl& decl) {
    if (decl.bad) return {};  // reading the file has reported it
    if (decl.type == "bus" && !own_type(s, decl)) return add_bus(s, decl);
    if (decl.repeat) return add_repeat(s, decl);
    report_ends(decl);
    return add_instance(s, decl);
  }

  GraphChild add_instance(std::uint32_t s, const BlockDecl& decl) {
    if (g_.scopes.size() + g_.blocks.size() > most_instances) {
      if (!too_many_) e_.findings.error(decl.mark, "this diagram has more than {} blocks", most_instances);
      too_many_ = true;
      return {};
    }
    if (decl.bad) return {};  // reading the file has reported it
    if (decl.expression) return add_expression(s, decl);
    if (decl.type.empty() || decl.type == "expression") return {};  // reading the file has reported it
    if (const TypeDecl* own = own_type(s, decl)) {
      if (own->bad) return {};  // reported too
      return add_scope(s, decl, *own);
    }
    if (decl.type == "state_machine" && !is_machine_core(decl)) {
      const Elaboration::MadeMachine* made = make_state_machine(e_, decl, s);
      return made ? add_scope(s, made->instance, *made->type) : GraphChild{};
    }
    if (const BlockType* built_in = find_block(decl.type)) return add_block(s, decl, *built_in);
    report_unknown_type(s, decl);
    return {};
  }

  const TypeDecl* own_type(std::uint32_t s, const BlockDecl& decl) const {
    const FileScope* file = g_.scopes[s].type->file;
    if (!file) return nullptr;
    const auto found = file->types.find(decl.type);
    return found != file->types.end() ? found->second.get() : nullptr;
  }

  // What a block or subsystem runs under: the activation of its own keys, or that of what is around it.
  std::uint32_t activation_of(std::uint32_t s, const BlockDecl& decl, GraphChild owner, const std::string& path) {
    if (!decl.enable && !decl.trigger) return g_.scopes[s].activation;
    GraphActivation made;
    made.path = path;
    made.declaration = &decl;
    made.parent = g_.scopes[s].activation;
    made.scope = s;
    made.owner = owner;
    if (decl.enable) made.enable_when = bind(decl.enable->when, s);
    if (decl.trigger) made.trigger_when = bind(decl.trigger->when, s);
    g_.activations.push_back(std::move(made));
    return static_cast<std::uint32_t>(g_.activations.size() - 1);
  }

  // What the outputs of a block show before its first activation: one value for all of them.
  void bind_initials(std::uint32_t s, const BlockDecl& decl, const GraphBlock& block) {
    if (!decl.enable && !decl.trigger) return;
    const ExpressionPtr& tree = decl.enable && decl.enable->initial ? decl.enable->initial
                                : decl.trigger                      ? decl.trigger->initial
                                                                    : decl.enable->initial;
    for (std::uint32_t i = 0; i < block.outputs; ++i)
      g_.activations[block.activation].initials.push_back(bind(tree, s));
  }

  // ---- copies and groups

  void report_ends(const BlockDecl& decl) {
    for (const auto* end : {&decl.first, &decl.last}) {
      if (!*end) continue;
      e_.findings
          .error((*end)->mark, "'{}' is for a block that is repeated: '{}' has no `repeat`",
                 end == &decl.first ? "first" : "last", decl.name)
          .named("repeat");
    }
  }

  GraphChild add_repeat(std::uint32_t s, const BlockDecl& decl) {
    const std::optional<std::uint32_t> count = count_copies(e_, decl, s);
    if (!count) return {};
    const auto index = static_cast<std::uint32_t>(g_.repeats.size());
    const auto first = static_cast<std::uint32_t>(g_.copies.size());
    g_.repeats.push_back({join_path(g_.scopes[s].path, decl.name), &decl, s, first, *count, nowhere});
    g_.copies.resize(first + *count);
    repeat_ = index;
    for (copy_ = 1; copy_ <= *count; ++copy_) {
      const GraphChild child = add_instance(s, decl);
      g_.copies[first + copy_ - 1] = child;
      if (child.kind == GraphChild::Kind::bad) break;
    }
    repeat_ = nowhere;
    copy_ = 0;
    if (g_.copies.back().kind == GraphChild::Kind::bad) return {};
    if (has_output(g_.copies.back())) add_copies_net(s, decl, index, *count);
    return {GraphChild::Kind::repeat, index};
  }

  bool has_output(const GraphChild& child) const {
    return child.kind == GraphChild::Kind::scope ? !g_.scopes[child.index].type->outputs.empty()
                                                 : g_.blocks[child.index].outputs > 0;
  }

  // `cell` alone: the vector of the copies' main outputs.
  void add_copies_net(std::uint32_t s, const BlockDecl& decl, std::uint32_t repeat, std::uint32_t count) {
    auto all = std::make_shared<Expression>();
    all->kind = Expression::Kind::vector;
    all->mark = decl.mark;
    for (std::uint32_t i = 1; i <= count; ++i) {
      auto one = std::make_shared<Expression>();
      one->kind = Expression::Kind::name;
      one->mark = decl.mark;
      one->parts = {decl.name, std::to_string(i)};
      all->arguments.push_back(std::move(one));
    }
    g_.repeats[repeat].net = static_cast<std::uint32_t>(g_.nets.size());
    GraphNet& net = g_.nets.emplace_back();
    net.kind = GraphNet::Kind::copies;
    net.owner = repeat;
    net.driver = e_.bind(all, s);
    net.mark = decl.mark;
  }

  GraphChild add_bus(std::uint32_t s, const BlockDecl& decl) {
    bool sound = true;
    const auto refuse = [&](const Mark& mark, std::string_view key) {
      e_.findings.error(mark, "'{}' is a bus, which only groups signals: it has no '{}'", decl.name, key).named("bus");
    };
    for (const FieldDecl& field : decl.fields) refuse(field.mark, field.name);
    if (decl.period) refuse(decl.rate_mark, "rate");
    if (decl.reset) refuse(decl.reset->mark, "reset");
    if (decl.enable) refuse(decl.enable->mark, "enable");
    if (decl.trigger) refuse(decl.trigger->mark, "trigger");
    if (decl.repeat) refuse(decl.repeat_mark, "repeat");
    report_ends(decl);
    for (const WireDecl& wire : decl.in) sound = sound && !wire.port.empty();
    if (!sound || decl.in.empty()) {
      e_.findings
          .error(decl.in.empty() ? decl.mark : decl.in[0].mark, "the signals of the bus '{}' need names", decl.name)
          .hint("write in: {ax: ..., ay: ...}")
          .named("bus");
      return {};
    }
    const auto index = static_cast<std::uint32_t>(g_.buses.size());
    g_.buses.push_back({join_path(g_.scopes[s].path, decl.name), &decl, s, static_cast<std::uint32_t>(g_.nets.size())});
    for (std::uint32_t i = 0; i < decl.in.size(); ++i) {
      GraphNet& net = g_.nets.emplace_back();
      net.kind = GraphNet::Kind::member;
      net.owner = index;
      net.port = i;
      net.driver = bind(tree_of(decl.in[i]), s);
      net.mark = decl.in[i].mark;
      net.bad = !net.driver;
    }
    return {GraphChild::Kind::bus, index};
  }

  void report_unknown_type(std::uint32_t s, const BlockDecl& decl) {
    if (asks_for_derivative(decl.type)) {
      e_.findings.error(decl.type_mark, "there is no pure derivative: it would amplify noise and steps without bound")
          .hint("use filtered_derivative, which has a pole at N, or velocity_pi for a controller in velocity form")
          .hint("the derivative of a state is the integrator's input: give that a name of its own")
          .named("no-derivative");
      return;
    }
    if (const FileScope* file = g_.scopes[s].type->file; file && file->incomplete) return;
    Finding& finding =
        e_.findings.error(decl.type_mark, "there is no block type '{}'", decl.type).named("unknown-type");
    std::vector<std::string> names;
    for (const BlockType& type : catalogue()) names.emplace_back(type.name);
    names.emplace_back("bus");
    std::vector<std::string> own;
    if (const FileScope* file = g_.scopes[s].type->file) {
      for (const auto& [name, type] : file->types) own.push_back(name);
    }
    names.insert(names.end(), own.begin(), own.end());
    const std::string_view familiar = nearest(decl.type, own).empty() ? familiar_type(decl.type) : std::string_view();
    const std::string near = familiar.empty() ? nearest(decl.type, names) : std::string();
    if (!familiar.empty()) finding.hint(fmt::format("here it is {}", familiar));
    if (!near.empty()) finding.hint(fmt::format("did you mean '{}'?", near));
    if (!own.empty()) finding.hint("types of this file and its imports: " + list_of(own));
    finding.hint("`plantloop blocks` lists the block types");
  }

  GraphChild add_expression(std::uint32_t s, const BlockDecl& decl) {
    GraphBlock block;
    block.path = join_path(g_.scopes[s].path, name_of(decl));
    block.declaration = &decl;
    block.scope = s;
    block.first_output = static_cast<std::uint32_t>(g_.nets.size());
    block.outputs = 1;
    block.first_input = block.first_output;
    if (decl.reset) {
      e_.findings.error(decl.reset->mark, "'{}' is an expression: it has no state that could be reset", decl.name);
    }
    GraphNet& net = g_.nets.emplace_back();
    net.kind = GraphNet::Kind::expression;
    net.owner = static_cast<std::uint32_t>(g_.blocks.size());
    net.driver = bind(expression_of(decl), s);
    net.mark = decl.mark;
    net.unit = decl.unit;
    block.activation = activation_of(s, decl, {GraphChild::Kind::block, net.owner}, block.path);
    bind_initials(s, decl, block);
    g_.blocks.push_back(std::move(block));
    return {GraphChild::Kind::block, static_cast<std::uint32_t>(g_.blocks.size() - 1)};
  }

  // ---- subsystems

  GraphChild add_scope(std::uint32_t s, const BlockDecl& decl, const TypeDecl& type) {
    if (is_inside_itself(s, decl, type)) return {};
    check_type(type);
    const auto index = static_cast<std::uint32_t>(g_.scopes.size());
    GraphScope& made = g_.scopes.emplace_back();
    made.path = join_path(g_.scopes[s].path, name_of(decl));
    made.type = &type;
    made.declaration = &decl;
    made.parent = s;
    made.depth = g_.scopes[s].depth + 1;
    made.plain = g_.scopes[s].plain || !decl.zero_crossing;
    made.activation = activation_of(s, decl, {GraphChild::Kind::scope, index}, made.path);
    bind_reset(s, decl, made.reset_when, made.reset_to);
    OverrideNode* below = overrides_of(s, decl);
    e_.scope_overrides.push_back(below);

    const TypeTable& table = e_.table_of(type);
    std::vector<const FieldDecl*> parameter_fields(type.parameters.size());
    std::vector<const FieldDecl*> input_fields(type.inputs.size());
    for (const FieldDecl& field : decl.fields) {
      const auto found = table.names.find(field.name);
      if (found != table.names.end() && found->second.kind == TypeName::Kind::parameter) {
        parameter_fields[found->second.index] = &field;
      } else if (found != table.names.end() && found->second.kind == TypeName::Kind::input) {
        input_fields[found->second.index] = &field;
      } else {
        std::vector<std::string> names;
        for (const ParameterDecl& p : type.parameters) names.push_back(p.name);
        for (const InputDecl& p : type.inputs) {
          if (p.fallback) names.push_back(p.name);
        }
        report_unknown_field(decl, field, type.name, names);
      }
    }

    g_.scopes[index].first_parameter = static_cast<std::uint32_t>(g_.parameters.size());
    for (std::size_t i = 0; i < type.parameters.size(); ++i) {
      add_scope_parameter(index, type.parameters[i], parameter_fields[i], s, decl.mark);
    }

    std::vector<Port> ports;
    for (const InputDecl& input : type.inputs) ports.push_back({input.name, input.fallback != nullptr});
    const std::vector<const WireDecl*>& wires = match_wires(decl, type.name, ports, input_fields);
    g_.scopes[index].first_input = static_cast<std::uint32_t>(g_.nets.size());
    for (std::size_t i = 0; i < type.inputs.size(); ++i) {
      const InputDecl& input = type.inputs[i];
      GraphNet& net = g_.nets.emplace_back();
      net.kind = GraphNet::Kind::scope_input;
      net.owner = index;
      net.port = static_cast<std::uint32_t>(i);
      net.unit = input.unit;
      net.mark = decl.mark;
      drive(net, s, wires[i], input_fields[i], input.fallback, index, below, input.name);
    }
    g_.scopes[index].first_output = static_cast<std::uint32_t>(g_.nets.size());
    for (std::size_t i = 0; i < type.outputs.size(); ++i) {
      GraphNet& net = g_.nets.emplace_back();
      net.kind = GraphNet::Kind::scope_output;
      net.owner = index;
      net.port = static_cast<std::uint32_t>(i);
      net.mark = type.outputs[i].mark;
      net.driver = e_.bind(type.outputs[i].from, index);
      if (decl.enable || decl.trigger)
        g_.activations[g_.scopes[index].activation].initials.push_back(e_.bind(type.outputs[i].initial, index));
      net.bad = !net.driver;
    }
    return {GraphChild::Kind::scope, index};
  }

  bool is_inside_itself(std::uint32_t s, const BlockDecl& decl, const TypeDecl& type) {
    for (std::uint32_t up = s; up != nowhere; up = g_.scopes[up].parent) {
      if (g_.scopes[up].type == &type) return true;  // reading the file has reported it
    }
    if (g_.scopes[s].depth >= deepest) {
      e_.findings.error(decl.mark, "subsystems are nested more than {} levels deep", deepest);
      return true;
    }
    return false;
  }

  void add_scope_parameter(std::uint32_t owner, const ParameterDecl& decl, const FieldDecl* field,
                           std::uint32_t outside, const Mark& instance) {
    const auto index = static_cast<std::uint32_t>(g_.parameters.size());
    GraphParameter& p = g_.parameters.emplace_back();
    p.name = decl.name;
    p.owner = owner;
    p.of_scope = true;
    p.unit = decl.unit;
    p.is_default = field == nullptr;
    p.mark = field ? field->mark : decl.mark;
    if (decl.bad) {  // reading the file has reported it
      p.bad = true;
      return;
    }
    OverrideNode* above = e_.scope_overrides[owner];
    OverrideNode* given = above ? above->find(decl.name) : nullptr;
    if (decl.text) {
      p.text = static_cast<std::uint32_t>(g_.texts.size());
      g_.texts.emplace_back();
      std::string text;
      if (given && given->given) {
        given->used = true;
        text = given->given->text;
      } else if (field && !field->value.is_scalar()) {
        e_.findings.error(field->value.mark, "'{}' of '{}' is a text", decl.name, g_.scopes[owner].path);
        g_.parameters[index].bad = true;
      } else if (field) {
        text = expand_text(e_, field->value.text, outside, field->value.mark);
      } else {
        text = expand_text(e_, *decl.text, owner, decl.mark);
      }
      g_.texts[g_.parameters[index].text] = std::move(text);
      return;
    }
    if (!field && !decl.value && !(given && given->given)) {
      p.bad = true;
      const GraphScope& scope = g_.scopes[owner];
      e_.findings.error(instance, "'{}' ({}) needs a value for '{}'", scope.path, scope.type->name, decl.name)
          .also(decl.mark, "the type has no default for it")
          .hint(fmt::format("write {}: ... beside type:", decl.name))
          .named("missing-parameter");
      return;
    }
    // A value given at the instance sees the scope around it, a default sees its own type.
    const ExpressionPtr tree = field ? e_.parse(field->value) : decl.value;
    set_expression(index, tree, field || owner == 0 ? (owner == 0 ? 0 : outside) : owner, given);
  }

  // ---- blocks

  GraphChild add_block(std::uint32_t s, const BlockDecl& decl, const BlockType& type) {
    const Block& kind = *type.block;
    const BlockTable& table = e_.table_of(type);
    const auto index = static_cast<std::uint32_t>(g_.blocks.size());
    {
      GraphBlock& block = g_.blocks.emplace_back();
      block.path = is_machine_core(decl) ? g_.scopes[s].path : join_path(g_.scopes[s].path, name_of(decl));
      block.declaration = &decl;
      block.type = &type;
      block.scope = s;
      block.first_parameter = static_cast<std::uint32_t>(g_.parameters.size());
      block.first_text = static_cast<std::uint32_t>(g_.texts.size());
      block.first_shape = static_cast<std::uint32_t>(g_.state_shapes.size());
      g_.state_shapes.resize(g_.state_shapes.size() + kind.states.size() + kind.discretes.size(), Shape::unknown());
      bind_reset(s, decl, block.reset_when, block.reset_to);
      block.activation = activation_of(s, decl, {GraphChild::Kind::block, index}, block.path);
    }
    OverrideNode* below = overrides_of(s, decl);

    // Fields by what they set.
    const std::size_t numbers = kind.numbers.size(), tables = kind.tables.size(), counts = kind.counts.size();
    fields_.assign(numbers + tables + counts + kind.choices.size() + kind.texts.size(), nullptr);
    input_fields_.assign(kind.inputs.size(), nullptr);
    for (const FieldDecl& field : decl.fields) {
      const auto found = table.names.find(field.name);
      if (found == table.names.end()) {
        std::vector<std::string> names(kind.settable.begin(), kind.settable.end());
        report_unknown_field(decl, field, type.name, names);
        continue;
      }
      const std::uint32_t i = found->second.index;
      switch (found->second.kind) {
        case BlockName::Kind::input:
          input_fields_[i] = &field;
          break;
        case BlockName::Kind::list:
          e_.findings.error(field.mark, "'{}' is the input of '{}' ({}): write in: [...]", field.name, decl.name,
                            type.name);
          break;
        case BlockName::Kind::number:
          fields_[i] = &field;
          break;
        case BlockName::Kind::table:
          fields_[numbers + i] = &field;
          break;
        case BlockName::Kind::count:
          fields_[numbers + tables + i] = &field;
          break;
        case BlockName::Kind::choice:
          fields_[numbers + tables + counts + i] = &field;
          break;
        case BlockName::Kind::text:
          fields_[numbers + tables + counts + kind.choices.size() + i] = &field;
          break;
      }
    }

    std::size_t slot = 0;
    for (const Number* n : kind.numbers) {
      const NumberSpec& spec = n->spec;
      GraphParameter& p = add_block_parameter(index, decl, n->name, spec.unit);
      p.min = spec.min, p.max = spec.max, p.above = spec.above;
      p.structural = spec.structural ? 2 : 0;
      set_block_value(index, decl, slot++, table, spec.optional, below);
    }
    for (const Table* t : kind.tables) {
      const TableSpec& spec = t->spec;
      GraphParameter& p = add_block_parameter(index, decl, t->name, spec.unit);
      p.min = spec.min, p.max = spec.max, p.above = spec.above, p.ascending = spec.ascending;
      p.structural = spec.structural ? 2 : spec.zeros_matter ? 1 : 0;
      set_block_value(index, decl, slot++, table, spec.optional, below);
    }
    for (const Count* c : kind.counts) {
      GraphParameter& p = add_block_parameter(index, decl, c->name, {});
      p.structural = 2;
      set_block_value(index, decl, slot++, table, false, below);
    }
    for (const Choice* c : kind.choices) add_choice(s, decl, *c, fields_[slot++], below);
    for (const Text* t : kind.texts) add_text(s, decl, *t, fields_[slot++], below);
    add_block_inputs(index, s, decl, type, below);

    g_.blocks[index].first_output = static_cast<std::uint32_t>(g_.nets.size());
    g_.blocks[index].outputs = static_cast<std::uint32_t>(kind.outputs_declared.size());
    for (std::uint32_t i = 0; i < kind.outputs_declared.size(); ++i) {
      GraphNet& net = g_.nets.emplace_back();
      net.kind = GraphNet::Kind::output;
      net.owner = index;
      net.port = i;
      net.mark = decl.mark;
      net.unit = i == 0 && !decl.unit.empty() ? std::string_view(decl.unit) : kind.outputs_declared[i]->spec.unit;
    }
    bind_initials(s, decl, g_.blocks[index]);
    return {GraphChild::Kind::block, index};
  }

  GraphParameter& add_block_parameter(std::uint32_t owner, const BlockDecl& decl, std::string_view name,
                                      std::string_view unit) {
    GraphParameter& p = g_.parameters.emplace_back();
    p.name = name;
    p.owner = owner;
    p.unit = unit;
    p.mark = decl.mark;
    return p;
  }

  void set_block_value(std::uint32_t owner, const BlockDecl& decl, std::size_t slot, const BlockTable& table,
                       bool optional, OverrideNode* below) {
    const auto index = static_cast<std::uint32_t>(g_.parameters.size() - 1);
    GraphParameter& p = g_.parameters[index];
    const std::uint32_t s = g_.blocks[owner].scope;
    OverrideNode* given = below ? below->find(p.name) : nullptr;
    const bool overridden = given && given->given;
    if (const FieldDecl* field = fields_[slot]) {
      p.mark = field->mark;
      if (field->value.kind == Node::Kind::null || (field->value.is_scalar() && field->value.text.empty())) {
        e_.findings.error(field->mark, "'{}' has no value", field->name);
        p.bad = true;
        return;
      }
      return set_expression(index, e_.parse(field->value), s, given);
    }
    p.is_default = true;
    const ExpressionPtr& standard = table.defaults[slot];
    if (standard || overridden) return set_expression(index, standard, s, given);
    p.is_set = false;
    if (optional) return;
    p.bad = true;
    e_.findings.error(decl.mark, "{} needs a value for '{}'", title_of(g_, g_.blocks[owner]), p.name)
        .hint(fmt::format("write {}: ... beside type:", p.name))
        .named("missing-parameter");
  }

  void add_choice(std::uint32_t s, const BlockDecl& decl, const Choice& choice, const FieldDecl* field,
                  OverrideNode* below) {
    std::string word = choice.words.front();
    Mark mark = decl.mark;
    if (field && !field->value.is_scalar()) {
      e_.findings.error(field->value.mark, "'{}' is one of the words {}", choice.name, list_of(choice.words));
    } else if (field) {
      word = expand_text(e_, field->value.text, s, field->value.mark);
      mark = field->value.mark;
    }
    if (OverrideNode* given = below ? below->find(choice.name) : nullptr; given && given->given) {
      given->used = true;
      word = given->given->text;
      mark = {given->source.get(), 1, static_cast<std::uint32_t>(given->given->path.size() + 2), 1};
    }
    if (std::find(choice.words.begin(), choice.words.end(), word) == choice.words.end()) {
      Finding& finding = e_.findings.error(mark, "'{}' is none of the words that '{}' of '{}' ({}) may be", word,
                                           choice.name, decl.name, decl.type);
      const std::string near = nearest(word, choice.words);
      finding.hint((near.empty() ? "" : "did you mean '" + near + "'?  ") + "it may be: " + list_of(choice.words))
          .named("choice");
      word = choice.words.front();
    }
    g_.texts.push_back(std::move(word));
  }

  void add_text(std::uint32_t s, const BlockDecl& decl, const Text& text, const FieldDecl* field, OverrideNode* below) {
    std::string value(text.spec.init);
    Mark mark = decl.mark;
    bool is_given = false;
    std::string from = e_.model.path;
    if (field && !field->value.is_scalar()) {
      e_.findings.error(field->value.mark, "'{}' of '{}' ({}) is a text", text.name, decl.name, decl.type);
      is_given = true;
    } else if (field) {
      value = expand_text(e_, field->value.text, s, field->value.mark);
      mark = field->value.mark;
      is_given = true;
      if (mark.source) from = mark.source->name;
    }
    if (OverrideNode* given = below ? below->find(text.name) : nullptr; given && given->given) {
      given->used = true;
      is_given = true;
      value = given->given->text;
      from = e_.model.path;
      mark = {given->source.get(), 1, static_cast<std::uint32_t>(given->given->path.size() + 2), 1};
    }
    if (text.spec.file && !value.empty()) {
      const FileResult path = resolve_path(e_.model.project, from, value);
      if (!path.ok()) {
        e_.findings.error(mark, "cannot read '{}': {}", value, path.error).named("file");
      } else if (const FileResult bytes = read_file(path.value); !bytes.ok()) {
        e_.findings.error(mark, "cannot read '{}': {}", value, bytes.error).named("file");
      } else {
        value = path.value;
      }
    } else if (text.spec.file && !is_given && !text.spec.optional) {
      e_.findings.error(decl.mark, "'{}' ({}) needs a value for '{}'", decl.name, decl.type, text.name)
          .hint(fmt::format("write {}: followed by a file's name", text.name))
          .named("missing-parameter");
    }
    g_.texts.push_back(std::move(value));
  }

  void add_block_inputs(std::uint32_t index, std::uint32_t s, const BlockDecl& decl, const BlockType& type,
                        OverrideNode* below) {
    const Block& kind = *type.block;
    g_.blocks[index].first_input = static_cast<std::uint32_t>(g_.nets.size());
    std::vector<Port>& ports = ports_;
    ports.clear();
    if (!kind.lists.empty()) {
      ports.push_back({kind.lists[0]->name, false});
      input_fields_.assign(1, nullptr);
    }
    for (const Input* input : kind.inputs) ports.push_back({input->name, !std::isnan(input->spec.init)});
    const std::vector<const WireDecl*>& wires = match_wires(decl, type.name, ports, input_fields_);
    if (!kind.lists.empty()) return add_list_inputs(index, s, decl, wires[0]);
    g_.blocks[index].inputs = static_cast<std::uint32_t>(kind.inputs.size());
    for (std::uint32_t i = 0; i < kind.inputs.size(); ++i) {
      const InputSpec& spec = kind.inputs[i]->spec;
      GraphNet& net = g_.nets.emplace_back();
      net.kind = GraphNet::Kind::block_input;
      net.owner = index;
      net.port = i;
      net.mark = decl.mark;
      net.unit = spec.unit;
      drive(net, s, wires[i], input_fields_[i], std::isnan(spec.init) ? nullptr : default_of(spec.init), s, below,
            kind.inputs[i]->name);
    }
  }

  void add_list_inputs(std::uint32_t index, std::uint32_t s, const BlockDecl& decl, const WireDecl* wire) {
    if (!wire) {
      g_.blocks[index].bad = true;
      return;
    }
    g_.blocks[index].reduces = !wire->is_sequence;
    g_.blocks[index].inputs = static_cast<std::uint32_t>(wire->items.size());
    for (std::uint32_t i = 0; i < wire->items.size(); ++i) {
      GraphNet& net = g_.nets.emplace_back();
      net.kind = GraphNet::Kind::block_input;
      net.owner = index;
      net.port = i;
      net.driver = bind(wire->items[i], s);
      net.bad = !net.driver;
      net.mark = net.driver ? net.driver.mark : decl.mark;
    }
    if (wire->items.empty()) {
      e_.findings.error(wire->mark, "{} has nothing to work on: its list is empty", title_of(g_, g_.blocks[index]));
    }
  }

  // ---- inputs of both kinds

  // Which wire feeds which port; null: none. Reports everything that is wrong with `in:`.
  const std::vector<const WireDecl*>& match_wires(const BlockDecl& decl, std::string_view type,
                                                  const std::vector<Port>& ports,
                                                  const std::vector<const FieldDecl*>& fields) {
    std::vector<const WireDecl*>& wires = wires_;
    wires.assign(ports.size(), nullptr);
    bool wrong = false;
    std::vector<std::size_t>& open = open_;
    open.clear();
    for (std::size_t i = 0; i < ports.size(); ++i) {
      if (!ports[i].has_default) open.push_back(i);
    }
    const auto take = [&](const std::vector<WireDecl>& given) {
      for (const WireDecl& wire : given) {
        if (wire.port.empty()) {
          if (open.size() == 1) {
            wires[open[0]] = &wire;
          } else if (open.empty() && ports.size() == 1) {
            wires[0] = &wire;
          } else {
            report_ambiguous_wire(decl, type, wire, ports, open);
            wrong = true;
          }
          continue;
        }
        const auto port = std::find_if(ports.begin(), ports.end(), [&](const Port& p) { return p.name == wire.port; });
        if (port == ports.end()) {
          report_unknown_port(decl, type, wire, ports);
          wrong = true;
          continue;
        }
        wires[static_cast<std::size_t>(port - ports.begin())] = &wire;
      }
    };
    take(decl.in);
    if (is_first() && decl.first) take(decl.first->wires);
    if (is_last() && decl.last) take(decl.last->wires);
    for (std::size_t i = 0; i < ports.size(); ++i) {
      const FieldDecl* field = i < fields.size() ? fields[i] : nullptr;
      if (field && wires[i]) {
        e_.findings
            .error(field->mark, "the input '{}' of '{}' is given twice: under in: and as {}:", ports[i].name, decl.name,
                   ports[i].name)
            .also(wires[i]->mark, "under in:")
            .hint("one value, one spelling: remove either")
            .named("given-twice");
      } else if (field && !ports[i].has_default) {
        e_.findings.error(field->mark, "'{}' is an input of '{}' ({}), not a parameter", ports[i].name, decl.name, type)
            .hint(fmt::format("write it under in: `in: {{{}: ...}}`", ports[i].name))
            .named("input-as-parameter");
        wrong = true;
      }
    }
    const bool is_alone = !e_.made_up.empty() && &decl == &e_.made_up.back();  // its inputs are left open
    if (!wrong && !is_alone) report_unconnected(decl, type, ports, wires);
    return wires;
  }

  static std::string mapping(const std::vector<Port>& ports, const std::vector<std::size_t>& which) {
    std::string text;
    for (const std::size_t i : which) text += fmt::format("{}{}: ...", text.empty() ? "" : ", ", ports[i].name);
    return "in: {" + text + "}";
  }

  void report_ambiguous_wire(const BlockDecl& decl, std::string_view type, const WireDecl& wire,
                             const std::vector<Port>& ports, const std::vector<std::size_t>& open) {
    if (ports.empty()) {
      e_.findings.error(wire.mark, "'{}' ({}) has no inputs", decl.name, type).named("no-inputs");
      return;
    }
    std::vector<std::size_t> shown = open;
    if (shown.empty()) {
      for (std::size_t i = 0; i < ports.size(); ++i) shown.push_back(i);
    }
    e_.findings
        .error(wire.mark, "'{}' ({}) has {} inputs{}: say which one is fed", decl.name, type, shown.size(),
               open.empty() ? ", all of them with a default" : " that must be fed")
        .hint("write " + mapping(ports, shown))
        .named("ambiguous-input");
  }

  void report_unknown_port(const BlockDecl& decl, std::string_view type, const WireDecl& wire,
                           const std::vector<Port>& ports) {
    if (ports.empty()) {
      e_.findings.error(wire.mark, "'{}' ({}) has no inputs", decl.name, type).named("no-inputs");
      return;
    }
    std::vector<std::string> names;
    for (const Port& p : ports) names.emplace_back(p.name);
    if (is_parameter(decl, wire.port)) {
      e_.findings.error(wire.mark, "'{}' is a parameter of '{}' ({}), not an input", wire.port, decl.name, type)
          .hint(fmt::format("write {}: beside in:", wire.port))
          .named("unknown-input");
      return;
    }
    e_.findings.error(wire.mark, "'{}' ({}) has no input '{}'", decl.name, type, wire.port)
        .suggest(wire.port, names)
        .named("unknown-input");
  }

  bool is_parameter(const BlockDecl& decl, const std::string& name) {
    const BlockType* type = find_block(decl.type);
    return type && e_.table_of(*type).names.contains(name);
  }

  static bool is_list(const BlockDecl& decl) {
    const BlockType* type = find_block(decl.type);
    return type && !type->block->lists.empty();
  }

  void report_unconnected(const BlockDecl& decl, std::string_view type, const std::vector<Port>& ports,
                          const std::vector<const WireDecl*>& wires) {
    std::vector<std::size_t> missing;
    for (const std::size_t i : open_) {
      if (!wires[i]) missing.push_back(i);
    }
    if (missing.empty()) return;
    const std::vector<std::size_t>& open = open_;
    const bool alone = open.size() == 1;
    std::string names;
    for (const std::size_t i : missing) names += fmt::format("{}'{}'", names.empty() ? "" : ", ", ports[i].name);
    e_.findings
        .error(decl.mark, "{} {} of '{}' ({}) {} not connected", missing.size() == 1 ? "the input" : "the inputs",
               names, decl.name, type, missing.size() == 1 ? "is" : "are")
        .hint(is_list(decl) ? "write in: [a, b, ...]"
              : alone       ? "write in: followed by a signal"
                            : "write " + mapping(ports, open))
        .named("unconnected");
  }

  // In a copy of a repeated block, what stands around it knows the copy's number; defaults inside its type do not.
  BoundExpression bind(const ExpressionPtr& tree, std::uint32_t scope) {
    BoundExpression bound = e_.bind(tree, scope);
    if (repeat_ != nowhere && scope == g_.repeats[repeat_].scope) bound.repeat = repeat_, bound.copy = copy_;
    return bound;
  }

  std::string name_of(const BlockDecl& decl) const {
    return copy_ == 0 ? decl.name : fmt::format("{}.{}", decl.name, copy_);
  }

  OverrideNode* overrides_of(std::uint32_t s, const BlockDecl& decl) {
    OverrideNode* above = e_.scope_overrides[s];
    OverrideNode* below = above ? above->find(decl.name) : nullptr;
    return copy_ == 0 ? below : overrides_of_copy(e_, below, copy_);
  }

  bool is_first() const { return copy_ == 1; }
  bool is_last() const { return copy_ != 0 && copy_ == g_.repeats[repeat_].count; }

  // What an expression block computes; at an end, what stands there instead.
  ExpressionPtr expression_of(const BlockDecl& decl) {
    const EndDecl* end = is_first() && decl.first ? &*decl.first : is_last() && decl.last ? &*decl.last : nullptr;
    if (!end || end->wires.empty()) return decl.expression;
    if (end->wires[0].port.empty()) return tree_of(end->wires[0]);
    e_.findings.error(end->wires[0].mark, "'{}' is an expression and has no input '{}'", decl.name, end->wires[0].port)
        .hint("write the expression that the end has instead: first: 0")
        .named("repeat");
    return nullptr;
  }

  // What feeds an input: a wire, a value given like a parameter, or the default, whose names belong to `default_scope`.
  void drive(GraphNet& net, std::uint32_t outside, const WireDecl* wire, const FieldDecl* field,
             const ExpressionPtr& fallback, std::uint32_t default_scope, OverrideNode* below, std::string_view name) {
    OverrideNode* given = below ? below->find(name) : nullptr;
    if (given && given->given && fallback) {
      if (const ExpressionPtr tree = parse_override(*given)) {
        net.driver = bind(tree, outside);
        net.mark = net.driver.mark;
      }
      net.bad = !net.driver;
      return;
    }
    if (wire) {
      net.driver = bind(tree_of(*wire), outside);
      if (net.driver) net.mark = net.driver.mark;
    } else if (field) {
      net.driver = bind(e_.parse(field->value), outside);
      net.mark = field->mark;
    } else if (fallback) {
      net.driver = e_.bind(fallback, default_scope);
      net.is_connected = false;
    }
    net.bad = !net.driver;
  }

  // A sequence that feeds one port is joined.
  ExpressionPtr tree_of(const WireDecl& wire) {
    if (!wire.is_sequence) return wire.items.empty() ? nullptr : wire.items[0];
    ExpressionPtr& tree = e_.joined[&wire];
    if (!tree) {
      auto made = std::make_shared<Expression>();
      made->kind = Expression::Kind::vector;
      made->text = "[";
      made->arguments = wire.items;
      made->mark = wire.mark;
      for (const ExpressionPtr& item : wire.items) {
        if (!item) return nullptr;
      }
      tree = made;
    }
    return tree;
  }

  ExpressionPtr default_of(double value) {
    ExpressionPtr& tree = defaults_[value];
    if (!tree) tree = number_expression(value);
    return tree;
  }

  // ---- values

  ExpressionPtr parse_override(OverrideNode& given) {
    given.used = true;
    TextPlace place;
    place.start = {given.source.get(), 1, static_cast<std::uint32_t>(given.given->path.size() + 2), 1};
    return parse_expression(given.given->text, place, e_.findings.report());
  }

  void set_expression(std::uint32_t index, ExpressionPtr tree, std::uint32_t scope, OverrideNode* given) {
    if (given && given->given) {
      tree = parse_override(*given);
      g_.parameters[index].mark = {given->source.get(), 1, 1, static_cast<std::uint32_t>(given->given->path.size())};
      g_.parameters[index].is_default = false;
    }
    if (given && tree) {
      for (auto& [key, child] : given->children) {
        if (child->given && all_digits(key)) tree = replace_element(tree, key, *child);
        for (auto& [column, inner] : child->children) {
          if (inner->given && all_digits(key) && all_digits(column)) tree = replace_element(tree, key, *inner, column);
        }
        if (!tree) break;
      }
    }
    g_.parameters[index].expression = bind(tree, scope);
    g_.parameters[index].bad = tree == nullptr;
  }

  // `K.2=5`: an element of a vector that is written out.
  ExpressionPtr replace_element(const ExpressionPtr& tree, const std::string& row, OverrideNode& given,
                                const std::string& column = {}) {
    const std::size_t i = row.size() > 9 ? 0 : std::stoul(row);
    given.used = true;
    const Mark mark{given.source.get(), 1, 1, static_cast<std::uint32_t>(given.given->path.size())};
    if (tree->kind != Expression::Kind::vector) {
      e_.findings.error(mark, "'{}' is not written as a list: set the whole of it",
                        given.given->path.substr(0, given.given->path.find_last_of('.')));
      return nullptr;
    }
    if (i < 1 || i > tree->arguments.size()) {
      e_.findings.error(mark, "'{}': elements are counted from 1 to {}", given.given->path, tree->arguments.size());
      return nullptr;
    }
    auto copy = std::make_shared<Expression>(*tree);
    copy->arguments[i - 1] =
        column.empty() ? parse_override(given) : replace_element(tree->arguments[i - 1], column, given);
    return copy->arguments[i - 1] ? copy : nullptr;
  }

  void bind_reset(std::uint32_t s, const BlockDecl& decl, BoundExpression& when, BoundExpression& to) {
    if (!decl.reset) return;
    when = bind(decl.reset->when, s);
    to = bind(decl.reset->to, s);
  }

  void report_unknown_field(const BlockDecl& decl, const FieldDecl& field, std::string_view type,
                            const std::vector<std::string>& names) {
    Finding& finding = e_.findings.error(field.mark, "'{}' ({}) has no parameter '{}'", decl.name, type, field.name);
    for (const char* other : {"input", "inputs", "from", "source", "signal"}) {
      if (field.name == other) finding.hint("what feeds a block stands under in:");
    }
    if (names.empty()) {
      finding.hint("it has no parameters");
    } else {
      finding.suggest(field.name, names);
    }
    finding.named("unknown-parameter");
  }

  // ---- what is said once of every type

  void check_type(const TypeDecl& type) {
    if (!checked_.insert(&type).second) return;
    if (type.file && !type.machine && !type.name.empty() && (find_block(type.name) || type.name == "bus")) {
      e_.findings.error(type.mark, "'{}' is the name of a built-in block type", type.name).named("built-in-type");
    }
  }

  Elaboration& e_;
  Graph& g_;
  bool too_many_ = false;
  std::uint32_t repeat_ = nowhere, copy_ = 0;  // the copy in hand
  std::vector<const FieldDecl*> fields_, input_fields_;
  std::vector<Port> ports_;
  std::vector<const WireDecl*> wires_;
  std::vector<std::size_t> open_;  // ports that must be fed
  std::map<double, ExpressionPtr> defaults_;
  std::unordered_set<const TypeDecl*> checked_;
};

}  // namespace

void instantiate(Elaboration& e) { Instantiation(e).run(); }
void instantiate_types(Elaboration& e, const TypeDecl& diagram, std::span<const TypeDecl* const> unused) {
  Instantiation(e).run_alone(diagram, unused);
}

}  // namespace plantloop
