// Every experiment in scripts/examples runs and ends with its answer.

#include <algorithm>
#include <cmath>
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
    fs::remove_all(place / "out" / "gallery");  // what an earlier run drew
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

// y(k) = 0.8 y(k-1) + 0.2 u(k-10), and with `coupled` a second output that drives the first one.
void write_record(const std::string& path, int samples, unsigned seed, bool coupled) {
  std::ofstream file(path);
  file << (coupled ? "time,u,y1,y2\n" : "time,u,y\n");
  const auto random = [&seed] { return (seed = seed * 1664525U + 1013904223U) / 4294967296.0 - 0.5; };
  std::vector<double> u;
  double level = 0, y1 = 0, y2 = 0;
  for (int k = 0; k < samples; ++k) {
    if (k % 7 == 0) level = 2 * random();
    u.push_back(level);
    const double before = y1;
    if (coupled) {
      y1 = 0.7 * y1 + 0.3 * y2;
      y2 = 0.8 * y2 - 0.2 * before + 0.2 * u[static_cast<std::size_t>(std::max(k - 1, 0))];
    } else {
      y1 = 0.8 * y1 + 0.2 * (k >= 10 ? u[static_cast<std::size_t>(k - 10)] : 0);
    }
    file << 0.1 * k << ',' << level << ',' << y1 + 0.01 * random();
    if (coupled) file << ',' << y2 + 0.01 * random();
    file << '\n';
  }
}

class IdentifyExample : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::current_path();
    fs::remove_all(place_);
    fs::create_directories(place_);
    fs::current_path(place_);
  }
  void TearDown() override { fs::current_path(root_); }
  std::string run(const std::vector<std::string>& arguments) const {
    std::ostringstream output, messages;
    ScriptOptions options;
    options.output = &output;
    options.messages = &messages;
    EXPECT_EQ(run_script((root_ / "scripts/examples/identify.lua").string(), arguments, options), script_done);
    EXPECT_EQ(messages.str(), "");
    return output.str();
  }

 private:
  fs::path root_;
  // Of each test its own: tests run at the same time.
  const fs::path place_ =
      fs::path("build") / "tests-of-identify" / testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(IdentifyExample, FindsALongDelayAndWritesWhatItPredictsOfTheRowsAfterTheSplit) {
  write_record("rig.csv", 700, 1, false);
  EXPECT_NE(run({"rig.csv", "train=500", "effort=0.02", "skip=30"}).find("delay 9"), std::string::npos);
  std::ifstream file("out/rig-y-test.csv");
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  EXPECT_EQ(line, "time,u,y,free_run,error");
  int rows = 0;
  double square = 0;
  for (; std::getline(file, line); ++rows) {
    const double error = std::stod(line.substr(line.rfind(',') + 1));
    if (rows >= 30) square += error * error;
  }
  EXPECT_EQ(rows, 200);
  EXPECT_LT(std::sqrt(square / 170), 2 * 0.01 / std::sqrt(12.0));  // the noise is even over a width of 0.01
}

TEST_F(IdentifyExample, HasAModelOfAllOutputsTogetherForATestInAFileOfItsOwn) {
  write_record("pair.csv", 500, 2, true);
  write_record("pair-fresh.csv", 200, 3, true);
  EXPECT_NE(run({"pair.csv", "test=pair-fresh.csv", "effort=0.02"}).find("All outputs together"), std::string::npos);
  EXPECT_TRUE(fs::exists("out/pair-y1-test.csv"));
  EXPECT_TRUE(fs::exists("out/pair-together.yaml"));
  EXPECT_TRUE(fs::exists("out/pair-together-test.csv"));
}

}  // namespace
}  // namespace plantloop
