// Findings for machines: a JSON array, and a SARIF 2.1.0 log (OASIS standard, 2020-03-27).

#include <set>

#include "engine/base/report.h"
#include "engine/base/text.h"

namespace plantloop {
namespace {

std::string quoted(std::string_view text) {
  std::string out = "\"";
  const bool valid = !find_invalid_utf8(text);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7F || (!valid && byte >= 0x80)) {
      out += fmt::format("\\u{:04x}", byte);
    } else {
      out += c;
    }
  }
  return out + '"';
}

const char* name_of(Severity severity) {
  return severity == Severity::error ? "error" : severity == Severity::warning ? "warning" : "note";
}

std::string place_json(const Mark& mark) {
  if (!mark.source) return {};
  std::string out = fmt::format("\"file\": {}", quoted(mark.source->name));
  if (mark.line > 0) {
    out += fmt::format(", \"line\": {}, \"column\": {}, \"length\": {}", mark.line, mark.column, mark.length);
  }
  return out;
}

std::string location_sarif(const Mark& mark, std::string_view message) {
  std::string region;
  if (mark.line > 0) {
    region = fmt::format(", \"region\": {{\"startLine\": {}, \"startColumn\": {}, \"endColumn\": {}}}", mark.line,
                         mark.column, mark.column + mark.length);
  }
  const std::string text =
      message.empty() ? std::string() : fmt::format(", \"message\": {{\"text\": {}}}", quoted(message));
  return fmt::format("{{\"physicalLocation\": {{\"artifactLocation\": {{\"uri\": {}}}{}}}{}}}",
                     quoted(mark.source->name), region, text);
}

std::string rule_of(const Finding& finding) { return finding.id.empty() ? "diagram" : finding.id; }

std::string result_sarif(const Finding& finding, bool silenced) {
  std::string message = finding.message;
  for (const std::string& hint : finding.hints) message += "\n" + hint;
  std::string locations;
  if (finding.mark.source) locations = location_sarif(finding.mark, "");
  std::string related;
  for (const auto& [mark, text] : finding.related) {
    if (!mark.source) continue;
    if (!related.empty()) related += ", ";
    related += location_sarif(mark, text);
  }
  if (!related.empty()) related = fmt::format(", \"relatedLocations\": [{}]", related);
  const char* const suppressed = silenced ? R"(, "suppressions": [{"kind": "inSource"}])" : "";
  return fmt::format("{{\"ruleId\": {}, \"level\": \"{}\", \"message\": {{\"text\": {}}}, \"locations\": [{}]{}{}}}",
                     quoted(rule_of(finding)), name_of(finding.severity), quoted(message), locations, related,
                     suppressed);
}

}  // namespace

std::string to_json(const Report& report) {
  std::string out;
  std::vector<const Finding*> all = report.sorted();
  const std::size_t shown = all.size();
  for (const Finding& finding : report.silenced()) all.push_back(&finding);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Finding* finding = all[k];
    out += out.empty() ? "[\n" : ",\n";
    out += fmt::format("  {{\"severity\": \"{}\", \"id\": {}", k < shown ? name_of(finding->severity) : "off",
                       quoted(finding->id));
    if (finding->mark.source) out += ", " + place_json(finding->mark);
    out += fmt::format(", \"message\": {}, \"hints\": [", quoted(finding->message));
    for (std::size_t i = 0; i < finding->hints.size(); ++i) out += (i > 0 ? ", " : "") + quoted(finding->hints[i]);
    out += "], \"related\": [";
    for (std::size_t i = 0; i < finding->related.size(); ++i) {
      const auto& [mark, text] = finding->related[i];
      const std::string place = place_json(mark);
      out +=
          fmt::format("{}{{{}{}\"message\": {}}}", i > 0 ? ", " : "", place, place.empty() ? "" : ", ", quoted(text));
    }
    out += "]}";
  }
  return out.empty() ? "[]\n" : out + "\n]\n";
}

std::string to_sarif(const Report& report) {
  std::set<std::string> rules;
  std::string results;
  const auto add = [&](const Finding& finding, bool silenced) {
    rules.insert(rule_of(finding));
    results += fmt::format("{}\n      {}", results.empty() ? "" : ",", result_sarif(finding, silenced));
  };
  for (const Finding* finding : report.sorted()) add(*finding, false);
  for (const Finding& finding : report.silenced()) add(finding, true);
  std::string listed;
  for (const std::string& rule : rules) {
    listed += fmt::format("{}{{\"id\": {}}}", listed.empty() ? "" : ", ", quoted(rule));
  }
  return fmt::format(R"({{
  "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
  "version": "2.1.0",
  "runs": [{{
    "tool": {{"driver": {{"name": "plantloop", "rules": [{}]}}}},
    "columnKind": "unicodeCodePoints",
    "results": [{}]
  }}]
}}
)",
                     listed, results);
}

}  // namespace plantloop
