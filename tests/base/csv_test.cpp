// Reading CSV files that people and instruments write, and what is said when they cannot be read.

#include "engine/base/csv.h"

#include <gtest/gtest.h>

namespace plantloop {
namespace {

TEST(Csv, ReadsAHeaderAndColumns) {
  const CsvResult csv = read_csv("time,u\n0,1.5\n0.1,-2e3\n");
  ASSERT_TRUE(csv.ok()) << csv.error;
  EXPECT_EQ(csv.table.find("u"), 1);
  EXPECT_EQ(csv.table.columns[1], (std::vector{1.5, -2e3}));
}

TEST(Csv, NumbersTheColumnsOfAFileWithoutHeader) {
  const CsvResult csv = read_csv("0,1\n1,2");
  ASSERT_TRUE(csv.ok());
  EXPECT_EQ(csv.table.names, (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(csv.table.rows(), 2U);
}

TEST(Csv, ReadsWhatSpreadsheetsAndInstrumentsWrite) {
  const CsvResult csv =
      read_csv("\xEF\xBB\xBF# recorded today\r\n\r\n\"time [s]\";\"flow, cold\"\r\n0 ; 1\r\n1;\t2\r\n");
  ASSERT_TRUE(csv.ok()) << csv.error;
  EXPECT_EQ(csv.table.names, (std::vector<std::string>{"time [s]", "flow, cold"}));
  EXPECT_EQ(csv.table.columns[1], (std::vector{1.0, 2.0}));
}

TEST(Csv, ReadsDecimalCommasWhereNoCommaSeparates) {
  const CsvResult csv = read_csv("Zeit;y\r\n0;-1,5\r\n0,1;2,5e-3\r\n0,2;7\r\n");
  ASSERT_TRUE(csv.ok()) << csv.error;
  EXPECT_EQ(csv.table.columns[0], (std::vector{0.0, 0.1, 0.2}));
  EXPECT_EQ(csv.table.columns[1], (std::vector{-1.5, 2.5e-3, 7.0}));
  const CsvResult tabs = read_csv("0,5\t1\n1\t\n", MissingCells::as_nan);
  ASSERT_TRUE(tabs.ok()) << tabs.error;
  EXPECT_EQ(tabs.table.names, (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(tabs.table.columns[0], (std::vector{0.5, 1.0}));
}

TEST(Csv, ReadsQuotedNumbersTrailingSeparatorsAndOldLineEnds) {
  for (const char* const text : {"t,y\n\"0\",\"1.5\"\n1,\"2.5\"\n", "t,y,\n0,1.5,\n1,2.5,\n", "t,y\n0,1.5,\n1,2.5,\n",
                                 "t,y\r0,1.5\r1,2.5\r", "t,y\r\n0,1.5\r\n\r\n1,2.5"}) {
    const CsvResult csv = read_csv(text);
    ASSERT_TRUE(csv.ok()) << text << csv.error;
    EXPECT_EQ(csv.table.names, (std::vector<std::string>{"t", "y"})) << text;
    EXPECT_EQ(csv.table.columns[0], (std::vector{0.0, 1.0})) << text;
    EXPECT_EQ(csv.table.columns[1], (std::vector{1.5, 2.5})) << text;
  }
  EXPECT_EQ(read_csv("# rig\nt,y\n\n0,1\n").table.lines, (std::vector<std::uint32_t>{4}));
}

TEST(Csv, ARowOfUnitsBecomesPartOfTheNames) {
  const CsvResult csv = read_csv("time,u [V],y,z\ns,V,(m/s),-\n0,1,2,3\n");
  ASSERT_TRUE(csv.ok()) << csv.error;
  EXPECT_EQ(csv.table.names, (std::vector<std::string>{"time [s]", "u [V]", "y [m/s]", "z"}));
  EXPECT_EQ(csv.table.rows(), 1U);
}

TEST(Csv, SaysWhatIsWrongAndWhere) {
  const auto error = [](std::string_view text) {
    const CsvResult csv = read_csv(text);
    return std::to_string(csv.line) + ":" + std::to_string(csv.column) + ": " + csv.error;
  };
  EXPECT_EQ(error("t,y\n0,1\n1, abc\n"), "3:4: 'abc' is no number");
  EXPECT_EQ(error("t;y\n0;1.234,5\n"), "2:3: '1.234,5' is no number");
  EXPECT_EQ(error("t;y\n0,5;1\n1.5;2\n"),
            "3:1: '1.5' has a decimal point, but numbers before it (line 2) a decimal comma");
  EXPECT_EQ(error("t;y\n0.5;1\n1;2,5\n"),
            "3:3: '2,5' has a decimal comma, but numbers before it (line 2) a decimal point");
  EXPECT_EQ(error("t,y\n0,5,1,25\n"),
            "2:5: 4 values, but the first line has 2; where a comma is the decimal mark, semicolons must separate the "
            "values");
  EXPECT_EQ(error("t,y\n0\n"), "2:2: 1 value, but the first line has 2");
  EXPECT_EQ(error("t,y\n0,1,2\n"), "2:5: 3 values, but the first line has 2");
  EXPECT_EQ(error("t,y\n0,\n"), "2:3: the value of 'y' is missing");
  EXPECT_EQ(error("t,t\n0,1\n"), "1:3: two columns are called 't'");
  EXPECT_EQ(error("t,\n0,1\n"), "1:3: column 2 has no name");
  EXPECT_EQ(error("t,y,\n0,1,2\n"), "1:5: column 3 has no name");
  EXPECT_EQ(error("t y\n0 1\n"),
            "2:1: '0 1' is no number; values are separated as the first line is, by commas, semicolons or tabs");
  EXPECT_EQ(error("t,y\nseconds,volts\n0,1\n"),
            "2:1: 'seconds' is no number and no unit; below the header stand numbers, or a row of units");
  EXPECT_EQ(error("t,y\n\"0\",\"1,5\"\n"), "2:5: '1,5' is no number");
  EXPECT_EQ(error(std::string_view("\xFF\xFEt\0,\0y\0", 8)),
            "1:1: the file is in UTF-16; save it in UTF-8 (spreadsheets call it CSV UTF-8)");
  EXPECT_EQ(error("# nothing\n"), "1:0: it holds no line with values");
  EXPECT_EQ(error("t,y\n0,nan\n"), "2:3: 'nan' is no number");
}

TEST(Csv, AHeaderAloneIsATableWithoutRows) {
  const CsvResult csv = read_csv("t,y\n");
  ASSERT_TRUE(csv.ok());
  EXPECT_EQ(csv.table.rows(), 0U);
}

}  // namespace
}  // namespace plantloop
