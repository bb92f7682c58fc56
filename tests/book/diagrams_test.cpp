// Every diagram of the book and every example checks without a finding, runs, and meets its own expectations.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "app/figures.h"
#include "tests/book/book_runs.h"

namespace plantloop::testing_book {
namespace {

std::vector<std::string> diagrams(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class BookDiagram : public testing::TestWithParam<std::string> {
 protected:
  std::string path() const { return "diagrams/book/" + GetParam() + ".yaml"; }
};

TEST_P(BookDiagram, ChecksWithoutAFinding) {
  Report report;
  const auto diagram = Diagram::load(path(), report, plot_words());
  ASSERT_TRUE(diagram) << to_text(report);
  diagram->check({}, report);
  EXPECT_EQ(to_text(report), "");
}

TEST_P(BookDiagram, MeetsItsExpectations) { EXPECT_EQ(run_file(path()).unmet(), ""); }

TEST_P(BookDiagram, MeetsItsExpectationsWithTheStiffSolver) {
  EXPECT_EQ(run_file(path(), {.rtol = 1e-10, .atol = 1e-12, .solver = "bdf"}).unmet(), "");
}

INSTANTIATE_TEST_SUITE_P(All, BookDiagram, testing::ValuesIn(diagrams("diagrams/book")),
                         [](const auto& instance) { return instance.param; });

class ExampleDiagram : public testing::TestWithParam<std::string> {};

TEST_P(ExampleDiagram, ChecksWithoutAFindingAndMeetsItsExpectations) {
  const std::string path = "diagrams/examples/" + GetParam() + ".yaml";
  Report report;
  const auto diagram = Diagram::load(path, report, plot_words());
  ASSERT_TRUE(diagram) << to_text(report);
  diagram->check({}, report);
  EXPECT_EQ(to_text(report), "");
  EXPECT_EQ(run_file(path).unmet(), "");
}

INSTANTIATE_TEST_SUITE_P(All, ExampleDiagram, testing::ValuesIn(diagrams("diagrams/examples")),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace plantloop::testing_book
