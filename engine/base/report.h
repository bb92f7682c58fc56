// What the user wrote wrongly, collected: findings with a place, what was expected, and what would be right.

#pragma once

#include <fmt/format.h>

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/base/checks.h"
#include "engine/base/mark.h"

namespace plantloop {

enum class Severity { note, warning, error };

// One finding. The message is one line in the user's words; hints are lines printed below the caret.
struct Finding {
  Severity severity = Severity::error;
  std::string id;  // stable name of the check, e.g. "unknown-key"; "" when it has none
  Mark mark;
  std::string message;
  std::vector<std::string> hints;
  std::vector<std::pair<Mark, std::string>> related;  // further places, e.g. the first use of a name

  // Adds "did you mean 'kp'?  it has: kp, ki, lower" to the hints; only the list when nothing is near.
  Finding& suggest(std::string_view text, const std::vector<std::string>& candidates);
  Finding& hint(std::string line);
  Finding& also(Mark place, std::string text);
  Finding& named(std::string check);
};

// Collects findings; never prints, never throws. Errors after the first twenty are counted, not kept.
class Report {
 public:
  template <typename... Args>
  Finding& error(const Mark& mark, fmt::format_string<Args...> text, Args&&... args) {
    return add(Severity::error, mark, fmt::format(text, std::forward<Args>(args)...));
  }
  template <typename... Args>
  Finding& warning(const Mark& mark, fmt::format_string<Args...> text, Args&&... args) {
    return add(Severity::warning, mark, fmt::format(text, std::forward<Args>(args)...));
  }
  template <typename... Args>
  Finding& note(const Mark& mark, fmt::format_string<Args...> text, Args&&... args) {
    return add(Severity::note, mark, fmt::format(text, std::forward<Args>(args)...));
  }
  Finding& add(Severity severity, const Mark& mark, std::string message);
  // A finding of one of checks(), with the severity that it has by default or that set_levels() gave it; one that is
  // off is kept apart. The id is set.
  template <typename... Args>
  Finding& check(std::string_view id, const Mark& mark, fmt::format_string<Args...> text, Args&&... args) {
    return add_check(id, mark, fmt::format(text, std::forward<Args>(args)...));
  }
  Finding& add_check(std::string_view id, const Mark& mark, std::string message);
  Level level_of(std::string_view id) const;

  // The severities of `checks:`, for all findings that follow.
  void set_levels(std::map<std::string, Level, std::less<>> levels) { levels_ = std::move(levels); }
  // From now on warnings are errors, and so are those that were found already.
  void make_strict();
  bool is_strict() const { return strict_; }

  // Takes over all findings of another report, and the sources they point into.
  void append(Report&& other);

  bool has_errors() const { return errors_ > 0; }
  std::size_t error_count() const { return errors_; }                // those that were not kept included
  const std::deque<Finding>& findings() const { return findings_; }  // in the order they were found
  std::vector<const Finding*> sorted() const;                        // by file, line and column
  const std::deque<Finding>& silenced() const { return silenced_; }  // of checks that are off because levels say so

  // Keeps a source alive as long as the report, so that findings can show its lines.
  void keep(std::shared_ptr<const Source> source);

 private:
  std::deque<Finding> findings_;  // a deque: a Finding& that error() returned stays valid
  std::deque<Finding> silenced_;
  std::map<std::string, Level, std::less<>> levels_;
  bool strict_ = false;
  std::vector<std::shared_ptr<const Source>> sources_;
  Finding overflow_;
  std::size_t errors_ = 0;
  std::size_t others_ = 0;
};

// The findings as text for people: file:line:column, severity, message, the line with a caret, hints; sorted by file
// and place.
std::string to_text(const Report& report, bool colour = false);
// The findings for machines: a JSON array, and a SARIF 2.1.0 log.
std::string to_json(const Report& report);
std::string to_sarif(const Report& report);

// The nearest of the candidates by edit distance, or "" when none is near enough to be what was meant.
std::string nearest(std::string_view text, const std::vector<std::string>& candidates);

}  // namespace plantloop
