// Pages and lists about block types.

#include "engine/graph/describe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "engine/base/numbers.h"

namespace plantloop {
namespace {

constexpr std::string_view format_version = "plantloop: 1";

struct Row {
  std::string name, standard, bounds, unit, doc;
};
struct Section {
  const char* title;
  std::vector<Row> rows;
};

std::string bounds_text(double min, double max, double above) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (above != -unbounded) add("> " + shortest(above));
  if (min != -unbounded) add(">= " + shortest(min));
  if (max != unbounded) add("<= " + shortest(max));
  return text;
}

std::string size_text(const Size& size) {
  switch (size.kind) {
    case Size::Kind::scalar:
      return "one number";
    case Size::Kind::any:
      return "any size";
    case Size::Kind::count:
      return fmt::format("{} numbers", size.count->name);
    case Size::Kind::fixed:
      return fmt::format("{} numbers", size.fixed);
    case Size::Kind::elementwise:
      break;
  }
  return {};
}

std::string joined(const std::string& a, const std::string& b) { return b.empty() ? a : a.empty() ? b : a + ", " + b; }

std::vector<Row> inputs_of(const Block& block) {
  std::vector<Row> rows;
  for (const Inputs* list : block.lists) {
    rows.push_back({std::string(list->name), "", "a list", std::string(list->spec.unit), std::string(list->spec.doc)});
  }
  for (const Input* input : block.inputs) {
    const InputSpec& s = input->spec;
    rows.push_back({std::string(input->name), std::isnan(s.init) ? "" : shortest(s.init), size_text(s.size),
                    std::string(s.unit), std::string(s.doc)});
  }
  return rows;
}

std::vector<Row> parameters_of(const BlockType& type) {
  const Block& block = *type.block;
  std::vector<Row> rows;
  for (const Number* n : block.numbers) {
    const NumberSpec& s = n->spec;
    const std::string standard = !std::isnan(s.init) ? shortest(s.init) : s.optional ? "none" : "required";
    rows.push_back({std::string(n->name), standard, joined(bounds_text(s.min, s.max, s.above), size_text(s.size)),
                    std::string(s.unit), std::string(s.doc)});
  }
  for (const Table* t : block.tables) {
    const TableSpec& s = t->spec;
    const std::string standard = !s.init.empty() ? std::string(s.init) : s.optional ? "none" : "required";
    rows.push_back({std::string(t->name), standard,
                    joined(bounds_text(s.min, s.max, s.above), s.ascending ? "ascending" : ""), std::string(s.unit),
                    std::string(s.doc)});
  }
  for (const Count* c : block.counts) {
    rows.push_back({std::string(c->name), std::to_string(c->spec.init),
                    fmt::format("whole, {} to {}", c->spec.min, c->spec.max), "", std::string(c->spec.doc)});
  }
  for (const Choice* c : block.choices) {
    std::string words;
    for (const std::string& word : c->words) words += (words.empty() ? "" : " | ") + word;
    rows.push_back({std::string(c->name), c->words.front(), words, "", std::string(c->doc)});
  }
  for (const Text* t : block.texts) {
    const bool own_form = !type.written.empty();
    const bool needed = (t->spec.file || own_form) && !t->spec.optional && t->spec.init.empty();
    rows.push_back({std::string(t->name), needed ? "required" : std::string(t->spec.init),
                    t->spec.file ? "a file"
                    : own_form   ? ""
                                 : "a text",
                    "", std::string(t->spec.doc)});
  }
  // In the order of declaration, whatever their kinds.
  std::vector<Row> ordered;
  for (const std::string_view name : block.settable) {
    for (Row& row : rows) {
      if (row.name == name) ordered.push_back(row);
    }
  }
  return ordered;
}

std::vector<Section> sections_of(const BlockType& type) {
  const Block& block = *type.block;
  std::vector<Section> sections{{"inputs", inputs_of(block)}, {"parameters", parameters_of(type)}};
  Section states{"states", {}};
  for (const State* s : block.states) {
    states.rows.push_back(
        {std::string(s->name), "", "continuous", std::string(s->spec.unit), std::string(s->spec.doc)});
  }
  for (const Discrete* s : block.discretes) {
    states.rows.push_back({std::string(s->name), "", "sampled", std::string(s->spec.unit), std::string(s->spec.doc)});
  }
  sections.push_back(std::move(states));
  Section outputs{"outputs", {}};
  for (const Output* o : block.outputs_declared) {
    outputs.rows.push_back(
        {std::string(o->name), "", size_text(o->spec.size), std::string(o->spec.unit), std::string(o->spec.doc)});
  }
  sections.push_back(std::move(outputs));
  return sections;
}

// A use that could be pasted: what must be given, and no more.
std::string shortest_use(const BlockType& type) {
  const Block& block = *type.block;
  std::string text = fmt::format("{{type: {}", type.name);
  if (!type.written.empty()) return fmt::format("{}, {}}}", text, type.written);
  std::vector<std::string_view> open;
  for (const Input* input : block.inputs) {
    if (std::isnan(input->spec.init)) open.push_back(input->name);
  }
  if (!block.lists.empty()) text += ", in: [a, b]";
  if (open.size() == 1) text += fmt::format(", in: {}", open[0]);
  if (open.size() > 1) {
    text += ", in: {";
    for (std::size_t i = 0; i < open.size(); ++i) text += fmt::format("{}{}: {}", i ? ", " : "", open[i], open[i]);
    text += "}";
  }
  for (const Number* n : block.numbers) {
    if (std::isnan(n->spec.init) && !n->spec.optional) text += fmt::format(", {}: 1", n->name);
  }
  for (const Table* t : block.tables) {
    if (t->spec.init.empty() && !t->spec.optional) text += fmt::format(", {}: [0, 1]", t->name);
  }
  for (const Text* t : block.texts) {
    if (t->spec.file && !t->spec.optional) text += fmt::format(", {}: models/a.yaml", t->name);
  }
  if (block.rate_kind() == RateKind::discrete) text += ", rate: 0.1";
  return text + "}";
}

std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? "\\|" : std::string(1, c);
  return out;
}

