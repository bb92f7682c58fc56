// What every name means at its place of use.

#include <algorithm>
#include <deque>
#include <limits>
#include <utility>

#include "engine/base/numbers.h"
#include "engine/graph/elaboration.h"

namespace plantloop {
namespace {

using Parts = std::span<const std::string>;

bool is_index(const std::string& part) { return !part.empty() && part[0] >= '0' && part[0] <= '9'; }

class Resolver {
 public:
  Resolver(Elaboration& e, const BoundExpression& bound, Context context)
      : e_(e), g_(e.g), bound_(bound), scope_(bound.scope), context_(context) {}

  Reference find(const Expression& node) {
    node_ = &node;
    const Parts parts(node.parts);
    if (parts[0] == "previous" || parts[0] == "next") return neighbour(parts);
    if (parts.size() == 1) {
      Reference reference;
      if (is_reserved(parts[0], reference)) return reference;
    }
    return in_scope(scope_, parts, true);
  }

 private:
  bool is_reserved(const std::string& name, Reference& reference) {
    const auto number = [&reference](double value) {
      reference.kind = Reference::Kind::number;
      reference.number = value;
      return true;
    };
    // Names that begin with other letters are spared the comparisons.
    switch (name.empty() ? ' ' : name[0]) {
      case 'p':
        return name == "pi" && number(3.14159265358979323846);
      case 'i':
        if (name == "inf") return number(std::numeric_limits<double>::infinity());
        if (name == "index" && bound_.repeat != nowhere) return number(bound_.copy);
        return name == "index" && nothing_here(name, "it is the number of a copy, around a block with `repeat`");
      case 't':
        if (name == "true") return number(1);
        if (name != "time") return false;
        if (context_ == Context::parameter) {
          error("a parameter cannot depend on the time: it has one value for the whole run");
        } else {
          reference.kind = Reference::Kind::time;
        }
        return true;
      case 'f':
        return name == "false" && number(0);
      case 'e':
        return name == "elapsed" && elapsed(reference);
      default:
        return false;
    }
  }
  // The time since the last trigger of what is around.
  bool elapsed(Reference& reference) {
    std::uint32_t a = g_.scopes[scope_].activation;
    while (a != 0 && !g_.activations[a].declaration->trigger) a = g_.activations[a].parent;
    if (a == 0) return nothing_here("elapsed", "it is the time since the last trigger, inside a triggered subsystem");
    if (context_ == Context::parameter) {
      error("a parameter cannot depend on the time: it has one value for the whole run");
      return true;
    }
    reference.kind = Reference::Kind::elapsed;
    reference.index = a;
    return true;
  }
  bool nothing_here(const std::string& name, const char* why) {
    error("'{}' means nothing here: {}", name, why);
    return true;
  }

  // The copy before or after the one around this expression.
  Reference neighbour(Parts parts) {
    const bool before = parts[0] == "previous";
    if (bound_.repeat == nowhere) {
      nothing_here(parts[0], before ? "it is the copy before, around a block with `repeat`"
                                    : "it is the copy behind, around a block with `repeat`");
      return {};
    }
    const GraphRepeat& repeat = g_.repeats[bound_.repeat];
    if (before ? bound_.copy > 1 : bound_.copy < repeat.count)
      return of_copy(repeat, before ? bound_.copy - 1 : bound_.copy + 1, parts.subspan(1));
    error("'{}.{}' is the {} copy: there is no {} one", repeat.path, bound_.copy, before ? "first" : "last", parts[0])
        .hint(before ? "say what it gets instead: first: {input: signal}"
                     : "say what it gets instead: last: {input: signal}")
        .named("repeat");
    return {};
  }

  // `cell.3` and what stands behind it.
  Reference of_copy(const GraphRepeat& repeat, std::uint32_t number, Parts rest) {
    std::vector<std::string>& parts = spelt_.emplace_back();
    parts.push_back(fmt::format("{}.{}", repeat.declaration->name, number));
    parts.insert(parts.end(), rest.begin(), rest.end());
    const GraphChild child = g_.copies[repeat.first_copy + number - 1];
    return child.kind == GraphChild::Kind::block ? of_block(child.index, parts) : of_scope(child.index, parts, false);
  }

