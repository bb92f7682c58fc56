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
        Experiment{"static_networks",
                   {"figure_1_8", "figure_1_9", "figure_1_10", "figure_1_11", "figure_1_12", "figure_1_13",
                    "figure_1_18", "figure_1_19", "figure_1_20", "figure_1_21", "figure_1_23"},
                   "equation (1.6), 1 neuron: RMSE 26.89\nequation (1.6), 2 neurons: RMSE 18.40\n"
                   "equation (1.6), 3 neurons: RMSE 13.68\n"},
        Experiment{
            "first_order_network",
            {"figure_3_1", "figure_3_8", "figure_3_9", "figure_3_10", "figure_3_11", "figure_3_12", "figure_3_13",
             "figure_3_14", "figure_3_15", "figure_3_16", "figure_3_17", "figure_3_18", "figure_3_19"},
            "no noise, 5 neurons: one step below 0.015, free run below 0.03\n"
            "noise 0.02, 5 neurons: training between 0.0185 and 0.024; the residuals are white\n"
            "the book's network: one step 0.022 within 0.004, free run 0.038 within 0.008\n"},
        Experiment{"local_models",
                   {"figure_5_6", "figure_5_7", "figure_5_11", "figure_5_12", "figure_5_13"},
                   "global estimation fits better than local: yes\nthe input alone schedules worse: yes\n"},
        Experiment{"gaussian_process",
                   {"figure_7_1", "figure_7_2", "figure_7_3", "figure_7_5", "figure_7_6", "figure_7_7", "figure_7_8",
                    "figure_7_9", "figure_7_10", "figure_7_11"},
                   "AE below 0.06, SE below 0.008, LD from -2.2 to -0.9: yes\n"},
        Experiment{"basics",
                   {"figure_1_7", "figure_1_15", "figure_1_16", "figure_1_17", "figure_3_2", "figure_3_3", "figure_3_4",
                    "figure_3_5", "figure_3_6", "figure_3_7", "figure_5_8", "figure_5_9"},
                   "the sigmoid is (1 + tanh(s/2))/2: yes\n20 functions leave 15 % of the deviation\n"
                   "nine functions follow the curve to 3 %: yes\n"
                   "one-step errors are as the noise, 0.02 within a quarter: yes\n"
                   "16 to 30 of 33 weights are left, with less error than all of them: yes\n"},
        Experiment{
            "ph_process",
            {"figure_3_22", "figure_3_23", "figure_3_24", "figure_3_25", "figure_3_26", "figure_3_27", "figure_3_28",
             "figure_3_29", "figure_3_30", "figure_7_12", "figure_7_13", "figure_7_14", "figure_7_15", "figure_7_16"},
            "one step below 0.01 pH: yes; free run below 0.03 and 0.08 pH: yes; five times better than linear: "
            "yes\nfive of its weights are superfluous, the validation changes by less than 10 %: yes\n"
            "process: AE below 0.15, SE below 0.05 inside: yes; less certain at the edge: yes\n"},
        Experiment{"network_control",
                   {"network_unknown_part", "network_feedback_linearisation", "network_instantaneous_linearisation",
                    "network_soft_sensor", "network_control_law", "network_imitation", "network_inverse",
                    "network_internal_model", "network_gains"},
                   "the tank in free run below 5 mm: yes; its inverse below 0.1 % of the pump: yes\n"
                   "the rest of the pendulum's equation to its noise of 0.3: yes\n"
                   "the concentration below 0.002 mol/l: yes\n"
                   "the predictive law below 0.1 % of the pump: yes; the PI controller below 0.1 %: yes\n"
                   "pH in free run below 0.05: yes\n"
                   "the networks are those that the diagrams run: yes\n"
                   "every loop does what its diagram expects: yes\n"},
        Experiment{"discrete_velocity", {"figure_5_18", "figure_5_23"}, "the blend 0.2339 (expected 0.2339)"},
        Experiment{"robot", {"figure_6_12"}, "the velocity form is 0.002 m short, the conventional one 0.059 m"},
        Experiment{"separator",
                   {"figure_6_17", "figure_6_18", "figure_6_20", "figure_6_21_6_22"},
                   "bar off (expected 0.00178)"},
        Experiment{"gain_scheduling", {"figure_6_8", "figure_6_8_signals"}, "whatever the height of the step"}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace plantloop
