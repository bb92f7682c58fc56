// YAML's syntax errors in plain words: what stands at the place decides, not the parser's message alone.

#include <fmt/format.h>

#include <vector>

#include "engine/base/text.h"
#include "engine/diagram/tree.h"

namespace plantloop {
namespace {

constexpr auto npos = std::string_view::npos;

struct Line {
  std::size_t begin = 0;
  std::string_view text;
  std::size_t indent() const { return std::min(text.find_first_not_of(" \t"), text.size()); }
  bool blank() const { return indent() == text.size() || text[indent()] == '#'; }
};

Line line_around(std::string_view source, std::size_t at) {
  const std::size_t before = at == 0 ? npos : source.rfind('\n', at - 1);
  const std::size_t begin = before == npos ? 0 : before + 1;
  std::string_view text = source.substr(begin, source.find('\n', begin) - begin);
  if (text.ends_with('\r')) text.remove_suffix(1);
  return {begin, text};
}

// The line with something on it above another, or an empty one.
Line line_above(std::string_view source, Line line) {
  while (line.begin > 0) {
    line = line_around(source, line.begin - 1);
    if (!line.blank()) return line;
  }
  return {};
}

// The bracket { or [ that is open at `end`, by a scan that skips quotes and comments; npos when there is none.
std::size_t open_bracket(std::string_view source, std::size_t end) {
  std::vector<std::size_t> open;
  char quote = '\0';
  for (std::size_t i = 0; i < end; ++i) {
    const char c = source[i];
    const bool begins_token = i == 0 || std::string_view(" \t\n,[{:").find(source[i - 1]) != npos;
    if (quote != '\0') {
      if (c == '\\' && quote == '"')
        ++i;
      else if (c == quote)
        quote = '\0';
    } else if ((c == '"' || c == '\'') && begins_token) {
      quote = c;
    } else if (c == '#' && (i == 0 || source[i - 1] == ' ' || source[i - 1] == '\n')) {
      i = std::min(source.find('\n', i), end);
    } else if ((c == '{' || c == '[') && (begins_token || !open.empty())) {
      open.push_back(i);
    } else if ((c == '}' || c == ']') && !open.empty()) {
      open.pop_back();
    }
  }
  return open.empty() ? npos : open.back();
}

// `in: dot([1, 2], x)` inside { }: the value's text ends before the bracket.
bool bracket_in_value(std::string_view source, std::size_t at, std::size_t& begin) {
  const Line line = line_around(source, at);
  const std::string_view before = line.text.substr(0, std::min(at - line.begin + 1, line.text.size()));
  const std::size_t bracket = before.find_last_of("[{");
  if (bracket == npos || bracket == 0) return false;
  const char c = before[bracket - 1];
  const bool inside_value = is_letter(c) || is_digit(c) || std::string_view("(*+-/^)").find(c) != npos ||
                            (c == ' ' && bracket > 1 && std::string_view("(*+-/^").find(before[bracket - 2]) != npos);
  if (!inside_value) return false;
  const std::size_t colon = before.substr(0, bracket).rfind(": ");
  begin = line.begin + (colon == npos ? line.indent() : colon + 2);
  return true;
}

// Where the value that holds `at` begins in its line.
std::size_t value_begin(const Line& line, std::size_t at) {
  std::size_t begin = line.indent();
  for (std::size_t i = begin + 1; i < line.text.size() && line.begin + i <= at; ++i) {
    const char before = line.text[i - 1];
    const bool after_space = before == ' ' && i > 1 && std::string_view(":,-").find(line.text[i - 2]) != npos;
    if (line.text[i] != ' ' && (after_space || before == '[' || before == '{')) begin = i;
  }
  return line.begin + begin;
}

// `θ [rad]` inside { }: the bracket at `at` ends the text before it.
bool bracket_in_text(std::string_view source, std::size_t at, std::size_t& begin) {
  if (source[at] != '[' && source[at] != '{') return false;
  const Line line = line_around(source, at);
  const std::string_view before = line.text.substr(0, at - line.begin);
  const std::size_t last = before.find_last_not_of(' ');
  if (last == npos || std::string_view(",:[{}]\"'-").find(before[last]) != npos) return false;
  const std::size_t separator = before.find_last_of(",[{");
  const std::size_t colon = before.rfind(": ");
  const std::size_t from = std::max(separator == npos ? 0 : separator + 1, colon == npos ? 0 : colon + 1);
  begin = line.begin + std::min(before.find_first_not_of(' ', from), last);
  return true;
}

// A second entry begins at `at`, or before the ':' there, and no comma stands between: where it begins; npos when
// something else is wrong.
std::size_t entry_without_comma(std::string_view source, std::size_t open, std::size_t at) {
  const Line line = line_around(source, at);
  if (at >= source.size() || open < line.begin || std::string_view("}],").find(source[at]) != npos) return npos;
  if (source[at] != ':') return at;
  std::size_t word = at - line.begin;
  while (word > 0 && (is_letter(line.text[word - 1]) || is_digit(line.text[word - 1]))) --word;
  const std::size_t last = word == 0 ? npos : line.text.find_last_not_of(' ', word - 1);
  if (last == npos || last + 1 == word || std::string_view(":,{[").find(line.text[last]) != npos) return npos;
  return line.begin + word;
}

// `plantloop:1`: the end of the key, npos when the line has no such.
std::size_t colon_without_space(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(" -"), text.size());
  std::size_t end = begin;
  while (end < text.size() && (is_letter(text[end]) || is_digit(text[end]))) ++end;
  const bool glued = end > begin && end + 1 < text.size() && text[end] == ':' && text[end + 1] != ' ';
  return glued ? end : npos;
}

Words misplaced_colon(std::string_view source, std::size_t at) {
  const Line line = line_around(source, at);
  const std::string_view before = line.text.substr(0, at - line.begin);
  if (const std::size_t brace = before.find('{'); brace != npos && before.find(':') > brace) {
    const std::string_view name =
        before.substr(line.indent(), before.find_last_not_of(' ', brace - 1) + 1 - line.indent());
    if (brace > line.indent() && !name.empty()) {
      return {line.begin + line.indent(), name.size(), fmt::format("a ':' is missing after '{}'", name),
              "an entry is written 'key: value'"};
    }
  }
  if (const std::size_t colon = before.find(": "); colon != npos) {
    const std::size_t value = std::min(before.find_first_not_of(' ', colon + 1), before.size());
    return {line.begin + value, line.text.size() - value, "a value cannot contain ': ' unless it is quoted",
            "quote the value, or put what follows on a line of its own"};
  }
  const Line above = line_above(source, line);
  const std::size_t above_colon = above.text.find(':');
  const std::size_t indent = line.indent();
  if (above_colon == npos && !above.text.empty()) {
    std::string_view words = above.text.substr(above.indent());
    words = words.substr(0, words.find(" #"));
    return {above.begin + above.indent(), words.size(), "this line has no ':'", "an entry is written 'key: value'"};
  }
  if (above.text.empty()) return {at, 1, "':' cannot stand here", {}};
  if (const std::size_t end = colon_without_space(above.text); end != npos) {
    const std::size_t begin = above.text.find_first_not_of(" -");
    return {above.begin + begin, end + 2 - begin, "a space is missing after ':'",
            fmt::format("write {}: {}", above.text.substr(begin, end - begin), above.text.substr(end + 1))};
  }
  if (indent > above.indent()) {
    return {line.begin + indent, before.size() - indent,
            "this line is indented deeper than the one above, but that one has its value already",
            "entries of one mapping begin in the same column"};
  }
  return {line.begin + indent, before.size() - indent, "this line is indented differently from its neighbours",
          "entries of one mapping begin in the same column"};
}

}  // namespace

