// From the operations that a part's outputs and next states need to statements, one for each operation, in order.

#include "engine/analysis/structured_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "engine/analysis/linear_program.h"
#include "engine/base/numbers.h"
#include "engine/program/resolve.h"

namespace plantloop {
namespace {

std::string literal(double value) {
  std::string text = shortest(value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  if (const std::size_t e = text.find('e'); e != std::string::npos && text.find('.') == std::string::npos)
    text.insert(e, ".0");
  return value < 0 ? "(" + text + ")" : text;
}

// Names of structured text: letters, digits and single underscores, equal in upper and lower case.
class Names {
 public:
  std::string make(const std::string& wanted) {
    std::string name;
    for (const char c : wanted) {
      const bool fits = std::isalnum(static_cast<unsigned char>(c)) != 0;
      if (fits) name += c;
      if (!fits && !name.empty() && name.back() != '_') name += '_';
    }
    while (!name.empty() && name.back() == '_') name.pop_back();
    if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) != 0) name = "x" + name;
    std::string unique = name;
    for (int k = 2; !used_.insert(upper(unique)).second; ++k) unique = fmt::format("{}_{}", name, k);
    return unique;
  }

 private:
  static std::string upper(std::string text) {
    for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
  }
  // Words that a name may not be.
  std::set<std::string> used_{"IF",    "THEN",  "ELSE",  "ELSIF",  "END_IF", "FOR",  "TO",  "BY",  "DO",
                              "CASE",  "OF",    "AND",   "OR",     "XOR",    "NOT",  "MOD", "VAR", "TRUE",
                              "FALSE", "REAL",  "LREAL", "INT",    "ABS",    "SQRT", "EXP", "LN",  "LOG",
                              "SIN",   "COS",   "TAN",   "ASIN",   "ACOS",   "ATAN", "MIN", "MAX", "SEL",
                              "LIMIT", "TRUNC", "EXPT",  "RETURN", "EXIT",   "AT",   "ON",  "TIME"};
};

class Writer {
 public:
  Writer(const LinearProgram& program, std::string part, Report& report)
      : program_(program), resolved_(*program.program->resolved), part_(std::move(part)), report_(report) {}

  std::optional<std::string> write(const std::string& name, const std::vector<std::string>& inputs,
                                   const std::vector<std::string>& outputs) {
    const auto& operations = resolved_.graph.operations;
    const std::string block = names_.make(name);
    std::vector<std::string> input_names, output_names;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      input_names.push_back(names_.make(inputs[i]));
      text_[resolved_.watches[outputs.size() + i]] = input_names.back();
      inputs_.insert(resolved_.watches[outputs.size() + i]);
    }
    for (const std::string& output : outputs) output_names.push_back(names_.make(output));

    std::vector<std::uint32_t> wanted(resolved_.watches.begin(),
                                      resolved_.watches.begin() + static_cast<std::ptrdiff_t>(outputs.size()));
    collect(wanted);
    if (report_.has_errors()) return std::nullopt;
    for (const auto& [d, state] : states_) text_[state.leaf] = state.name;

