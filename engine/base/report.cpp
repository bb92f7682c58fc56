// Findings, collected.

#include "engine/base/report.h"

#include <algorithm>

namespace plantloop {
namespace {

constexpr std::size_t most_errors = 20;
constexpr std::size_t most_others = 100;  // warnings and notes
constexpr std::size_t most_listed = 24;   // names in "it has: ..."

}  // namespace

Finding& Finding::suggest(std::string_view text, const std::vector<std::string>& candidates) {
  if (candidates.empty()) return *this;
  const std::string near = nearest(text, candidates);
  std::string line = near.empty() ? std::string() : fmt::format("did you mean '{}'?  ", near);
  const std::size_t listed = std::min(candidates.size(), most_listed);
  line +=
      fmt::format("it has: {}", fmt::join(candidates.begin(), candidates.begin() + static_cast<long>(listed), ", "));
  if (listed < candidates.size()) line += fmt::format(", ... ({} in all)", candidates.size());
  hints.push_back(std::move(line));
  return *this;
}

Finding& Finding::hint(std::string line) {
  hints.push_back(std::move(line));
  return *this;
}

Finding& Finding::also(Mark place, std::string text) {
  related.emplace_back(place, std::move(text));
  return *this;
}

Finding& Finding::named(std::string check) {
  id = std::move(check);
  return *this;
}

Level Report::level_of(std::string_view id) const {
  const auto set = levels_.find(id);
  if (set != levels_.end()) return set->second;
  const CheckInfo* info = find_check(id);
  return info ? info->level : Level::error;
}

Finding& Report::add_check(std::string_view id, const Mark& mark, std::string message) {
  const Level level = level_of(id);
  if (level != Level::off) {
    const Severity severity = level == Level::error     ? Severity::error
                              : level == Level::warning ? Severity::warning
                                                        : Severity::note;
    return add(severity, mark, std::move(message)).named(std::string(id));
  }
  Finding finding{.severity = Severity::note,
                  .id = std::string(id),
                  .mark = mark,
                  .message = std::move(message),
                  .hints = {},
                  .related = {}};
  if (!levels_.contains(id) || silenced_.size() >= most_others) {
    overflow_ = std::move(finding);
    return overflow_;
  }
  return silenced_.emplace_back(std::move(finding));
}

void Report::make_strict() {
  strict_ = true;
  for (Finding& finding : findings_) {
    if (finding.severity != Severity::warning) continue;
    finding.severity = Severity::error;
    ++errors_, --others_;
  }
}

Finding& Report::add(Severity severity, const Mark& mark, std::string message) {
  if (strict_ && severity == Severity::warning) severity = Severity::error;
  const bool is_error = severity == Severity::error;
  std::size_t& count = is_error ? errors_ : others_;
  ++count;
  Finding finding{
      .severity = severity, .id = {}, .mark = mark, .message = std::move(message), .hints = {}, .related = {}};
  if (count > (is_error ? most_errors : most_others)) {
    overflow_ = std::move(finding);
    return overflow_;
  }
  return findings_.emplace_back(std::move(finding));
}

void Report::append(Report&& other) {
  for (Finding& finding : other.findings_) findings_.push_back(std::move(finding));
  for (Finding& finding : other.silenced_) silenced_.push_back(std::move(finding));
  for (auto& source : other.sources_) keep(std::move(source));
  errors_ += other.errors_;
  others_ += other.others_;
}

void Report::keep(std::shared_ptr<const Source> source) {
  if (std::find(sources_.begin(), sources_.end(), source) == sources_.end()) sources_.push_back(std::move(source));
}

std::vector<const Finding*> Report::sorted() const {
  std::vector<const Finding*> order;
  for (const Finding& finding : findings_) order.push_back(&finding);
  const auto key = [](const Finding& f) {
    return std::tuple(f.mark.source ? std::string_view(f.mark.source->name) : std::string_view(), f.mark.line,
                      f.mark.column);
  };
  std::stable_sort(order.begin(), order.end(), [&](const Finding* a, const Finding* b) { return key(*a) < key(*b); });
  return order;
}

}  // namespace plantloop
