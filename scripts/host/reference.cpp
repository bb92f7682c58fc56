// The functions of scripts as a page of documentation, made from the tables that register them.

#include <fmt/format.h>

#include <string>

#include "identify/fit/training.h"
#include "identify/gp/covariance.h"
#include "identify/mlp/activation.h"
#include "identify/rbf/radial.h"
#include "scripts/host/api.h"
#include "scripts/host/host.h"

namespace plantloop {
namespace lua {
namespace {

// Options whose values are names of a catalogue.
std::string catalogue_of(std::string_view option) {
  std::vector<std::string> names;
  if (option == "activation") names = identify::activation_names();
  if (option == "function") names = identify::radial_names();
  if (option == "method") {
    using enum identify::TrainingMethod;
    names = {name_of(levenberg_marquardt), name_of(gauss_newton), name_of(back_propagation)};
  }
  if (option == "covariance") {
    for (const identify::CovarianceType& type : identify::covariances()) names.emplace_back(type.name);
  }
  if (names.empty()) return {};
  return fmt::format("one of `{}`{}", fmt::join(names, "`, `"),
                     option == "covariance" ? ", or a sum or product of them: `se_ard*(periodic + linear)`" : "");
}

// A type as people read it: names in code, alternatives with "or".
std::string type_text(std::string_view name, std::string_view type) {
  if (type == "string") {
    const std::string names = catalogue_of(name);
    if (!names.empty()) return names;
  }
  std::string text = "`";
  for (const char c : type) {
    if (c == '|') {
      text += "` or `";
    } else {
      text += c;
    }
  }
  return text + "`";
}

bool is_optional(std::string_view name) { return name.ends_with('?'); }
std::string_view bare(std::string_view name) { return is_optional(name) ? name.substr(0, name.size() - 1) : name; }

// The options of a parameter that is a table of them, one line each.
std::string option_lines(std::string_view type) {
  if (!type.starts_with('{') || !type.ends_with('}') || type.find(": ") == std::string_view::npos) return {};
  std::string text;
  for (const auto& [name, own] : split_parameters(type.substr(1, type.size() - 2)))
    text +=
        fmt::format("  - `{}`{}: {}\n", bare(name), is_optional(name) ? "" : " (needed)", type_text(bare(name), own));
  return text;
}

std::string function_text(const std::string& prefix, const Entry& entry) {
  std::string names, lines;
  for (const auto& [name, type] : split_parameters(entry.parameters)) {
    names += (names.empty() ? "" : ", ") + name;
    const std::string options = option_lines(type);
    lines += options.empty() ? fmt::format("- `{}`: {}\n", bare(name), type_text(bare(name), type))
                             : fmt::format("- `{}`, a table:\n{}", bare(name), options);
  }
  std::string text = fmt::format("\n### `{}{}({})`\n\n{}", prefix, entry.name, names, entry.doc);
  if (!entry.returns.empty()) text += fmt::format("{} Gives `{}`.", entry.doc.empty() ? "" : ".", entry.returns);
  text += "\n";
  return lines.empty() ? text : text + "\n" + lines;
}

}  // namespace
}  // namespace lua

std::string lua_reference() {
  std::string text =
      "# Functions of scripts\n\n"
      "<!-- Made by `plantloop schema --functions`; a build brings it up to date. -->\n\n"
      "What `require \"plantloop\"` and its objects offer, from the program's own table: an option that is not listed "
      "is an "
      "error. The [guide](guide.md) shows how the parts play together. `plantloop schema --lua` prints the same as "
      "declarations for editors.\n";
  for (const lua::TypeInfo& type : lua::api()) {
    const bool is_module = type.name == "pl", is_table = lua::is_table_of_functions(type.name);
    const std::string name = is_module ? "pl" : fmt::format("pl.{}", type.name);
    text += fmt::format("\n## `{}`\n\n{}\n", name, type.doc);
    for (const lua::FieldInfo& field : type.fields)
      text += fmt::format("{}- `.{}`: `{}`, {}\n", &field == type.fields.data() ? "\n" : "", field.name, field.type,
                          field.doc);
    std::string prefix = name + ".";
    if (!is_module && !is_table) {
      prefix = std::string(type.name) + ":";
      for (char& c : prefix) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
      if (prefix.ends_with("model:") || prefix.starts_with("neural")) prefix = "model:";
      if (prefix == "dataset:") prefix = "data:";
    }
    for (const lua::Entry& entry : type.entries) text += lua::function_text(prefix, entry);
  }
  return text;
}

}  // namespace plantloop