std::map<std::string_view, std::vector<const BlockType*>> by_group() {
  std::map<std::string_view, std::vector<const BlockType*>> groups;
  for (const BlockType& type : catalogue()) groups[type.group].push_back(&type);
  return groups;
}

// Lines of at most 100 characters, indented.
std::string wrapped(std::string_view text, const char* indent) {
  std::string out, line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
    const std::string_view word = text.substr(at, end - at);
    if (!line.empty() && line.size() + word.size() > 96) {
      out += indent + line + "\n";
      line.clear();
    }
    if (!word.empty()) line += (line.empty() ? "" : " ") + std::string(word);
    if (end < text.size() && text[end] == '\n') {
      out += indent + line + "\n";
      line.clear();
    }
    at = end + 1;
  }
  return line.empty() ? out : out + indent + line + "\n";
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

// A block's page, or its part of a longer one.
std::string block_section(const BlockType& type, std::string_view heading) {
  std::string text = fmt::format("{} {}\n\n{}\n\n", heading, type.name, type.summary);
  if (!type.details.empty()) text += fmt::format("```\n{}```\n\n", wrapped(type.details, ""));
  text += fmt::format("Group: {}. In short: `name: {}`\n", type.group, shortest_use(type));
  for (const Section& section : sections_of(type)) {
    if (section.rows.empty()) continue;
    const bool parameters =
        section.title == std::string_view("parameters") || section.title == std::string_view("inputs");
    text += fmt::format("\n{}# {}\n\n", heading, section.title);
    text += parameters ? "| name | default | unit | range | meaning |\n| --- | --- | --- | --- | --- |\n"
                       : "| name | unit | kind | meaning |\n| --- | --- | --- | --- |\n";
    for (const Row& row : section.rows) {
      text += fmt::format("| `{}` |", row.name);
      if (parameters) text += fmt::format(" {} |", cell(row.standard));
      text += fmt::format(" {} | {} | {} |\n", cell(row.unit), cell(row.bounds), cell(row.doc));
    }
  }
  if (type.example.empty()) return text;
  return text + fmt::format("\n{}# example\n\n```yaml\n{}\n{}```\n", heading, format_version, type.example);
}

}  // namespace

std::string block_text(const BlockType& type) {
  std::string text = fmt::format("{} ({}): {}\n\n{}", type.name, type.group, type.summary, wrapped(type.details, "  "));
  for (const Section& section : sections_of(type)) {
    if (section.rows.empty()) continue;
    std::size_t name = 0, standard = 0, unit = 0;
    for (const Row& row : section.rows) {
      name = std::max(name, row.name.size());
      standard = std::max(standard, row.standard.size());
      unit = std::max(unit, row.unit.size());
    }
    text += fmt::format("\n{}\n", section.title);
    for (const Row& row : section.rows) {
      std::string line = fmt::format("  {:<{}}", row.name, name);
      if (standard) line += fmt::format("  {:<{}}", row.standard, standard);
      if (unit) line += fmt::format("  {:<{}}", row.unit, unit);
      line += "  " + row.doc;
      if (!row.bounds.empty()) line += fmt::format(" ({})", row.bounds);
      text += line + "\n";
    }
  }
  if (!type.example.empty()) text += "\nexample\n";
  for (const std::string_view line : lines_of(type.example)) text += fmt::format("  {}\n", line);
  return text + fmt::format("\nin short\n  name: {}\n", shortest_use(type));
}

std::string block_markdown(const BlockType& type) { return block_section(type, "#"); }

std::string catalogue_text() {
  std::size_t width = 0;
  for (const BlockType& type : catalogue()) width = std::max(width, type.name.size());
  std::string text;
  for (const auto& [group, types] : by_group()) {
    text += fmt::format("{}{}\n", text.empty() ? "" : "\n", group);
    for (const BlockType* type : types) text += fmt::format("  {:<{}}  {}\n", type->name, width, type->summary);
  }
  return text;
}

std::string catalogue_markdown() {
  std::string text =
      "# Blocks\n\nMade from the declarations of the blocks by `plantloop blocks --markdown`. Any block also takes the "
      "keys\n"
      "that the [guide](guide.md) lists.\n";
  for (const auto& [group, types] : by_group()) {
    text += fmt::format("\n## Group: {}\n\n| block | what it does |\n| --- | --- |\n", group);
    for (const BlockType* type : types) {
      text += fmt::format("| [`{}`](#{}) | {} |\n", type->name, type->name, cell(std::string(type->summary)));
    }
  }
  for (const auto& [group, types] : by_group()) {
    for (const BlockType* type : types) text += "\n" + block_section(*type, "##");
  }
  return text;
}

}  // namespace plantloop
