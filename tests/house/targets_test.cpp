// What CMake's targets use against the include table.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <string>

#include "tests/house/include_table.h"
#include "tests/house/tree.h"

namespace plantloop::house {
namespace {

std::string whole(const TextFile& file) {
  std::string text;
  for (const std::string& line : file.lines) text += line.substr(0, line.find('#')) + '\n';
  return text;
}

// True when the layer of `path` may include the layer that the target `name` builds; a target that is no layer is not
// judged.
bool may_use(const Layer& user, const std::string& name) {
  const auto used = std::ranges::find(layers(), std::string_view(name), &Layer::target);
  if (used == layers().end() || &*used == &user) return true;
  return std::ranges::any_of(
      user.may_include, [&](std::string_view path) { return covers(path, used->path) || covers(used->path, path); });
}

TEST(House, TheTargetsUseWhatTheIncludeTableAllows) {
  const std::regex library(R"(plantloop_library\(([^)]*)\))");
  const std::regex use(R"(plantloop::(\w+))");
  std::string findings;
  for (const TextFile& file : text_files()) {
    const Layer* layer = layer_of(file.path);
    if (!file.path.ends_with("CMakeLists.txt") || !layer || layer->target.empty()) continue;
    const std::string text = whole(file);
    for (std::sregex_iterator call(text.begin(), text.end(), library), end; call != end; ++call) {
      const std::string arguments = (*call)[1];
      for (std::sregex_iterator at(arguments.begin(), arguments.end(), use); at != end; ++at) {
        const std::string used = (*at)[1];
        if (!may_use(*layer, used))
          findings += fmt::format("{}: {} may not use plantloop::{}\n", file.path, layer->path, used);
      }
    }
  }
  EXPECT_EQ(findings, "");
}

}  // namespace
}  // namespace plantloop::house
