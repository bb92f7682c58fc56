// "Did you mean": the nearest of some names by edit distance.

#include <algorithm>

#include "engine/base/report.h"
#include "engine/base/text.h"

namespace plantloop {
namespace {

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

// Damerau-Levenshtein distance in its restricted form: insert, delete, replace, swap two neighbours.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

// How many slips a name of this length may have and still be recognised.
std::size_t tolerated(std::size_t length) {
  if (length < 2) return 0;
  if (length < 5) return 1;
  return length < 9 ? 2 : 3;
}

}  // namespace

std::string nearest(std::string_view text, const std::vector<std::string>& candidates) {
  constexpr std::size_t longest = 200;
  if (text.empty() || text.size() > longest) return {};
  const std::string wanted = lower_case(text);
  const std::string* best = nullptr;
  std::size_t best_distance = tolerated(text.size()) + 1;
  for (const std::string& candidate : candidates) {
    if (candidate == text || candidate.size() > longest) continue;
    const std::size_t difference =
        candidate.size() > text.size() ? candidate.size() - text.size() : text.size() - candidate.size();
    if (difference >= best_distance) continue;
    const std::size_t d = distance(wanted, lower_case(candidate));
    if (d >= best_distance || d >= std::max(candidate.size(), text.size())) continue;
    best = &candidate;
    best_distance = d;
  }
  if (best) return *best;
  // A cut word, `init` for `initial`: the only candidate that begins so.
  if (text.size() < 3) return {};
  for (const std::string& candidate : candidates) {
    if (candidate == text || !lower_case(candidate).starts_with(wanted)) continue;
    if (best) return {};
    best = &candidate;
  }
  return best ? *best : std::string();
}

}  // namespace plantloop
