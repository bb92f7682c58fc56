// One name of a diagram: what it is, what drives it, who reads it, when it runs and why.

#include <fmt/format.h>

#include <algorithm>

#include "engine/analysis/explained.h"
#include "engine/base/numbers.h"

namespace plantloop {

namespace {

std::string place(const Mark& mark) { return mark.source == nullptr ? "" : fmt::format(" ({})", to_string(mark)); }

std::string article(std::string_view name) {
  const bool vowel = std::string_view("aeiou").find(name.front()) != std::string_view::npos;
  return fmt::format("{} {}", vowel ? "an" : "a", name);
}

std::string value_text(const GraphParameter& p) {
  if (p.text != nowhere || !p.is_set) return "not given";
  if (p.reads_signals) return "computed at the start of a run";
  std::string text;
  for (int i = 0; i < p.value.size() && i < 8; ++i)
    text += (i > 0 ? ", " : "") + (p.value[i].is_known() ? shortest(p.value[i].number()) : std::string("?"));
  if (p.value.size() > 8) text += ", ...";
  return p.value.size() == 1 ? text : "[" + text + "]";
}

class Teller {
 public:
  explicit Teller(const Explained& e) : e_(e), graph_(*e.graph) {}

  std::string net(std::uint32_t index) const {
    const GraphNet& n = graph_.nets[index];
    std::string text = fmt::format("{}: {}{}\n", path_of(graph_, n), what(n), place(n.mark));
    text += "  size: " + in_words(n.shape) + "\n";
    if (!n.unit.empty()) text += fmt::format("  unit: {}\n", n.unit);
    text += driver(n);
    text += "  rate: " + in_words(graph_, n.rate) + "\n";
    if (n.kind == GraphNet::Kind::output || n.kind == GraphNet::Kind::expression)
      text += rate_reasons(graph_, n.owner, "    ");
    text += "  read by: " + readers({index}) + "\n";
    const std::string now = reached_from(n);
    text += "  at the same instant it depends on: " + (now.empty() ? "nothing but states, time and parameters" : now);
    return text + "\n";
  }

  std::string block(std::uint32_t index) const {
    const GraphBlock& b = graph_.blocks[index];
    const std::string type = b.type ? article(b.type->name) : "an expression";
    std::string text = fmt::format("{}: {}{}\n", b.path, type, place(b.declaration->mark));
    if (b.type) text += fmt::format("  {}\n", b.type->summary);
    if (!b.declaration->doc.empty()) text += fmt::format("  {}\n", b.declaration->doc);
    for (std::uint32_t a = b.activation; a != 0; a = graph_.activations[a].parent) {
      const GraphActivation& activation = graph_.activations[a];
      if (activation.enable_when)
        text += fmt::format("  active: while {} > 0, '{}'{}\n", to_string(*activation.enable_when.code->tree),
                            activation.path, place(activation.declaration->enable->mark));
    }
    text += "  rate: " + in_words(graph_, b.type ? b.rate : graph_.nets[b.first_output].rate) + "\n";
    text += rate_reasons(graph_, index, "    ");
    for (std::uint32_t i = 0; i < b.inputs; ++i) {
      const GraphNet& n = graph_.nets[b.first_input + i];
      text += fmt::format("  input {}: {}\n", path_of(graph_, n), drive_text(n));
    }
    std::vector<std::uint32_t> outputs;
    for (std::uint32_t i = 0; i < b.outputs; ++i) {
      const GraphNet& n = graph_.nets[b.first_output + i];
      outputs.push_back(b.first_output + i);
      text += fmt::format("  output {}: {}{}\n", path_of(graph_, n), in_words(n.shape),
                          b.type ? through(b, n) : " = " + driver_text(n));
    }
    text += parameters(b) + states(b) + events(b);
    return text + "  read by: " + readers(outputs) + "\n";
  }

  std::string parameter(std::uint32_t index) const {
    const GraphParameter& p = graph_.parameters[index];
    const std::string path = path_of(graph_, p);
    std::string text = fmt::format("{}: a parameter{}\n  value: {}{}\n", path, place(p.mark), value_text(p),
                                   p.unit.empty() ? "" : " " + std::string(p.unit));
    if (p.expression && !p.literal) text += fmt::format("  from: {}\n", to_string(*p.expression.code->tree));
    if (p.is_default && !p.of_scope) text += "  it is the default\n";
    const char* const uses[] = {"a new value needs no new compilation",
                                "a new value needs a new compilation only when an element becomes or leaves zero",
                                "a new value needs a new compilation"};
    text += fmt::format("  {}\n", uses[p.structural]);
    std::vector<std::string> users;
    for (const GraphParameter& other : graph_.parameters) {
      if (reads_parameter(other.expression, index)) users.push_back(path_of(graph_, other));
    }
    for (const GraphNet& n : graph_.nets) {
      if (!n.by_parameter && reads_parameter(n.driver, index)) users.push_back(path_of(graph_, n));
    }
    return text + fmt::format("  used by: {}\n", users.empty() ? "nothing else" : names(users));
  }

