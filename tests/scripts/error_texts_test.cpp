// Calls of pl.identify that cannot be done, and the exact texts that they give: tests/errors/scripts/<name>.lua beside
// <name>.txt. `says(function, ...)` prints the message, or that there was none.

#include <algorithm>

#include "engine/base/files.h"
#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

namespace fs = std::filesystem;

// The tests start in the source folder, a workshop in its own.
const fs::path& folder() {
  static const fs::path path = fs::current_path() / "tests/errors/scripts";
  return path;
}

std::vector<std::string> cases() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder())) {
    if (entry.path().extension() == ".lua") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class ScriptErrors : public Workshop, public ::testing::WithParamInterface<std::string> {};

TEST_P(ScriptErrors, TellsTheUser) {
  const FileResult script = read_file((folder() / (GetParam() + ".lua")).string());
  const FileResult expected = read_file((folder() / (GetParam() + ".txt")).string());
  ASSERT_TRUE(script.ok()) << script.error;
  // What it reads, in a folder of the same name.
  if (fs::exists(folder() / GetParam())) fs::copy(folder() / GetParam(), fs::current_path());
  EXPECT_EQ(
      printed(
          "local function says(f, ...) local ok, message = pcall(f, ...); print(ok and 'no error' or message) end;" +
          script.value) +
          "\n",
      expected.value);
}

INSTANTIATE_TEST_SUITE_P(All, ScriptErrors, ::testing::ValuesIn(cases()),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace plantloop
