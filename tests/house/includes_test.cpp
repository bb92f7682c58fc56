// Every include of the tree against the include table.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <string>

#include "tests/house/include_table.h"
#include "tests/house/tree.h"

namespace plantloop::house {
namespace {

struct Include {
  bool quoted = false;  // "..." and not <...>
  std::string text;
};

// The include on a line, with an empty text when there is none.
Include include_of(const std::string& line) {
  static const std::regex pattern(R"rx(^\s*#\s*include\s*([<"])([^>"]+)[>"].*)rx");
  std::smatch match;
  if (line.find("include") == std::string::npos || !std::regex_match(line, match, pattern)) return {};
  return {.quoted = match[1] == "\"", .text = match[2]};
}

bool any_covers(const std::vector<std::string_view>& paths, std::string_view path) {
  return std::ranges::any_of(paths, [&](std::string_view p) { return covers(p, path); });
}

// What is wrong with one of our own headers being included from a file; "" when nothing is.
std::string wrong_with_own(const TextFile& file, const std::string& header) {
  const Layer* from = layer_of(file.path);
  const Layer* to = layer_of(header);
  if (!to) return fmt::format("'{}' is no path from the root to a layer of the include table", header);
  if (!from) return "this file lies in no layer of the include table";
  if (from == to || any_covers(from->may_include, header)) return "";
  return fmt::format("{} may not include '{}'", from->path, header);
}

// The same for somebody else's header. One without '.' and '/' is a header of the C++ library.
std::string wrong_with_foreign(const TextFile& file, const std::string& header) {
  if (header.find_first_of("./") == std::string::npos) return "";
  const auto door = std::ranges::find_if(doors(), [&](const Door& d) { return header.starts_with(d.header); });
  if (door == doors().end()) return fmt::format("<{}> is not in the include table", header);
  if (any_covers(door->files, file.path)) return "";
  return fmt::format("<{}> may be included only by {}", header, fmt::join(door->files, ", "));
}

TEST(House, EveryIncludeIsAllowedByTheIncludeTable) {
  std::string findings;
  for (const TextFile& file : cpp_files()) {
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      const Include include = include_of(file.lines[i]);
      if (include.text.empty()) continue;
      const std::string wrong =
          include.quoted ? wrong_with_own(file, include.text) : wrong_with_foreign(file, include.text);
      if (!wrong.empty()) findings += at_line(file, i, wrong);
    }
  }
  EXPECT_EQ(findings, "");
}

TEST(House, TheIncludeTableHasNoCycle) {
  // A layer may include only layers that stand before it, so the table itself is an order.
  std::set<std::string_view> before;
  for (const Layer& layer : layers()) {
    for (const std::string_view path : layer.may_include) {
      const bool known =
          std::ranges::any_of(before, [&](std::string_view b) { return covers(b, path) || covers(path, b); });
      EXPECT_TRUE(known) << layer.path << " names " << path << ", which does not stand before it";
    }
    before.insert(layer.path);
  }
}

TEST(House, ATestOfTheTableSeesAForbiddenInclude) {
  EXPECT_EQ(wrong_with_own({"engine/solve/rk.cpp", {}}, "engine/graph/graph.h"),
            "engine/solve may not include 'engine/graph/graph.h'");
  EXPECT_EQ(wrong_with_own({"blocks/math/gain.cpp", {}}, "engine/program/program.h"),
            "blocks may not include 'engine/program/program.h'");
  EXPECT_EQ(wrong_with_own({"blocks/math/gain.cpp", {}}, "engine/block.h"), "");
  EXPECT_NE(wrong_with_foreign({"engine/graph/graph.cpp", {}}, "yaml-cpp/yaml.h"), "");
  EXPECT_NE(wrong_with_foreign({"engine/graph/graph.cpp", {}}, "boost/any.hpp"), "");
  EXPECT_EQ(wrong_with_foreign({"engine/graph/graph.cpp", {}}, "vector"), "");
}

}  // namespace
}  // namespace plantloop::house
