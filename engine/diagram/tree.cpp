// What both readers of YAML share.

#include "engine/diagram/tree.h"

#include <algorithm>
#include <numeric>

namespace plantloop {
namespace {

void report_double(const Node& mapping, std::size_t first, std::size_t second, Report& report) {
  report.error(mapping.key_marks[second], "the key '{}' is written twice", mapping.keys[second])
      .also(mapping.key_marks[first], "first written here")
      .named("duplicate-key");
}

}  // namespace

const Node* Node::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == key) return &items[i];
  }
  return nullptr;
}

void check_keys(const Node& mapping, Report& report) {
  const auto& keys = mapping.keys;
  constexpr std::size_t few = 12;
  if (keys.size() <= few) {
    for (std::size_t j = 1; j < keys.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        if (keys[i] != keys[j]) continue;
        report_double(mapping, i, j, report);
        break;
      }
    }
    return;
  }
  std::vector<std::uint32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const int difference = keys[a].compare(keys[b]);
    return difference != 0 ? difference < 0 : a < b;
  });
  std::uint32_t first = order[0];
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (keys[order[i]] == keys[first])
      report_double(mapping, first, order[i], report);
    else
      first = order[i];
  }
}

std::size_t scalar_size(std::string_view source, std::size_t offset, std::string_view text, bool quoted) {
  const std::string_view rest = source.substr(std::min(offset, source.size()));
  const auto first_line = [&] {
    std::string_view line = rest.substr(0, rest.find_first_of("\r\n"));
    while (line.ends_with(' ')) line.remove_suffix(1);
    return std::max<std::size_t>(1, line.size());
  };
  if (!quoted || rest.empty()) return rest.starts_with(text) ? text.size() : first_line();
  if (rest[0] != '"' && rest[0] != '\'') return 1;  // | or >
  for (std::size_t i = 1; i < rest.size(); ++i) {
    if (rest[0] == '"' && rest[i] == '\\') {
      ++i;
    } else if (rest[i] == rest[0]) {
      if (rest[0] == '\'' && i + 1 < rest.size() && rest[i + 1] == '\'') {
        ++i;
        continue;
      }
      return i + 1;
    }
  }
  return 0;
}

}  // namespace plantloop
