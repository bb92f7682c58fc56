// State machines: an instance that says `states` and `transitions` becomes an instance of a subsystem type made for it.
//
//   gear: {type: state_machine, in: {v: speed}, initial: low, states: {low: {set: {r: 3}}, high: {set: {r: 1}}},
//          transitions: [{from: low, to: high, when: v > 9 and elapsed > 1}]}
//
// is taken as if there were
//
//   gear: {type: T, in: {v: speed}}
//   T: {inputs: [v], outputs: {state: core, r: "where(core == 1, 3, 1)"},
//       blocks: {core: {type: state_machine, in: [v > 9 and core.elapsed > 1], transitions: 1 2}}}
//
// where `core` cannot be written in a file. Parameters of the scope around that guards and values read are handed in.

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "engine/diagram/read.h"
#include "engine/diagram/section.h"
#include "engine/graph/elaboration.h"

namespace plantloop {
namespace {

constexpr const char* core_name = "(machine)";
constexpr const char* id = "state-machine";

ExpressionPtr name_tree(std::vector<std::string> parts, const Mark& mark) {
  auto tree = std::make_shared<Expression>();
  tree->kind = Expression::Kind::name;
  tree->parts = std::move(parts);
  tree->mark = mark;
  return tree;
}

ExpressionPtr tree_of(Expression::Kind kind, const char* text, const Mark& mark, std::vector<ExpressionPtr> arguments) {
  auto tree = std::make_shared<Expression>();
  tree->kind = kind;
  tree->text = text;
  tree->mark = mark;
  tree->arguments = std::move(arguments);
  return tree;
}

// A number where a condition belongs, as far as the form tells: arithmetic, a vector, or a function of numbers.
bool is_number(const Expression& tree) {
  switch (tree.kind) {
    case Expression::Kind::number:
    case Expression::Kind::vector:
      return true;
    case Expression::Kind::name:
      return tree.parts.size() == 1 &&
             (tree.parts[0] == "pi" || tree.parts[0] == "inf" || tree.parts[0] == "elapsed" || tree.parts[0] == "time");
    case Expression::Kind::unary:
      return tree.text != "not";
    case Expression::Kind::binary:
      return std::string_view("+-*/^").find(tree.text) != std::string_view::npos;
    case Expression::Kind::call:
      return tree.text != "where" && tree.text != "min" && tree.text != "max";
  }
  return false;
}

class MachineReader {
 public:
  MachineReader(Elaboration& e, const BlockDecl& decl, std::uint32_t scope)
      : e_(e), decl_(decl), around_(*e.g.scopes[scope].type), report_(e.findings.report()) {}

  std::shared_ptr<const Elaboration::MadeMachine> read() {
    const std::size_t errors = report_.error_count();
    check_fields();
    read_inputs();
    if (const FieldDecl* states = need("states", "states: {low: {set: {y: 0}}, high: {set: {y: 1}}}"))
      read_states(*states);
    if (!machine_.states.empty()) {
      read_initial();
      if (const FieldDecl* list = need("transitions", "transitions: [{from: low, to: high, when: u > 1}]"))
        read_transitions(*list);
      if (report_.error_count() == errors) check_outputs();
    }
    if (report_.error_count() > errors) return nullptr;
    warn_of_unreachable();
    warn_of_repeated();
    return make();
  }

 private:
  const FieldDecl* find(std::string_view name) const {
    for (const FieldDecl& field : decl_.fields) {
      if (field.name == name) return &field;
    }
    return nullptr;
  }

  const FieldDecl* need(const char* name, const char* example) {
    const FieldDecl* field = find(name);
    if (!field && !misspelt_.contains(name)) {
      report_.error(decl_.mark, "the state machine '{}' has no '{}'", decl_.name, name)
          .hint(fmt::format("for example {}", example))
          .named(id);
    }
    return field;
  }

