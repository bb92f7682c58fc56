// Every experiment in scripts/examples runs and ends with its answer.

#include <fmt/format.h>

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

  fs::path root_;

 private:
  // Of each test its own: tests run at the same time.
  const fs::path place_ =
      fs::path("build") / "tests-of-identify" / testing::UnitTest::GetInstance()->current_test_info()->name();
};

// Each wrong record, and what is said of it.
TEST_F(IdentifyExample, SaysWhatIsWrongWithARecord) {
  const auto rows = [](int count, const auto& row) {
    std::string text = "time,u,y\n";
    for (int k = 0; k < count; ++k) text += row(k);
    return text;
  };
  const auto plain = [](int k) { return fmt::format("{},{},{}\n", 0.1 * k, k % 7, (k % 7) * 0.5); };
  const auto at_50 = [&](const std::string& y) {
    return rows(300, [&](int k) { return k == 50 ? fmt::format("5,1,{}\n", y) : plain(k); });
  };
  const auto scaled = [&](const char* power) {
    return rows(300, [&](int k) { return fmt::format("{},{}{},{}\n", 0.1 * k, k % 7 + 1, power, k % 5); });
  };
  const struct {
    std::string text, complaint;
  } records[] = {
      {"", "bad.csv:0:0: it holds no line with values"},
      {"time,u,y\n", "bad.csv has a header and no rows"},
      {rows(2, plain), "'y' has 2 samples; a search of structures that holds some of them back needs 100"},
      {rows(60, plain), "'y' has 60 samples; a search of structures that holds some of them back needs 100"},
      {rows(300, [](int k) { return fmt::format("{},{},3\n", 0.1 * k, k % 7); }), "none of the outputs varies"},
      {rows(300, [](int k) { return fmt::format("{},{},\n", 0.1 * k, k % 7); }),
       "'y' has no values in experiment 1: leave the column out, or the experiment"},
      {at_50("inf"), "'y' is infinite at sample 51 (time 5 s) of experiment '1'"},
      {at_50("broken"), "bad.csv:52:5: 'broken' is no number"},
      {at_50("1,2"), "bad.csv:52:7: 4 values, but the first line has 3"},
      {scaled("e300"),
       "'u' has values of about 7e+300 in experiment '1', whose squares cannot be computed; take another unit"},
      {scaled("e-300"),
       "'u' has values of about 7e-300 in experiment '1', whose squares cannot be computed; take another unit"},
      {"y\n1\n2\n3\n", "bad.csv has no column 'time': give the sampling time Ts in s, as in Ts=0.1"},
      {"time,valve,y\n0,1,2\n1,2,2\n",
       "bad.csv: 'valve' is no time and neither an input (u...) nor an output (y...); say which columns are inputs and "
       "outputs, the others are then left out, as in inputs=flow,valve outputs=level"},
      {"time,y,y\n0,1,2\n", "bad.csv:1:8: two columns are called 'y'"},
      {"time,u,y\n0,1,2\n1,1,2\n2,1,2\n7,1,2\n8,1,2\n",
       "bad.csv:5: the time goes from 2 s to 7 s, but most steps are 1 s; leave the cells of missing samples empty, or "
       "number the parts of the record in a column 'experiment'"},
  };
  for (const auto& record : records) {
    std::ofstream("bad.csv") << record.text;
    std::ostringstream output, messages;
    ScriptOptions options;
    options.output = &output;
    options.messages = &messages;
    EXPECT_EQ(run_script((root_ / "scripts/examples/identify.lua").string(), {"bad.csv", "effort=0.02"}, options),
              script_failed)
        << record.complaint;
    const std::string said = messages.str();
    EXPECT_EQ(said.substr(0, said.find('\n')), record.complaint);
  }
}

TEST_F(IdentifyExample, TakesNamedColumnsWithoutTimesAndValuesThatAreMissing) {
  std::ofstream file("rig.csv");
  file << "valve,level,remark\n";
  double level = 0;
  unsigned seed = 4;
  const auto random = [&seed] { return (seed = seed * 1664525U + 1013904223U) / 4294967296.0 - 0.5; };
  for (int k = 0; k < 300; ++k) {
    const int valve = k / 9 % 2;
    const bool missing = k < 4 || k == 50 || k == 51;
    file << valve << ',' << (missing ? std::string() : fmt::format("{}", level + 0.01 * random())) << ",7\n";
    level = 0.8 * level + 0.2 * valve;
  }
  file.close();
  const std::string said = run({"rig.csv", "inputs=valve", "outputs=level", "Ts=2", "effort=0.02"});
  EXPECT_NE(said.find("4 samples at the ends of the record"), std::string::npos);
  EXPECT_NE(said.find("2 missing values inside of the record"), std::string::npos);
  EXPECT_TRUE(fs::exists("out/rig-level.yaml"));
}

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
