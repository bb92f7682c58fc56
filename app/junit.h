// Verdicts as JUnit XML, which continuous integration shows.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plantloop::app {

struct TestCase {
  std::string name;
  enum Outcome { passed, failed, error } outcome = passed;
  std::string message;  // what was measured, or went wrong
  std::string file;
  std::uint32_t line = 0;  // 0: none
};
struct TestSuite {
  std::string name;
  std::vector<TestCase> cases;
  double seconds = 0;
};

std::string to_junit(const std::vector<TestSuite>& suites);

}  // namespace plantloop::app