  Reference of_repeat(std::uint32_t index, Parts parts) {
    const GraphRepeat& repeat = g_.repeats[index];
    const bool slice = parts.size() == 2 && node_->slice_end > 0;
    if (parts.size() == 1 || slice) {
      if (repeat.net != nowhere) return net(repeat.net, parts);
      error("'{}' has no output", repeat.path);
      return {};
    }
    const std::optional<long> number = parse_integer(parts[1]);
    if (!number) {
      error("'{}' is repeated: its copies are {}.1 to {}.{}", parts[0], parts[0], parts[0], repeat.count)
          .hint(fmt::format("for example {}.1.{}", parts[0], parts[1]))
          .named("repeat");
      return {};
    }
    if (*number >= 1 && *number <= static_cast<long>(repeat.count))
      return of_copy(repeat, static_cast<std::uint32_t>(*number), parts.subspan(2));
    error("there is no copy '{}.{}': '{}' is repeated {} times", parts[0], parts[1], parts[0], repeat.count)
        .named("repeat");
    return {};
  }

  // ---- buses

  std::string members_of(const GraphBus& bus, std::string_view name) const {
    std::string text;
    for (const WireDecl& wire : bus.declaration->in)
      text += fmt::format("{}{}.{}", text.empty() ? "" : ", ", name, wire.port);
    return text;
  }

  Reference of_bus(std::uint32_t index, Parts parts) {
    const GraphBus& bus = g_.buses[index];
    if (parts.size() == 1) {
      error("'{}' is a bus, a group of signals: read one of them", parts[0])
          .hint("it has: " + members_of(bus, parts[0]))
          .named("bus");
      return {};
    }
    std::vector<std::string> names;
    for (std::uint32_t i = 0; i < bus.declaration->in.size(); ++i) {
      if (bus.declaration->in[i].port == parts[1]) return net(bus.first_member + i, parts.subspan(1));
      names.push_back(bus.declaration->in[i].port);
    }
    error("the bus '{}' has no '{}'", parts[0], parts[1]).suggest(parts[1], names).named("bus");
    return {};
  }

  Reference in_scope(std::uint32_t s, Parts parts, bool first) {
    const GraphScope& scope = g_.scopes[s];
    const TypeTable& table = e_.table_of(*scope.type);
    const auto found = table.names.find(parts[0]);
    if (found == table.names.end()) return unknown(s, parts, first);
    const std::uint32_t i = found->second.index;
    switch (found->second.kind) {
      case TypeName::Kind::parameter:
        return parameter(scope.first_parameter + i, parts);
      case TypeName::Kind::input:
        if (parts.size() > 1 && !is_index(parts[1]) && g_.nets[scope.first_input + i].bus == nowhere) {
          error("'{}' is an input: it has elements, {}.1, but no '{}'", parts[0], parts[0], parts[1]);
          return {};
        }
        return net(scope.first_input + i, parts);
      case TypeName::Kind::block:
        break;
    }
    const GraphChild child = g_.children[scope.first_child + i];
    switch (child.kind) {
      case GraphChild::Kind::block:
        return of_block(child.index, parts);
      case GraphChild::Kind::scope:
        return of_scope(child.index, parts, first);
      case GraphChild::Kind::repeat:
        return of_repeat(child.index, parts);
      case GraphChild::Kind::bus:
        return of_bus(child.index, parts);
      case GraphChild::Kind::bad:
        break;
    }
    return {};  // its block has been reported
  }

  Reference of_block(std::uint32_t index, Parts parts) {
    const GraphBlock& block = g_.blocks[index];
    if (parts.size() == 1 || is_index(parts[1])) {
      if (block.outputs == 0) {
        error("{} has no output", title_of(g_, block));
        return {};
      }
      return net(block.first_output, parts);
    }
    if (!block.type) {
      error("'{}' is an expression: it has one value and no '{}'", parts[0], parts[1]);
      return {};
    }
    const BlockTable& table = e_.table_of(*block.type);
    if (const auto output = table.outputs.find(parts[1]); output != table.outputs.end()) {
      return net(block.first_output + output->second, parts.subspan(1));
    }
    const auto found = table.names.find(parts[1]);
    if (found != table.names.end()) {
      const Block& kind = *block.type->block;
      switch (found->second.kind) {
        case BlockName::Kind::number:
          return instance_parameter(block.first_parameter + found->second.index, parts);
        case BlockName::Kind::table:
          return instance_parameter(
              block.first_parameter + static_cast<std::uint32_t>(kind.numbers.size()) + found->second.index, parts);
        case BlockName::Kind::count:
          return instance_parameter(block.first_parameter +
                                        static_cast<std::uint32_t>(kind.numbers.size() + kind.tables.size()) +
                                        found->second.index,
                                    parts);
        case BlockName::Kind::input:
          if (context_ == Context::inside) return net(block.first_input + found->second.index, parts.subspan(1));
          error("'{}' is an input of {}: read what feeds it", parts[1], title_of(g_, block));
          return {};
        default:
          break;
      }
    }
    std::vector<std::string> names;
    for (const Output* output : block.type->block->outputs_declared) names.emplace_back(output->name);
    Finding& finding = error("{} has no output '{}'", title_of(g_, block), parts[1]);
    if (!names.empty()) finding.suggest(parts[1], names);
    return {};
  }

