// First quietly over all recorded operations, which gives every signal the unit that can be known; then over the
// expressions as they are written, so that what is said has a place in the file.

#include "engine/graph/check_units.h"

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engine/graph/findings.h"
#include "engine/graph/unit_facts.h"

namespace plantloop {
namespace {

bool compares(Op op) {
  switch (op) {
    case Op::add:
    case Op::sub:
    case Op::min:
    case Op::max:
    case Op::less:
    case Op::less_equal:
    case Op::equal:
    case Op::where:
    case Op::hypot:
    case Op::mod:
    case Op::atan2:
      return true;
    default:
      return false;
  }
}

// A temperature and a difference of temperatures may be added.
bool really_clash(Op op, const UnitFact& a, const UnitFact& b) {
  if (!clash(a, b)) return false;
  const bool of_temperatures = a.unit.same_dimension(b.unit) && (a.unit.offset != 0) != (b.unit.offset != 0);
  if (of_temperatures && op == Op::add) return a.unit.factor != b.unit.factor;
  return !(of_temperatures && op == Op::sub && a.unit.offset != 0) || a.unit.factor != b.unit.factor;
}

// The units of all nodes of the record, as far as they follow from what is stated.
class NodeUnits {
 public:
  NodeUnits(const Graph& graph, const RecordedGraph& recorded)
      : record_(recorded.record), facts_(record_.nodes.size()) {
    claim(graph);
    // Units only become known, and each does so once; loops through states are short.
    for (bool changed = true; changed;) {
      changed = false;
      for (std::uint32_t id = 0; id < record_.nodes.size(); ++id) {
        if (facts_[id].is_known()) continue;
        const UnitFact now = fact_of(id);
        if (now.kind == facts_[id].kind) continue;
        facts_[id] = now;
        changed = changed || now.is_known();
      }
    }
  }

  UnitFact of(Value value) const { return value.is_known() ? UnitFact::literal(value.number()) : facts_[value.id()]; }
  UnitFact of_node(std::uint32_t id) const { return facts_[id]; }
  // Of a signal with its elements: known when all have one unit.
  UnitFact of_net(const std::string& path) const {
    const auto found = by_name_.find(path);
    return found != by_name_.end() ? found->second : UnitFact{};
  }
  void gather(const RecordedGraph& recorded) {
    for (const RecordedSignal& signal : recorded.record.signals) {
      const UnitFact fact = of(signal.value);
      add(signal.name, fact, false);
      // `T.3` belongs to `T`, `A.1.2` to `A`.
      std::string whole = signal.name;
      for (int level = 0; level < 2; ++level) {
        const std::size_t dot = whole.rfind('.');
        if (dot == std::string::npos || dot + 1 >= whole.size() || whole[dot + 1] < '0' || whole[dot + 1] > '9') break;
        whole.resize(dot);
        add(whole, fact, true);
      }
    }
  }

 private:
  void add(const std::string& name, const UnitFact& fact, bool part) {
    const auto [it, is_new] = by_name_.try_emplace(name, fact);
    if (is_new || !part) return;
    if (!it->second.is_known() || !fact.is_known() || clash(it->second, fact)) it->second = {};
  }

  // What the file says of a signal that an equation or an expression makes; another name of it claims nothing.
  void claim(const Graph& graph) {
    std::unordered_map<std::string_view, const RecordedSignal*> by_name;
    for (const RecordedSignal& signal : record_.signals) by_name.emplace(signal.name, &signal);
    for (const GraphNet& net : graph.nets) {
      if (net.unit.empty() || net.bus != nowhere) continue;
      const bool made_here =
          net.kind == GraphNet::Kind::output || (net.kind == GraphNet::Kind::expression && !net.driver.code->is_name());
      if (!made_here) continue;
      const std::string path = path_of(graph, net);
      const auto give = [&](const std::string& name) {
        const auto found = by_name.find(name);
        if (found == by_name.end() || found->second->value.is_known()) return false;
        const std::uint32_t id = found->second->value.id();
        if (record_.nodes[id].op != Op::parameter) facts_[id] = UnitFact::of_text(net.unit);
        return true;
      };
      if (give(path)) continue;
      for (int i = 1; i <= net.shape.size(); ++i) {
        give(net.shape.rank == 1
                 ? fmt::format("{}.{}", path, i)
                 : fmt::format("{}.{}.{}", path, (i - 1) / net.shape.columns + 1, (i - 1) % net.shape.columns + 1));
      }
    }
  }

