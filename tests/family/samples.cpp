// Required parameters get small numbers that keep the bounds; sizes are tried until the diagram is right.

#include "tests/family/samples.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "tests/blocks/diagrams.h"

namespace plantloop::family {
namespace {

double fitting(double wanted, double min, double max, double above) {
  if (wanted < min) wanted = min;
  if (wanted > max) wanted = max;
  return wanted > above ? wanted : above + 1;
}

// What tables are filled with.
enum class Fill { vectors, numbers, matrices };

// Capital letters are matrices; the zero in the corner is there so that zeros matter.
std::string table_value(const Table& table, Fill fill) {
  const TableSpec& spec = table.spec;
  if (fill == Fill::numbers) return fmt::format("{}", fitting(0.3, spec.min, spec.max, spec.above));
  if (table.name.size() == 1 && table.name[0] >= 'A' && table.name[0] <= 'Z') return "[[-1, 0.5], [0.25, 0]]";
  if (spec.ascending) return "[0, 1, 2]";
  const auto number = [&](double wanted) { return fmt::format("{}", fitting(wanted, spec.min, spec.max, spec.above)); };
  const std::string row = fmt::format("[{}, {}, {}]", number(1), number(2), number(3));
  return fill == Fill::matrices ? fmt::format("[{}, [{}, {}, {}], {}]", row, number(3), number(2), number(4), row)
                                : row;
}

std::string record_list(const Sample& sample, const std::string& name) {
  std::string text;
  for (const std::string& output : sample.outputs(name)) text += (text.empty() ? "" : ", ") + output;
  return text;
}

// A block of a learned model has its model file; every other one reads a table.
std::string file_for(const BlockType& type) {
  const std::string model = fmt::format("tests/blocks/models/{}.yaml", type.name);
  return std::filesystem::exists(model) ? model : "tests/blocks/signals.csv";
}

Sample with_parameters(const BlockType& type, Fill fill) {
  Sample sample;
  sample.type = &type;
  const Block& block = *type.block;
  for (const Number* n : block.numbers) {
    if (!std::isnan(n->spec.init) || n->spec.optional) continue;
    sample.parameters.emplace_back(n->name, fmt::format("{}", fitting(1, n->spec.min, n->spec.max, n->spec.above)));
  }
  for (const Table* t : block.tables) {
    if (t->spec.init.empty() && !t->spec.optional) sample.parameters.emplace_back(t->name, table_value(*t, fill));
  }
  for (const Text* t : block.texts) {
    if (t->spec.file && !t->spec.optional) sample.parameters.emplace_back(t->name, file_for(type));
  }
  sample.list = !block.lists.empty();
  sample.written = type.written;
  sample.sampled = block.rate_kind() == RateKind::discrete;
  return sample;
}

// Vectors, single numbers or matrices for tables; every combination of 1, 2 and 3 elements for the ports of a size
// of their own.
std::vector<Sample> candidates(const BlockType& type) {
  if (!type.written.empty()) {
    Sample sample = with_parameters(type, Fill::vectors);
    sample.parameters.clear();
    sample.inputs.emplace_back("a", 1);
    return {sample};
  }
  std::vector<Sample> found{with_parameters(type, Fill::vectors), with_parameters(type, Fill::numbers),
                            with_parameters(type, Fill::matrices)};
  const auto extend = [&](const std::string& port, const Size& size) {
    std::vector<Sample> longer;
    for (const Sample& sample : found) {
      for (int elements = 1; elements <= (size.kind == Size::Kind::any ? 3 : 1); ++elements) {
        longer.push_back(sample);
        longer.back().inputs.emplace_back(port, size.kind == Size::Kind::fixed ? size.fixed : elements);
      }
    }
    found = longer;
  };
  if (!type.block->lists.empty()) {
    for (const char* entry : {"1", "2", "3"}) extend(entry, Size());
  }
  for (const Input* input : type.block->inputs) {
    if (std::isnan(input->spec.init)) extend(std::string(input->name), input->spec.size);
  }
  Sample closed = with_parameters(type, Fill::vectors);
  closed.closed = true;
  for (const Input* input : type.block->inputs) closed.inputs.emplace_back(input->name, 1);
  if (!closed.inputs.empty()) found.push_back(closed);
  return found;
}

Sample first_that_checks(const BlockType& type) {
  std::string why;
  for (const Sample& sample : candidates(type)) {
    const std::string findings = testing_diagrams::findings(diagram(sample));
    if (findings.empty()) return sample;
    why = findings;
  }
  throw std::runtime_error(
      fmt::format("no sample of block type '{}' is without findings; the last one:\n{}", type.name, why));
}

}  // namespace

std::string wire(const std::string& signal, int elements) {
  if (elements == 1) return signal;
  std::string text = "[" + signal;
  for (int i = 1; i < elements; ++i) text += fmt::format(", (1 - {}/10)*{}", i, signal);
  return text + "]";
}

std::string Sample::instance(const std::string& name, const std::string& prefix) const {
  std::string text = fmt::format("  {}:\n    type: {}\n", name, type->name);
  if (!written.empty()) {
    std::string keys(written);
    for (const auto& [parameter, value] : parameters) keys += fmt::format(", {}: {}", parameter, value);
    text = fmt::format("  {}:\n    {{type: {}, {}}}\n", name, type->name, keys);
    if (const std::size_t at = text.find(": a}"); at != std::string::npos)
      return text.replace(at, 3, fmt::format(": {}1", prefix));
    // Entries are conditional blocks, active one after the other.
    text.replace(text.find("[low, high]"), 11, fmt::format("[{}_low, {}_high]", name, name));
    text += fmt::format("  {}_low: {{expr: {}1, enable: {{when: sin(3*time), initial: 0}}}}\n", name, prefix);
    return text + fmt::format("  {}_high: {{expr: 2*{}1, enable: {{when: -sin(3*time), initial: 0}}}}\n", name, prefix);
  }
  if (sampled) text += "    rate: 0.1\n";
  for (const auto& [parameter, value] : parameters) text += fmt::format("    {}: {}\n", parameter, value);
  if (inputs.empty()) return text;
  text += "    in:";
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const std::string own = closed ? " - " + name : "";
    const std::string signal = wire(fmt::format("{}{}{}", prefix, i + 1, own), inputs[i].second);
    text += list ? fmt::format("\n      - {}", signal) : fmt::format("\n      {}: {}", inputs[i].first, signal);
  }
  return text + "\n";
}

std::vector<std::string> Sample::outputs(const std::string& name) const {
  std::vector<std::string> names;
  for (const Output* output : type->block->outputs_declared) names.push_back(fmt::format("{}.{}", name, output->name));
  return names;
}

std::string diagram(const Sample& sample) {
  std::string text = "blocks:\n";
  for (std::size_t i = 0; i < sample.inputs.size(); ++i) {
    text += fmt::format("  in{}: 0.7 + 0.4*sin({}*time + {})\n", i + 1, i + 1, 0.3 * static_cast<double>(i));
  }
  return text + sample.instance("it") + "simulation: {stop: 2}\nrecord: [" + record_list(sample, "it") + "]\n";
}

const std::vector<Sample>& samples() {
  static const std::vector<Sample> all = [] {
    std::vector<Sample> list;
    for (const BlockType& type : catalogue()) list.push_back(first_that_checks(type));
    return list;
  }();
  return all;
}

}  // namespace plantloop::family
