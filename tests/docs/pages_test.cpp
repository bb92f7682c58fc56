// The generated pages in docs/ are fresh, and the YAML of the hand-written ones is read.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "app/figures.h"
#include "engine/base/checks.h"
#include "engine/base/files.h"
#include "engine/diagram/model.h"
#include "engine/graph/describe.h"
#include "scripts/host/host.h"

namespace plantloop {
namespace {

std::string text_of(const std::string& path) {
  FileResult file = read_file(path);
  EXPECT_TRUE(file.ok()) << path << ": " << file.error;
  return std::move(file.value);
}

// EXPECT_EQ would print both pages.
void expect_fresh(const std::string& path, const std::string& printed, const std::string& command) {
  EXPECT_TRUE(text_of(path) == printed) << path
                                        << " is not what the program prints; a whole build makes it again, or:\n  "
                                        << "build/release/plantloop " << command << " > " << path;
}

TEST(Docs, ThePageOfTheBlocksIsWhatTheProgramPrints) {
  expect_fresh("docs/blocks.md", catalogue_markdown(), "blocks --markdown");
}

TEST(Docs, TheSchemaIsWhatTheProgramPrints) {
  expect_fresh("docs/diagram.schema.json", diagram_schema(plot_words()), "schema");
}

TEST(Docs, ThePageOfTheChecksIsWhatTheProgramPrints) {
  expect_fresh("docs/checks.md", checks_markdown(), "check --list");
}

TEST(Docs, ThePageOfTheFunctionsIsWhatTheProgramPrints) {
  expect_fresh("docs/lua.md", lua_reference(), "schema --functions");
}

TEST(Docs, ThePageOfTheFunctionsNamesOptionsAndTheirValues) {
  const std::string page = text_of("docs/lua.md");
  for (const char* const part :
       {"### `pl.identify.mlp(data, options)`", "  - `regressors` (needed): `string`",
        "`activation`: one of `sigmoid`, `tanh`", "`covariance`: one of `linear`, `matern_3_2`",
        "`function`: one of `gaussian`", "`method`: one of `levenberg_marquardt`", "### `model:residuals(data)`"})
    EXPECT_THAT(page, testing::HasSubstr(part));
}

// The complete diagrams in a page: its blocks of YAML that begin with a comment or the version.
std::vector<std::string> diagrams_in(const std::string& page) {
  std::vector<std::string> diagrams;
  const std::string open = "```yaml\n";
  for (std::size_t at = page.find(open); at != std::string::npos; at = page.find(open, at)) {
    at += open.size();
    std::string text = page.substr(at, page.find("```", at) - at);
    if (text.find("plantloop: 1") != std::string::npos) diagrams.push_back(std::move(text));
  }
  return diagrams;
}

TEST(Docs, TheDiagramOfTheReadmeIsRead) {
  const std::vector<std::string> diagrams = diagrams_in(text_of("README.md"));
  ASSERT_THAT(diagrams, testing::SizeIs(1));
  Report report;
  read_model_text(diagrams.front(), "README.md", report);
  EXPECT_TRUE(report.findings().empty()) << to_text(report);
}

}  // namespace
}  // namespace plantloop
