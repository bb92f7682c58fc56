// The example in the documentation of a block is a diagram that checks, runs and does what it says.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "engine/block.h"
#include "engine/run/diagram.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;

bool keeps_its_lines_short(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 120) return false;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return true;
}

// The file that an example reads stands beside it.
TEST(EveryExample, MeetsItsExpectations) {
  for (const BlockType& type : catalogue()) {
    if (type.example.empty()) continue;
    SCOPED_TRACE(type.name);
    const std::string example(type.example);
    EXPECT_THAT(example, HasSubstr("type: " + std::string(type.name)));
    EXPECT_TRUE(keeps_its_lines_short(example));
    Report report;
    const auto diagram = Diagram::from_text("plantloop: 1\n" + example, "tests/blocks/example.yaml", report);
    ASSERT_TRUE(diagram) << to_text(report);
    const auto run = diagram->run({}, report);
    ASSERT_TRUE(run) << to_text(report);
    EXPECT_TRUE(report.findings().empty()) << to_text(report);
    EXPECT_FALSE(run->verdicts.empty()) << "an example says what it does in `expect:`";
    for (const Verdict& v : run->verdicts) EXPECT_TRUE(v.met) << v.text << ": " << v.measured;
  }
}

}  // namespace
}  // namespace plantloop
