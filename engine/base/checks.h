// The checks whose findings have a severity that a diagram may change, under `checks:`; the one list of them.

#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop {

// How much a finding matters; a silenced one is counted and not shown.
enum class Level { off, note, warning, error };

struct CheckInfo {
  std::string_view id;
  Level level;  // by default
  std::string_view doc;
  bool fixed = false;  // an error in any case: nothing runs with it
};

// By name.
const std::vector<CheckInfo>& checks();
// The check of that name, or null.
const CheckInfo* find_check(std::string_view id);

std::string_view name_of(Level level);
std::optional<Level> level_named(std::string_view name);

// The table for the documentation, in Markdown.
std::string checks_markdown();

}  // namespace plantloop