    std::string body;
    for (const std::uint32_t id : needed_) {
      if (text_.count(id) == 0) body += statement(id, operations[id]);
    }
    if (report_.has_errors()) return std::nullopt;
    // A state that becomes another one's value takes it before that one moves on.
    std::string moves;
    for (const auto& [d, state] : states_) {
      std::string value = operand(resolved_.nexts[d]);
      const bool is_state =
          std::any_of(states_.begin(), states_.end(), [&](const auto& other) { return other.second.name == value; });
      if (is_state) {
        temporaries_.push_back(names_.make(fmt::format("v{}", temporaries_.size() + 1)));
        body += fmt::format("{} := {};\n", temporaries_.back(), value);
        value = temporaries_.back();
      }
      moves += fmt::format("{} := {};\n", state.name, value);
    }
    std::string text = fmt::format("(* Written by plantloop export from '{}'{}. *)\nFUNCTION_BLOCK {}\n", part_,
                                   period_ > 0 ? fmt::format(": call it every {} s", shortest(period_)) : "", block);
    const auto section = [&](const char* word, const std::vector<std::string>& names) {
      if (names.empty()) return;
      text += fmt::format("{}\n", word);
      for (const std::string& one : names) text += fmt::format("  {};\n", one);
      text += "END_VAR\n";
    };
    const auto typed = [](std::vector<std::string> names) {
      for (std::string& one : names) one += " : LREAL";
      return names;
    };
    section("VAR_INPUT", typed(input_names));
    section("VAR_OUTPUT", typed(output_names));
    std::vector<std::string> states;
    const List& start = program_.program->initial_list;
    for (const auto& [d, state] : states_) {
      const double initial = program_.frame->arena[start.roots[program_.program->state_names.size() + d]];
      const std::string number = literal(initial);
      states.push_back(
          fmt::format("{} : LREAL := {}", state.name, number[0] == '(' ? number.substr(1, number.size() - 2) : number));
    }
    section("VAR", states);
    section("VAR_TEMP", typed(temporaries_));
    text += body;
    for (std::size_t i = 0; i < outputs.size(); ++i)
      text += fmt::format("{} := {};\n", output_names[i], operand(wanted[i]));
    return text + moves + "END_FUNCTION_BLOCK\n";
  }

 private:
  struct State {
    std::string name;
    std::uint32_t leaf;
  };

  void collect(const std::vector<std::uint32_t>& roots) {
    std::vector<std::uint32_t> open = roots;
    while (!open.empty()) {
      const std::uint32_t id = open.back();
      open.pop_back();
      if (!needed_.insert(id).second || text_.count(id) != 0) continue;
      const Operation& o = resolved_.graph.operations[id];
      if (!supported(o)) continue;
      if (o.op == Op::discrete) {
        remember(o.a, id);
        open.push_back(resolved_.nexts[o.a]);
      }
      const int arity = arity_of(o.op);
      if (arity > 0) open.push_back(o.a);
      if (arity > 1) open.push_back(o.b);
      if (arity > 2) open.push_back(o.c);
    }
  }

  void remember(std::uint32_t d, std::uint32_t leaf) {
    const Program& p = *program_.program;
    std::string name = p.discrete_names[d];
    if (name.rfind(part_ + ".", 0) == 0) name.erase(0, part_.size() + 1);
    states_.emplace(d, State{names_.make(name), leaf});
    const double period = p.rates[p.discrete_rates[d]].period.to_double();
    if (period_ > 0 && period != period_)
      refuse(resolved_.graph.operations[leaf],
             fmt::format("has a period of {} s, other states have {} s; a function block has one", shortest(period),
                         shortest(period_)));
    period_ = period;
  }

  void refuse(const Operation& o, const std::string& why) {
    const Site& site = program_.program->sites[o.site];
    if (!refused_.insert(site.path + why).second) return;
    report_.error(site.mark, "'{}' cannot be written as structured text: it {}", site.path, why);
  }

  bool supported(const Operation& o) {
    const auto no = [&](const char* why) {
      refuse(o, why);
      return false;
    };
    if (o.activation != 0) return no("does not always run");
    switch (o.op) {
      case Op::constant:
        return std::isfinite(std::bit_cast<double>(o.b | (std::uint64_t{o.c} << 32))) || no("has an infinite number");
      case Op::parameter:
        return std::isfinite(program_.program->parameter_info[o.a].value) || no("has an infinite number");
      case Op::discrete:
        return true;
      case Op::state:
        return no("reads a continuous state that is no input of the part");
      case Op::time:
      case Op::segment:
      case Op::hit:
        return no("reads the time");
      case Op::mode:
        return no("compares a continuous signal; read it by an adc or a zero_order_hold");
      case Op::kernel:
      case Op::kernel_output:
        return no("is computed by more than arithmetic");
      case Op::loop:
      case Op::unknown:
        return no("is found by solving an equation");
      case Op::atan2:
      case Op::erf:
        return no("uses a function that structured text does not have");
      default:
        return arity_of(o.op) > 0 || no("has no counterpart");
    }
  }