  void check_fields() {
    const std::vector<std::string> known{"initial", "states", "transitions"};
    for (const FieldDecl& field : decl_.fields) {
      if (std::find(known.begin(), known.end(), field.name) != known.end()) continue;
      report_.error(field.mark, "'{}' (state_machine) has no parameter '{}'", decl_.name, field.name)
          .suggest(field.name, known)
          .named("unknown-parameter");
      misspelt_.insert(nearest(field.name, known));
    }
  }

  void read_inputs() {
    for (const WireDecl& wire : decl_.in) {
      if (wire.port.empty()) {
        report_.error(wire.mark, "the inputs of the state machine '{}' need names", decl_.name)
            .hint("write in: {u: ...}, then guards and values read u")
            .named(id);
      } else if (check_name(wire.port, wire.mark, "input", report_)) {
        inputs_.push_back(wire.port);
      }
    }
  }

  // ---- states

  void read_states(const FieldDecl& field) {
    const Node& node = field.value;
    if (!node.is_mapping() || node.items.empty()) {
      report_
          .error(node.kind == Node::Kind::null ? field.mark : node.mark,
                 "'states' is a mapping from names to what holds there, here is {}",
                 node.is_mapping() ? "an empty one" : describe(node))
          .hint("for example states: {low: {set: {y: 0}}, high: {set: {y: 1}}}")
          .named(id);
      return;
    }
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      StateMachineDecl::State state;
      state.name = node.keys[i];
      state.mark = node.key_marks[i];
      check_name(state.name, state.mark, "state", report_);
      if (node.items[i].kind != Node::Kind::null) read_state(node.items[i], state);
      machine_.states.push_back(std::move(state));
    }
  }

  void read_state(const Node& node, StateMachineDecl::State& state) {
    const Section section(node, fmt::format("the state '{}'", state.name), {"set"}, report_);
    const Node* set = section.find("set");
    if (!set) return;
    if (!set->is_mapping()) {
      report_.error(set->mark, "'set' is a mapping from outputs to values, here is {}", describe(*set))
          .hint("for example set: {y: 0}")
          .named("kind");
      return;
    }
    for (std::size_t i = 0; i < set->items.size(); ++i) {
      const std::string& output = set->keys[i];
      if (!check_name(output, set->key_marks[i], "output", report_)) continue;
      if (output == "state") {
        report_.error(set->key_marks[i], "'state' is the number of the state: an output that is set has another name")
            .named(id);
        continue;
      }
      const ExpressionPtr value = meant(parse_expression(set->items[i], report_), "value", output);
      if (value) state.set.emplace_back(output, value);
    }
  }

  // An output without a value in some state would have none, or an old one that nobody sees.
  void check_outputs() {
    for (const auto& [output, mark] : outputs()) {
      for (const StateMachineDecl::State& state : machine_.states) {
        if (value_of(state, output)) continue;
        report_.error(state.mark, "the state '{}' does not set the output '{}' of '{}'", state.name, output, decl_.name)
            .also(mark, fmt::format("'{}' is set here", output))
            .hint(fmt::format("an output has a value in every state: {}: {{set: {{{}: ...}}}}", state.name, output))
            .named(id);
      }
    }
  }

  static ExpressionPtr value_of(const StateMachineDecl::State& state, const std::string& output) {
    for (const auto& [name, value] : state.set) {
      if (name == output) return value;
    }
    return nullptr;
  }

  // In the order in which the file first names them.
  std::vector<std::pair<std::string, Mark>> outputs() const {
    std::vector<std::pair<std::string, Mark>> found;
    for (const StateMachineDecl::State& state : machine_.states) {
      for (const auto& entry : state.set) {
        const bool known =
            std::any_of(found.begin(), found.end(), [&](const auto& f) { return f.first == entry.first; });
        if (!known) found.emplace_back(entry.first, entry.second->mark);
      }
    }
    return found;
  }

  // ---- transitions

  std::optional<std::size_t> state_named(const Node& node, std::string_view key) {
    if (!require_text(node, fmt::format("'{}'", key), report_)) return std::nullopt;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < machine_.states.size(); ++i) {
      names.push_back(machine_.states[i].name);
      if (names.back() == node.text) return i;
    }
    report_.error(node.mark, "the state machine '{}' has no state '{}'", decl_.name, node.text)
        .suggest(node.text, names)
        .named(id);
    return std::nullopt;
  }

