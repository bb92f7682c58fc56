// Types: parameters, inputs, outputs, and the one namespace of a scope.

#include <unordered_map>

#include "engine/diagram/read.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace {

void refuse_instance_key(const std::string& name, const Mark& mark, std::string_view what, Report& report) {
  if (!is_instance_key(name)) return;
  report.error(mark, "'{}' cannot be the name of {}: every block has a key of that name", name, with_article(what))
      .named("name");
}

void read_long_parameter(const Node& node, bool of_type, ParameterDecl& parameter, Report& report) {
  const Section section(node, fmt::format("parameter '{}'", parameter.name), {"value", "unit", "doc", "text"}, report);
  parameter.unit = section.unit("unit");
  parameter.doc = section.text("doc");
  const Node* text = section.find("text");
  const Node* value = section.find("value");
  if (text && value) {
    report.error(section.mark_of("text"), "parameter '{}' has both a value and a text", parameter.name)
        .also(section.mark_of("value"), "the value")
        .named("unknown-key");
  } else if (text) {
    if (require_text(*text, "'text'", report)) parameter.text = plain_text(*text, "'text'", report);
  } else if (of_type && !value) {
    return;  // each block of the type gives one
  } else if (section.require("value", parameter.mark, fmt::format("{}: {{value: 1, unit: m}}", parameter.name))) {
    parameter.value = section.expression("value");
  }
}

std::vector<InputDecl> read_inputs(const Node& node, Report& report) {
  std::vector<InputDecl> inputs;
  const auto add = [&](const std::string& name, const Mark& mark) -> InputDecl& {
    check_name(name, mark, "input", report);
    InputDecl input;
    input.name = name;
    input.mark = mark;
    return inputs.emplace_back(std::move(input));
  };
  if (node.is_sequence()) {
    for (const Node& item : node.items) {
      if (require_text(item, "the name of an input", report)) add(item.text, item.mark);
    }
    return inputs;
  }
  if (!node.is_mapping()) {
    report.error(node.mark, "'inputs' is a list of names, [u], or a mapping; here is {}", describe(node)).named("kind");
    return inputs;
  }
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    InputDecl& input = add(node.keys[i], node.key_marks[i]);
    const Node& value = node.items[i];
    if (value.kind == Node::Kind::null) continue;
    if (value.is_scalar()) {
      report.error(value.mark, "an input is described by a mapping, here is {}", describe(value))
          .hint(fmt::format("for example {}: {{default: {}}}", input.name, value.text))
          .named("kind");
      continue;
    }
    const Section section(value, fmt::format("input '{}'", input.name), {"default", "size", "unit", "doc"}, report);
    input.fallback = section.expression("default");
    if (section.find("default")) refuse_instance_key(input.name, input.mark, "input with a default", report);
    if (const auto size = section.integer("size")) {
      if (*size < 1)
        report.error(section.find("size")->mark, "an input has at least one element").named("kind");
      else
        input.size = static_cast<int>(*size);
    }
    input.unit = section.unit("unit");
    input.doc = section.text("doc");
  }
  return inputs;
}

std::vector<OutputDecl> read_outputs(const Node& node, Report& report) {
  std::vector<OutputDecl> outputs;
  if (node.is_sequence()) {
    for (const Node& item : node.items) {
      if (!require_text(item, "the name of an output", report)) continue;
      if (!check_name(item.text, item.mark, "output", report)) continue;
      outputs.push_back({item.text, item.mark, parse_expression(item, report), nullptr});
    }
    return outputs;
  }
  if (!node.is_mapping()) {
    report.error(node.mark, "'outputs' is a list of names, [y], or a mapping; here is {}", describe(node))
        .named("kind");
    return outputs;
  }
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    OutputDecl output{node.keys[i], node.key_marks[i], nullptr, nullptr};
    check_name(output.name, output.mark, "output", report);
    const Node& value = node.items[i];
    if (value.is_mapping()) {
      const Section section(value, fmt::format("output '{}'", output.name), {"from", "initial"}, report);
      section.require("from", output.mark, fmt::format("{}: {{from: x, initial: 0}}", output.name));
      output.from = section.expression("from");
      output.initial = section.expression("initial");
    } else {
      output.from = parse_expression(value, report);
    }
    outputs.push_back(std::move(output));
  }
  return outputs;
}

}  // namespace

