// The book's experiments run to their end, print numbers and write the figures that docs/book.md names, and no others.

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
#include "tests/book/figure_table.h"

namespace plantloop {
namespace {

namespace fs = std::filesystem;

struct Experiment {
  std::string name;
  std::vector<std::string> answers;  // in what it prints
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
    figures_ = testing_book::figures_of("scripts/book/" + GetParam().name + ".lua");
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
    for (const std::string& answer : GetParam().answers) EXPECT_THAT(output.str(), testing::HasSubstr(answer));
    EXPECT_THAT(output.str(), testing::Not(testing::HasSubstr("nan")));
  }

  std::string bytes_of(const std::string& figure) const {
    std::ifstream file(scratch_ / "out" / figure, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void expect_figures(const std::string& ending, const testing::Matcher<std::string>& contents) const {
    std::vector<std::string> written;
    for (const auto& entry : fs::directory_iterator(scratch_ / "out")) {
      if (entry.path().extension() != ending) continue;
      written.push_back(entry.path().stem().string());
      EXPECT_THAT(bytes_of(written.back() + ending), contents) << written.back();
    }
    EXPECT_THAT(written, testing::UnorderedElementsAreArray(figures_)) << "docs/book.md names the figures";
    EXPECT_FALSE(written.empty());
  }

 private:
  fs::path root_, scratch_;
  std::vector<std::string> figures_;
};

TEST_P(BookExperiment, DrawsItsFiguresAsPng) {
  run({});
  expect_figures(".png", testing::StartsWith("\x89PNG\r\n\x1a\n"));
}

TEST_P(BookExperiment, DrawsItsFiguresAsSvg) {
  run({"svg"});
  expect_figures(".svg", testing::HasSubstr("</svg>"));
}

INSTANTIATE_TEST_SUITE_P(
    All, BookExperiment,
    testing::Values(
        Experiment{"pendulum", {"at most 0.381 rad/s divided by N"}},
        Experiment{"pendulum_blend", {"at most 0.0450 rad off"}},
        Experiment{"pi_velocity", {"by 13.75 (expected 13.75)"}},
        Experiment{
            "first_order_data",
            {"a1 = -0.9512000000, b1 = 0.0975400000, gain 1.9988", "all samples lie in the plane of the model: yes\n"}},
        Experiment{"motor_generator",
                   {"step: gain 0.8850, overshoot 7.83 %\n",
                    "power of the input: half at 27.8 rad/s: yes; none at the clock's 62.8 rad/s: yes\n",
                    "det(Psi'Psi/N) for orders 1 to 4: 0.312 0.00052 8.61e-08 8.1e-12; order 2\n",
                    "delay of the best output-error model: 2 samples\n",
                    "least squares                   -1.636142   0.685165   0.032362   0.012466",
                    "filtered least squares          -1.705559   0.750585   0.039203   0.000565",
                    "output error, one coefficient   -1.706500   0.751365   0.039620",
                    "residuals outside of the 95 % band: 32 % of the lags by least squares, 12 % filtered\n",
                    "filtered least squares: within 3 dB of the spectral analysis from 2 to 30 rad/s: yes\n",
                    "output error, one coefficient: within 3 dB of the spectral analysis from 2 to 30 rad/s: yes\n",
                    "simulates 5.7 times better than least squares in validation"}},
        Experiment{"static_networks",
                   {"equation (1.6), 1 neuron: RMSE 26.89\nequation (1.6), 2 neurons: RMSE 18.40\n"
                    "equation (1.6), 3 neurons: RMSE 13.68\n",
                    "equation (1.10), 3 functions: nRMSE 0.776\n", "equation (1.10), 31 functions: nRMSE 0.087\n",
                    "below 0.05\n"}},
        Experiment{"first_order_network",
                   {"no noise, 5 neurons: one step below 0.015, free run below 0.03\n",
                    "noise 0.02, 5 neurons: training between 0.0185 and 0.024; the residuals are white\n"
                    "the book's network: one step 0.022 within 0.004, free run 0.038 within 0.008\n",
                    "is off by 0.022 where data are, by 0.086 over the plane, of which 78 % are within 0.05\n"}},
        Experiment{"local_models",
                   {"global estimation fits better than local: yes\nthe input alone schedules worse: yes\n",
                    "five blended tangents follow the points of rest to 0.180: yes\n",
                    "three samples of four lie at rest: yes; the model changes 11 times\n",
                    "over the whole plane the complete vector is nearer to the system: yes\n"}},
        Experiment{
            "gaussian_process",
            {"static: outside of the data three times less sure than inside: yes\n"
             "static: the error stays within two deviations nearly everywhere: yes\n",
             "AE below 0.06, SE below 0.008, LD from -2.2 to -0.9: yes\n",
             "the slope where the data lie is right to 0.15: yes\n", "less sure beyond the inputs of the data: yes\n"}},
        Experiment{"basics",
                   {"the sigmoid is (1 + tanh(s/2))/2: yes\n20 functions leave 15 % of the deviation\n"
                    "nine functions follow the curve to 3 %: yes\n"
                    "one-step errors are as the noise, 0.02 within a quarter: yes\n"
                    "16 to 30 of 33 weights are left, with less error than all of them: yes\n"}},
        Experiment{"ph_process",
                   {"one step below 0.01 pH: yes; free run below 0.03 and 0.08 pH: yes; five times better than linear: "
                    "yes\nfive of its weights are superfluous, the validation changes by less than 10 %: yes\n"
                    "process: AE below 0.15, SE below 0.05 inside: yes; less certain at the edge: yes\n"}},
        Experiment{"network_control",
                   {"the tank in free run below 5 mm: yes; its inverse below 0.1 % of the pump: yes\n"
                    "the rest of the pendulum's equation to its noise of 0.3: yes\n"
                    "the concentration below 0.002 mol/l: yes\n"
                    "the predictive law below 0.1 % of the pump: yes; the PI controller below 0.1 %: yes\n"
                    "pH in free run below 0.05: yes\n"
                    "the networks are those that the diagrams run: yes\n"
                    "every loop does what its diagram expects: yes\n"}},
        Experiment{"discrete_velocity", {"the blend 0.2339 (expected 0.2339)"}},
        Experiment{"robot", {"the velocity form is 0.002 m short, the conventional one 0.059 m"}},
        Experiment{"separator", {"bar off (expected 0.00178)"}},
        Experiment{"gain_scheduling", {"whatever the height of the step"}}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace plantloop
