// docs/book.md names every figure of the book once, every script and diagram, and only what is there.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "tests/book/figure_table.h"

namespace plantloop::testing_book {
namespace {

TEST(FigureTable, NamesOnlyWhatIsThere) {
  for (const FigureRow& row : figure_table()) {
    EXPECT_FALSE(row.makers.empty());
    EXPECT_FALSE(row.tests.empty());
    for (const auto* list : {&row.makers, &row.tests}) {
      for (const std::string& path : *list) EXPECT_TRUE(std::filesystem::is_regular_file(path)) << path;
    }
    // A script writes files, a diagram has its own figures.
    const bool by_script = row.makers.front().rfind("scripts/", 0) == 0;
    EXPECT_EQ(by_script, !row.file.empty()) << row.makers.front();
    EXPECT_THAT(row.tests,
                testing::Contains(by_script ? "tests/book/scripts_test.cpp" : "tests/book/diagrams_test.cpp"));
  }
}

// A file is named as the figures it shows, where it shows figures of the book and is not a diagram's.
TEST(FigureTable, NamesFilesLikeTheirFigures) {
  for (const FigureRow& row : figure_table()) {
    if (row.file.rfind("figure_", 0) != 0 || row.figures.empty()) continue;
    std::string name = "figure";
    for (const std::string& figure : row.figures) name += "_" + figure;
    std::replace(name.begin(), name.end(), '.', '_');
    EXPECT_EQ(row.file, name);
  }
}

TEST(FigureTable, HasEveryFigureOfTheBookOnce) {
  std::vector<std::string> expected, found = missing_figures();
  for (const auto& [chapter, count] : {std::pair{1, 23}, std::pair{2, 24}, std::pair{3, 30}, std::pair{4, 12},
                                       std::pair{5, 23}, std::pair{6, 22}, std::pair{7, 24}}) {
    for (int i = 1; i <= count; ++i) expected.push_back(std::to_string(chapter) + "." + std::to_string(i));
  }
  for (const FigureRow& row : figure_table()) found.insert(found.end(), row.figures.begin(), row.figures.end());
  EXPECT_THAT(found, testing::UnorderedElementsAreArray(expected));
}

TEST(FigureTable, HasEveryScriptAndDiagramOfTheBook) {
  std::ifstream file("docs/book.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  for (const std::string folder : {"scripts/book", "diagrams/book"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      EXPECT_THAT(page, testing::HasSubstr("`" + entry.path().generic_string() + "`"));
    }
  }
}

}  // namespace
}  // namespace plantloop::testing_book