Words plain_words(std::string_view source, std::size_t at, std::string_view message) {
  at = std::min(at, source.size());
  const Line line = line_around(source, at);
  if (const std::size_t begin = value_begin(line, at);
      begin < at && std::string_view("!&*").find(source[begin]) != npos) {
    at = begin;
    message = "";
  }
  const char c = at < source.size() ? source[at] : '\0';
  const std::size_t tab = line.text.substr(0, line.indent()).find('\t');
  const std::size_t open = open_bracket(source, at);
  if (tab != npos && open == npos) {
    return {line.begin + tab, 1, "a tab stands in the indentation", "YAML indents with spaces"};
  }
  std::size_t begin = at;
  if (open != npos && bracket_in_value(source, at, begin)) {
    return {begin, 1, "a bracket ends a value inside { } and [ ]: quote the expression", {}};
  }
  const bool flow_end = message.find("flow not found") != npos;
  if (open != npos && at < source.size() && bracket_in_text(source, at, begin)) {
    const std::string_view text = source.substr(begin, source.find_first_of("]}\n", at) + 1 - begin);
    return {begin, text.size(), "a bracket ends a text inside { } and [ ]: quote the text",
            fmt::format("write \"{}\"", text.substr(0, text.find_last_not_of("\r\n") + 1))};
  }
  if (flow_end && (c == '}' || c == ']') && open != npos) {
    return {at,
            1,
            fmt::format("'{}' does not close '{}': a '{}' is missing before it", c, source[open], c == '}' ? ']' : '}'),
            {}};
  }
  if (const std::size_t entry = flow_end && open != npos ? entry_without_comma(source, open, at) : npos;
      entry != npos) {
    return {entry, 1, "a comma is missing before this entry",
            fmt::format("between {} entries are separated by commas", source[open] == '{' ? "{ }" : "[ ]")};
  }
  if (flow_end && open != npos) {
    return {open, 1, fmt::format("the bracket '{}' is never closed", source[open]), {}};
  }
  if (message == "illegal map value") return misplaced_colon(source, at);
  if (message == "illegal block entry" || (c == '-' && message.find("block entry") != npos)) {
    return {at, 1, "'- ' begins an entry of a list, which cannot stand here",
            "a minus is written without a space, -x, or the value is quoted"};
  }
  if (c == '*' || message.find("alias") != npos || message.find("anchor is not defined") != npos) {
    return {at, 1, "YAML takes a text that begins with '*' for a reference: quote it", {}};
  }
  if (c == '&' || message.find("anchor") != npos) {
    return {at, 1, "YAML takes a text that begins with '&' for the name of a node: quote it", {}};
  }
  if (c == '!' || message.find("tag") != npos) {
    return {at, 1, "YAML takes a text that begins with '!' for a tag: quote it", "'not' is written as a word: not a"};
  }
  if (c == '@' || c == '`' || c == '%' || message == "unknown token") {
    const std::size_t size = at < source.size() ? character_length(source, at) : 1;
    return {at, size, fmt::format("a value cannot begin with '{}' unless it is quoted", source.substr(at, size)), {}};
  }
  if ((c == '}' || c == ']') && open != npos && (source[open] == '{') != (c == '}')) {
    return {at,
            1,
            fmt::format("'{}' does not close '{}': a '{}' is missing before it", c, source[open], c == '}' ? ']' : '}'),
            {}};
  }
  if (c == '}' || c == ']') return {at, 1, fmt::format("'{}' closes a bracket that was never opened", c), {}};
  if (message.find("escape") != npos) {
    return {at, 1, "this is no escape that YAML knows", "in single quotes a backslash is a backslash"};
  }
  if (message.find("end of map") != npos || message.find("end of sequence") != npos) {
    const std::string_view before = line.text.substr(0, std::min(at - line.begin, line.text.size()));
    const std::size_t last = before.find_last_not_of(' ');
    if (last != npos && (before[last] == '"' || before[last] == '\'')) {
      return {at, line.text.size() - before.size(), "this value ends with its closing quote, but the line goes on",
              "quote the whole value or nothing of it"};
    }
    return {line.begin + line.indent(), std::max<std::size_t>(1, line.text.size() - line.indent()),
            "this line does not fit the ones above", "entries of one mapping or list begin in the same column"};
  }
  return {at, 1, fmt::format("this is no YAML ({})", message), {}};
}

}  // namespace plantloop
