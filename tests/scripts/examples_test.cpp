// Every experiment in scripts/examples runs and ends with its answer.

#include <algorithm>
#include <fstream>

#include "render/plots/plot.h"
#include "render/theme.h"
#include "tests/scripts/workshop.h"

namespace plantloop {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> examples() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator("scripts/examples")) {
    if (entry.path().extension() == ".lua") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST(Examples, AnswerTheirQuestion) {
  // They write below out/ of a folder of their own.
  const fs::path root = fs::current_path();
  const fs::path place = fs::path("build") / "tests-of-examples";
  for (const std::string& name : examples()) {
    SCOPED_TRACE(name);
    const fs::path script = root / "scripts" / "examples" / (name + ".lua");
    std::string question;
    std::ifstream file(script);
    std::getline(file, question);
    EXPECT_TRUE(question.starts_with("-- ") && question.ends_with("?")) << question;
    fs::remove_all(place);  // what an earlier run drew
    fs::create_directories(place);
    fs::current_path(place);
    std::ostringstream output;
    std::ostringstream messages;
    ScriptOptions options;
    options.output = &output;
    options.messages = &messages;
    EXPECT_EQ(run_script(script.string(), {}, options), script_done) << messages.str();
    EXPECT_EQ(messages.str(), "");
    EXPECT_NE(output.str(), "");
    for (const Plot* plot : name == "gallery" ? plots() : std::vector<const Plot*>())
      for (const std::string& theme : theme_names())
        EXPECT_TRUE(fs::exists("out/gallery/" + theme + "/" + std::string(plot->name()) + ".svg")) << plot->name();
    fs::current_path(root);
  }
}

}  // namespace
}  // namespace plantloop
