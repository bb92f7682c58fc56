// Blocks first, then what feeds each of their inputs.

#include "app/drawing/sheet_maker.h"

#include <algorithm>
#include <utility>

#include "app/drawing/faces.h"
#include "app/drawing/formulas.h"

namespace plantloop {

Sheet SheetMaker::run() {
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

int SheetMaker::add(SheetBlock block) {
  sheet_.blocks.push_back(std::move(block));
  return static_cast<int>(sheet_.blocks.size()) - 1;
}

void SheetMaker::connect_pending() {
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

void SheetMaker::add_inputs(const GraphScope& scope) {
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

void SheetMaker::add_outputs(const GraphScope& scope) {
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

SheetWire& SheetMaker::wire_from(SheetPort from) {
  const auto [it, is_new] = wire_at_.try_emplace({from.block, from.port}, sheet_.wires.size());
  if (is_new) {
    SheetWire wire;
    wire.from = from;
    sheet_.wires.push_back(std::move(wire));
  }
  return sheet_.wires[it->second];
}

void SheetMaker::connect(const BoundExpression& driver, SheetPort to, const std::string& path) {
  bind(driver);
  const SheetPort from = build(*driver.code->tree, path);
  wire_from(from).to.push_back(to);
}

void SheetMaker::bind(const BoundExpression& bound) {
  for (std::size_t i = 0; i < bound.code->names.size(); ++i)
    meaning_[bound.code->names[i]] = g_.references[bound.first_reference + i];
}

const Reference* SheetMaker::meaning(const Expression& name) const {
  const auto it = meaning_.find(&name);
  return it == meaning_.end() ? nullptr : &it->second;
}

bool SheetMaker::reads_signals(const BoundExpression& bound) {
  bind(bound);
  return reads_signals(*bound.code->tree);
}

bool SheetMaker::reads_signals(const Expression& e) const {
  if (e.kind == Kind::name) {
    const Reference* r = meaning(e);
    return r != nullptr && (r->kind == Reference::Kind::net || r->kind == Reference::Kind::time);
  }
  return std::any_of(e.arguments.begin(), e.arguments.end(),
                     [this](const ExpressionPtr& a) { return reads_signals(*a); });
}

bool SheetMaker::reads_nets(const Expression& e) const {
  if (e.kind == Kind::name) {
    const Reference* r = meaning(e);
    return r != nullptr && r->kind == Reference::Kind::net;
  }
  return std::any_of(e.arguments.begin(), e.arguments.end(), [this](const ExpressionPtr& a) { return reads_nets(*a); });
}

SheetPort SheetMaker::source_of(std::uint32_t net) {
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

SheetPort SheetMaker::placeholder(std::uint32_t net) {
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

Sheet sheet_of(const Graph& graph, std::uint32_t scope, const SheetOptions& options) {
  Sheet sheet = SheetMaker(graph, scope, options).run();
  sheet.title = scope == 0 ? graph.model->title : graph.scopes[scope].path;
  return sheet;
}

}  // namespace plantloop