  void read_initial() {
    const FieldDecl* field = find("initial");
    if (field) {
      machine_.initial = state_named(field->value, "initial").value_or(0);
    } else if (!misspelt_.contains("initial")) {
      report_.error(decl_.mark, "the state machine '{}' does not say in which state it begins", decl_.name)
          .hint(fmt::format("write initial: {}", machine_.states.front().name))
          .named(id);
    }
  }

  void read_transitions(const FieldDecl& field) {
    if (!field.value.is_sequence()) {
      report_
          .error(field.value.kind == Node::Kind::null ? field.mark : field.value.mark,
                 "'transitions' is a list, here is {}", describe(field.value))
          .hint("for example transitions: [{from: low, to: high, when: u > 1}]")
          .named(id);
      return;
    }
    for (const Node& item : field.value.items) read_transition(item);
  }

  void read_transition(const Node& node) {
    const Section section(node, "a transition", {"from", "to", "when"}, report_);
    if (!section) return;
    StateMachineDecl::Transition transition;
    transition.mark = node.mark;
    bool sound = true;
    for (const char* key : {"from", "to", "when"})
      sound = section.require(key, node.mark, "{from: low, to: high, when: u > 1}") && sound;
    if (!sound) return;
    const auto from = state_named(*section.find("from"), "from");
    const auto to = state_named(*section.find("to"), "to");
    const ExpressionPtr guard = section.expression("when");
    if (guard && is_number(*guard)) {
      Finding& finding =
          report_.error(guard->mark, "the guard '{}' is a number, not a condition", to_string(*guard)).named(id);
      if (guard->kind != Expression::Kind::number && guard->kind != Expression::Kind::vector)
        finding.hint(fmt::format("compare it with a number: {} > 0", to_string(*guard)));
      return;
    }
    transition.when = meant(guard, "guard", {});
    if (!from || !to || !transition.when) return;
    transition.from = *from, transition.to = *to;
    machine_.transitions.push_back(std::move(transition));
  }

  // ---- names

  // The tree with what its names mean inside the type: `elapsed` is the core's; null after reporting.
  ExpressionPtr meant(const ExpressionPtr& tree, const char* what, const std::string& output) {
    if (!tree) return nullptr;
    if (tree->kind == Expression::Kind::name) return meant_name(tree, what, output);
    std::shared_ptr<Expression> copy;
    bool sound = true;
    for (std::size_t i = 0; i < tree->arguments.size(); ++i) {
      ExpressionPtr argument = meant(tree->arguments[i], what, output);
      sound = sound && argument != nullptr;
      if (argument == tree->arguments[i]) continue;
      if (!copy) copy = std::make_shared<Expression>(*tree);
      copy->arguments[i] = std::move(argument);
    }
    if (!sound) return nullptr;
    return copy ? copy : tree;
  }

  ExpressionPtr meant_name(const ExpressionPtr& name, const char* what, const std::string& output) {
    const std::string& first = name->parts.front();
    if (first == "elapsed" && name->parts.size() == 1) return name_tree({core_name, "elapsed"}, name->mark);
    if (std::find(reserved_names().begin(), reserved_names().end(), first) != reserved_names().end()) return name;
    if (std::find(inputs_.begin(), inputs_.end(), first) != inputs_.end()) return name;
    const auto named = [&](const auto& list) {
      return std::any_of(list.begin(), list.end(), [&](const auto& thing) { return thing.name == first; });
    };
    const auto parameter = std::find_if(around_.parameters.begin(), around_.parameters.end(),
                                        [&](const ParameterDecl& p) { return p.name == first; });
    if (parameter != around_.parameters.end()) {
      if (std::find(handed_in_.begin(), handed_in_.end(), &*parameter) == handed_in_.end())
        handed_in_.push_back(&*parameter);
      return name;
    }
    const std::string where = output.empty() ? fmt::format("a {} of '{}'", what, decl_.name)
                                             : fmt::format("'{}' of '{}'", output, decl_.name);
    if (named(around_.blocks) || named(around_.inputs)) {
      report_.error(name->mark, "{} reads '{}', which is no input of the state machine", where, to_string(*name))
          .hint(fmt::format("add it: in: {{{}: {}}}", first, to_string(*name)))
          .named(id);
      return nullptr;
    }
    std::vector<std::string> names = inputs_;
    for (const ParameterDecl& p : around_.parameters) names.push_back(p.name);
    names.emplace_back("elapsed");
    Finding& finding = report_.error(name->mark, "there is no '{}' for {}", first, where).named("unknown-name");
    if (const std::string near = nearest(first, names); !near.empty()) {
      finding.hint(fmt::format("did you mean '{}'?", near));
    } else {
      finding.hint("it sees the inputs of the state machine, the parameters around it, and elapsed");
    }
    return nullptr;
  }

