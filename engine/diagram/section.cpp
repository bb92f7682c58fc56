// Reading a mapping whose keys are known.

#include "engine/diagram/section.h"

#include <algorithm>
#include <unordered_set>
#include <variant>

#include "engine/base/numbers.h"
#include "engine/base/text.h"
#include "engine/base/units.h"

namespace plantloop {
namespace {

std::vector<std::string> strings(std::initializer_list<std::string_view> list) { return {list.begin(), list.end()}; }

// The key or value that a choice was probably meant to be, for what YAML 1.1 calls true and false.
std::string_view truth(std::string_view text) {
  constexpr std::string_view yes[] = {"yes", "on", "y", "1", "True", "TRUE"};
  constexpr std::string_view no[] = {"no", "off", "n", "0", "False", "FALSE"};
  if (std::find(std::begin(yes), std::end(yes), text) != std::end(yes)) return "true";
  if (std::find(std::begin(no), std::end(no), text) != std::end(no)) return "false";
  return {};
}

std::string suggested_name(std::string_view name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); i += character_length(name, i)) {
    out += is_letter(name[i]) || is_digit(name[i]) ? name[i] : '_';
  }
  if (!out.empty() && is_digit(out[0])) out.insert(out.begin(), '_');
  return out;
}

}  // namespace

Section::Section(const Node& node, std::string what, std::initializer_list<std::string_view> keys, Report& report)
    : Section(node, std::move(what), strings(keys), report) {}

Section::Section(const Node& node, std::string what, const std::vector<std::string>& keys, Report& report)
    : node_(node), what_(std::move(what)), report_(report), valid_(node.is_mapping()) {
  if (!valid_) {
    report.error(node.mark, "{} is a mapping, here is {}", what_, describe(node)).named("kind");
    return;
  }
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const std::string& key = node.keys[i];
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    has_unknown_keys_ = true;
    Finding& finding = report.error(node.key_marks[i], "{} has no key '{}'", what_, key).named("unknown-key");
    std::string near = nearest(key, keys);
    const std::string home = home_of(key);
    if (near.empty() && !home.empty()) finding.hint(fmt::format("'{}' belongs to {}", key, home));
    finding.suggest(key, keys);
    if (!near.empty()) meant_.push_back(std::move(near));
  }
}

const Mark& Section::mark_of(std::string_view key) const {
  for (std::size_t i = 0; i < node_.keys.size(); ++i) {
    if (node_.keys[i] == key) return node_.key_marks[i];
  }
  return node_.mark;
}

ExpressionPtr Section::expression(std::string_view key) const {
  const Node* node = find(key);
  return node ? parse_expression(*node, report_) : nullptr;
}

std::string Section::text(std::string_view key, std::string fallback) const {
  const Node* node = find(key);
  if (!node || !require_text(*node, fmt::format("'{}'", key), report_)) return fallback;
  return plain_text(*node, fmt::format("'{}'", key), report_);
}

std::string Section::unit(std::string_view key) const {
  const Node* node = find(key);
  if (!node || !require_text(*node, fmt::format("'{}'", key), report_)) return {};
  check_unit(*node, report_);
  return node->text;
}

std::string Section::choice(std::string_view key, std::initializer_list<std::string_view> choices,
                            std::string fallback) const {
  const Node* node = find(key);
  if (!node) return fallback;
  std::string chosen = to_choice(*node, key, choices, report_);
  return chosen.empty() ? fallback : chosen;
}

bool Section::boolean(std::string_view key, bool fallback) const {
  const Node* node = find(key);
  return node ? to_boolean(*node, key, fallback, report_) : fallback;
}

std::optional<long> Section::integer(std::string_view key) const {
  const Node* node = find(key);
  return node ? to_integer(*node, key, report_) : std::nullopt;
}

bool Section::require(std::string_view key, const Mark& owner, std::string_view example) const {
  if (!valid_ || find(key)) return valid_;
  if (std::find(meant_.begin(), meant_.end(), key) != meant_.end()) return false;
  report_.error(owner, "{} needs '{}'", what_, key).hint(fmt::format("for example {}", example)).named("missing-key");
  return false;
}

std::string describe(const Node& node) {
  switch (node.kind) {
    case Node::Kind::null:
      return "nothing";
    case Node::Kind::sequence:
      return fmt::format("a list of {}", node.items.size());
    case Node::Kind::mapping:
      return "a mapping";
    case Node::Kind::scalar:
      break;
  }
  constexpr std::size_t most = 40;
  if (parse_number(node.text)) return fmt::format("the number {}", node.text);
  if (count_characters(node.text) <= most) return fmt::format("'{}'", node.text);
  std::size_t end = 0;
  for (std::size_t i = 0; i < most; ++i) end += character_length(node.text, end);
  return fmt::format("'{}...'", node.text.substr(0, end));
}

std::string with_article(std::string_view what) {
  const bool vowel = !what.empty() && std::string_view("aeiou").find(what[0]) != std::string_view::npos;
  return fmt::format("{} {}", vowel ? "an" : "a", what);
}

bool require_text(const Node& node, std::string_view what, Report& report) {
  if (node.is_scalar()) return true;
  report.error(node.mark, "{} is a text, here is {}", what, describe(node)).named("kind");
  return false;
}