std::vector<ParameterDecl> read_parameters(const Node& node, bool of_type, Report& report) {
  std::vector<ParameterDecl> parameters;
  if (!node.is_mapping()) {
    Finding& finding =
        report.error(node.mark, "'parameters' is a mapping from names to values, here is {}", describe(node))
            .named("kind");
    if (node.is_sequence()) finding.hint("every parameter has a value: parameters: {k: 1}");
    return parameters;
  }
  parameters.reserve(node.items.size());
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const std::size_t errors = report.error_count();
    ParameterDecl parameter;
    parameter.name = node.keys[i];
    parameter.mark = node.key_marks[i];
    const bool named = check_name(parameter.name, parameter.mark, "parameter", report);
    if (named && of_type) refuse_instance_key(parameter.name, parameter.mark, "parameter", report);
    const Node& value = node.items[i];
    if (value.is_mapping()) {
      read_long_parameter(value, of_type, parameter, report);
    } else if (value.kind == Node::Kind::null && of_type) {
      // Each block of the type gives one.
    } else if (value.kind == Node::Kind::null) {
      report.error(parameter.mark, "parameter '{}' has no value", parameter.name).named("missing-key");
    } else {
      parameter.value = parse_expression(value, report);
    }
    parameter.bad = report.error_count() > errors;
    parameters.push_back(std::move(parameter));
  }
  return parameters;
}

std::shared_ptr<TypeDecl> read_type(const std::string& name, const Mark& mark, Node& node, Report& report) {
  auto type = std::make_shared<TypeDecl>();
  const std::size_t errors = report.error_count();
  std::size_t errors_of_parts = 0;
  const auto counting = [&](auto&& read) {
    const std::size_t before = report.error_count();
    auto parts = read();
    errors_of_parts += report.error_count() - before;
    return parts;
  };
  type->name = name;
  type->mark = mark;
  check_name(name, mark, "type", report);
  const Section section(node, fmt::format("type '{}'", name), {"doc", "parameters", "inputs", "outputs", "blocks"},
                        report);
  type->bad = !section;
  if (!section) return type;
  type->doc = section.text("doc");
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    Node& value = node.items[i];
    const std::string& key = node.keys[i];
    if (value.kind == Node::Kind::null) {
      if (key != "doc") report.error(node.key_marks[i], "'{}' of type '{}' is empty", key, name).named("missing-key");
      continue;
    }
    if (key == "parameters") type->parameters = counting([&] { return read_parameters(value, true, report); });
    if (key == "inputs") type->inputs = read_inputs(value, report);
    if (key == "outputs") type->outputs = read_outputs(value, report);
    if (key == "blocks") type->blocks = counting([&] { return read_blocks(value, report); });
  }
  check_scope(*type, report);
  type->bad = report.error_count() > errors + errors_of_parts;
  return type;
}

void check_scope(const TypeDecl& type, Report& report) {
  struct Use {
    const Mark* mark;
    std::string_view what;
  };
  std::unordered_map<std::string_view, Use> uses;
  uses.reserve(type.parameters.size() + type.inputs.size() + type.blocks.size());
  const auto add = [&](const std::string& name, const Mark& mark, std::string_view what) {
    const auto [use, is_new] = uses.try_emplace(name, Use{&mark, what});
    if (is_new) return;
    const std::string_view before = use->second.what;
    if (before != what) {
      report.error(mark, "'{}' is the name of {} and of {} here", name, with_article(before), with_article(what))
          .also(*use->second.mark, fmt::format("the {}", before))
          .named("duplicate-name");
    } else if (what == "input" && mark.column != use->second.mark->column) {
      // Two equal keys of a mapping were reported before.
      report.error(mark, "the input '{}' is listed twice", name)
          .also(*use->second.mark, "first listed here")
          .named("duplicate-name");
    }
  };
  for (const ParameterDecl& parameter : type.parameters) add(parameter.name, parameter.mark, "parameter");
  for (const InputDecl& input : type.inputs) add(input.name, input.mark, "input");
  for (const BlockDecl& block : type.blocks) add(block.name, block.mark, "block");

  std::unordered_map<std::string_view, const Mark*> outputs;
  for (const OutputDecl& output : type.outputs) {
    if (const auto [first, is_new] = outputs.try_emplace(output.name, &output.mark); !is_new) {
      report.error(output.mark, "the output '{}' is listed twice", output.name)
          .also(*first->second, "first listed here")
          .named("duplicate-name");
      continue;
    }
    const auto bearer = uses.find(output.name);
    if (bearer == uses.end() || !output.from) continue;
    const bool driven = output.from->kind == Expression::Kind::name && output.from->parts.front() == output.name;
    if (driven) continue;
    report
        .error(output.mark, "the output '{}' has the name of {} that does not drive it", output.name,
               with_article(bearer->second.what))
        .also(*bearer->second.mark, fmt::format("the {}", bearer->second.what))
        .hint("a name means one thing: rename one of them")
        .named("duplicate-name");
  }
}

}  // namespace plantloop
