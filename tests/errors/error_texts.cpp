// Wrong diagrams and the exact text that they must give.

#include "tests/errors/error_texts.h"

#include <algorithm>
#include <filesystem>

#include "engine/base/files.h"

namespace plantloop {

std::vector<std::string> error_cases(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void expect_error_text(const std::string& folder, const std::string& name, const Check& check) {
  const std::string base = folder + "/" + name;
  const FileResult expected = read_file(base + ".txt");
  ASSERT_TRUE(expected.ok()) << base << ".txt: " << expected.error;
  Report report;
  check(base + ".yaml", report);
  EXPECT_EQ(to_text(report), expected.value);
}

}  // namespace plantloop
