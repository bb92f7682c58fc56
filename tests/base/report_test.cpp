// Reports: the look of findings, and the nearest name.

#include "engine/base/report.h"

#include <gtest/gtest.h>

#include "engine/base/error.h"

namespace plantloop {
namespace {

const Source& car() {
  static const Source source{"diagrams/car.yaml", "blocks:\n  pi:\n      Kp: 800\n  θθ: {a: 1}\n"};
  return source;
}

TEST(Report, LooksAsTheStyleGuideShows) {
  Report report;
  report.error({&car(), 3, 7, 2}, "block '{}' ({}) has no parameter '{}'", "pi", "velocity_pi", "Kp")
      .suggest("Kp", {"kp", "ki", "t_track", "lower", "upper"});
  EXPECT_EQ(to_text(report), R"(diagrams/car.yaml:3:7: error: block 'pi' (velocity_pi) has no parameter 'Kp'
    3 |       Kp: 800
      |       ^~
  did you mean 'kp'?  it has: kp, ki, t_track, lower, upper
)");
}

TEST(Report, IsSortedByPlaceAndShowsRelatedOnes) {
  Report report;
  report.warning({&car(), 4, 8, 1}, "second").also({&car(), 2, 3, 2}, "written here");
  report.error({&car(), 1, 1, 6}, "first").hint("a hint");
  report.note({}, "without place");
  EXPECT_EQ(to_text(report), R"(note: without place
diagrams/car.yaml:1:1: error: first
    1 | blocks:
      | ^~~~~~
  a hint
diagrams/car.yaml:4:8: warning: second
    4 |   θθ: {a: 1}
      |        ^
diagrams/car.yaml:2:3: note: written here
    2 |   pi:
      |   ^~
)");
}

TEST(Report, KeepsTwentyErrorsAndCountsTheRest) {
  Report report;
  for (int i = 0; i < 50; ++i) report.error({&car(), 1, 1, 1}, "error {}", i).hint("hint");
  EXPECT_EQ(report.findings().size(), 20U);
  EXPECT_EQ(report.error_count(), 50U);
  EXPECT_TRUE(to_text(report).ends_with("... and 30 more errors\n"));
}

TEST(Report, FindingsStayValidWhileMoreAreAdded) {
  Report report;
  Finding& first = report.error({}, "first");
  for (int i = 0; i < 10; ++i) report.error({}, "more");
  first.hint("late");
  EXPECT_EQ(report.findings().front().hints.size(), 1U);
}

TEST(Report, ShowsThePartOfALongLineAroundTheCaret) {
  const Source source{"x", std::string(5000, 'a') + "b" + std::string(5000, 'c') + "\n"};
  Report report;
  report.error({&source, 1, 5001, 1}, "here");
  const std::string text = to_text(report);
  EXPECT_LT(text.size(), 600U);
  const std::size_t shown = text.find("    1 | ");
  const std::size_t caret = text.find('^');
  const std::size_t caret_line = text.rfind('\n', caret) + 1;
  EXPECT_EQ(text[shown + caret - caret_line], 'b');
}

TEST(Report, CannotSteerATerminal) {
  const Source source{"x", "a: \x1b[31m\n"};
  Report report;
  report.error({&source, 1, 4, 1}, "text '{}'", "\x1b[0m");
  EXPECT_EQ(to_text(report).find('\x1b'), std::string::npos);
  EXPECT_NE(to_text(report, true).find("\x1b[1;31m"), std::string::npos);
}

TEST(Report, IsJson) {
  Report report;
  report.error({&car(), 3, 7, 2}, "a \"quoted\" word").hint("h").also({&car(), 2, 3, 2}, "there").named("unknown-key");
  EXPECT_EQ(
      to_json(report),
      "[\n  {\"severity\": \"error\", \"id\": \"unknown-key\", \"file\": \"diagrams/car.yaml\", \"line\": 3, "
      "\"column\": 7, \"length\": 2, \"message\": \"a \\\"quoted\\\" word\", \"hints\": [\"h\"], \"related\": "
      "[{\"file\": \"diagrams/car.yaml\", \"line\": 2, \"column\": 3, \"length\": 2, \"message\": \"there\"}]}\n]\n");
  EXPECT_EQ(to_json(Report()), "[]\n");
}

TEST(Report, IsSarif) {
  Report report;
  report.warning({&car(), 3, 7, 2}, "text").named("comma");
  const std::string sarif = to_sarif(report);
  for (const char* part : {"\"version\": \"2.1.0\"", "\"name\": \"plantloop\"", "\"ruleId\": \"comma\"",
                           "\"level\": \"warning\"", "\"startLine\": 3, \"startColumn\": 7, \"endColumn\": 9",
                           "\"uri\": \"diagrams/car.yaml\"", "\"columnKind\": \"unicodeCodePoints\""}) {
    EXPECT_NE(sarif.find(part), std::string::npos) << part;
  }
}

TEST(Nearest, FindsSlipsCaseAndSwaps) {
  const std::vector<std::string> names{"integrator", "initial", "saturation", "kp", "ki", "step"};
  EXPECT_EQ(nearest("intergator", names), "integrator");
  EXPECT_EQ(nearest("Kp", names), "kp");
  EXPECT_EQ(nearest("setp", names), "step");
  EXPECT_EQ(nearest("satuartion", names), "saturation");
  EXPECT_EQ(nearest("init", names), "initial");
  EXPECT_EQ(nearest("STEP", names), "step");
}

TEST(Nearest, IsSilentWhenNothingIsNear) {
  const std::vector<std::string> names{"integrator", "kp", "x"};
  EXPECT_EQ(nearest("gain", names), "");
  EXPECT_EQ(nearest("zz", names), "");
  EXPECT_EQ(nearest("y", names), "");
  EXPECT_EQ(nearest("", names), "");
}

TEST(RunError, CarriesTimeAndPlace) {
  const RunError error("the step became too small", 1.5, "loop.plant");
  EXPECT_EQ(error.time(), 1.5);
  EXPECT_EQ(error.place(), "loop.plant");
  EXPECT_STREQ(error.what(), "the step became too small");
}

}  // namespace
}  // namespace plantloop
