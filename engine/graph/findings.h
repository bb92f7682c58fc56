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
  bool failed() const { return report_.error_count() > errors_before_; }
  Report& report() { return report_; }

 private:
  Finding& add(Severity severity, const Mark& mark, std::string message) {
    const std::size_t place =
        std::hash<const void*>()(mark.source) * 31 + (static_cast<std::size_t>(mark.line) << 20U) + mark.column;
    if (!said_.insert(std::hash<std::string>()(message) ^ (place * 0x9e3779b97f4a7c15U)).second) {
      repeated_ = {};
      return repeated_;
    }
    return report_.add(severity, mark, std::move(message));
  }

  Report& report_;
  std::size_t errors_before_;
  std::unordered_set<std::size_t> said_;
  Finding repeated_;
};

}  // namespace plantloop
