// What every file of the tree must and must not say.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <string>

#include "tests/house/tree.h"

namespace plantloop::house {
namespace {

// A finding for each line that the pattern matches in the files that `wanted` selects.
template <typename Wanted>
std::string lines_that_match(const std::regex& pattern, std::string_view what, Wanted wanted) {
  std::string findings;
  for (const TextFile& file : text_files()) {
    if (file.path == "tests/house/files_test.cpp" || !wanted(file.path)) continue;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      if (std::regex_search(file.lines[i], pattern)) findings += at_line(file, i, what);
    }
  }
  return findings;
}

bool any_file(const std::string&) { return true; }

bool is_cpp(const std::string& path) { return path.ends_with(".cpp") || path.ends_with(".h"); }

TEST(House, TheFirstLineOfEverySourceFileSaysWhatItIsFor) {
  std::string findings;
  for (const TextFile& file : text_files()) {
    const bool cmake = file.path.ends_with(".cmake") || file.path.ends_with("CMakeLists.txt");
    const std::string_view comment = is_cpp(file.path) ? "// " : file.path.ends_with(".lua") ? "--" : "# ";
    if (!is_cpp(file.path) && !cmake && !file.path.ends_with(".lua") && !file.path.ends_with(".yaml")) continue;
    if (file.path.starts_with("tests/errors/")) continue;  // what is wrong there is written beside it
    if (!file.lines.empty() && file.lines[0].starts_with("plantloop_model: ")) continue;  // written by the program
    if (file.lines.empty() || !file.lines[0].starts_with(comment)) {
      findings += at_line(file, 0, fmt::format("the first line is no comment that says what the file is for"));
    }
  }
  EXPECT_EQ(findings, "");
}

TEST(House, NoFileNamesAPathOfOneMachine) {
  EXPECT_EQ(lines_that_match(std::regex(R"((^|[\s"'(=:`])/(work|home|root|tmp/[a-z]|mnt|Users)/)"),
                             "names a path of one machine", any_file),
            "");
}

TEST(House, NoFileNamesAPackageRegistry) {
  EXPECT_EQ(lines_that_match(
                std::regex(R"(registry\.|artifactory|artifact-?registry|deb\.debian\.org|pypi\.|npmjs|crates\.io)"),
                "names a package registry", any_file),
            "");
}

TEST(House, NoTodoWithoutAnIssueNumber) {
  EXPECT_EQ(
      lines_that_match(std::regex(R"(\b(TODO|FIXME|XXX)\b(?!.*#\d))"), "a TODO without an issue's number", is_cpp), "");
}

TEST(House, TheEngineIdentificationAndDrawingNeverPrintOrExit) {
  const std::regex pattern(
      R"(std::(cout|cerr|clog|exit|quick_exit|abort|terminate)\b|fmt::print|\b(printf|puts|fprintf|perror)\s*\()");
  EXPECT_EQ(lines_that_match(pattern, "prints or exits; say it to a Report or throw",
                             [](const std::string& path) {
                               return is_cpp(path) && (covers("engine", path) || covers("blocks", path) ||
                                                       covers("identify", path) || covers("render", path));
                             }),
            "");
}

TEST(House, ABlockHasNoHeaderAndNoMutableMember) {
  std::string findings;
  for (const TextFile& file : text_files()) {
    if (covers("blocks", file.path) && file.path.ends_with(".h")) findings += at_line(file, 0, "a block has no header");
  }
  findings += lines_that_match(std::regex(R"(\bmutable\b(?!\s*\{))"), "a block has no mutable member",
                               [](const std::string& path) { return is_cpp(path) && covers("blocks", path); });
  EXPECT_EQ(findings, "");
}

TEST(House, EveryHeaderIsReadOnce) {
  std::string findings;
  for (const TextFile& file : text_files()) {
    if (file.path.ends_with(".h") && std::ranges::find(file.lines, "#pragma once") == file.lines.end()) {
      findings += at_line(file, 0, "no '#pragma once'");
    }
  }
  EXPECT_EQ(findings, "");
}

TEST(House, LinesEndWithoutBlanksAndReturnsAndFilesWithANewline) {
  EXPECT_EQ(lines_that_match(std::regex(R"([ \t\r]$)"), "ends in a blank", is_cpp), "");
}

}  // namespace
}  // namespace plantloop::house