  std::string operand(std::uint32_t id) {
    const auto known = text_.find(id);
    if (known != text_.end()) return known->second;
    const Operation& o = resolved_.graph.operations[id];
    if (o.op == Op::constant) return literal(resolved_.graph.constant(id));
    if (o.op == Op::parameter) return literal(program_.program->parameter_info[o.a].value);
    return "0.0";
  }

  std::string statement(std::uint32_t id, const Operation& o) {
    if (is_leaf(o.op)) return {};
    const int arity = arity_of(o.op);
    const std::string a = operand(o.a), b = arity > 1 ? operand(o.b) : "", c = arity > 2 ? operand(o.c) : "";
    const bool is_input = o.op == Op::add && inputs_.count(o.a) != 0 &&
                          resolved_.graph.operations[o.b].op == Op::parameter;  // the number that a probe adds, 0
    if (o.op == Op::copy || is_input) {
      text_[id] = a;
      return {};
    }
    const std::string v = names_.make(fmt::format("v{}", temporaries_.size() + 1));
    temporaries_.push_back(v);
    text_[id] = v;
    const auto set = [&](const std::string& expression) { return fmt::format("{} := {};\n", v, expression); };
    const auto when = [&](const std::string& condition) {
      return fmt::format("IF {} THEN {} := 1.0; ELSE {} := 0.0; END_IF;\n", condition, v, v);
    };
    const auto correct = [&](const std::string& condition, const char* by) {
      return fmt::format("{} := TRUNC({});\nIF {} THEN {} := {} {}; END_IF;\n", v, a, condition, v, v, by);
    };
    switch (o.op) {
      case Op::neg:
        return set("-" + a);
      case Op::abs:
        return set("ABS(" + a + ")");
      case Op::sqrt:
        return set("SQRT(" + a + ")");
      case Op::exp:
        return set("EXP(" + a + ")");
      case Op::log:
        return set("LN(" + a + ")");
      case Op::log2:
        return set("LN(" + a + ") / " + literal(std::log(2.0)));
      case Op::log10:
        return set("LOG(" + a + ")");
      case Op::sin:
        return set("SIN(" + a + ")");
      case Op::cos:
        return set("COS(" + a + ")");
      case Op::tan:
        return set("TAN(" + a + ")");
      case Op::asin:
        return set("ASIN(" + a + ")");
      case Op::acos:
        return set("ACOS(" + a + ")");
      case Op::atan:
        return set("ATAN(" + a + ")");
      case Op::sinh:
        return set(fmt::format("(EXP({}) - EXP(-{})) / 2.0", a, a));
      case Op::cosh:
        return set(fmt::format("(EXP({}) + EXP(-{})) / 2.0", a, a));
      case Op::tanh:  // by the part that does not overflow
        return fmt::format(
            "{0} := EXP(-2.0 * ABS({1}));\n{0} := (1.0 - {0}) / (1.0 + {0});\nIF {1} < 0.0 THEN {0} := -{0}; END_IF;\n",
            v, a);
      case Op::trunc:
        return set("TRUNC(" + a + ")");
      case Op::floor:
        return correct(fmt::format("{} > {}", v, a), "- 1.0");
      case Op::ceil:
        return correct(fmt::format("{} < {}", v, a), "+ 1.0");
      case Op::round:
        return fmt::format(
            "{0} := TRUNC({1});\nIF {1} - {0} >= 0.5 THEN {0} := {0} + 1.0; ELSIF {0} - {1} >= 0.5 THEN {0} := {0} - "
            "1.0; END_IF;\n",
            v, a);
      case Op::sign:
        return fmt::format("IF {1} > 0.0 THEN {0} := 1.0; ELSIF {1} < 0.0 THEN {0} := -1.0; ELSE {0} := 0.0; END_IF;\n",
                           v, a);
      case Op::logical_not:
        return when(a + " = 0.0");
      case Op::add:
        return set(a + " + " + b);
      case Op::sub:
        return set(a + " - " + b);
      case Op::mul:
        return set(a + " * " + b);
      case Op::div:
        return set(a + " / " + b);
      case Op::pow:
        return set("EXPT(" + a + ", " + b + ")");
      case Op::mod:  // a - b floor(a/b), exact for whole numbers that fit
        return fmt::format(
            "{0} := TRUNC({1} / {2});\nIF {0} > {1} / {2} THEN {0} := {0} - 1.0; END_IF;\n{0} := {1} - {2} * {0};\n", v,
            a, b);
      case Op::min:
        return set("MIN(" + a + ", " + b + ")");
      case Op::max:
        return set("MAX(" + a + ", " + b + ")");
      case Op::less:
        return when(a + " < " + b);
      case Op::less_equal:
        return when(a + " <= " + b);
      case Op::equal:
        return when(a + " = " + b);
      case Op::logical_and:
        return when(fmt::format("({} <> 0.0) AND ({} <> 0.0)", a, b));
      case Op::logical_or:
        return when(fmt::format("({} <> 0.0) OR ({} <> 0.0)", a, b));
      case Op::where:
        return fmt::format("IF {} <> 0.0 THEN {} := {}; ELSE {} := {}; END_IF;\n", a, v, b, v, c);
      default:
        refuse(o, "uses a function that structured text does not have");
        return {};
    }
  }

