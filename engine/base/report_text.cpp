// Findings as text for people.
//
//   diagrams/car.yaml:12:7: error: block 'pi' (velocity_pi) has no parameter 'Kp'
//      12 |       Kp: 800
//         |       ^~
//     did you mean 'kp'?  it has: kp, ki, t_track, lower, upper

#include <algorithm>
#include <map>

#include "engine/base/report.h"
#include "engine/base/text.h"

namespace plantloop {
namespace {

constexpr std::size_t widest = 160;  // characters of a source line that are shown

struct Style {
  bool colour = false;
  std::string paint(const char* code, const std::string& text) const {
    return colour ? fmt::format("\x1b[{}m{}\x1b[0m", code, text) : text;
  }
};

const char* colour_of(Severity severity) {
  switch (severity) {
    case Severity::error:
      return "1;31";
    case Severity::warning:
      return "1;35";
    case Severity::note:
      return "1;36";
  }
  return "0";
}

const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::error:
      return "error";
    case Severity::warning:
      return "warning";
    case Severity::note:
      return "note";
  }
  return "";
}

std::string_view line_of(const Source& source, std::uint32_t line) {
  std::string_view rest = source.text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  for (std::uint32_t i = 1; i < line; ++i) {
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) return {};
    rest.remove_prefix(end + 1);
  }
  rest = rest.substr(0, rest.find('\n'));
  if (rest.ends_with('\r')) rest.remove_suffix(1);
  return rest;
}

// A text by characters, so that a caret stands below what it means.
std::vector<std::string_view> characters_of(std::string_view text) {
  std::vector<std::string_view> out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t n = character_length(text, i);
    out.push_back(text.substr(i, n));
    i += n;
  }
  return out;
}

// The line with its number, and the caret with tildes below it. Of a long line the part around the caret.
std::string excerpt(const Mark& mark, const char* colour, const Style& style) {
  const std::string_view full = line_of(*mark.source, mark.line);
  const std::vector<std::string_view> all = characters_of(find_invalid_utf8(full) ? std::string_view() : full);
  if (all.empty()) return {};
  const std::size_t at = std::min<std::size_t>(mark.column == 0 ? 0 : mark.column - 1, all.size());
  const std::size_t first = all.size() > widest && at > widest / 2 ? std::min(at - widest / 2, all.size() - widest) : 0;
  const std::size_t end = std::min(all.size(), first + widest);
  std::string shown = first > 0 ? "..." : "";
  const std::size_t shift = shown.size();
  for (std::size_t i = first; i < end; ++i) shown += printable(all[i]);
  if (end < all.size()) shown += "...";
  const std::size_t room = std::max<std::size_t>(end, at + 1) - at;
  const std::size_t tildes = std::min<std::size_t>(std::max<std::uint32_t>(mark.length, 1), room) - 1;
  std::string caret(tildes + 1, '~');
  caret[0] = '^';
  while (!shown.empty() && shown.back() == ' ') shown.pop_back();
  return fmt::format("{:5} | {}\n      | {}{}\n", mark.line, shown, std::string(at - first + shift, ' '),
                     style.paint(colour, caret));
}

void append(std::string& out, Severity severity, const Mark& mark, const std::string& message, const Style& style) {
  const std::string place = to_string(mark);
  if (!place.empty()) out += style.paint("1", printable(place) + ":") + " ";
  out += style.paint(colour_of(severity), fmt::format("{}:", name_of(severity))) + " ";
  out += style.paint("1", printable(message)) + "\n";
  if (mark.source && mark.line > 0) out += excerpt(mark, colour_of(severity), style);
}

}  // namespace

std::string to_text(const Report& report, bool colour) {
  const Style style{colour};
  std::string out;
  for (const Finding* finding : report.sorted()) {
    append(out, finding->severity, finding->mark, finding->message, style);
    for (const std::string& hint : finding->hints) out += fmt::format("  {}\n", printable(hint));
    for (const auto& [place, text] : finding->related) append(out, Severity::note, place, text, style);
  }
  const auto kept =
      static_cast<std::size_t>(std::count_if(report.findings().begin(), report.findings().end(),
                                             [](const Finding& f) { return f.severity == Severity::error; }));
  const std::size_t more = report.error_count() - kept;
  std::map<std::string_view, std::size_t> silenced;
  for (const Finding& finding : report.silenced()) ++silenced[finding.id];
  for (const auto& [id, count] : silenced) {
    out += fmt::format("checks: '{}' is off in this file: {} {} not shown\n", id, count,
                       count == 1 ? "finding is" : "findings are");
  }
  if (more > 0) out += fmt::format("... and {} more {}\n", more, more == 1 ? "error" : "errors");
  return out;
}

}  // namespace plantloop