  // ---- what is suspicious

  void warn_of_unreachable() {
    std::vector<std::uint8_t> reached(machine_.states.size());
    std::vector<std::size_t> open{machine_.initial};
    while (!open.empty()) {
      const std::size_t state = open.back();
      open.pop_back();
      if (std::exchange(reached[state], std::uint8_t{1})) continue;
      for (const StateMachineDecl::Transition& t : machine_.transitions) {
        if (t.from == state) open.push_back(t.to);
      }
    }
    for (std::size_t i = 0; i < reached.size(); ++i) {
      if (reached[i]) continue;
      e_.findings
          .check("unreachable-state", machine_.states[i].mark, "the state '{}' of '{}' cannot be reached from '{}'",
                 machine_.states[i].name, decl_.name, machine_.states[machine_.initial].name)
          .hint(fmt::format("no transition leads there: {{from: ..., to: {}, when: ...}}", machine_.states[i].name));
    }
  }

  // Of two equal conditions the first one in the list is taken.
  void warn_of_repeated() {
    for (std::size_t i = 0; i < machine_.transitions.size(); ++i) {
      const StateMachineDecl::Transition& later = machine_.transitions[i];
      for (std::size_t j = 0; j < i; ++j) {
        const StateMachineDecl::Transition& first = machine_.transitions[j];
        if (first.from != later.from || to_string(*first.when) != to_string(*later.when)) continue;
        e_.findings
            .check("unreachable-transition", later.mark,
                   "this transition is never taken: the one to '{}' has the same condition and stands before it",
                   machine_.states[first.to].name)
            .also(first.mark, "the one that is taken");
        break;
      }
    }
  }

  // ---- the type

  std::shared_ptr<const Elaboration::MadeMachine> make() {
    auto made = std::make_shared<Elaboration::MadeMachine>();
    auto type = std::make_shared<TypeDecl>();
    type->name = "state_machine";
    type->mark = decl_.type_mark;
    type->file = around_.file;
    type->machine = std::make_shared<const StateMachineDecl>(machine_);
    for (const std::string& input : inputs_) {
      InputDecl& one = type->inputs.emplace_back();
      one.name = input;
      one.mark = decl_.mark;
    }
    made->instance = decl_;
    made->instance.fields.clear();
    for (const ParameterDecl* parameter : handed_in_) {
      ParameterDecl& one = type->parameters.emplace_back();
      one.name = parameter->name;
      one.mark = parameter->mark;
      one.unit = parameter->unit;
      made->instance.fields.push_back({parameter->name, decl_.mark, {}});
    }
    for (const FieldDecl& field : made->instance.fields) e_.parsed[&field.value] = name_tree({field.name}, decl_.mark);
    const ExpressionPtr core = name_tree({core_name}, decl_.mark);
    type->outputs.push_back({"state", decl_.mark, core, number_expression(static_cast<double>(machine_.initial + 1))});
    type->outputs.push_back(
        {"elapsed", decl_.mark, name_tree({core_name, "elapsed"}, decl_.mark), number_expression(0)});
    for (const auto& [output, mark] : outputs()) {
      type->outputs.push_back(
          {output, mark, selected(output, core), at_start(value_of(machine_.states[machine_.initial], output))});
    }
    type->blocks.push_back(core_block());
    made->type = std::move(type);
    return made;
  }

