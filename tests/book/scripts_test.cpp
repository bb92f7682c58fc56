// The book's experiments run to their end, print numbers and write their figures.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "scripts/host/host.h"

namespace plantloop {
namespace {

namespace fs = std::filesystem;

struct Experiment {
  std::string name;
  std::vector<std::string> figures;
  std::string answer;  // in the last lines that it prints
};

void PrintTo(const Experiment& experiment, std::ostream* out) { *out << experiment.name; }

// Scripts write below the working directory: an empty folder for each test.
class BookExperiment : public testing::TestWithParam<Experiment> {
 protected:
  void SetUp() override {
    root_ = fs::current_path();
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    std::string folder = test;
    std::replace(folder.begin(), folder.end(), '/', '_');
    scratch_ = fs::temp_directory_path() / ("plantloop_book_" + GetParam().name + "_" + folder);
    fs::remove_all(scratch_);
    fs::create_directories(scratch_);
    fs::current_path(scratch_);
  }
  void TearDown() override {
    fs::current_path(root_);
    fs::remove_all(scratch_);
  }

  void run(const std::vector<std::string>& arguments) {
    std::ostringstream output;
    std::ostringstream messages;
    ScriptOptions options;
    options.output = &output;
    options.messages = &messages;
    const std::string path = (root_ / "scripts/book" / (GetParam().name + ".lua")).string();
    EXPECT_EQ(run_script(path, arguments, options), script_done);
    EXPECT_EQ(messages.str(), "");
    EXPECT_THAT(output.str(), testing::HasSubstr(GetParam().answer));
    EXPECT_THAT(output.str(), testing::Not(testing::HasSubstr("nan")));
  }

  std::string bytes_of(const std::string& figure) const {
    std::ifstream file(scratch_ / "out" / figure, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  fs::path root_, scratch_;
};

TEST_P(BookExperiment, DrawsItsFiguresAsPng) {
  run({});
  for (const std::string& figure : GetParam().figures) {
    EXPECT_EQ(bytes_of(figure + ".png").substr(0, 8), "\x89PNG\r\n\x1a\n") << figure;
  }
}

TEST_P(BookExperiment, DrawsItsFiguresAsSvg) {
  run({"svg"});
  for (const std::string& figure : GetParam().figures) {
    EXPECT_THAT(bytes_of(figure + ".svg"), testing::HasSubstr("</svg>")) << figure;
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, BookExperiment,
    testing::Values(
        Experiment{"pendulum", {"figure_5_17"}, "at most 0.381 rad/s divided by N"},
        Experiment{"pendulum_blend", {"figure_5_19", "figure_5_20", "figure_5_21_5_22"}, "at most 0.0450 rad off"},
        Experiment{"pi_velocity", {"figure_6_4", "figure_6_5_6_6", "pi_scheduled"}, "by 13.75 (expected 13.75)"},
        Experiment{"first_order_data", {"figure_2_5", "figure_2_6"}, "a1 = -0.9512000000, b1 = 0.0975400000"},
        Experiment{"motor_generator",
                   {"figure_2_9", "figure_2_10", "figure_2_11", "figure_2_12", "figure_2_13", "figure_2_14",
                    "figure_2_15", "figure_2_16", "figure_2_17", "figure_2_18", "figure_2_19", "figure_2_20",
                    "figure_2_21", "figure_2_22", "figure_2_23", "figure_2_24"},
                   "least squares                   -1.636142   0.685165   0.032362   0.012466"},
        Experiment{"gain_scheduling", {"figure_6_8", "figure_6_8_signals"}, "whatever the height of the step"}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace plantloop
