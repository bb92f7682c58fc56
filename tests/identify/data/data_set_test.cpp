// Data sets: CSV in and out, parts, missing values, hashes.

#include "identify/data/data_set.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/data/data_csv.h"
#include "identify/error.h"

namespace plantloop::identify {
namespace {

using ::testing::HasSubstr;

std::string message(const std::function<void()>& action) {
  try {
    action();
  } catch (const IdentifyError& e) {
    return e.what();
  }
  return "no error";
}

const std::string two_experiments =
    "experiment,time,u_flow [l/s],u2,y_temperature [degC]\n"
    "1,0,0.1,5,20\n1,0.5,0.30000000000000004,6,21\n1,1,0.2,7,\n"
    "2,10,1,8,30\n2,10.5,2,9,31\n";

TEST(DataSet, ReadsSignalsUnitsAndExperimentsFromCsv) {
  const DataSet data = read_data_csv(two_experiments, "rig.csv");
  EXPECT_EQ(data.Ts, 0.5);
  ASSERT_EQ(data.experiments.size(), 2U);
  EXPECT_EQ(data.inputs, (std::vector<Channel>{{"u_flow", "l/s"}, {"u2", ""}}));
  EXPECT_EQ(data.outputs, (std::vector<Channel>{{"y_temperature", "degC"}}));
  EXPECT_EQ(data.experiments[1].start, 10);
  EXPECT_EQ(data.experiments[1].u(1, 1), 9);
  EXPECT_EQ(data.missing(), 1);
  EXPECT_TRUE(std::isnan(data.experiments[0].y(2, 0)));
}

TEST(DataSet, ComesBackFromCsvWithTheSameBits) {
  const DataSet data = read_data_csv(two_experiments, "rig.csv");
  const DataSet again = read_data_csv(to_csv(data), "again.csv");
  EXPECT_EQ(hash(data), hash(again));
  EXPECT_EQ(again.experiments[0].u(1, 0), 0.30000000000000004);
}

TEST(DataSet, HashChangesWithTheLastBitOfOneNumberAndWithAUnit) {
  DataSet data = read_data_csv(two_experiments, "rig.csv");
  const std::string before = hash(data);
  data.experiments[0].u(1, 0) = std::nextafter(data.experiments[0].u(1, 0), 1);
  EXPECT_NE(hash(data), before);
  data = read_data_csv(two_experiments, "rig.csv");
  data.inputs[0].unit = "m^3/s";
  EXPECT_NE(hash(data), before);
}

TEST(DataSet, RoundedTimesStillGiveOneSamplingTime) {
  EXPECT_EQ(read_data_csv("time,u,y\n0.00,1,1\n0.33,1,1\n0.67,1,1\n1.00,1,1\n", "thirds.csv").Ts, 0.3333333333);
}

TEST(DataSet, TimesOfSixDigitsMayBeLongerThanTheSamplingTimeResolves) {
  // 610.35 Hz for 200 s: at the end the last digit is 1 ms of 1.638 ms.
  const auto times = [](int left_out) {
    std::string text = "time,u,y\n";
    for (int k = 0; k < 120'000; ++k) {
      if (k != left_out) text += fmt::format("{:.6g},1,2\n", k / 610.35);
    }
    return text;
  };
  EXPECT_NEAR(read_data_csv(times(-1), "long.csv").Ts * 610.35, 1, 1e-5);
  EXPECT_NE(message([&] { read_data_csv(times(100'000), "long.csv"); }), "");
  EXPECT_NE(message([&] { read_data_csv(times(1000), "long.csv"); }).find("at row 1001,"), std::string::npos);
}

TEST(DataSet, SaysWhatIsWrongWithACsvFile) {
  EXPECT_EQ(
      message([] { read_data_csv("time,u,y\n0,1,1\n1,1,1\n3,1,1\n4,1,1\n", "a.csv"); }),
      "a.csv: time goes from 1 s to 3 s at row 3, but most steps are 1 s; the times of an experiment must grow evenly: "
      "leave cells of missing samples empty, and number the experiments in a column 'experiment'");
  EXPECT_EQ(
      message([] { read_data_csv("time,volt,y\n0,1,1\n1,1,1\n", "a.csv"); }),
      "a.csv: 'volt' is no time and neither an input (u...) nor an output (y...); say which columns are inputs and "
      "outputs, the others are then left out");
  EXPECT_EQ(message([] {
              read_data_csv("time,volt,y\n0,1,1\n1,1,1\n", "a.csv", {{"volts"}, {"y"}, {}});
            }),
            "a.csv has no column 'volts', did you mean 'volt'; it has: time, volt, y");
  EXPECT_EQ(message([] { read_data_csv("u,y\n1,1\n", "a.csv"); }),
            "a.csv has no column 'time': give the sampling time Ts in s");
  EXPECT_EQ(message([] { read_data_csv("time,u,y\n0,1,x\n", "a.csv"); }), "a.csv:2:5: 'x' is no number");
}

TEST(DataSet, NamedColumnsLeaveTheOthersOut) {
  const DataSet data = read_data_csv("time,volt,bulb,speed\n0,1,7,2\n1,3,7,4\n", "rig.csv", {{"volt"}, {"speed"}, {}});
  EXPECT_EQ(data.inputs[0].name, "volt");
  EXPECT_EQ(data.experiments[0].y(1, 0), 4);
}

TEST(DataSet, SplitsEachExperimentAndKeepsTime) {
  const DataSet data = make_data_set(Eigen::VectorXd::LinSpaced(10, 0, 9), Eigen::VectorXd::LinSpaced(10, 0, 18), 0.1);
  const auto [first, second] = split(data, 0.7);
  EXPECT_EQ(first.samples(), 7);
  EXPECT_EQ(second.experiments[0].u(0, 0), 7);
  EXPECT_DOUBLE_EQ(second.experiments[0].start, 0.7);
  EXPECT_EQ(join(first, second).samples(), 10);
  EXPECT_EQ(part(data, 2, 5).experiments[0].y(0, 0), 4);
}

TEST(DataSet, RefusesInfinityAndEqualNamesAndSaysWhereAValueIsMissing) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(4);
  Eigen::VectorXd y = u;
  y[2] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(message([&] { make_data_set(u, y, 1); }), "'y' is infinite at sample 3 (time 2 s) of experiment '1'");
  y[2] = std::numeric_limits<double>::quiet_NaN();
  const DataSet data = make_data_set(u, y, 1);
  EXPECT_THAT(
      message([&] { refuse_missing(data, "a spectrum"); }),
      HasSubstr("'y' is missing at sample 3 (time 2 s) of experiment '1', and a spectrum needs a record without gaps"));
  EXPECT_EQ(message([&] { make_data_set(u, u, 1, {{"a", ""}}, {{"a", ""}}); }), "two signals are called 'a'");
  EXPECT_EQ(message([&] { make_data_set(u, u, 0); }), "the sampling time must be greater than 0 s, it is 0 s");
}

}  // namespace
}  // namespace plantloop::identify