  // where(core == 1, value in the first state, where(core == 2, ...))
  ExpressionPtr selected(const std::string& output, const ExpressionPtr& core) const {
    ExpressionPtr tree = value_of(machine_.states.back(), output);
    for (std::size_t i = machine_.states.size() - 1; i-- > 0;) {
      const ExpressionPtr value = value_of(machine_.states[i], output);
      const ExpressionPtr number = number_expression(static_cast<double>(i + 1));
      const ExpressionPtr holds = tree_of(Expression::Kind::binary, "==", value->mark, {core, number});
      tree = tree_of(Expression::Kind::call, "where", value->mark, {holds, value, tree});
    }
    return tree;
  }

  // Nothing has elapsed before the first activation.
  static ExpressionPtr at_start(const ExpressionPtr& tree) {
    if (tree->kind == Expression::Kind::name && tree->parts.front() == core_name) return number_expression(0);
    if (tree->arguments.empty()) return tree;
    auto copy = std::make_shared<Expression>(*tree);
    for (ExpressionPtr& argument : copy->arguments) argument = at_start(argument);
    return copy;
  }

  BlockDecl core_block() const {
    BlockDecl core;
    core.name = core_name;
    core.mark = decl_.mark;
    core.type = "state_machine";
    core.type_mark = decl_.type_mark;
    core.zero_crossing = false;  // its guards are events of their own, and need none of the conditions inside them
    WireDecl guards;
    guards.mark = decl_.mark;
    guards.is_sequence = true;
    std::string states, transitions;
    for (const StateMachineDecl::State& state : machine_.states) states += (states.empty() ? "" : " ") + state.name;
    for (const StateMachineDecl::Transition& t : machine_.transitions) {
      guards.items.push_back(t.when);
      transitions += fmt::format("{}{} {}", transitions.empty() ? "" : " ", t.from + 1, t.to + 1);
    }
    if (guards.items.empty()) {  // a list is not empty; this one is never true
      guards.items.push_back(number_expression(0));
      transitions = "1 1";
    }
    core.in.push_back(std::move(guards));
    const auto text = [&](const char* name, std::string value) {
      FieldDecl field{name, decl_.mark, {}};
      field.value.kind = Node::Kind::scalar;
      field.value.text = std::move(value);
      field.value.mark = decl_.mark;
      core.fields.push_back(std::move(field));
    };
    text("initial", std::to_string(machine_.initial + 1));
    text("states", states);
    text("transitions", transitions);
    return core;
  }

  Elaboration& e_;
  const BlockDecl& decl_;
  const TypeDecl& around_;
  Report& report_;
  StateMachineDecl machine_;
  std::vector<std::string> inputs_;
  std::vector<const ParameterDecl*> handed_in_;
  std::set<std::string> misspelt_;
};

}  // namespace

bool is_machine_core(const BlockDecl& decl) { return decl.name == core_name; }

const Elaboration::MadeMachine* make_state_machine(Elaboration& e, const BlockDecl& decl, std::uint32_t scope) {
  const auto [it, is_new] = e.machines.try_emplace(&decl);
  if (is_new) {
    it->second = MachineReader(e, decl, scope).read();
    e.g.made.push_back(it->second);
  }
  return it->second.get();
}

void check_state_machines(Elaboration& e) {
  for (const GraphBlock& block : e.g.blocks) {
    if (!block.type || !is_machine_core(*block.declaration)) continue;
    for (std::uint32_t i = 0; i < block.inputs; ++i) {
      const GraphNet& net = e.g.nets[block.first_input + i];
      if (net.bad || !net.shape.is_known() || net.shape.size() == 1) continue;
      e.findings
          .error(net.mark, "the guard '{}' is {}: a transition needs one condition", to_string(*net.driver.code->tree),
                 to_string(net.shape))
          .hint("take one element, min(...) where all must hold, max(...) where one is enough")
          .named(id);
    }
  }
}

}  // namespace plantloop
