// Reads hints by the rules of diagram files: unknown keys and names are errors.

#include "app/drawing/hints.h"

#include <memory>
#include <utility>

#include "engine/base/files.h"
#include "engine/diagram/document.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace {

std::vector<std::string> top_names(const Graph& graph) {
  std::vector<std::string> names;
  for (const BlockDecl& b : graph.scopes[0].type->blocks) names.push_back(b.name);
  return names;
}

// The names of a list that are blocks or subsystems of the diagram.
std::vector<std::string> names_of(const Section& section, std::string_view key, const Graph& graph, Report& report) {
  std::vector<std::string> names;
  const Node* list = section.find(key);
  if (list == nullptr) return names;
  if (!list->is_sequence()) {
    report.error(list->mark, "'{}' is a list of names, as in {}: [sensor]; got {}", key, key, describe(*list));
    return names;
  }
  for (const Node& item : list->items) {
    if (!require_text(item, "the name of a block", report)) continue;
    const Named named = find_named(graph, item.text);
    if (named.kind == Named::Kind::block || named.kind == Named::Kind::scope || named.kind == Named::Kind::net) {
      names.push_back(item.text);
    } else {
      report.error(item.mark, "the diagram has no block '{}'", item.text).suggest(item.text, top_names(graph));
    }
  }
  return names;
}

}  // namespace

std::optional<DrawingHints> read_hints(const std::string& path, const Graph& graph, Report& report) {
  FileResult file = read_file(path);
  if (!file.ok()) {
    report.error({}, "cannot read '{}': {}", path, file.error);
    return std::nullopt;
  }
  const auto source = std::make_shared<const Source>(Source{path, std::move(file.value)});
  report.keep(source);
  const Node root = read_document(source, report);
  if (report.has_errors()) return std::nullopt;
  const Section section(root, "the file of hints", {"forward", "feedback", "hide"}, report);
  DrawingHints hints;
  for (const std::string& name : names_of(section, "forward", graph, report))
    hints.directions.push_back({name, SheetHint::Where::forward});
  for (const std::string& name : names_of(section, "feedback", graph, report))
    hints.directions.push_back({name, SheetHint::Where::feedback});
  for (const std::string& name : names_of(section, "hide", graph, report)) hints.hidden.insert(name);
  if (report.has_errors()) return std::nullopt;
  return hints;
}

}  // namespace plantloop
