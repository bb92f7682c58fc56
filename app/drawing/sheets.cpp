// Blocks first, then what feeds each of their inputs.

#include "app/drawing/sheets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "app/drawing/faces.h"
#include "app/drawing/formulas.h"
#include "engine/base/numbers.h"
#include "render/diagram/arrangement.h"

namespace plantloop {
namespace {

using Kind = Expression::Kind;
using Shape = SheetBlock::Shape;

// A term of a sum, or a factor of a product.
struct Part {
  const Expression* node = nullptr;
  bool inverse = false;  // subtracted; divided by
};

class SheetMaker {
 public:
  SheetMaker(const Graph& graph, std::uint32_t scope, const SheetOptions& options)
      : g_(graph), scope_(scope), options_(options) {}

  Sheet run() {
    const GraphScope& scope = g_.scopes[scope_];
    if (scope_ != 0) add_inputs(scope);
    for (std::size_t i = 0; i < scope.type->blocks.size(); ++i) add_child(g_.children[scope.first_child + i]);
    connect_pending();
    for (const std::uint32_t net : named_) source_of(net);
    if (scope_ != 0) add_outputs(scope);
    connect_pending();
    for (const auto& [bus, port] : buses_)
      if (wire_from(port).to.empty()) bus_port(bus), wire_from(port).is_shown = true;
    mark_results();
    drop_unread_outputs();
    if (scope_ != 0) sheet_.path = scope.path + ".";
    return std::move(sheet_);
  }

 private:
  struct Pending {
    BoundExpression driver;
    SheetPort to;
    std::string path;
  };

  SheetBlock& block(SheetPort port) { return sheet_.blocks[static_cast<std::size_t>(port.block)]; }

  int add(SheetBlock block) {
    sheet_.blocks.push_back(std::move(block));
    return static_cast<int>(sheet_.blocks.size()) - 1;
  }

  // What is connected may need further blocks, with inputs of their own.
  void connect_pending() {
    // NOLINTNEXTLINE(modernize-loop-convert): the list grows meanwhile
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      const Pending p = pending_[i];
      connect(p.driver, p.to, p.path);
    }
    pending_.clear();
    for (const auto& [net, to] : std::exchange(unwired_, {})) wire_from(source_of(net)).to.push_back(to);
    for (const auto& [bus, to] : std::exchange(bus_reads_, {}))
      if (const auto from = bus_port(bus)) wire_from(*from).to.push_back(to);
  }

  // ---- ports of the sheet

  void add_inputs(const GraphScope& scope) {
    for (std::size_t i = 0; i < scope.type->inputs.size(); ++i) {
      const auto net = static_cast<std::uint32_t>(scope.first_input + i);
      const InputDecl& input = scope.type->inputs[i];
      SheetBlock b;
      b.path = input.name;
      b.shape = Shape::input;
      b.formula = pretty_name(input.name);
      b.outputs = {""};
      sources_[net] = {add(std::move(b)), 0};
      nets_[net] = sources_[net];
    }
  }

  void add_outputs(const GraphScope& scope) {
    for (std::size_t i = 0; i < scope.type->outputs.size(); ++i) {
      const OutputDecl& output = scope.type->outputs[i];
      SheetBlock b;
      b.path = output.name + ">";
      b.shape = Shape::output;
      b.formula = pretty_name(output.name);
      b.inputs = {""};
      const SheetPort to{add(std::move(b)), 0};
      connect(g_.nets[scope.first_output + i].driver, to, output.name + ">");
    }
  }

  // ---- children

  const std::string& path_of(const GraphChild& child) const {
    if (child.kind == GraphChild::Kind::bus) return g_.buses[child.index].path;
    if (child.kind == GraphChild::Kind::repeat) return g_.repeats[child.index].path;
    return child.kind == GraphChild::Kind::scope ? g_.scopes[child.index].path : g_.blocks[child.index].path;
  }

  static std::string shown_name(const BlockDecl& decl) {
    return decl.label.empty() ? pretty_name(decl.name) : decl.label;
  }