std::string plain_text(const Node& node, std::string_view what, Report& report) {
  if (node.quoted || !node.mark.source) return node.text;
  // A comment has a blank after #; `Motor #2` has none.
  const std::string_view source = node.mark.source->text;
  const std::string_view here = source.substr(std::min<std::size_t>(node.offset, source.size()));
  if (!here.starts_with(node.text)) return node.text;
  std::string_view rest = here.substr(node.text.size());
  rest = rest.substr(0, rest.find('\n'));
  const std::size_t hash = rest.find_first_not_of(' ');
  const bool cut = hash == 1 && rest[hash] == '#' && hash + 1 < rest.size() &&
                   (is_letter(rest[hash + 1]) || is_digit(rest[hash + 1]));
  if (cut) {
    report.warning(node.mark, "{} ends here, because ' #' begins a comment", what)
        .hint("quote the text if it goes on, or write a blank after #")
        .named("cut-by-comment");
  }
  return node.text;
}

bool to_boolean(const Node& node, std::string_view key, bool fallback, Report& report) {
  if (node.is_scalar() && (node.text == "true" || node.text == "false")) return node.text == "true";
  Finding& finding = report.error(node.mark, "'{}' is true or false, here is {}", key, describe(node)).named("choice");
  const std::string_view meant = node.is_scalar() ? truth(node.text) : std::string_view();
  if (!meant.empty()) finding.hint(fmt::format("write {}", meant));
  return fallback;
}

std::string to_choice(const Node& node, std::string_view key, const std::vector<std::string_view>& choices,
                      Report& report) {
  if (node.is_scalar() && std::find(choices.begin(), choices.end(), node.text) != choices.end()) return node.text;
  const std::vector<std::string> all(choices.begin(), choices.end());
  Finding& finding = report.error(node.mark, "'{}' is one of {}; here is {}", key, fmt::join(all, ", "), describe(node))
                         .named("choice");
  const std::string near = node.is_scalar() ? nearest(node.text, all) : std::string();
  if (!near.empty()) finding.hint(fmt::format("did you mean '{}'?", near));
  return {};
}

std::optional<long> to_integer(const Node& node, std::string_view key, Report& report) {
  const auto value = node.is_scalar() ? parse_integer(node.text) : std::nullopt;
  if (!value) report.error(node.mark, "'{}' is a whole number, here is {}", key, describe(node)).named("kind");
  return value;
}

void check_unit(const Node& node, Report& report) {
  const auto unit = parse_unit(node.text);
  const auto* error = std::get_if<UnitError>(&unit);
  if (!error) return;
  Mark mark = node.mark;
  if (!node.quoted) {
    mark.column += static_cast<std::uint32_t>(count_characters(std::string_view(node.text).substr(0, error->at)));
    const auto length = count_characters(std::string_view(node.text).substr(error->at, error->length));
    mark.length = static_cast<std::uint32_t>(std::max<std::size_t>(1, length));
  }
  Finding& finding = report.error(mark, "{}", error->message).named("unit");
  if (!error->hint.empty()) finding.hint(error->hint);
}

bool check_name(const std::string& name, const Mark& mark, std::string_view what, Report& report) {
  static const std::unordered_set<std::string> reserved(reserved_names().begin(), reserved_names().end());
  if (!is_identifier(name)) {
    Finding& finding = report.error(mark, "'{}' cannot be the name of {}", name, with_article(what)).named("name");
    finding.hint("names are ASCII letters, digits and _, and begin with no digit");
    if (const std::string near = suggested_name(name);
        is_identifier(near) && near.find_first_not_of('_') != near.npos) {
      finding.hint(fmt::format("for example {}", near));
    }
    return false;
  }
  if (reserved.contains(name)) {
    const bool is_function = std::any_of(expression_functions().begin(), expression_functions().end(),
                                         [&](const FunctionSignature& f) { return f.name == name; });
    report
        .error(mark, "'{}' cannot be the name of {}: it is {}", name, with_article(what),
               is_function ? "a function" : "reserved")
        .named("name");
    return false;
  }
  return true;
}

std::string home_of(std::string_view key) {
  struct Home {
    std::string_view key, home;
  };
  constexpr Home homes[] = {
      {"stop", "simulation"},
      {"start", "simulation"},
      {"solver", "simulation"},
      {"step", "simulation"},
      {"rtol", "simulation"},
      {"atol", "simulation"},
      {"max_step", "simulation"},
      {"event_tol", "simulation"},
      {"output_interval", "simulation"},
      {"max_steps", "simulation"},
      {"max_rows", "simulation"},
      {"zeno", "simulation"},
      {"loops", "simulation"},
      {"seed", "simulation"},
      {"strict", "simulation"},
      {"panels", "a figure"},
      {"inputs", "a type"},
      {"outputs", "a type"},
      {"blocks", "the top level or a type"},
      {"parameters", "the top level or a type"},
      {"types", "the top level"},
      {"import", "the top level"},
      {"simulation", "the top level"},
      {"record", "the top level"},
      {"figures", "the top level"},
      {"expect", "the top level"},
      {"checks", "the top level"},
      {"plantloop", "the top level"},
      {"type", "a block"},
      {"rate", "a block"},
      {"reset", "a block"},
      {"in", "a block"},
  };
  for (const Home& entry : homes) {
    if (entry.key == key) return std::string(entry.home);
  }
  return {};
}

}  // namespace plantloop
