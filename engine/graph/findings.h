// Findings of elaboration: a type that is used a hundred times is wrong once.

#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>
#include <unordered_set>
#include <utility>

#include "engine/base/report.h"

namespace plantloop {

class Findings {
 public:
  explicit Findings(Report& report) : report_(report), errors_before_(report.error_count()) {}

  // Reports unless the same was said of the same place; what is added to a repeated finding is dropped.
  template <typename... Args>
  Finding& error(const Mark& mark, fmt::format_string<Args...> text, Args&&... args) {
    return add(Severity::error, mark, fmt::format(text, std::forward<Args>(args)...));
  }
  template <typename... Args>
  Finding& note(const Mark& mark, fmt::format_string<Args...> text, Args&&... args) {
    return add(Severity::note, mark, fmt::format(text, std::forward<Args>(args)...));
  }
  // A finding of one of checks().
  template <typename... Args>
  Finding& check(std::string_view id, const Mark& mark, fmt::format_string<Args...> text, Args&&... args) {
    std::string message = fmt::format(text, std::forward<Args>(args)...);
    return is_new(mark, message) ? report_.add_check(id, mark, std::move(message)) : repeated_;
  }
  bool failed() const { return report_.error_count() > errors_before_; }
  Report& report() { return report_; }

 private:
  Finding& add(Severity severity, const Mark& mark, std::string message) {
    return is_new(mark, message) ? report_.add(severity, mark, std::move(message)) : repeated_;
  }
  bool is_new(const Mark& mark, const std::string& message) {
    const std::size_t place =
        std::hash<const void*>()(mark.source) * 31 + (static_cast<std::size_t>(mark.line) << 20U) + mark.column;
    if (said_.insert(std::hash<std::string>()(message) ^ (place * 0x9e3779b97f4a7c15U)).second) return true;
    repeated_ = {};
    return false;
  }

  Report& report_;
  std::size_t errors_before_;
  std::unordered_set<std::size_t> said_;
  Finding repeated_;
};

}  // namespace plantloop