  UnitFact fact_of(std::uint32_t id) const {
    const RecordedNode& node = record_.nodes[id];
    const auto operand = [&](std::uint32_t i) { return facts_[i]; };
    switch (node.op) {
      case Op::constant:
        return UnitFact::literal(record_.constants[node.a]);
      case Op::parameter:
        return UnitFact::of_text(record_.parameters[node.a].unit);
      case Op::time:
      case Op::step:
        return UnitFact::of_text("s");
      case Op::state: {
        const RecordedState& state = record_.states[node.a];
        if (!state.unit.empty()) return UnitFact::of_text(state.unit);
        const UnitFact rate = of(state.derivative);
        return rate.is_known() ? times_seconds(rate) : UnitFact{};
      }
      case Op::discrete: {
        const RecordedDiscrete& state = record_.discretes[node.a];
        if (!state.unit.empty()) return UnitFact::of_text(state.unit);
        const UnitFact next = of(state.next);
        return next.is_known() ? next : UnitFact{};
      }
      case Op::wire:
        return of(record_.wires[node.a]);
      default:
        break;
    }
    if (is_leaf(node.op) || is_compound(node.op) || is_result(node.op)) return {};
    const int arity = arity_of(node.op);
    return unit_after(node.op, operand(node.a), arity > 1 ? operand(node.b) : UnitFact{},
                      arity > 2 ? operand(node.c) : UnitFact{});
  }

  const Record& record_;
  std::vector<UnitFact> facts_;
  std::unordered_map<std::string, UnitFact> by_name_;
};

class UnitChecks {
 public:
  UnitChecks(const Graph& graph, const RecordedGraph& recorded, Findings& findings)
      : g_(graph), record_(recorded.record), findings_(findings), units_(graph, recorded) {
    units_.gather(recorded);
  }

  void run() {
    for (const GraphParameter& p : g_.parameters) parameter(p);
    for (const GraphNet& net : g_.nets) this->net(net);
    for (const GraphBlock& block : g_.blocks) conditions(block.reset_when, block.reset_to);
    for (const GraphScope& scope : g_.scopes) conditions(scope.reset_when, scope.reset_to);
    for (std::size_t a = 1; a < g_.activations.size(); ++a)
      conditions(g_.activations[a].enable_when, g_.activations[a].trigger_when);
    for (const GraphShown& shown : g_.shown) expression(shown.bound);
    blocks();
    states();
  }

 private:
  // ---- expressions

  struct Operand {
    UnitFact fact;
    const Expression* node = nullptr;
    Mark origin;  // where the unit was stated; of an operand that is a name
  };

  Operand of_name(const BoundExpression& bound, const Step& step) {
    const Reference& r = g_.references[bound.first_reference + step.name];
    Operand operand{{}, step.node, {}};
    switch (r.kind) {
      case Reference::Kind::number:
        operand.fact = UnitFact::literal(r.number);
        break;
      case Reference::Kind::time:
      case Reference::Kind::elapsed:
        operand.fact = UnitFact::of_text("s");
        break;
      case Reference::Kind::parameter: {
        const GraphParameter& p = g_.parameters[r.index];
        operand.fact = of_parameter(p);
        operand.origin = p.mark;
        break;
      }
      case Reference::Kind::net: {
        const GraphNet& net = g_.nets[r.index];
        operand.fact = of_net(net);
        if (!net.unit.empty()) operand.origin = net.mark;
        break;
      }
      case Reference::Kind::missing:
        break;
    }
    return operand;
  }