  const LinearProgram& program_;
  const Resolved& resolved_;
  std::string part_;
  Report& report_;
  Names names_;
  std::set<std::uint32_t> inputs_;
  std::set<std::uint32_t> needed_;             // in the order of computation
  std::map<std::uint32_t, std::string> text_;  // what stands for an operation
  std::map<std::uint32_t, State> states_;
  std::vector<std::string> temporaries_;
  std::set<std::string> refused_;
  double period_ = 0;  // s
};

}  // namespace

std::optional<std::string> structured_text(const std::shared_ptr<const Model>& model,
                                           const StructuredTextRequest& request, Report& report) {
  const auto graph = elaborate(model, request.set, report);
  if (!graph || report.has_errors()) return std::nullopt;
  const Named named = find_named(*graph, request.part);
  if (named.kind != Named::Kind::scope || request.part.empty()) {
    report.error({}, "the part '{}' is no subsystem of the diagram", request.part)
        .hint("a function block is made of a block whose type stands under 'types:'");
    return std::nullopt;
  }
  const TypeDecl& type = *graph->scopes[named.index].type;
  std::vector<std::string> inputs, outputs, input_paths, output_paths;
  for (const InputDecl& input : type.inputs) inputs.push_back(input.name);
  for (const OutputDecl& output : type.outputs) outputs.push_back(output.name);
  for (const std::string& name : inputs) input_paths.push_back(request.part + "." + name);
  for (const std::string& name : outputs) output_paths.push_back(request.part + "." + name);
  const auto program = make_linear_program(model, request.set, {}, input_paths, output_paths, report);
  if (!program) return std::nullopt;
  if (program->outputs.size() != outputs.size() ||
      program->program->resolved->watches.size() != outputs.size() + inputs.size()) {
    report.error({}, "'{}' has inputs or outputs that are vectors; a function block of numbers has none", request.part);
    return std::nullopt;
  }
  // The states before the first hit.
  KernelFrame kernels = program->frame->kernel_frame(false);
  execute(program->program->parameter_list, program->frame->arena, &kernels);
  execute(program->program->initial_list, program->frame->arena, &kernels);
  const std::size_t dot = request.part.rfind('.');
  const std::string name = !request.name.empty()      ? request.name
                           : dot == std::string::npos ? request.part
                                                      : request.part.substr(dot + 1);
  return Writer(*program, request.part, report).write(name, inputs, outputs);
}

}  // namespace plantloop
