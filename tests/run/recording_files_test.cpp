// Recordings as CSV, JSON and NPZ: what is in them, and that nothing is lost on the way.

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "engine/base/csv.h"
#include "engine/run/zip.h"
#include "tests/run/recordings.h"

namespace plantloop {
namespace {

// Numbers of every size, with both zeros and the extremes.
Recording many_numbers() {
  Recording recording;
  recording.columns = {{.name = "a"}, {.name = "b"}};
  recording.hits.resize(1);
  recording.rates.resize(1);
  std::mt19937_64 random(1);
  double time = 0;
  const auto add = [&](double a, double b) {
    const std::vector<double> row{a, b};
    recording.append(time, 0, row);
    time = std::nextafter(time + 0.1, 1e9);
  };
  add(0.1, -0.0);
  add(std::numeric_limits<double>::max(), std::numeric_limits<double>::min());
  add(1e22, 1e-300);
  while (recording.rows() < 10000) {
    std::uint64_t bits = random();
    double a = 0;
    std::memcpy(&a, &bits, sizeof a);
    if (std::isnormal(a)) add(a, 1 / a);
  }
  return recording;
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST(RecordingFiles, CsvReadsBackExactly) {
  const Recording recording = many_numbers();
  const CsvResult csv = read_csv(to_csv(recording));
  ASSERT_TRUE(csv.ok()) << csv.error;
  EXPECT_EQ(csv.table.names, (std::vector<std::string>{"time", "a", "b"}));
  ASSERT_EQ(csv.table.rows(), recording.rows());
  for (std::size_t row = 0; row < recording.rows(); ++row) {
    ASSERT_TRUE(same_bits(csv.table.columns[0][row], recording.time()[row]));
    ASSERT_TRUE(same_bits(csv.table.columns[1][row], recording.at(row, 0)));
    ASSERT_TRUE(same_bits(csv.table.columns[2][row], recording.at(row, 1)));
  }
}

TEST(RecordingFiles, CsvIsOneTableWithBothSidesOfAJumpAndNothingHidden) {
  EXPECT_EQ(to_csv(testing::mixed()),
            "time,ramp,held\n"
            "0,0,1\n"
            "0.25,0.25,1\n"
            "0.5,0.5,2\n"
            "1,1,2\n"
            "1,11,3\n"
            "1.1000000000000001,11.1,3\n");
}

TEST(RecordingFiles, CsvLeavesOutARightSideThatDiffersOnlyInHiddenColumns) {
  Recording recording;
  recording.columns = {{.name = "a"}, {.name = "b", .hidden = true}};
  recording.append(1, -1, std::vector<double>{1, 1});
  recording.append(1, 1, std::vector<double>{1, 2});
  EXPECT_EQ(to_csv(recording), "time,a\n1,1\n");
}

TEST(RecordingFiles, CsvOfAMillionRowsIsWrittenInASecondOrSo) {
  Recording recording;
  recording.columns = {{.name = "x"}, {.name = "y"}, {.name = "z"}};
  recording.reserve(1000000);
  for (int k = 0; k < 1000000; ++k) {
    const double t = k * 1e-3;
    const std::array<double, 3> row{std::sin(t), std::cos(t), t * t / 3};
    recording.append(t, 0, row);
  }
  std::size_t bytes = 0;
  const auto began = std::chrono::steady_clock::now();
  write_csv(recording, [&](std::string_view part) { bytes += part.size(); });
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  RecordProperty("milliseconds", static_cast<int>(took.count() * 1000));
  EXPECT_GT(bytes, 60000000U);
  EXPECT_LT(took.count(), 20);  // 0.6 s on an idle machine; a bound that a busy one with sanitizers meets too
}

TEST(RecordingFiles, JsonKeepsNativeRates) {
  const auto json = nlohmann::json::parse(to_json(testing::mixed()));
  EXPECT_EQ(json["plantloop_recording"], 1);
  EXPECT_EQ(json["provenance"]["diagram"], "a \"quoted\"\nname.yaml");
  EXPECT_EQ(json["rates"][0]["time"], (std::vector<double>{0, 0.25, 0.5, 1, 1, 1.1}));
  EXPECT_EQ(json["rates"][0]["side"], (std::vector{0, 0, 0, -1, 1, 0}));
  EXPECT_EQ(json["rates"][1]["time"], (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(json["rates"][1]["period"], 0.5);
  EXPECT_EQ(json["columns"].size(), 2U);
  EXPECT_EQ(json["columns"][1]["name"], "held");
  EXPECT_EQ(json["columns"][1]["unit"], "V");
  EXPECT_EQ(json["columns"][1]["rate"], 1);
  EXPECT_EQ(json["columns"][1]["values"], (std::vector{1, 2, 3}));
  EXPECT_EQ(json["events"]["h.reset"], (std::vector<double>{1.0}));
}

TEST(RecordingFiles, JsonOfAnEmptyRecordingIsJson) { EXPECT_TRUE(nlohmann::json::accept(to_json(Recording()))); }

TEST(RecordingFiles, NpzReadsBackWhatIsNotHidden) {
  const Recording original = testing::mixed();
  const RecordingResult read = from_npz(to_npz(original));
  ASSERT_TRUE(read.ok()) << read.error;
  const Recording& copy = read.recording;
  EXPECT_EQ(copy.time(), original.time());
  EXPECT_EQ(copy.side(), original.side());
  EXPECT_EQ(copy.hits, original.hits);
  EXPECT_EQ(copy.rates, original.rates);
  EXPECT_EQ(copy.provenance, original.provenance);
  EXPECT_EQ(copy.events, original.events);
  ASSERT_EQ(copy.columns.size(), 2U);
  EXPECT_EQ(copy.columns[1].unit, "V");
  EXPECT_EQ(copy.column(0), original.column(0));
  EXPECT_EQ(copy.column(1), original.column(1));
  EXPECT_EQ(to_csv(copy), to_csv(original));
}

TEST(RecordingFiles, NpzHoldsEveryBitOfEveryNumber) {
  const Recording original = many_numbers();
  const RecordingResult read = from_npz(to_npz(original));
  ASSERT_TRUE(read.ok()) << read.error;
  for (std::size_t row = 0; row < original.rows(); ++row) {
    ASSERT_TRUE(same_bits(read.recording.at(row, 0), original.at(row, 0)));
  }
}

TEST(RecordingFiles, NpzIsWhatNumpyReads) {
  // Format 1.0 of numpy.lib.format: header length a multiple of 64 with the magic, then little-endian doubles.
  const std::string file = to_npz(testing::mixed());
  const ZipResult zip = read_zip(file);
  ASSERT_TRUE(zip.ok()) << zip.error;
  const std::string_view held = zip.members.at("held.npy");
  EXPECT_EQ(held.substr(0, 8), std::string_view("\x93NUMPY\x01\x00", 8));
  const std::size_t length = static_cast<unsigned char>(held[8]);
  EXPECT_EQ((10 + length) % 64, 0U);
  EXPECT_EQ(held.substr(10, length).find("{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }"), 0U);
  EXPECT_EQ(held[9 + length], '\n');
  ASSERT_EQ(held.size(), 10 + length + 3 * sizeof(double));
  double last = 0;
  std::memcpy(&last, held.data() + held.size() - sizeof last, sizeof last);
  EXPECT_EQ(last, 3);
  EXPECT_TRUE(zip.members.contains("held.time.npy"));
  EXPECT_TRUE(zip.members.contains("time.side.npy"));
  EXPECT_FALSE(zip.members.contains("inner.npy"));
}

TEST(RecordingFiles, EqualRecordingsGiveEqualFiles) {
  EXPECT_EQ(to_npz(testing::mixed()), to_npz(testing::mixed()));
  EXPECT_EQ(to_json(testing::mixed()), to_json(testing::mixed()));
}

TEST(RecordingFiles, ADamagedNpzIsRefusedWithAReason) {
  const std::string file = to_npz(testing::mixed());
  EXPECT_EQ(from_npz("time,x\n").error, "it is no ZIP archive");
  EXPECT_EQ(from_npz(file.substr(0, file.size() / 2)).error, "it is no ZIP archive, or its end is missing");
  // Whatever one byte is changed to, reading ends with a recording or a reason.
  for (std::size_t at = 0; at < file.size(); at += 7) {
    std::string damaged = file;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    const RecordingResult read = from_npz(damaged);
    EXPECT_TRUE(!read.ok() || read.recording.rows() == 6) << at;
  }
  ZipWriter other;
  other.add("a.npy", "x");
  EXPECT_EQ(from_npz(other.finish()).error, "it is no recording of plantloop: it has no array 'time.meta'");
}

TEST(Crc32, HasItsCheckValue) {
  EXPECT_EQ(crc32("123456789"), 0xCBF43926U);  // the published check value of CRC-32/ISO-HDLC
  EXPECT_EQ(crc32("56789", crc32("1234")), 0xCBF43926U);
  EXPECT_EQ(crc32(""), 0U);
}

}  // namespace
}  // namespace plantloop
