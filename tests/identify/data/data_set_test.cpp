// Data sets: CSV in and out, parts, missing values, hashes.

#include "identify/data/data_set.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "engine/base/files.h"
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
  EXPECT_NE(message([&] { read_data_csv(times(1000), "long.csv"); }).find("long.csv:1002: the time goes from"),
            std::string::npos);
}

TEST(DataSet, SaysWhatIsWrongWithACsvFile) {
  EXPECT_EQ(
      message([] { read_data_csv("time,u,y\n0,1,1\n1,1,1\n3,1,1\n4,1,1\n", "a.csv"); }),
      "a.csv:4: the time goes from 1 s to 3 s, but most steps are 1 s; leave the cells of missing samples empty, or "
      "number the parts of the record in a column 'experiment'");
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

TEST(DataSet, TimesAreReadInTheUnitOfTheirHeader) {
  for (const auto& [header, Ts] :
       {std::pair("time [ms]", 0.1), {"Time (ms)", 0.1}, {"t", 100.0}, {"TIME [min]", 6000.0}}) {
    const DataSet data = read_data_csv(fmt::format("{},u,y\n50,1,1\n150,1,2\n250,1,3\n", header), "a.csv");
    EXPECT_NEAR(data.Ts / Ts, 1, 1e-12) << header;
    EXPECT_NEAR(data.experiments[0].start / Ts, 0.5, 1e-12) << header;
  }
}

TEST(DataSet, UnitsMayStandInRoundBracketsOrInARowOfTheirOwn) {
  for (const char* const text : {"time (ms),u (V),y (m/s)\n0,1,1\n10,1,2\n", "time,u,y\nms,V,m/s\n0,1,1\n10,1,2\n",
                                 "time,u [V],y\n[ms],,(m/s)\n0,1,1\n10,1,2\n"}) {
    const DataSet data = read_data_csv(text, "a.csv");
    EXPECT_EQ(data.inputs[0], (Channel{"u", "V"})) << text;
    EXPECT_EQ(data.outputs[0], (Channel{"y", "m/s"})) << text;
    EXPECT_EQ(data.Ts, 0.01) << text;
    EXPECT_EQ(data.samples(), 2) << text;
  }
  // Brackets that belong to the name.
  EXPECT_EQ(channel_of("y(1)").name, "y(1)");
  EXPECT_EQ(channel_of("y (inlet)").name, "y (inlet)");
}

TEST(DataSet, TimesMayBeRoundedToTheDigitsOfTheirColumn) {
  const auto times = [](int decimals, double Ts, int left_out) {
    std::string text = "time,u,y\n";
    for (int k = 0; k < 200; ++k) {
      if (k != left_out) text += fmt::format("{:.{}f},1,2\n", k * Ts, decimals);
    }
    return text;
  };
  EXPECT_NEAR(read_data_csv(times(2, 0.0333, -1), "a.csv").Ts, 0.0333, 0.01 / 199);
  EXPECT_NE(message([&] { read_data_csv(times(2, 0.0333, 120), "a.csv"); }), "");
  // Digits that do not tell the samples apart need Ts, and are then taken as they come.
  EXPECT_NE(message([&] { read_data_csv(times(1, 0.0333, -1), "a.csv"); }), "");
  EXPECT_EQ(read_data_csv(times(1, 0.0333, -1), "a.csv", {{}, {}, 0.0333}).Ts, 0.0333);
  // With Ts a time belongs to the instant that it is nearest to; a sample that is not there is still found.
  const auto shaken = [](int left_out) {
    std::string text = "time,u,y\n";
    for (int k = 0; k < 100; ++k) {
      if (k != left_out) text += fmt::format("{:.9f},1,2\n", 0.1 * k + 0.03 * std::sin(3.0 * k * k));
    }
    return text;
  };
  EXPECT_NE(message([&] { read_data_csv(shaken(-1), "a.csv"); }), "");
  EXPECT_EQ(read_data_csv(shaken(-1), "a.csv", {{}, {}, 0.1}).Ts, 0.1);
  EXPECT_NE(message([&] { read_data_csv(shaken(40), "a.csv", {{}, {}, 0.1}); }), "");
  EXPECT_NE(message([&] { read_data_csv(times(1, 0.1, 40), "a.csv", {{}, {}, 0.1}); }), "");
}

TEST(DataSet, SinglePrecisionTimesLateInARecordAreEven) {
  std::string text = "time,u,y\n";
  for (int k = 0; k < 200; ++k) text += fmt::format("{:.10g},1,2\n", static_cast<float>(1e5 + 0.1 * k));
  EXPECT_NEAR(read_data_csv(text, "a.csv").Ts, 0.1, 1e-4);
}

// tests/errors/data/<name>.csv beside <name>.txt.
TEST(DataSet, TellsWhatIsWrongInAFile) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("tests/errors/data")) {
    if (entry.path().extension() != ".csv") continue;
    const FileResult text = read_file(entry.path().string());
    const FileResult expected = read_file(std::filesystem::path(entry.path()).replace_extension(".txt").string());
    const std::string name = entry.path().filename().string();
    EXPECT_EQ(message([&] { read_data_csv(text.value, name); }) + "\n", expected.value) << name;
    ++count;
  }
  EXPECT_GT(count, 5);
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