  Reference of_scope(std::uint32_t index, Parts parts, bool first) {
    const GraphScope& scope = g_.scopes[index];
    const TypeTable& table = e_.table_of(*scope.type);
    if (parts.size() == 1 || is_index(parts[1])) {
      if (scope.type->outputs.empty()) {
        error("'{}' ({}) has no outputs", scope.path, scope.type->name)
            .hint(fmt::format("give the type '{}' outputs: [...]", scope.type->name));
        return {};
      }
      return net(scope.first_output, parts);
    }
    if (const auto output = table.outputs.find(parts[1]); output != table.outputs.end()) {
      return net(scope.first_output + output->second, parts.subspan(1));
    }
    const auto found = table.names.find(parts[1]);
    if (context_ == Context::inside) {
      if (found == table.names.end()) return unknown(index, parts.subspan(1), false);
      return in_scope(index, parts.subspan(1), false);
    }
    if (found != table.names.end() && found->second.kind == TypeName::Kind::parameter) {
      return instance_parameter(scope.first_parameter + found->second.index, parts);
    }
    if (found != table.names.end()) {
      const bool is_input = found->second.kind == TypeName::Kind::input;
      Finding& finding = error("wires do not reach inside '{}' ({})", parts[0], scope.type->name);
      if (is_input) {
        finding.hint(fmt::format("'{}' is its input: read what feeds it", parts[1]));
      } else {
        finding.hint(fmt::format("add '{}' to the outputs of the type '{}', then {}.{} can be read", parts[1],
                                 scope.type->name, parts[0], parts[1]));
      }
      finding.named("reach-inside");
      return {};
    }
    std::vector<std::string> names;
    for (const OutputDecl& output : scope.type->outputs) names.push_back(output.name);
    Finding& finding = error("'{}' ({}) has no output '{}'", parts[0], scope.type->name, parts[1]);
    if (!names.empty()) finding.suggest(parts[1], names);
    finding.named("unknown-output");
    (void)first;
    return {};
  }

  Reference instance_parameter(std::uint32_t index, Parts parts) {
    if (context_ == Context::wire) {
      error("'{}.{}' is a parameter of '{}': wires read signals", parts[0], parts[1], parts[0])
          .hint("parameters of an instance can be read in parameters and in initial:")
          .named("parameter-in-wire");
      return {};
    }
    return parameter(index, parts.subspan(1));
  }

  Reference parameter(std::uint32_t index, Parts parts) {
    const GraphParameter& p = g_.parameters[index];
    if (p.text != nowhere) {
      error("'{}' is a text, not a number", parts[0]).hint(fmt::format("write ${} where a text is expected", parts[0]));
      return {};
    }
    if (!p.is_set) {
      if (!p.bad) error("'{}' has no value here", to_string(*node_));
      return {};
    }
    Reference reference;
    reference.kind = Reference::Kind::parameter;
    reference.index = index;
    return elements(reference, parts) ? reference : Reference{};
  }

  Reference net(std::uint32_t index, Parts parts) {
    if (g_.nets[index].bus != nowhere) return of_bus(g_.nets[index].bus, parts);
    if (context_ == Context::parameter) {
      error("a parameter cannot read the signal '{}': it has one value for the whole run", to_string(*node_))
          .hint("only wires and initial: read signals")
          .named("signal-in-parameter");
      return {};
    }
    Reference reference;
    reference.kind = Reference::Kind::net;
    reference.index = index;
    return elements(reference, parts) ? reference : Reference{};
  }