  std::string scope(std::uint32_t index) const {
    const GraphScope& s = graph_.scopes[index];
    std::string text = s.type->machine ? fmt::format("{}: a state machine{}\n", s.path, place(s.declaration->mark))
                                       : fmt::format("{}: a subsystem of type {}{}\n", s.path, s.type->name,
                                                     place(s.declaration->mark));
    if (!s.type->doc.empty()) text += fmt::format("  {}\n", s.type->doc);
    if (s.type->machine) text += machine(*s.type->machine);
    for (std::uint32_t i = 0; i < s.type->inputs.size(); ++i) {
      const GraphNet& n = graph_.nets[s.first_input + i];
      text += fmt::format("  input {}: {}, {}\n", path_of(graph_, n), drive_text(n), in_words(graph_, n.rate));
    }
    std::vector<std::uint32_t> outputs;
    for (std::uint32_t i = 0; i < s.type->outputs.size(); ++i) {
      const GraphNet& n = graph_.nets[s.first_output + i];
      outputs.push_back(s.first_output + i);
      text += fmt::format("  output {}: {}, {}, {}\n", path_of(graph_, n), drive_text(n), in_words(n.shape),
                          in_words(graph_, n.rate));
    }
    std::vector<std::string> inside;
    for (const GraphBlock& b : graph_.blocks) {
      if (b.scope == index) inside.push_back(b.path);
    }
    if (s.type->machine) return text + fmt::format("  read by: {}\n", readers(outputs));
    return text + fmt::format("  blocks: {}\n  read by: {}\n", names(inside), readers(outputs));
  }

  static std::string machine(const StateMachineDecl& machine) {
    std::string text;
    for (std::size_t i = 0; i < machine.states.size(); ++i) {
      const StateMachineDecl::State& state = machine.states[i];
      text += fmt::format("  state {} {}{}:", i + 1, state.name, i == machine.initial ? ", where it begins" : "");
      for (std::size_t k = 0; k < state.set.size(); ++k)
        text += fmt::format("{} {} = {}", k > 0 ? "," : "", state.set[k].first, written(*state.set[k].second));
      text += state.set.empty() ? " sets nothing\n" : "\n";
      for (const StateMachineDecl::Transition& t : machine.transitions) {
        if (t.from == i) text += fmt::format("    to {} when {}\n", machine.states[t.to].name, written(*t.when));
      }
    }
    return text;
  }
  // As the author wrote it: inside, `elapsed` is an output of the block that keeps the state.
  static std::string written(const Expression& tree) {
    std::string text = to_string(tree);
    constexpr std::string_view inside = "(machine).elapsed";
    for (std::size_t at = text.find(inside); at != std::string::npos; at = text.find(inside, at))
      text.replace(at, inside.size(), "elapsed");
    return text;
  }

 private:
  static std::string names(std::vector<std::string> list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return fmt::format("{}", fmt::join(list, ", "));
  }

  static std::string what(const GraphNet& n) {
    switch (n.kind) {
      case GraphNet::Kind::output:
        return "an output";
      case GraphNet::Kind::block_input:
        return "an input";
      case GraphNet::Kind::scope_input:
        return "an input of a subsystem";
      case GraphNet::Kind::scope_output:
        return "an output of a subsystem";
      case GraphNet::Kind::expression:
        return "an expression";
      case GraphNet::Kind::copies:
        return "the main outputs of a repeated block";
      case GraphNet::Kind::member:
        return "a signal of a bus";
    }
    return {};
  }

  std::string drive_text(const GraphNet& n) const {
    if (n.by_parameter) return n.is_connected ? "set to a value" : "not wired, its default holds";
    const std::string text = driver_text(n);
    return text.empty() ? "written by the block" : text;
  }
  std::string driver(const GraphNet& n) const { return fmt::format("  driven by: {}\n", drive_text(n)); }

