// One suite for each diagram, one case for each expectation; what cannot stand in XML is left out.

#include "app/junit.h"

#include <fmt/format.h>

#include <string_view>

namespace plantloop::app {

namespace {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\n')
      out += "&#10;";
    else if (byte >= 0x20 || c == '\t')
      out += c;
  }
  return out;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::size_t count(const TestSuite& suite, TestCase::Outcome outcome) {
  std::size_t n = 0;
  for (const TestCase& c : suite.cases) n += c.outcome == outcome ? 1 : 0;
  return n;
}

std::string to_xml(const TestSuite& suite, const TestCase& c) {
  std::string place;
  if (!c.file.empty()) place += fmt::format(" file=\"{}\"", escaped(c.file));
  if (c.line > 0) place += fmt::format(" line=\"{}\"", c.line);
  const std::string open =
      fmt::format("    <testcase classname=\"{}\" name=\"{}\"{}", escaped(suite.name), escaped(c.name), place);
  if (c.outcome == TestCase::passed) return open + "/>\n";
  const char* const tag = c.outcome == TestCase::failed ? "failure" : "error";
  return fmt::format("{}>\n      <{} message=\"{}\">{}</{}>\n    </testcase>\n", open, tag,
                     escaped(first_line(c.message)), escaped(c.message), tag);
}

}  // namespace

std::string to_junit(const std::vector<TestSuite>& suites) {
  std::size_t tests = 0, failures = 0, errors = 0;
  double time = 0;
  std::string body;
  for (const TestSuite& suite : suites) {
    const std::size_t failed = count(suite, TestCase::failed), wrong = count(suite, TestCase::error);
    tests += suite.cases.size(), failures += failed, errors += wrong, time += suite.seconds;
    body += fmt::format("  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{:.3f}\">\n",
                        escaped(suite.name), suite.cases.size(), failed, wrong, suite.seconds);
    for (const TestCase& c : suite.cases) body += to_xml(suite, c);
    body += "  </testsuite>\n";
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuites tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{:.3f}\">\n{}</testsuites>\n",
      tests, failures, errors, time, body);
}

}  // namespace plantloop::app
