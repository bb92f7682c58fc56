// Blocks, subsystems, buses and copies of a diagram as blocks of its sheet.

#include "app/drawing/sheet_maker.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <utility>

#include "app/drawing/faces.h"
#include "app/drawing/formulas.h"

namespace plantloop {

const std::string& SheetMaker::path_of(const GraphChild& child) const {
  if (child.kind == GraphChild::Kind::bus) return g_.buses[child.index].path;
  if (child.kind == GraphChild::Kind::repeat) return g_.repeats[child.index].path;
  return child.kind == GraphChild::Kind::scope ? g_.scopes[child.index].path : g_.blocks[child.index].path;
}

std::string SheetMaker::shown_name(const BlockDecl& decl) {
  return decl.label.empty() ? pretty_name(decl.name) : decl.label;
}

void SheetMaker::add_child(const GraphChild& child) {
  if (child.kind == GraphChild::Kind::bad || options_.hidden.contains(path_of(child))) return;
  if (child.kind == GraphChild::Kind::scope) return (void)add_subsystem(child.index);
  if (child.kind == GraphChild::Kind::repeat) return add_repeated(g_.repeats[child.index]);
  if (child.kind == GraphChild::Kind::bus) return add_bus(child.index);
  if (child.kind != GraphChild::Kind::block) return;
  const GraphBlock& graph_block = g_.blocks[child.index];
  if (graph_block.type == nullptr) {
    named_.push_back(graph_block.first_output);
    names_[graph_block.first_output] = graph_block.declaration;
    return;
  }
  add_block(child.index);
}

void SheetMaker::add_bus(std::uint32_t index) {
  const GraphBus& bus = g_.buses[index];
  SheetBlock b;
  b.path = bus.declaration->name;
  b.shape = Shape::bar;
  b.outputs = {""};
  b.inputs.assign(bus.declaration->in.size(), "");
  const std::string path = b.path;
  const SheetPort port{add(std::move(b)), 0};
  buses_[index] = port;
  for (std::size_t i = 0; i < bus.declaration->in.size(); ++i)
    feed(bus.first_member + static_cast<std::uint32_t>(i), {port.block, static_cast<int>(i)},
         path + "<" + std::to_string(i));
}

void SheetMaker::feed(std::uint32_t net, SheetPort to, const std::string& path) {
  if (g_.nets[net].bus != nowhere)
    bus_reads_.emplace_back(g_.nets[net].bus, to);
  else if (g_.nets[net].driver)
    pending_.push_back({g_.nets[net].driver, to, path});
}

std::optional<SheetPort> SheetMaker::bus_port(std::uint32_t bus) {
  if (const auto own = buses_.find(bus); own != buses_.end()) {
    wire_from(own->second).label = shown_name(*g_.buses[bus].declaration);
    return own->second;
  }
  for (const auto& [net, port] : sources_)
    if (g_.nets[net].bus == bus) return port;
  return std::nullopt;
}

SheetPort SheetMaker::member_port(std::uint32_t net) {
  const GraphNet& member = g_.nets[net];
  const std::optional<SheetPort> from = bus_port(member.owner);
  if (!from) return placeholder(net);
  const BlockDecl& decl = *g_.buses[member.owner].declaration;
  const std::string& name = decl.in[member.port].port;
  SheetBlock b;
  b.path = decl.name + "." + name;
  b.formula = pretty_name(name);
  b.inputs = b.outputs = {""};
  const SheetPort port{add(std::move(b)), 0};
  wire_from(*from).to.push_back({port.block, 0});
  return sources_[net] = port;
}

void SheetMaker::add_repeated(const GraphRepeat& repeat) {
  const auto copy = [&](std::uint32_t k) { return g_.copies[repeat.first_copy + k]; };
  if (repeat.count == 0) return;
  const std::uint32_t middle = repeat.count > 2 ? 1 : 0;
  const GraphChild shown = copy(middle);
  if (shown.kind == GraphChild::Kind::bad) return;
  int index = 0;
  if (shown.kind == GraphChild::Kind::scope) {
    index = add_subsystem(shown.index);
  } else if (g_.blocks[shown.index].type != nullptr) {
    index = add_block(shown.index);
  } else {
    index = add_repeated_expression(g_.blocks[shown.index], repeat);
  }
  SheetBlock& b = sheet_.blocks[static_cast<std::size_t>(index)];
  b.copies = static_cast<int>(repeat.count);
  b.caption = fmt::format("{} × {}", shown_name(*repeat.declaration), repeat.count);
  labels_.erase(first_output(shown));
  if (b.formula.kind == Formula::Kind::text && b.is_subsystem) b.formula = repeat.declaration->type;
  const std::set<std::uint32_t> recorded = scope_ == 0 ? recorded_nets() : std::set<std::uint32_t>();
  for (std::uint32_t k = 0; k < repeat.count; ++k) add_ends(copy(k), shown, index, recorded);
  if (repeat.net != nowhere) sources_[repeat.net] = {index, 0};
  if (recorded.contains(repeat.net)) nets_[repeat.net] = {index, 0};
}

std::uint32_t SheetMaker::first_output(const GraphChild& child) const {
  return child.kind == GraphChild::Kind::scope ? g_.scopes[child.index].first_output
                                               : g_.blocks[child.index].first_output;
}

void SheetMaker::add_ends(const GraphChild& copy, const GraphChild& shown, int index,
                          const std::set<std::uint32_t>& recorded) {
  if (copy.kind != shown.kind || copy.index == shown.index) return;
  const bool is_scope = copy.kind == GraphChild::Kind::scope;
  const std::uint32_t outputs =
      is_scope ? static_cast<std::uint32_t>(g_.scopes[copy.index].type->outputs.size()) : g_.blocks[copy.index].outputs;
  for (std::uint32_t i = 0; i < outputs; ++i) {
    const std::uint32_t net = first_output(copy) + i;
    const SheetPort port = sources_.at(first_output(shown) + i);
    sources_[net] = port;
    if (!recorded.contains(net)) continue;
    nets_.erase(first_output(shown) + i);
    nets_[net] = port;
  }
  if (!is_scope && g_.blocks[copy.index].type == nullptr) return;
  const std::uint32_t first = is_scope ? g_.scopes[copy.index].first_input : g_.blocks[copy.index].first_input;
  const std::uint32_t own = is_scope ? g_.scopes[shown.index].first_input : g_.blocks[shown.index].first_input;
  const std::uint32_t inputs =
      is_scope ? static_cast<std::uint32_t>(g_.scopes[copy.index].type->inputs.size()) : g_.blocks[copy.index].inputs;
  SheetBlock& b = sheet_.blocks[static_cast<std::size_t>(index)];
  if (b.inside) return;
  for (std::uint32_t i = 0; i < inputs; ++i) {
    const GraphNet &net = g_.nets[first + i], &usual = g_.nets[own + i];
    if (net.by_parameter || !net.is_connected || !net.driver || net.driver.code == usual.driver.code) continue;
    const BoundExpression& bound = net.driver;
    const bool is_first = bound.copy == 1;
    const std::string name =
        is_scope ? g_.scopes[copy.index].type->inputs[i].name : std::string(input_name(g_.blocks[copy.index], i));
    b.inputs.push_back((is_first ? "first: " : "last: ") + pretty_name(name));
    pending_.push_back({bound,
                        {index, static_cast<int>(b.inputs.size()) - 1},
                        fmt::format("{}<{}{}", b.path, is_first ? "first" : "last", i)});
  }
}

std::string_view SheetMaker::input_name(const GraphBlock& block, std::uint32_t input) {
  const Block& kind = *block.type->block;
  return kind.lists.empty() ? kind.inputs[input]->name : std::string_view();
}

int SheetMaker::add_repeated_expression(const GraphBlock& from, const GraphRepeat& repeat) {
  const GraphNet& net = g_.nets[from.first_output];
  bind(net.driver);
  const SheetPort port = build_box(*net.driver.code->tree, repeat.declaration->name, true);
  sources_[from.first_output] = nets_[from.first_output] = port;
  return port.block;
}

void SheetMaker::add_conditions(GraphChild::Kind kind, std::uint32_t child, int index) {
  for (std::size_t i = 1; i < g_.activations.size(); ++i) {
    const GraphActivation& a = g_.activations[i];
    if (a.owner.kind != kind || a.owner.index != child) continue;
    const std::string edge = !a.declaration->trigger                     ? ""
                             : a.declaration->trigger->edge == "rising"  ? " ↑"
                             : a.declaration->trigger->edge == "falling" ? " ↓"
                                                                         : " ↕";
    if (a.enable_when) add_condition(a.enable_when, "enable", index);
    if (a.trigger_when) add_condition(a.trigger_when, "trigger" + edge, index);
  }
}

void SheetMaker::add_condition(const BoundExpression& when, const std::string& name, int index) {
  if (!reads_signals(when)) return;
  SheetBlock& b = sheet_.blocks[static_cast<std::size_t>(index)];
  // The sides of a frame belong to the ports inside.
  if (b.inside && b.top_input >= 0) return;
  b.inputs.push_back(name);
  const int port = static_cast<int>(b.inputs.size()) - 1;
  if (b.top_input < 0 && b.shape == Shape::box) b.top_input = port;
  pending_.push_back({when, {index, port}, b.path + "<" + name.substr(0, name.find(' '))});
}

int SheetMaker::add_block(std::uint32_t block_index) {
  const GraphBlock& from = g_.blocks[block_index];
  const Block& kind = *from.type->block;
  SheetBlock b;
  b.path = from.declaration->name;
  b.has_state = !kind.states.empty() || !kind.discretes.empty();
  for (std::uint32_t i = 0; i < from.inputs; ++i)
    b.inputs.push_back(kind.lists.empty() ? pretty_name(kind.inputs[i]->name) : "");
  for (const Output* o : kind.outputs_declared) b.outputs.push_back(pretty_name(o->name));
  give_face(g_, from, b);
  if (options_.rates && from.rate.kind == GraphRate::Kind::discrete)
    b.note += (b.note.empty() ? "" : ", ") + rate_text(from.rate);
  drop_unfed_inputs(from, b);
  const std::string name = shown_name(*from.declaration);
  const bool on_wire = b.outputs.size() == 1 && (is_symbol(from.declaration->name) || b.shape == Shape::circle);
  if (!on_wire) b.caption = name;
  const std::string path = b.path;
  const int index = add(std::move(b));
  for (std::uint32_t i = 0; i < from.outputs; ++i) {
    sources_[from.first_output + i] = {index, static_cast<int>(i)};
    nets_[from.first_output + i] = {index, static_cast<int>(i)};
  }
  if (on_wire) labels_[from.first_output] = name;
  for (std::uint32_t i = 0; i < from.outputs; ++i)
    if (from.outputs > 1) results_[from.first_output + i] = name + "." + pretty_name(kind.outputs_declared[i]->name);
  for (std::size_t i = 0; i < fed_.size(); ++i)
    pending_.push_back({g_.nets[fed_[i]].driver, {index, static_cast<int>(i)}, path + "<" + std::to_string(i)});
  add_reset(from.reset_when, from.reset_to, index, path);
  add_conditions(GraphChild::Kind::block, block_index, index);
  if (from.type->group == "run") ends_.insert(index);
  return index;
}

void SheetMaker::drop_unfed_inputs(const GraphBlock& from, SheetBlock& b) {
  fed_.clear();
  std::vector<std::string> texts;
  const bool list = !from.type->block->lists.empty();
  for (std::uint32_t i = 0; i < from.inputs; ++i) {
    const GraphNet& net = g_.nets[from.first_input + i];
    const bool optional = !list && !std::isnan(from.type->block->inputs[i]->spec.init);
    if (net.by_parameter || !net.is_connected || !net.driver) continue;
    if (optional && !reads_signals(net.driver)) continue;
    fed_.push_back(from.first_input + i);
    texts.push_back(b.inputs[i]);
  }
  b.inputs = std::move(texts);
}

void SheetMaker::add_reset(const BoundExpression& when, const BoundExpression& to, int index, const std::string& path) {
  const auto add = [&](const BoundExpression& bound, const char* name) {
    SheetBlock& b = sheet_.blocks[static_cast<std::size_t>(index)];
    b.inputs.emplace_back(name);
    pending_.push_back({bound, {index, static_cast<int>(b.inputs.size()) - 1}, path + "<" + name});
  };
  if (!when || !reads_signals(when)) return;
  add(when, "reset");
  if (to && reads_signals(to)) add(to, "to");
}

std::string SheetMaker::rate_text(GraphRate rate) const {
  const ClockRate& clock = g_.rates[rate.index];
  std::string text = fmt::format("T_s = {} s", pretty_number(clock.period.to_double()));
  if (!clock.offset.is_zero()) text += fmt::format(", from {} s", pretty_number(clock.offset.to_double()));
  return text;
}

Formula SheetMaker::face_of(const StateMachineDecl& machine) {
  std::vector<Formula> lines;
  for (std::size_t i = 0; i < machine.states.size() && i < 6; ++i) {
    std::string line = machine.states[i].name;
    std::string targets;
    for (const StateMachineDecl::Transition& t : machine.transitions) {
      if (t.from == i) targets += (targets.empty() ? " → " : ", ") + machine.states[t.to].name;
    }
    lines.emplace_back(line + targets);
  }
  if (machine.states.size() > 6) lines.emplace_back(fmt::format("and {} more", machine.states.size() - 6));
  return {Formula::Kind::lines, std::move(lines)};
}

int SheetMaker::add_subsystem(std::uint32_t s) {
  const GraphScope& scope = g_.scopes[s];
  SheetBlock b;
  b.path = scope.declaration->name;
  b.is_subsystem = true;
  b.has_state = true;
  if (options_.rates && scope.rate != 0) b.note = rate_text({GraphRate::Kind::discrete, scope.rate});
  const std::string name = shown_name(*scope.declaration);
  const bool open = options_.depth > 0 && !scope.type->machine;
  std::vector<std::uint32_t> fed;
  for (std::size_t i = 0; i < scope.type->inputs.size(); ++i) {
    const auto net = static_cast<std::uint32_t>(scope.first_input + i);
    b.inputs.push_back(pretty_name(scope.type->inputs[i].name));
    fed.push_back(net);
  }
  for (const OutputDecl& o : scope.type->outputs) b.outputs.push_back(pretty_name(o.name));
  if (open) {
    SheetOptions inner = options_;
    --inner.depth;
    b.inside = std::make_shared<Sheet>(SheetMaker(g_, s, inner).run());
    b.caption = name;
  } else {
    std::vector<std::string> texts;
    std::vector<std::uint32_t> really;
    for (std::size_t i = 0; i < fed.size(); ++i) {
      const GraphNet& net = g_.nets[fed[i]];
      if (net.by_parameter || !net.is_connected || !net.driver) continue;
      really.push_back(fed[i]);
      texts.push_back(b.inputs[i]);
    }
    b.inputs = std::move(texts);
    fed = std::move(really);
    b.formula = name;
    if (scope.type->machine) {
      b.is_subsystem = false;
      b.caption = name;
      b.formula = face_of(*scope.type->machine);
    }
  }
  const std::string path = b.path;
  const int index = add(std::move(b));
  for (std::size_t i = 0; i < scope.type->outputs.size(); ++i) {
    const auto net = static_cast<std::uint32_t>(scope.first_output + i);
    sources_[net] = nets_[net] = {index, static_cast<int>(i)};
    if (scope.type->outputs.size() > 1 || open)
      results_[net] = scope.type->outputs.size() == 1 ? name : name + "." + pretty_name(scope.type->outputs[i].name);
  }
  for (std::size_t i = 0; i < fed.size(); ++i)
    feed(fed[i], {index, static_cast<int>(i)}, path + "<" + std::to_string(i));
  if (!open) add_reset(scope.reset_when, scope.reset_to, index, path);
  add_conditions(GraphChild::Kind::scope, s, index);
  return index;
}

}  // namespace plantloop