  UnitFact of_parameter(const GraphParameter& p) {
    if (!p.unit.empty()) return UnitFact::of_text(p.unit);
    if (!p.expression || p.literal || p.text != nowhere || depth_ > 50) return {};
    ++depth_;
    const UnitFact fact = quiet(p.expression);
    --depth_;
    return fact.is_known() ? fact : UnitFact{};
  }

  UnitFact of_net(const GraphNet& net) const {
    if (!net.unit.empty()) return UnitFact::of_text(net.unit);
    if (net.bus != nowhere) return {};
    return units_.of_net(path_of(g_, net));
  }

  UnitFact quiet(const BoundExpression& bound) {
    const bool before = std::exchange(quiet_, true);
    const UnitFact fact = expression(bound);
    quiet_ = before;
    return fact;
  }

  UnitFact expression(const BoundExpression& bound) {
    if (!bound) return {};
    std::vector<Operand> stack;
    for (const Step& step : bound.code->steps) {
      if (step.kind == Step::Kind::number) {
        stack.push_back({UnitFact::literal(step.number), step.node, {}});
        continue;
      }
      if (step.kind == Step::Kind::name) {
        stack.push_back(of_name(bound, step));
        continue;
      }
      const std::size_t count = step.kind == Step::Kind::unary     ? 1
                                : step.kind == Step::Kind::binary  ? 2
                                : step.kind == Step::Kind::ternary ? 3
                                                                   : step.arguments;
      const std::vector<Operand> arguments(stack.end() - static_cast<std::ptrdiff_t>(count), stack.end());
      stack.resize(stack.size() - count);
      stack.push_back({result(step, arguments), step.node, {}});
    }
    return stack.empty() ? UnitFact{} : stack.back().fact;
  }

  UnitFact result(const Step& step, const std::vector<Operand>& arguments) {
    const auto fact = [&](std::size_t i) { return i < arguments.size() ? arguments[i].fact : UnitFact{}; };
    if (step.kind == Step::Kind::unary) return unit_after(step.op, fact(0), {}, {});
    if (step.kind == Step::Kind::binary) {
      if (compares(step.op)) meet(step, step.op, arguments[0], arguments[1]);
      return unit_after(step.op, fact(0), fact(1), {});
    }
    if (step.kind == Step::Kind::ternary) {
      meet(step, Op::where, arguments[1], arguments[2]);
      return unit_after(step.op, fact(0), fact(1), fact(2));
    }
    if (step.kind == Step::Kind::join) return all_alike(arguments);
    switch (step.function) {
      case Function::extreme:
      case Function::clamp: {
        UnitFact common = fact(0);
        for (std::size_t i = 1; i < arguments.size(); ++i) {
          meet(step, Op::min, arguments[0], arguments[i]);
          common = unit_of_either(common, fact(i));
        }
        return common;
      }
      case Function::dot:
      case Function::mul:
        return unit_after(Op::mul, fact(0), fact(1), {});
      case Function::sum:
      case Function::transpose:
        return fact(0);
      case Function::norm:
        return unit_after(Op::abs, fact(0), {}, {});
      case Function::zeros:
      case Function::ones:
      case Function::eye:
        return UnitFact::literal(0);
      case Function::expm1:
      case Function::log1p:
        return unit_after(Op::exp, fact(0), {}, {});
    }
    return {};
  }

  // Elements of a vector may have units of their own.
  static UnitFact all_alike(const std::vector<Operand>& entries) {
    if (entries.empty()) return {};
    UnitFact common = entries[0].fact;
    for (const Operand& entry : entries) {
      if (entry.fact.kind != common.kind || clash(entry.fact, common)) return {};
    }
    return common;
  }

  static const char* in_words(const Step& step, Op op) {
    if (op == Op::add) return "are added";
    if (op == Op::sub) return "are subtracted";
    if (op == Op::where) return "are alternatives";
    (void)step;
    return "are compared";
  }

  // Two numbers that must have one unit.
  void meet(const Step& step, Op op, const Operand& a, const Operand& b) {
    if (quiet_) return;
    const std::string left = to_string(*a.node), right = to_string(*b.node);
    if (really_clash(op, a.fact, b.fact)) {
      Finding& finding = findings_.check("unit-clash", step.node->mark, "'{}' in {} and '{}' in {} {}", left,
                                         unit_text(a.fact.unit), right, unit_text(b.fact.unit), in_words(step, op));
      explain(finding, a, b);
      return;
    }
    lonely(step.node->mark, a, b, in_words(step, op));
  }

