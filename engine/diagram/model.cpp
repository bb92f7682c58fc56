// Diagram files -> Model.

#include "engine/diagram/model.h"

#include <algorithm>
#include <utility>

#include "engine/base/files.h"
#include "engine/diagram/imports.h"
#include "engine/diagram/read.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace {

// The parameters and blocks of the diagram itself.
std::shared_ptr<TypeDecl> read_top(Node& root, Report& report) {
  auto top = std::make_shared<TypeDecl>();
  top->mark = root.mark;
  for (std::size_t i = 0; i < root.keys.size(); ++i) {
    if (root.keys[i] == "parameters") top->parameters = read_parameters(root.items[i], false, report);
    if (root.keys[i] == "blocks") top->blocks = read_blocks(root.items[i], report);
  }
  check_scope(*top, report);
  return top;
}

void read_sections(const Node& root, const PlotWords& plots, Model& model, Report& report) {
  for (std::size_t i = 0; i < root.keys.size(); ++i) {
    const std::string& key = root.keys[i];
    const Node& value = root.items[i];
    if (key == "title" && require_text(value, "'title'", report)) model.title = plain_text(value, "'title'", report);
    if (key == "simulation") {
      model.simulation = read_simulation(value, root.key_marks[i], report);
      model.has_simulation = true;
    }
    if (key == "record") {
      model.record = read_record(value, report);
      model.has_record = true;
    }
    if (key == "figures") model.figures = read_figures(value, plots, report);
    if (key == "expect") model.expect = read_expect(value, report);
    if (key == "checks") model.checks = read_checks(value, report);
  }
  std::map<std::string, Level, std::less<>> levels;
  for (const auto& [id, level] : model.checks) levels.emplace(id, level_named(level).value_or(Level::error));
  report.set_levels(std::move(levels));
  if (model.simulation.strict) report.make_strict();
}

void check_library(const Node& root, Model& model, Report& report) {
  const bool has_blocks = root.find("blocks") != nullptr;
  model.is_library = !has_blocks && !model.has_simulation && root.find("types") != nullptr;
  const bool misspelt = std::any_of(root.keys.begin(), root.keys.end(), [](const std::string& key) {
    return !nearest(key, {"blocks", "types"}).empty();
  });
  if (has_blocks || model.is_library || misspelt) return;
  report.error(root.key_marks.empty() ? root.mark : root.key_marks.front(), "this diagram has no blocks")
      .hint("for example blocks: {y: {type: integrator, in: 1 - y}}")
      .named("missing-key");
}

std::shared_ptr<const Model> build(std::string text, const std::string& path, const PlotWords& plots, Report& report) {
  const std::size_t errors = report.error_count();
  const auto source = std::make_shared<const Source>(Source{path, std::move(text)});
  Node root = read_document(source, report);
  const std::size_t errors_of_yaml = report.error_count();
  if (root.kind == Node::Kind::null || !check_top_level(root, report)) return nullptr;
  auto model = std::make_shared<Model>();
  model->is_broken = report.error_count() > errors_of_yaml;
  model->path = path;
  model->project = project_folder(path);
  Files files(model->project, report);
  const Files::File& file = files.add_root(path, root);
  const auto top = read_top(root, report);
  top->file = file.scope.get();
  model->top = top;
  model->files = std::move(files.scopes);
  model->sources = std::move(files.sources);
  model->sources.insert(model->sources.begin(), source);
  read_sections(root, plots, *model, report);
  const std::size_t errors_of_parts = report.error_count();
  check_library(root, *model, report);
  check_containment(*model, report);
  model->is_broken = model->is_broken || report.error_count() > errors_of_parts;
  model->has_errors = report.error_count() > errors;
  return model;
}

}  // namespace

std::shared_ptr<const Model> read_model(const std::string& path, Report& report, const PlotWords& plots) {
  FileResult file = read_file(path);
  if (!file.ok()) {
    report.error({}, "cannot read '{}': {}", path, file.error).named("file");
    return nullptr;
  }
  return build(std::move(file.value), path, plots, report);
}

std::shared_ptr<const Model> read_model_text(const std::string& text, const std::string& path, Report& report,
                                             const PlotWords& plots) {
  return build(text, path, plots, report);
}

}  // namespace plantloop
