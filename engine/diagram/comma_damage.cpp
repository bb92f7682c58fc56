// Inside { } and [ ] a comma ends a value: recognised by a value with more ( than ), or a number, followed by entries
// without value. And a colon ends a key only when a space follows.

#include <fmt/format.h>

#include <algorithm>

#include "engine/base/numbers.h"
#include "engine/base/text.h"
#include "engine/diagram/tree.h"

namespace plantloop {
namespace {

int open_brackets(std::string_view text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '(') - std::count(text.begin(), text.end(), ')'));
}

bool cut(const Node& value) { return value.is_scalar() && !value.quoted && open_brackets(value.text) > 0; }

void say(Node& value, const Mark& last, std::string_view brackets, Report& report) {
  Mark whole = value.mark;
  if (last.line == whole.line && last.column >= whole.column) whole.length = last.column + last.length - whole.column;
  report.error(whole, "a comma ends a value inside {}: quote the expression, \"{}\"", brackets, value.text)
      .named("comma");
}

// How many entries after `at` belong to the value there: until its brackets are closed. 0 when they never are.
template <typename TextOf>
std::size_t belonging(const Node& node, std::size_t at, TextOf text_of) {
  int open = open_brackets(node.items[at].text);
  for (std::size_t i = at + 1; i < node.items.size(); ++i) {
    const std::string* text = text_of(i);
    if (!text) return 0;
    open += open_brackets(*text);
    if (open <= 0) return i - at;
  }
  return 0;
}

void erase(Node& node, std::size_t first, std::size_t end) {
  const auto from = static_cast<long>(first);
  const auto to = static_cast<long>(end);
  node.items.erase(node.items.begin() + from, node.items.begin() + to);
  if (!node.is_mapping()) return;
  node.keys.erase(node.keys.begin() + from, node.keys.begin() + to);
  node.key_marks.erase(node.key_marks.begin() + from, node.key_marks.begin() + to);
}

bool all_digits(std::string_view text) { return !text.empty() && std::all_of(text.begin(), text.end(), is_digit); }

// `{k: 1,5}`
void repair_decimal_commas(Node& node, Report& report) {
  for (std::size_t at = 0; at + 1 < node.items.size(); ++at) {
    Node& value = node.items[at];
    const bool number = value.is_scalar() && !value.quoted && parse_number(value.text).has_value();
    if (!number || node.items[at + 1].kind != Node::Kind::null || !all_digits(node.keys[at + 1])) continue;
    const std::string& decimals = node.keys[at + 1];
    Mark whole = value.mark;
    const Mark& last = node.key_marks[at + 1];
    if (last.line == whole.line) whole.length = last.column + last.length - whole.column;
    value.text += "." + decimals;
    report.error(whole, "a decimal number is written with a point: {}", value.text).named("comma");
    erase(node, at + 1, at + 2);
  }
}

}  // namespace

void repair_colons(Node& node, Report& report) {
  for (std::size_t i = 0; node.is_mapping() && i < node.items.size(); ++i) {
    if (node.items[i].kind != Node::Kind::null) continue;
    const std::string key = node.keys[i];
    const std::size_t colon = key.find(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == key.size() || !is_letter(key[colon - 1])) continue;
    Mark& mark = node.key_marks[i];
    Node& value = node.items[i];
    report.error(mark, "a space is missing after ':'")
        .hint(fmt::format("write {}: {}", key.substr(0, colon), key.substr(colon + 1)))
        .named("yaml");
    value.kind = Node::Kind::scalar;
    value.text = key.substr(colon + 1);
    value.mark = mark;
    value.mark.column += static_cast<std::uint32_t>(colon + 1);
    value.mark.length = static_cast<std::uint32_t>(key.size() - colon - 1);
    node.keys[i].resize(colon);
    mark.length = static_cast<std::uint32_t>(colon);
  }
}

void repair_commas(Node& node, Report& report) {
  const bool mapping = node.is_mapping();
  if (mapping) repair_decimal_commas(node, report);
  const auto text_of = [&](std::size_t i) -> const std::string* {
    const Node& item = node.items[i];
    if (mapping) return item.kind == Node::Kind::null ? &node.keys[i] : nullptr;
    return item.is_scalar() && !item.quoted ? &item.text : nullptr;
  };
  for (std::size_t at = 0; at < node.items.size(); ++at) {
    if (!cut(node.items[at])) continue;
    const std::size_t n = belonging(node, at, text_of);
    if (n == 0) continue;
    for (std::size_t i = at + 1; i <= at + n; ++i) {
      const std::string* part = text_of(i);
      if (part != nullptr) node.items[at].text.append(", ").append(*part);
    }
    say(node.items[at], mapping ? node.key_marks[at + n] : node.items[at + n].mark, mapping ? "{ }" : "[ ]", report);
    erase(node, at + 1, at + n + 1);
  }
}

}  // namespace plantloop