  // What stands behind the name: `.3`, `.1:99`, `.1.2`.
  bool elements(Reference& reference, Parts parts) {
    if (parts.size() == 1) return true;
    long index[2] = {0, 0};
    if (parts.size() > 3) {
      error("'{}' has too many parts: elements are {}.3 of a vector and {}.1.2 of a matrix", to_string(*node_),
            parts[0], parts[0]);
      return false;
    }
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const std::optional<long> number = parse_integer(parts[i]);
      if (!number) {
        error("'{}' has elements, {}.1, but no '{}'", parts[0], parts[0], parts[i]);
        return false;
      }
      if (*number < 1 || *number > 1000000000) {
        error("elements are counted from 1: there is no {}", to_string(*node_));
        return false;
      }
      index[i - 1] = *number;
    }
    reference.whole = false;
    reference.first = static_cast<std::int32_t>(index[0]);
    reference.column = static_cast<std::int32_t>(index[1]);
    reference.last = static_cast<std::int32_t>(std::min(node_->slice_end, 1000000000L));
    if (reference.last > 0 && reference.column > 0) {
      error("a slice is taken of a vector: {}", to_string(*node_));
      return false;
    }
    if (reference.last > 0 && reference.last < reference.first) {
      error("the slice {} ends before it begins", to_string(*node_));
      return false;
    }
    return true;
  }

  // What other tools call by this name.
  static std::string_view familiar_name(std::string_view name) {
    constexpr std::pair<std::string_view, std::string_view> pairs[] = {
        {"t", "time"},
        {"e", "exp(x) for a power of Euler's number, exp(1) for the number"},
        {"yes", "true"},
        {"on", "true"},
        {"no", "false"},
        {"off", "false"},
        {"nan", "a number; there is no nan"},
        {"NaN", "a number; there is no nan"},
        {"Inf", "inf"},
        {"infinity", "inf"},
        {"null", "a number"},
        {"none", "a number"},
        {"M_PI", "pi"}};
    for (const auto& [other, ours] : pairs) {
      if (other == name) return ours;
    }
    return {};
  }

  Reference unknown(std::uint32_t s, Parts parts, bool own_scope) {
    const GraphScope& scope = g_.scopes[s];
    const TypeDecl& type = *scope.type;
    // One name may be missing in many places; the first one is enough for it.
    if (own_scope && !e_.unknown_names.emplace(&type, std::string(parts[0])).second) return {};
    std::vector<std::string> names;
    const bool parameters_only = context_ == Context::parameter;
    for (const ParameterDecl& p : type.parameters) names.push_back(p.name);
    if (!parameters_only) {
      for (const InputDecl& p : type.inputs) names.push_back(p.name);
      for (const BlockDecl& b : type.blocks) names.push_back(b.name);
    }
    std::vector<std::string> candidates = names;
    if (own_scope) candidates.insert(candidates.end(), {"pi", "inf", "true", "false"});
    if (own_scope && !parameters_only) candidates.emplace_back("time");
    const std::string near = nearest(parts[0], candidates);
    if (!own_scope) {
      error("'{}' ({}) has no '{}'", scope.path, type.name, parts[0]).suggest(parts[0], names).named("unknown-name");
      return {};
    }
    Finding& finding =
        s == 0 ? error("there is no '{}'", parts[0]) : error("there is no '{}' in the type '{}'", parts[0], type.name);
    finding.named("unknown-name");
    if (const std::string_view ours = familiar_name(parts[0]); !ours.empty()) {
      finding.hint(fmt::format("write {}", ours));
    } else if (!near.empty()) {
      finding.hint(fmt::format("did you mean '{}'?", near));
    } else if (s != 0 && e_.table_of(*g_.scopes[0].type).names.contains(parts[0])) {
      finding.hint("a type sees only its own parameters, inputs and blocks: hand it in as an input or a parameter");
    } else if (names.size() <= 12 && !names.empty()) {
      finding.suggest(parts[0], names);
    }
    return {};
  }

  template <typename... Args>
  Finding& error(fmt::format_string<Args...> text, Args&&... args) {
    return e_.findings.error(node_->mark, text, std::forward<Args>(args)...);
  }