  // Who reads any of the nets, by path.
  std::string readers(const std::vector<std::uint32_t>& wanted) const {
    std::vector<std::string> found;
    for (const GraphNet& n : graph_.nets) {
      for (const auto read : nets_read(graph_, n.driver)) {
        if (std::find(wanted.begin(), wanted.end(), read) != wanted.end()) found.push_back(path_of(graph_, n));
      }
    }
    return found.empty() ? "nothing" : names(found);
  }

  // The signals of the diagram's first level and of the block's own inputs that reach a net at the same instant.
  std::string reached_from(const GraphNet& net) const {
    const std::vector<std::uint32_t> to = e_.operations_of(net);
    std::vector<std::string> found;
    for (const GraphNet& other : graph_.nets) {
      if (&other == &net || other.kind == GraphNet::Kind::block_input) continue;
      const std::vector<std::uint32_t> from = e_.operations_of(other);
      if (from == to) {  // another name of the same value
        if (driver_text(net) == path_of(graph_, other)) found.push_back(path_of(graph_, other));
        continue;
      }
      if (e_.reaches(from, to)) found.push_back(path_of(graph_, other));
    }
    return found.empty() ? "" : names(found);
  }

  std::string through(const GraphBlock& b, const GraphNet& output) const {
    std::vector<std::string> direct;
    const std::vector<std::uint32_t> to = e_.operations_of(output);
    for (std::uint32_t i = 0; i < b.inputs; ++i) {
      const GraphNet& in = graph_.nets[b.first_input + i];
      if (e_.reaches(e_.operations_of(in), to)) direct.push_back(path_of(graph_, in));
    }
    return direct.empty() ? "; no input reaches it at the same instant"
                          : "; at the same instant it depends on " + names(direct);
  }

  std::string parameters(const GraphBlock& b) const {
    if (!b.type) return {};
    const Block& kind = *b.type->block;
    const auto count = static_cast<std::uint32_t>(kind.numbers.size() + kind.tables.size() + kind.counts.size());
    std::string text;
    for (std::uint32_t i = 0; i < count; ++i) {
      const GraphParameter& p = graph_.parameters[b.first_parameter + i];
      if (!p.is_set) continue;
      text += fmt::format("  parameter {}: {}{}{}\n", path_of(graph_, p), value_text(p),
                          p.unit.empty() ? "" : " " + std::string(p.unit), p.is_default ? ", the default" : "");
    }
    return text;
  }

  std::string states(const GraphBlock& b) const {
    std::string text;
    const auto belongs = [&](const std::string& name) { return name == b.path || name.rfind(b.path + ".", 0) == 0; };
    for (const std::string& name : e_.program->state_names) {
      if (belongs(name)) text += fmt::format("  continuous state {}\n", name);
    }
    for (const std::string& name : e_.program->discrete_names) {
      if (belongs(name)) text += fmt::format("  sampled state {}\n", name);
    }
    return text;
  }

  std::string events(const GraphBlock& b) const {
    std::string text;
    for (const Program::Jump& jump : e_.program->jumps) {
      if (e_.program->sites[jump.site].path == b.path && !jump.of_kernel)
        text += fmt::format("  event {}: its states jump\n", jump.name);
    }
    std::size_t modes = 0;
    for (const Mode& mode : e_.operations().modes) {
      if (!mode.of_loop && e_.program->sites[mode.site].path == b.path) ++modes;
    }
    if (modes > 0) text += fmt::format("  {} whose changes are located\n", counted(modes, "mode"));
    return text;
  }

  bool reads_parameter(const BoundExpression& expression, std::uint32_t parameter) const {
    for (std::size_t i = 0; expression && i < expression.code->names.size(); ++i) {
      const Reference& r = graph_.references[expression.first_reference + i];
      if (r.kind == Reference::Kind::parameter && r.index == parameter) return true;
    }
    return false;
  }

  const Explained& e_;
  const Graph& graph_;
};

}  // namespace

std::string explain_name(const Explained& e, const std::string& name) {
  const Named found = find_named(*e.graph, name);
  const Teller tell(e);
  switch (found.kind) {
    case Named::Kind::net:
      return tell.net(found.index);
    case Named::Kind::parameter:
      return tell.parameter(found.index);
    case Named::Kind::block:
      return tell.block(found.index);
    case Named::Kind::scope:
      return tell.scope(found.index);
    case Named::Kind::nothing:
      break;
  }
  return {};
}

}  // namespace plantloop