  void add_child(const GraphChild& child) {
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

  // ---- buses: a bar that joins the members, and a box with a member's name where one is read

  void add_bus(std::uint32_t index) {
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

  // What drives a net: an expression, or a whole bus.
  void feed(std::uint32_t net, SheetPort to, const std::string& path) {
    if (g_.nets[net].bus != nowhere)
      bus_reads_.emplace_back(g_.nets[net].bus, to);
    else if (g_.nets[net].driver)
      pending_.push_back({g_.nets[net].driver, to, path});
  }

  // Where a bus comes from in this sheet: its bar, or the port of a subsystem that stands for it.
  std::optional<SheetPort> bus_port(std::uint32_t bus) {
    if (const auto own = buses_.find(bus); own != buses_.end()) {
      wire_from(own->second).label = shown_name(*g_.buses[bus].declaration);
      return own->second;
    }
    for (const auto& [net, port] : sources_)
      if (g_.nets[net].bus == bus) return port;
    return std::nullopt;
  }

  SheetPort member_port(std::uint32_t net) {
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

  // All copies are one block. It is drawn as one in the middle is connected, to others of the copies by a wire that
  // leads back to it; what the two ends get instead has inputs of its own.
  void add_repeated(const GraphRepeat& repeat) {
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

  std::uint32_t first_output(const GraphChild& child) const {
    return child.kind == GraphChild::Kind::scope ? g_.scopes[child.index].first_output
                                                 : g_.blocks[child.index].first_output;
  }

  // The outputs of a copy are those of the one that is shown; its inputs, too, but for those wired in another way.
  void add_ends(const GraphChild& copy, const GraphChild& shown, int index, const std::set<std::uint32_t>& recorded) {
    if (copy.kind != shown.kind || copy.index == shown.index) return;
    const bool is_scope = copy.kind == GraphChild::Kind::scope;
    const std::uint32_t outputs = is_scope ? static_cast<std::uint32_t>(g_.scopes[copy.index].type->outputs.size())
                                           : g_.blocks[copy.index].outputs;
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

  static std::string_view input_name(const GraphBlock& block, std::uint32_t input) {
    const Block& kind = *block.type->block;
    return kind.lists.empty() ? kind.inputs[input]->name : std::string_view();
  }

  int add_repeated_expression(const GraphBlock& from, const GraphRepeat& repeat) {
    const GraphNet& net = g_.nets[from.first_output];
    bind(net.driver);
    const SheetPort port = build_box(*net.driver.code->tree, repeat.declaration->name, true);
    sources_[from.first_output] = nets_[from.first_output] = port;
    return port.block;
  }

  // The condition under which a block or subsystem runs.
  void add_conditions(GraphChild::Kind kind, std::uint32_t child, int index) {
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

  // At the top of the block, where there is one only.
  void add_condition(const BoundExpression& when, const std::string& name, int index) {
    if (!reads_signals(when)) return;
    SheetBlock& b = sheet_.blocks[static_cast<std::size_t>(index)];
    // The sides of a frame belong to the ports inside.
    if (b.inside && b.top_input >= 0) return;
    b.inputs.push_back(name);
    const int port = static_cast<int>(b.inputs.size()) - 1;
    if (b.top_input < 0 && b.shape == Shape::box) b.top_input = port;
    pending_.push_back({when, {index, port}, b.path + "<" + name.substr(0, name.find(' '))});
  }

  int add_block(std::uint32_t block_index) {
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

  // Inputs that no signal feeds are parameters in the picture.
  void drop_unfed_inputs(const GraphBlock& from, SheetBlock& b) {
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

  void add_reset(const BoundExpression& when, const BoundExpression& to, int index, const std::string& path) {
    const auto add = [&](const BoundExpression& bound, const char* name) {
      SheetBlock& b = sheet_.blocks[static_cast<std::size_t>(index)];
      b.inputs.emplace_back(name);
      pending_.push_back({bound, {index, static_cast<int>(b.inputs.size()) - 1}, path + "<" + name});
    };
    if (!when || !reads_signals(when)) return;
    add(when, "reset");
    if (to && reads_signals(to)) add(to, "to");
  }

  std::string rate_text(GraphRate rate) const {
    const ClockRate& clock = g_.rates[rate.index];
    std::string text = fmt::format("T_s = {} s", pretty_number(clock.period.to_double()));
    if (!clock.offset.is_zero()) text += fmt::format(", from {} s", pretty_number(clock.offset.to_double()));
    return text;
  }

  // The states in the order of the file, each with where it leads.
  static Formula face_of(const StateMachineDecl& machine) {
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

  int add_subsystem(std::uint32_t s) {
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

  // ---- wires

  SheetWire& wire_from(SheetPort from) {
    const auto [it, is_new] = wire_at_.try_emplace({from.block, from.port}, sheet_.wires.size());
    if (is_new) {
      SheetWire wire;
      wire.from = from;
      sheet_.wires.push_back(std::move(wire));
    }
    return sheet_.wires[it->second];
  }

  void connect(const BoundExpression& driver, SheetPort to, const std::string& path) {
    bind(driver);
    const SheetPort from = build(*driver.code->tree, path);
    wire_from(from).to.push_back(to);
  }

  // What the names of an expression mean where it stands.
  void bind(const BoundExpression& bound) {
    for (std::size_t i = 0; i < bound.code->names.size(); ++i)
      meaning_[bound.code->names[i]] = g_.references[bound.first_reference + i];
  }

  const Reference* meaning(const Expression& name) const {
    const auto it = meaning_.find(&name);
    return it == meaning_.end() ? nullptr : &it->second;
  }

  bool reads_signals(const BoundExpression& bound) {
    bind(bound);
    return reads_signals(*bound.code->tree);
  }

  bool reads_signals(const Expression& e) const {
    if (e.kind == Kind::name) {
      const Reference* r = meaning(e);
      return r != nullptr && (r->kind == Reference::Kind::net || r->kind == Reference::Kind::time);
    }
    return std::any_of(e.arguments.begin(), e.arguments.end(),
                       [this](const ExpressionPtr& a) { return reads_signals(*a); });
  }

  bool reads_nets(const Expression& e) const {
    if (e.kind == Kind::name) {
      const Reference* r = meaning(e);
      return r != nullptr && r->kind == Reference::Kind::net;
    }
    return std::any_of(e.arguments.begin(), e.arguments.end(),
                       [this](const ExpressionPtr& a) { return reads_nets(*a); });
  }

  // The port that gives a net; what an expression block computes is built when it is first asked for.
  SheetPort source_of(std::uint32_t net) {
    if (const auto it = sources_.find(net); it != sources_.end()) return it->second;
    if (g_.nets[net].kind == GraphNet::Kind::member) return member_port(net);
    const auto name = names_.find(net);
    if (name == names_.end()) return placeholder(net);
    const BlockDecl& decl = *name->second;
    const GraphNet& graph_net = g_.nets[net];
    if (!graph_net.driver || building_.contains(net)) return placeholder(net);
    building_.insert(net);
    bind(graph_net.driver);
    const Expression& tree = *graph_net.driver.code->tree;
    // What runs under a condition is one box, so that the condition has a place.
    const bool conditional = decl.enable || decl.trigger;
    const SheetPort port = conditional ? build_box(tree, decl.name) : build(tree, decl.name);
    if (conditional) add_conditions(GraphChild::Kind::block, graph_net.owner, port.block);
    building_.erase(net);
    sources_[net] = port;
    const std::string shown = shown_name(decl);
    SheetBlock& b = block(port);
    // An expression that is a plain name is another name of that signal.
    if (graph_net.driver.code->is_name() && labels_of_port_.contains({port.block, port.port}) && !conditional)
      return port;
    if (!nets_.contains(net)) nets_[net] = port;
    if (b.shape == Shape::box && b.caption.empty() && !is_symbol(decl.name)) {
      b.caption = shown;
    } else {
      labels_[net] = shown;
    }
    labels_of_port_.insert({port.block, port.port});
    if (options_.rates && graph_net.rate.kind == GraphRate::Kind::discrete && b.shape == Shape::box)
      b.note = rate_text(graph_net.rate);
    return port;
  }

  // For a net that reaches here from elsewhere, and for circles of names.
  SheetPort placeholder(std::uint32_t net) {
    SheetBlock b;
    const std::string path = plantloop::path_of(g_, g_.nets[net]);
    b.path = path + "@";
    b.shape = Shape::input;
    b.formula = pretty_name(path.substr(path.rfind('.') + 1));
    b.outputs = {""};
    const SheetPort port{add(std::move(b)), 0};
    sources_[net] = port;
    return port;
  }

  // ---- expressions

  SheetPort build(const Expression& e, const std::string& path) {
    if (!reads_signals(e)) return terminal(formula_of(e), path);
    if (e.kind != Kind::name && !reads_nets(e)) return build_box(e, path);  // a waveform
    if (e.kind == Kind::name) return build_name(e, path);
    if (e.kind == Kind::unary && e.text == "+") return build(*e.arguments[0], path);
    if (e.kind == Kind::binary && (e.text == "+" || e.text == "-")) return build_sum(e, path);
    if ((e.kind == Kind::unary && e.text == "-") || (e.kind == Kind::binary && (e.text == "*" || e.text == "/"))) {
      if (const auto port = build_product(e, path)) return *port;
    }
    if (e.kind == Kind::vector) return build_vector(e, path);
    return build_box(e, path);
  }

  SheetPort terminal(Formula formula, const std::string& path) {
    SheetBlock b;
    b.path = path;
    b.shape = Shape::value;
    b.formula = std::move(formula);
    b.outputs = {""};
    return {add(std::move(b)), 0};
  }

  SheetPort build_name(const Expression& e, const std::string& path) {
    const Reference& r = *meaning(e);
    if (r.kind == Reference::Kind::time) return terminal("t", path + "t");
    if (r.whole) return source_of(r.index);
    return build_box(e, path);
  }

  static void flatten(const Expression& e, bool inverse, const char* direct, const char* opposite,
                      std::vector<Part>& into) {
    if (e.kind == Kind::binary && e.text == direct) {
      flatten(*e.arguments[0], inverse, direct, opposite, into);
      flatten(*e.arguments[1], inverse, direct, opposite, into);
    } else if (e.kind == Kind::binary && e.text == opposite) {
      flatten(*e.arguments[0], inverse, direct, opposite, into);
      flatten(*e.arguments[1], !inverse, direct, opposite, into);
    } else {
      into.push_back({&e, inverse});
    }
  }

  SheetPort build_sum(const Expression& e, const std::string& path) {
    std::vector<Part> terms;
    flatten(e, false, "+", "-", terms);
    SheetBlock b;
    b.path = path;
    b.shape = Shape::circle;
    b.outputs = {""};
    for (Part& term : terms) {
      // -k*x is k*x subtracted.
      while (term.node->kind == Kind::unary && term.node->text == "-") {
        term.node = term.node->arguments[0].get();
        term.inverse = !term.inverse;
      }
      b.inputs.emplace_back(term.inverse ? "−" : "+");
    }
    const int index = add(std::move(b));
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const SheetPort from = build(*terms[i].node, fmt::format("{}+{}", path, i + 1));
      wire_from(from).to.push_back({index, static_cast<int>(i)});
    }
    return {index, 0};
  }

  // Constant factors as a gain, signals as a circle; nothing when a quotient of signals is better read as a formula.
  std::optional<SheetPort> build_product(const Expression& e, const std::string& path) {
    std::vector<Part> factors;
    bool minus = false;
    collect_factors(e, false, factors, minus);
    std::vector<Part> numbers, signals;
    for (const Part& f : factors) (reads_signals(*f.node) ? signals : numbers).push_back(f);
    const bool quotient = std::any_of(signals.begin(), signals.end(), [](const Part& p) { return p.inverse; });
    if (quotient && signals.size() == 1) return std::nullopt;
    if (signals.size() > 3) return std::nullopt;
    SheetPort port;
    const bool has_gain = !numbers.empty() || minus;
    if (signals.size() == 1) {
      port = build(*signals[0].node, has_gain ? path + "*" : path);
    } else {
      SheetBlock b;
      b.path = has_gain ? path + "*" : path;
      b.shape = Shape::circle;
      b.outputs = {""};
      for (const Part& f : signals) b.inputs.emplace_back(f.inverse ? "÷" : "×");
      const int index = add(std::move(b));
      for (std::size_t i = 0; i < signals.size(); ++i) {
        const SheetPort from = build(*signals[i].node, fmt::format("{}*{}", path, i + 1));
        wire_from(from).to.push_back({index, static_cast<int>(i)});
      }
      port = {index, 0};
    }
    if (!has_gain) return port;
    SheetBlock gain;
    gain.path = path;
    gain.shape = Shape::gain;
    gain.formula = gain_formula(numbers, minus);
    gain.inputs = {""};
    gain.outputs = {""};
    const int index = add(std::move(gain));
    wire_from(port).to.push_back({index, 0});
    return SheetPort{index, 0};
  }

  static void collect_factors(const Expression& e, bool inverse, std::vector<Part>& into, bool& minus) {
    if (e.kind == Kind::unary && e.text == "-") {
      minus = !minus;
      collect_factors(*e.arguments[0], inverse, into, minus);
    } else if (e.kind == Kind::binary && (e.text == "*" || e.text == "/")) {
      collect_factors(*e.arguments[0], inverse, into, minus);
      collect_factors(*e.arguments[1], e.text == "/" ? !inverse : inverse, into, minus);
    } else {
      into.push_back({&e, inverse});
    }
  }

  static Formula gain_formula(const std::vector<Part>& numbers, bool minus) {
    std::vector<Formula> over, under;
    const Expression* before[2] = {nullptr, nullptr};
    const auto below = std::count_if(numbers.begin(), numbers.end(), [](const Part& p) { return p.inverse; });
    const auto above = static_cast<std::ptrdiff_t>(numbers.size()) - below;
    for (const Part& p : numbers) {
      // A sum needs brackets only beside others, or behind a minus.
      const bool is_factor = (p.inverse ? below : above) > 1 || (minus && below == 0);
      std::vector<Formula>& into = p.inverse ? under : over;
      if (const Expression* last = before[p.inverse]) {
        const bool dot = p.node->kind == Kind::number || is_word(*p.node) || is_word(*last);
        into.emplace_back(dot ? " · " : " ");
      }
      into.push_back(formula_of(*p.node, {}, is_factor));
      before[p.inverse] = p.node;
    }
    if (over.empty()) over.emplace_back("1");
    Formula top(Formula::Kind::row, std::move(over));
    if (!under.empty()) {
      Formula bottom(Formula::Kind::row, std::move(under));
      top = Formula(Formula::Kind::fraction, {std::move(top), std::move(bottom)});
    }
    if (!minus) return top;
    if (top.kind == Formula::Kind::row && top.parts.size() == 1 && top.parts[0].text == "1") return "−1";
    return {Formula::Kind::row, {"−", std::move(top)}};
  }
  static bool is_word(const Expression& e) { return e.kind == Kind::name && !is_symbol(e.parts.back()); }

  SheetPort build_vector(const Expression& e, const std::string& path) {
    SheetBlock b;
    b.path = path;
    b.shape = Shape::bar;
    b.outputs = {""};
    b.inputs.assign(e.arguments.size(), "");
    const int index = add(std::move(b));
    for (std::size_t i = 0; i < e.arguments.size(); ++i) {
      const SheetPort from = build(*e.arguments[i], fmt::format("{},{}", path, i + 1));
      wire_from(from).to.push_back({index, static_cast<int>(i)});
    }
    return {index, 0};
  }

  // The whole expression as a formula over the signals that it reads.
  SheetPort build_box(const Expression& e, const std::string& path, bool later = false) {
    std::vector<std::uint32_t> read;
    std::map<std::uint32_t, std::string> text;
    collect(e, read, text);
    SheetBlock b;
    b.path = path;
    b.formula = formula_of(e, [this](const Expression& name, bool is_factor) { return element_of(name, is_factor); });
    b.outputs = {""};
    for (const std::uint32_t net : read) b.inputs.push_back(text[net]);
    const FormulaSize size = measure(b.formula, sheet_style.text);
    if (size.width > 420) {
      std::vector<Formula> words{"f("};
      for (std::size_t i = 0; i < read.size(); ++i) words.emplace_back((i > 0 ? ", " : "") + text[read[i]]);
      words.emplace_back(")");
      b.formula = Formula(Formula::Kind::row, std::move(words));
    }
    const int index = add(std::move(b));
    for (std::size_t i = 0; i < read.size(); ++i) {
      if (later)
        unwired_.push_back({read[i], {index, static_cast<int>(i)}});
      else
        wire_from(source_of(read[i])).to.push_back({index, static_cast<int>(i)});
    }
    return {index, 0};
  }

  std::optional<Formula> element_of(const Expression& name, bool) const {
    const Reference* r = meaning(name);
    if (r != nullptr && r->kind == Reference::Kind::time) return Formula("t");
    return std::nullopt;
  }

  void collect(const Expression& e, std::vector<std::uint32_t>& read,
               std::map<std::uint32_t, std::string>& text) const {
    if (e.kind == Kind::name) {
      const Reference* r = meaning(e);
      if (r == nullptr || r->kind != Reference::Kind::net) return;
      if (std::find(read.begin(), read.end(), r->index) == read.end()) read.push_back(r->index);
      std::size_t names = e.parts.size();
      while (names > 1 && e.parts[names - 1][0] >= '0' && e.parts[names - 1][0] <= '9') --names;
      text.emplace(r->index, pretty_name(e.parts[names - 1]));
      return;
    }
    for (const ExpressionPtr& a : e.arguments) collect(*a, read, text);
  }

  // ---- results and labels

  void mark_results() {
    std::set<std::uint32_t> shown;
    if (scope_ == 0) shown = recorded_nets();
    for (const auto& [net, port] : nets_) {
      const bool recorded = shown.contains(net);
      const auto it = wire_at_.find({port.block, port.port});
      const bool unread = it == wire_at_.end();
      if (unread && (block(port).outputs.size() > 1 ? !recorded : scope_ != 0)) continue;
      if (unread && !recorded && ends_.contains(port.block)) continue;
      SheetWire& wire = wire_from(port);
      if (const auto label = labels_.find(net); label != labels_.end()) wire.label = label->second;
      // What leaves the sheet under the same name needs no second label.
      if (std::any_of(wire.to.begin(), wire.to.end(), [&](const SheetPort& to) {
            return block(to).shape == Shape::output && block(to).formula.text == wire.label;
          }))
        wire.label.clear();
      if (recorded || unread) wire.is_shown = true;
      // At its end a result has its name again, unless the block before says it.
      if (const auto result = results_.find(net); result != results_.end()) {
        wire.result = result->second;
      } else {
        wire.result = wire.label;
      }
      if (options_.sizes && g_.nets[net].shape.is_known() && !g_.nets[net].shape.is_scalar()) {
        const plantloop::Shape s = g_.nets[net].shape;
        wire.note = s.rank == 1 ? fmt::format("({})", s.rows) : fmt::format("({} × {})", s.rows, s.columns);
      }
      if (options_.units && !g_.nets[net].unit.empty())
        wire.note += (wire.note.empty() ? "" : " ") + fmt::format("[{}]", g_.nets[net].unit);
      if (const std::string value = value_of(g_.nets[net]); !value.empty())
        wire.note += (wire.note.empty() ? "" : " ") + value;
    }
  }

  // By the paths that a recording may have for the signal: plant.y, and plant for its main output.
  std::string value_of(const GraphNet& net) const {
    if (options_.values.empty()) return {};
    const auto find = [&](const std::string& path, std::string_view output) {
      auto found = options_.values.find(fmt::format("{}.{}", path, output));
      if (found == options_.values.end() && net.port == 0) found = options_.values.find(path);
      return found == options_.values.end() ? std::string() : found->second;
    };
    if (net.kind == GraphNet::Kind::scope_output) {
      const GraphScope& scope = g_.scopes[net.owner];
      return find(scope.path, scope.type->outputs[net.port].name);
    }
    if (net.kind != GraphNet::Kind::output && net.kind != GraphNet::Kind::expression) return {};
    const GraphBlock& from = g_.blocks[net.owner];
    return find(from.path, from.type ? from.type->block->outputs_declared[net.port]->name : std::string_view("y"));
  }

  // Of a block with several outputs only those are drawn that something reads.
  void drop_unread_outputs() {
    for (std::size_t i = 0; i < sheet_.blocks.size(); ++i) {
      SheetBlock& b = sheet_.blocks[i];
      if (b.outputs.size() < 2 || b.inside) continue;
      std::vector<std::string> kept;
      std::vector<std::pair<SheetWire*, int>> moves;
      for (std::size_t port = 0; port < b.outputs.size(); ++port) {
        const auto it = wire_at_.find({static_cast<int>(i), static_cast<int>(port)});
        if (it == wire_at_.end()) continue;
        moves.emplace_back(&sheet_.wires[it->second], static_cast<int>(kept.size()));
        kept.push_back(b.outputs[port]);
      }
      if (kept.empty()) kept.emplace_back("");
      for (const auto& [wire, port] : moves) wire->from.port = port;
      b.outputs = std::move(kept);
    }
  }

  // Signals that `record:`, or else `figures:`, names.
  std::set<std::uint32_t> recorded_nets() const {
    std::set<std::uint32_t> nets;
    const auto take = [&](const Expression* e) {
      const auto at = g_.shown_at.find(e);
      if (at == g_.shown_at.end()) return;
      const BoundExpression& bound = g_.shown[at->second].bound;
      if (!bound.code || !bound.code->is_name()) return;
      const Reference& r = g_.references[bound.first_reference];
      if (r.kind == Reference::Kind::net) nets.insert(r.index);
    };
    for (const RecordDecl& r : g_.model->record) take(r.signal.get());
    if (nets.empty())
      for (const FigureDecl& f : g_.model->figures)
        for (const ExpressionPtr& s : f.signals()) take(s.get());
    return nets;
  }

  const Graph& g_;
  const std::uint32_t scope_;
  const SheetOptions options_;
  Sheet sheet_;
  std::vector<Pending> pending_;
  std::vector<std::pair<std::uint32_t, SheetPort>> unwired_;  // nets, and the inputs that wait for them
  std::set<int> ends_;                                        // blocks that act on the run, not on the diagram
  std::vector<std::uint32_t> named_, fed_;
  std::map<std::uint32_t, const BlockDecl*> names_;             // expression blocks by their nets
  std::map<std::uint32_t, SheetPort> sources_;                  // of every net that has been drawn
  std::map<std::uint32_t, SheetPort> buses_;                    // the bars of buses
  std::vector<std::pair<std::uint32_t, SheetPort>> bus_reads_;  // buses, and the inputs that wait for them
  std::map<std::uint32_t, SheetPort> nets_;                     // the net that gives a port its names
  std::map<std::uint32_t, std::string> labels_, results_;
  std::set<std::pair<int, int>> labels_of_port_;
  std::set<std::uint32_t> building_;
  std::map<std::pair<int, int>, std::size_t> wire_at_;
  std::unordered_map<const Expression*, Reference> meaning_;
};

}  // namespace

Sheet sheet_of(const Graph& graph, std::uint32_t scope, const SheetOptions& options) {
  Sheet sheet = SheetMaker(graph, scope, options).run();
  sheet.title = scope == 0 ? graph.model->title : graph.scopes[scope].path;
  return sheet;
}

}  // namespace plantloop