  Elaboration& e_;
  Graph& g_;
  const BoundExpression& bound_;
  std::uint32_t scope_;
  Context context_;
  std::deque<std::vector<std::string>> spelt_;  // names with the copy that `previous` means
  const Expression* node_ = nullptr;
};

// The default of an input or one set like a parameter is a number that can be set, unless it reads signals.
void make_parameter(Elaboration& e, std::uint32_t index, std::string_view name) {
  Graph& g = e.g;
  GraphNet& net = g.nets[index];
  for (std::size_t i = 0; i < net.driver.code->names.size(); ++i) {
    const Reference::Kind kind = g.references[net.driver.first_reference + i].kind;
    if (kind == Reference::Kind::net || kind == Reference::Kind::time) return;
  }
  net.by_parameter = true;
  net.parameter = static_cast<std::uint32_t>(g.parameters.size());
  GraphParameter& p = g.parameters.emplace_back();
  p.name = name;
  p.owner = net.owner;
  p.of_scope = net.kind == GraphNet::Kind::scope_input;
  p.expression = net.driver;
  p.literal = net.driver.code->literal;
  p.unit = net.unit;
  p.mark = net.mark;
  p.bad = net.bad;
  p.is_default = !net.is_connected;
}

void resolve_parameters(Elaboration& e) {
  Graph& g = e.g;
  for (GraphParameter& p : g.parameters) {
    if (!p.expression) continue;
    p.literal = p.expression.code->literal;
    Context context = Context::parameter;
    if (!p.of_scope) {
      const GraphBlock& block = g.blocks[p.owner];
      const auto slot = static_cast<std::size_t>(&p - &g.parameters[block.first_parameter]);
      const Block& kind = *block.type->block;
      const bool initial = slot < kind.numbers.size() ? kind.numbers[slot]->spec.initial
                           : slot < kind.numbers.size() + kind.tables.size()
                               ? kind.tables[slot - kind.numbers.size()]->spec.initial
                               : false;
      if (initial) context = Context::initial;
    }
    p.bad |= !resolve(e, p.expression, context);
    if (context != Context::initial) continue;
    for (std::size_t i = 0; i < p.expression.code->names.size(); ++i) {
      const Reference& r = g.references[p.expression.first_reference + i];
      p.reads_signals |= r.kind == Reference::Kind::net || r.kind == Reference::Kind::time ||
                         (r.kind == Reference::Kind::parameter && g.parameters[r.index].reads_signals);
    }
  }
}

}  // namespace

bool resolve(Elaboration& e, BoundExpression& bound, Context context) {
  bound.first_reference = static_cast<std::uint32_t>(e.g.references.size());
  if (!bound.code) return false;
  if (bound.code->names.empty()) return true;
  Resolver resolver(e, bound, context);
  bool sound = true;
  for (const Expression* name : bound.code->names) {
    const Reference reference = resolver.find(*name);
    sound &= reference.kind != Reference::Kind::missing;
    e.g.references.push_back(reference);
  }
  return sound;
}

void resolve_names(Elaboration& e) {
  Graph& g = e.g;
  find_buses(e);
  resolve_parameters(e);
  for (BoundExpression& bound : e.counts) resolve(e, bound, Context::parameter);
  const std::size_t count = g.nets.size();
  for (std::uint32_t i = 0; i < count; ++i) {
    GraphNet& net = g.nets[i];
    if (!net.driver) continue;
    net.bad |= !resolve(e, net.driver, Context::wire);
    if (net.kind == GraphNet::Kind::scope_input && net.bus == nowhere) {
      const InputDecl& input = g.scopes[net.owner].type->inputs[net.port];
      if (input.fallback) make_parameter(e, i, input.name);
    } else if (net.kind == GraphNet::Kind::block_input) {
      const Block& kind = *g.blocks[net.owner].type->block;
      if (kind.lists.empty() && kind.inputs[net.port]->spec.init == kind.inputs[net.port]->spec.init) {
        make_parameter(e, i, kind.inputs[net.port]->name);
      }
    }
  }
  const auto resets = [&e](auto& owner) {
    if (owner.reset_when) resolve(e, owner.reset_when, Context::wire);
    if (owner.reset_to) resolve(e, owner.reset_to, Context::initial);
  };
  for (std::size_t a = 1; a < g.activations.size(); ++a) {
    GraphActivation& activation = g.activations[a];
    if (activation.enable_when) resolve(e, activation.enable_when, Context::wire);
    if (activation.trigger_when) resolve(e, activation.trigger_when, Context::wire);
    for (BoundExpression& initial : activation.initials) {
      if (initial) resolve(e, initial, Context::initial);
    }
  }
  for (GraphBlock& block : g.blocks) resets(block);
  for (GraphScope& scope : g.scopes) resets(scope);
}

}  // namespace plantloop
