// The files of a diagram and the types that each may name.

#include "engine/diagram/imports.h"

#include <algorithm>
#include <filesystem>

#include "engine/base/files.h"
#include "engine/diagram/read.h"
#include "engine/diagram/section.h"

namespace plantloop {
namespace fs = std::filesystem;
namespace {

std::string key_of(const std::string& path) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? path : real.string();
}

// The YAML files near a file that is not there, as somebody would write them.
std::vector<std::string> neighbours(const std::string& path, const std::string& written) {
  std::vector<std::string> names;
  std::error_code error;
  const fs::path folder = fs::path(path).parent_path();
  constexpr std::size_t most = 200;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
    if (entry.path().extension() != ".yaml" || names.size() >= most) continue;
    names.push_back((fs::path(written).parent_path() / entry.path().filename()).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

const Files::File& Files::add_root(const std::string& path, Node& root) {
  const std::string key = key_of(path);
  chain_.emplace_back(key, path);
  File& file = files_[key];
  file.scope = std::make_shared<FileScope>();
  file.scope->path = path;
  scopes.push_back(file.scope);
  read_types(file, root);
  const std::size_t errors = report_.error_count();
  read_imports(file, root);
  file.scope->incomplete = report_.error_count() > errors;
  file.complete = true;
  chain_.pop_back();
  return file;
}

void Files::read_types(File& file, Node& root) {
  Node* types = nullptr;
  for (std::size_t i = 0; i < root.keys.size(); ++i) {
    if (root.keys[i] == "types") types = &root.items[i];
  }
  if (!types) return;
  if (!types->is_mapping()) {
    report_.error(types->mark, "'types' is a mapping from names to types, here is {}", describe(*types)).named("kind");
    return;
  }
  for (std::size_t i = 0; i < types->keys.size(); ++i) {
    const auto type = read_type(types->keys[i], types->key_marks[i], types->items[i], report_);
    type->file = file.scope.get();
    file.own.emplace(type->name, type);
    file.scope->types.emplace(type->name, type);
  }
}

void Files::read_imports(File& file, const Node& root) {
  const Node* imports = root.find("import");
  if (!imports) return;
  if (imports->is_sequence()) {
    for (const Node& item : imports->items) {
      if (item.is_scalar()) {
        import(file, "", item);
        continue;
      }
      report_.error(item.mark, "an import is a path, here is {}", describe(item))
          .hint("prefixes are given by a mapping: import: {std: parts/control.yaml}")
          .named("kind");
    }
  } else if (imports->is_mapping()) {
    for (std::size_t i = 0; i < imports->items.size(); ++i) {
      check_name(imports->keys[i], imports->key_marks[i], "prefix", report_);
      if (require_text(imports->items[i], "an import", report_))
        import(file, imports->keys[i] + ".", imports->items[i]);
    }
  } else {
    Finding& finding =
        report_
            .error(imports->mark, "'import' is a list of files, or a mapping from prefixes to files; here is {}",
                   describe(*imports))
            .named("kind");
    if (imports->is_scalar()) finding.hint(fmt::format("write import: [{}]", imports->text));
  }
}

void Files::import(File& into, const std::string& prefix, const Node& path) {
  const FileResult resolved = resolve_path(project_, into.scope->path, path.text);
  if (!resolved.ok()) {
    report_.error(path.mark, "cannot import '{}': {}", path.text, resolved.error).named("import");
    return;
  }
  const File* file = load(resolved.value, path);
  if (!file) return;
  for (const auto& [name, type] : file->own) bring(into, prefix + name, type, path);
}

const Files::File* Files::load(const std::string& path, const Node& from) {
  const std::string key = key_of(path);
  if (const auto known = files_.find(key); known != files_.end()) {
    if (known->second.complete) return &known->second;
    if (chain_.back().first == key) {
      report_.error(from.mark, "this file imports itself").named("import");
      return nullptr;
    }
    std::string chain;
    bool inside = false;
    for (const auto& [open, written] : chain_) {
      inside = inside || open == key;
      if (inside) chain += written + " -> ";
    }
    report_.error(from.mark, "these files import each other: {}{}", chain, path).named("import");
    return nullptr;
  }
  constexpr std::size_t deepest = 50;
  if (chain_.size() > deepest) {
    report_.error(from.mark, "imports are nested more than {} files deep", deepest).named("import");
    return nullptr;
  }
  FileResult bytes = read_file(path);
  if (!bytes.ok()) {
    std::error_code error;
    Finding& finding = report_.error(from.mark, "cannot import '{}': {}", from.text, bytes.error).named("import");
    if (!fs::exists(path, error)) finding.suggest(from.text, neighbours(path, from.text));
    return nullptr;
  }
  const auto source = std::make_shared<const Source>(Source{path, std::move(bytes.value)});
  sources.push_back(source);
  Node root = read_document(source, report_);
  if (root.kind == Node::Kind::null || !check_top_level(root, report_)) return nullptr;
  return &add_root(path, root);
}

void Files::bring(File& into, const std::string& name, const std::shared_ptr<const TypeDecl>& type, const Node& from) {
  const auto [present, is_new] = into.scope->types.emplace(name, type);
  if (is_new) return;
  if (present->second == type) {
    report_.error(from.mark, "'{}' is imported twice", from.text).named("import");
    return;
  }
  report_.error(from.mark, "'{}' brings a type '{}', and there is one of that name already", from.text, name)
      .also(present->second->mark, "the one that is there")
      .also(type->mark, "the one that it brings")
      .hint("a prefix keeps them apart: import: {std: ...}, then std." + name)
      .named("duplicate-name");
}

namespace {

// `blocks:` with nothing below, and then keys that no diagram has: they were meant to stand inside.
bool check_indented(const Node& root, Report& report) {
  constexpr std::string_view sections[] = {"parameters", "blocks", "types", "simulation", "figures"};
  constexpr std::string_view others[] = {"plantloop", "title", "import", "record", "expect", "checks"};
  const auto among = [](const auto& list, const std::string& key) {
    return std::find(std::begin(list), std::end(list), key) != std::end(list);
  };
  for (std::size_t i = 0; i + 1 < root.keys.size(); ++i) {
    const std::string& next = root.keys[i + 1];
    if (root.items[i].kind != Node::Kind::null || !among(sections, root.keys[i])) continue;
    if (among(sections, next) || among(others, next)) continue;
    if (!nearest(next, {"parameters", "blocks", "types", "simulation", "figures", "record", "expect"}).empty())
      continue;
    report.error(root.key_marks[i + 1], "'{}' stands in the same column as '{}'", next, root.keys[i])
        .hint(fmt::format("what belongs to '{}' is indented, mostly by two spaces", root.keys[i]))
        .named("yaml");
    return false;
  }
  return true;
}

}  // namespace

bool check_top_level(const Node& root, Report& report) {
  if (!root.is_mapping()) {
    report
        .error(root.mark, "a diagram is a mapping with the keys plantloop, blocks, simulation...; here is {}",
               describe(root))
        .named("kind");
    return false;
  }
  const Node* version = root.find("plantloop");
  if (!version) {
    report.error(root.key_marks.empty() ? root.mark : root.key_marks.front(), "the format version is missing")
        .hint("a diagram begins with the line plantloop: 1")
        .named("version");
  } else if (!version->is_scalar() || version->text != "1") {
    report
        .error(version->mark, "this is format {}, and this program reads format 1",
               version->is_scalar() ? version->text : describe(*version))
        .named("version");
    return false;
  }
  if (root.keys.size() > 1 && !check_indented(root, report)) return false;
  const Section section(root, "a diagram",
                        {"plantloop", "title", "import", "parameters", "blocks", "types", "simulation", "record",
                         "figures", "expect", "checks"},
                        report);
  return true;
}

}  // namespace plantloop