  // Known meets unknown: for those who want to hear of it.
  void lonely(const Mark& mark, const Operand& a, const Operand& b, const char* how) {
    for (const auto& [one, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
      if (!one->fact.is_known() || other->fact.kind != UnitFact::Kind::unknown) continue;
      findings_.check("units", mark, "'{}' in {} and '{}' without a unit {}", to_string(*one->node),
                      unit_text(one->fact.unit), to_string(*other->node), how);
    }
  }

  void explain(Finding& finding, const Operand& a, const Operand& b) {
    if (a.fact.unit.same_dimension(b.fact.unit)) {
      if (const auto text = conversion(as_factor(*a.node), a.fact.unit, b.fact.unit))
        finding.hint(
            fmt::format("numbers are never converted: write {} for a number in {}", *text, unit_text(b.fact.unit)));
    } else {
      finding.hint(fmt::format("{} is {}, {} is {}", unit_text(a.fact.unit), dimension_text(a.fact.unit),
                               unit_text(b.fact.unit), dimension_text(b.fact.unit)));
    }
    for (const Operand* operand : {&a, &b}) {
      if (operand->origin.source)
        finding.also(operand->origin,
                     fmt::format("'{}' is in {}", to_string(*operand->node), unit_text(operand->fact.unit)));
    }
  }

  static std::string as_factor(const Expression& node) {
    const bool simple = node.kind == Expression::Kind::name || node.kind == Expression::Kind::call ||
                        node.kind == Expression::Kind::number;
    return simple ? to_string(node) : "(" + to_string(node) + ")";
  }

  // ---- what is stated and what is there

  void conditions(const BoundExpression& a, const BoundExpression& b) {
    expression(a);
    expression(b);
  }

  void parameter(const GraphParameter& p) {
    if (!p.expression || p.bad) return;
    const UnitFact fact = expression(p.expression);
    compare(fact, p.unit, p.expression, [&] { return fmt::format("'{}'", path_of(g_, p)); });
  }

  void net(const GraphNet& net) {
    if (!net.driver || net.by_parameter || net.bad || net.bus != nowhere || net.kind == GraphNet::Kind::copies) return;
    const UnitFact fact = expression(net.driver);
    compare(fact, net.unit, net.driver, [&] {
      const bool input = net.kind == GraphNet::Kind::block_input || net.kind == GraphNet::Kind::scope_input;
      return fmt::format("{}'{}'", input ? "the input " : "", path_of(g_, net));
    });
  }

  template <typename Name>
  void compare(const UnitFact& fact, std::string_view unit, const BoundExpression& bound, const Name& name) {
    if (unit.empty() || fact.kind == UnitFact::Kind::literal) return;
    const UnitFact stated = UnitFact::of_text(unit);
    const std::string text = to_string(*bound.code->tree);
    if (clash(fact, stated)) {
      Finding& finding = findings_.check("unit-clash", bound.mark, "{} is in {}, but '{}' is in {}", name(), unit, text,
                                         unit_text(fact.unit));
      if (const auto converted = conversion(as_factor(*bound.code->tree), fact.unit, stated.unit)) {
        finding.hint(fmt::format("numbers are never converted: write {}", *converted));
      } else {
        finding.hint(fmt::format("{} is {}, {} is {}", unit, dimension_text(stated.unit), unit_text(fact.unit),
                                 dimension_text(fact.unit)));
      }
    } else if (!fact.is_known() && stated.is_known()) {
      findings_.check("units", bound.mark, "{} is in {}, and the unit of '{}' is not known", name(), unit, text);
    }
  }

  // ---- inside blocks

  // Sums and comparisons that a block's own equations make of what it reads.
  void blocks() {
    std::unordered_map<std::uint32_t, std::vector<std::string_view>> names;
    for (const RecordedSignal& signal : record_.signals) {
      if (!signal.value.is_known()) names[signal.value.id()].push_back(signal.name);
    }
    for (const RecordedNode& node : record_.nodes) {
      if (!compares(node.op)) continue;
      const Site& site = record_.sites[node.site];
      if (site.method != "outputs" && site.method != "derivatives" && site.method != "update") continue;
      const bool choice = node.op == Op::where;
      const std::uint32_t first = choice ? node.b : node.a, second = choice ? node.c : node.b;
      const UnitFact a = units_.of_node(first), b = units_.of_node(second);
      if (!really_clash(node.op, a, b)) continue;
      // Of several names that of the block's own input.
      const auto name = [&](std::uint32_t id) -> std::string_view {
        const auto known = names.find(id);
        if (known == names.end()) return {};
        for (const std::string_view one : known->second) {
          if (one.starts_with(site.path) && one.size() > site.path.size() && one[site.path.size()] == '.') return one;
        }
        return known->second.front();
      };
      const auto called = [&](std::uint32_t id, const UnitFact& fact) {
        return name(id).empty() ? "a number in " + unit_text(fact.unit)
                                : fmt::format("'{}' in {}", name(id), unit_text(fact.unit));
      };
      const char* how = node.op == Op::add || node.op == Op::sub ? "are added" : "are compared";
      Finding& finding = findings_.check("unit-clash", site.mark, "in '{}' {} and {} {}", site.path, called(first, a),
                                         called(second, b), how);
      if (name(first).empty()) continue;
      if (const auto text = conversion(std::string(name(first)), a.unit, b.unit))
        finding.hint(fmt::format("numbers are never converted: {} is in {}", *text, unit_text(b.unit)));
    }
  }

  void begins(const RecordedState& state, const UnitFact& own) {
    const UnitFact start = units_.of(state.initial);
    if (!start.is_known() || !own.is_known() || !clash(start, own)) return;
    Finding& finding = findings_.check("unit-clash", record_.sites[state.site].mark,
                                       "'{}' is in {}, but it begins with a number in {}", state.name,
                                       unit_text(own.unit), unit_text(start.unit));
    if (const auto text = conversion("initial", start.unit, own.unit))
      finding.hint(fmt::format("numbers are never converted: {} would be in {}", *text, unit_text(own.unit)));
  }

  void states() {
    for (const RecordedState& state : record_.states) {
      const UnitFact rate = units_.of(state.derivative), stated = UnitFact::of_text(state.unit);
      const UnitFact integral = times_seconds(rate);
      begins(state, stated.is_known() ? stated : rate.is_known() ? integral : UnitFact{});
      if (!rate.is_known() || !clash(integral, stated)) continue;
      Finding& finding = findings_.check("unit-clash", record_.sites[state.site].mark,
                                         "'{}' is in {}, but it changes by {} in a second", state.name, state.unit,
                                         unit_text(rate.unit));
      finding.hint(fmt::format("what is integrated to {} is in {}", state.unit,
                               unit_text(unit_after(Op::div, stated, UnitFact::of_text("s"), {}).unit)));
    }
  }

  const Graph& g_;
  const Record& record_;
  Findings& findings_;
  NodeUnits units_;
  bool quiet_ = false;
  int depth_ = 0;
};

// Whether the author states a unit; those of the blocks' declarations alone say nothing.
bool states_units(const Graph& graph) {
  for (const GraphScope& scope : graph.scopes) {
    for (const ParameterDecl& p : scope.type->parameters) {
      if (!p.unit.empty()) return true;
    }
    for (const InputDecl& input : scope.type->inputs) {
      if (!input.unit.empty()) return true;
    }
  }
  return std::any_of(graph.blocks.begin(), graph.blocks.end(),
                     [](const GraphBlock& block) { return !block.declaration->unit.empty(); });
}

}  // namespace

void check_units(const Graph& graph, const RecordedGraph& recorded, Report& report) {
  if (!states_units(graph)) return;
  Findings findings(report);
  UnitChecks(graph, recorded, findings).run();
}

}  // namespace plantloop
