// Paths and numbers of a finished graph.

#include <algorithm>
#include <utility>

#include "engine/base/numbers.h"
#include "engine/graph/evaluate.h"
#include "engine/graph/graph.h"

namespace plantloop {
namespace {

template <typename List>
std::uint32_t index_of(const List& list, std::string_view name) {
  for (std::uint32_t i = 0; i < list.size(); ++i) {
    if (list[i].name == name) return i;
  }
  return nowhere;
}
template <typename List>
std::uint32_t index_of_declared(const List& list, std::string_view name) {
  for (std::uint32_t i = 0; i < list.size(); ++i) {
    if (list[i]->name == name) return i;
  }
  return nowhere;
}

Named named_of_block(const Graph& graph, std::uint32_t index, std::string_view rest) {
  const GraphBlock& block = graph.blocks[index];
  if (rest.empty()) return {Named::Kind::block, index};
  if (!block.type) return {};
  const Block& kind = *block.type->block;
  if (const auto i = index_of_declared(kind.outputs_declared, rest); i != nowhere)
    return {Named::Kind::net, block.first_output + i};
  if (const auto i = index_of_declared(kind.inputs, rest); i != nowhere)
    return {Named::Kind::net, block.first_input + i};
  const auto parameters = static_cast<std::uint32_t>(kind.numbers.size() + kind.tables.size() + kind.counts.size());
  for (std::uint32_t i = 0; i < parameters; ++i) {
    if (graph.parameters[block.first_parameter + i].name == rest)
      return {Named::Kind::parameter, block.first_parameter + i};
  }
  return {};
}

Named named_of_bus(const Graph& graph, const GraphBus& bus, std::string_view rest) {
  for (std::uint32_t i = 0; i < bus.declaration->in.size(); ++i) {
    if (bus.declaration->in[i].port == rest && graph.nets[bus.first_member + i].bus == nowhere)
      return {Named::Kind::net, bus.first_member + i};
  }
  return {};
}

// The names of an expression over parameters, looked up by path.
class PathNames final : public Names {
 public:
  PathNames(const Graph& graph, const Code& code, Report& report) : values_(code.names.size()) {
    for (std::size_t i = 0; i < code.names.size(); ++i) look_up(graph, *code.names[i], values_[i], report);
  }
  bool sound() const { return sound_; }
  Shape shape(std::uint32_t name) override { return values_[name].shape(); }
  Array value(std::uint32_t name) override { return values_[name]; }
  const Array* known(std::uint32_t name) override { return &values_[name]; }

 private:
  void look_up(const Graph& graph, const Expression& node, Array& value, Report& report) {
    if (node.parts.size() == 1) {
      const std::string& name = node.parts[0];
      if (name == "pi") return void(value = 3.14159265358979323846);
      if (name == "inf") return void(value = unbounded);
      if (name == "true") return void(value = 1.0);
      if (name == "false") return void(value = 0.0);
    }
    // The longest beginning that names a parameter; the rest are elements.
    for (std::size_t used = node.parts.size(); used > 0; --used) {
      std::string path;
      for (std::size_t i = 0; i < used; ++i) path += (i ? "." : "") + node.parts[i];
      const Named named = find_named(graph, path);
      if (named.kind != Named::Kind::parameter) continue;
      const GraphParameter& p = graph.parameters[named.index];
      if (p.text != nowhere || p.reads_signals || !p.shape.is_known()) break;
      if (take(p.value, node, used, value)) return;
      break;
    }
    sound_ = false;
    std::vector<std::string> names;
    for (const ParameterDecl& p : graph.scopes[0].type->parameters) names.push_back(p.name);
    Finding& finding = report.error(node.mark, "'{}' is no number that is known before the run", to_string(node));
    const std::string near = nearest(node.parts[0], names);
    if (!near.empty()) finding.hint(fmt::format("did you mean '{}'?", near));
  }

  static bool take(const Array& array, const Expression& node, std::size_t used, Array& value) {
    long index[2] = {0, 0};
    const std::size_t count = node.parts.size() - used;
    if (count == 0) return value = array, true;
    if (count > 2) return false;
    for (std::size_t i = 0; i < count; ++i) index[i] = parse_integer(node.parts[used + i]).value_or(0);
    const bool matrix = array.shape().rank == 2;
    const long last = std::max(index[0], node.slice_end);
    if (index[0] < 1 || (count == 2) != matrix || last > array.rows() ||
        (matrix && (index[1] < 1 || index[1] > array.columns()))) {
      return false;
    }
    value = element_of(array, static_cast<int>(index[0]), static_cast<int>(node.slice_end), static_cast<int>(index[1]));
    return true;
  }

  std::vector<Array> values_;
  bool sound_ = true;
};

}  // namespace

Named find_named(const Graph& graph, std::string_view path) {
  std::uint32_t s = 0;
  while (true) {
    const GraphScope& scope = graph.scopes[s];
    const TypeDecl& type = *scope.type;
    const std::size_t dot = path.find('.');
    const std::string_view head = path.substr(0, dot);
    const std::string_view rest = dot == std::string_view::npos ? std::string_view() : path.substr(dot + 1);
    if (rest.empty() && s != 0) {
      if (const auto i = index_of(type.outputs, head); i != nowhere) return {Named::Kind::net, scope.first_output + i};
    }
    if (const auto i = index_of(type.blocks, head); i != nowhere) {
      GraphChild child = graph.children[scope.first_child + i];
      std::string_view inside = rest;
      if (child.kind == GraphChild::Kind::repeat) {
        const GraphRepeat& repeat = graph.repeats[child.index];
        if (rest.empty()) return repeat.net != nowhere ? Named{Named::Kind::net, repeat.net} : Named{};
        const std::size_t end = std::min(rest.find('.'), rest.size());
        const long number = parse_integer(rest.substr(0, end)).value_or(0);
        if (number < 1 || number > static_cast<long>(repeat.count)) return {};
        child = graph.copies[repeat.first_copy + static_cast<std::uint32_t>(number) - 1];
        inside = end < rest.size() ? rest.substr(end + 1) : std::string_view();
      }
      if (child.kind == GraphChild::Kind::bus) return named_of_bus(graph, graph.buses[child.index], inside);
      if (child.kind == GraphChild::Kind::block) return named_of_block(graph, child.index, inside);
      if (child.kind == GraphChild::Kind::bad) return {};
      if (inside.empty()) return {Named::Kind::scope, child.index};
      s = child.index;
      path = inside;
      continue;
    }
    if (!rest.empty()) return {};
    if (const auto i = index_of(type.inputs, head); i != nowhere) return {Named::Kind::net, scope.first_input + i};
    if (const auto i = index_of(type.parameters, head); i != nowhere)
      return {Named::Kind::parameter, scope.first_parameter + i};
    return {};
  }
}

std::optional<Array> evaluate_number(const Graph& graph, const Expression& expression, Report& report) {
  CodeCache cache;
  const Code* code = cache.of(std::shared_ptr<const Expression>(std::shared_ptr<const Expression>(), &expression));
  PathNames names(graph, *code, report);
  if (!names.sound()) return {};
  Findings findings(report);
  if (!shape_of(*code, names, &findings).is_known()) return {};
  return evaluate(*code, names);
}

std::optional<double> evaluate_scalar(const Graph& graph, const Expression& expression, std::string_view what,
                                      Report& report) {
  const std::optional<Array> value = evaluate_number(graph, expression, report);
  if (!value) return {};
  if (value->size() == 1) return (*value)[0].number();
  report.error(expression.mark, "'{}' is one number, got {}", what, to_string(value->shape()));
  return {};
}

}  // namespace plantloop
